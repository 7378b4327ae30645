#pragma once
// The way in of a re-entry, held against part, fixtures and machine before it moves: `tiltfeed-sim prove` as
// a process of its own, on the job's set-up.

#include <string>

#include "daemon/journal/reentry_text.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// The set-up that it is held against. Empty job: there is none, as of a program that was handed in by
/// itself.
struct EntrySetup {
  std::string job, stl, machine;  ///< files
  std::string operation;          ///< of the job, in which the entry is; empty: the job is one
};

/// A line for the operator: that it keeps clear, or why and of what that is not known. The place where the
/// tool stands may be in the part, as after a fault: then its way off is held against no part, and the line
/// says so. Errors: kInput: two bodies come too near to each other, or the tool cuts into the part, with the
/// line of the way in and both bodies; what to do.
Result<std::string> hold_entry(const Reentry& entry, const EntrySetup& setup);

}  // namespace tiltfeed::daemon
