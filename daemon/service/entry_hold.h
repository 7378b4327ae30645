#pragma once
// The way in of a start or a re-entry, held against part, fixtures and machine before it moves: `tiltfeed-sim
// prove` as a process of its own, on the job's set-up.

#include <optional>
#include <string>

#include "config/machine_profile.h"
#include "daemon/journal/reentry_text.h"
#include "daemon/wire/link.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// The set-up that it is held against. Empty job: there is none, as of a program that was handed in by
/// itself.
struct EntrySetup {
  std::string job, stl, machine;  ///< files
  std::string operation;          ///< of the job, in which the way ends; empty: the job is one
};

/// A line for the operator: that it keeps clear, or why and of what that is not known. The place where the
/// tool stands may be in the part, as after a fault: then its way off is held against no part, and the line
/// says so. Errors: kInput: two bodies come too near to each other, or the tool cuts into the part, with the
/// line of the way in and both bodies; what to do.
Result<std::string> hold_entry(const Reentry& entry, const EntrySetup& setup);

/// The same of a program from its beginning: from where the machine `stands`, by the program's own moves, to
/// the first place that states every axis, none of it in the part. What comes behind it was proven as the
/// program was planned. The tool is the one of the job's first operation, whatever is in the spindle before
/// the program changes it. Requires: a job. Errors: likewise.
Result<std::string> hold_start(const std::string& program, const config::MachineProfile& machine,
                               const Joints& stands, const EntrySetup& setup, LinkKind link);

/// The same of the way back from a tool change, a small program of its own (tool_return.h), to its end, with
/// the tool of the setup's operation. Errors: likewise.
Result<std::string> hold_way_back(const std::string& way, const config::MachineProfile& machine,
                                  const Joints& stands, const EntrySetup& setup, LinkKind link);

/// Where the machine says that it stands; nothing: this link does not tell. Errors: kUsage: it takes no
/// program where it stands; kLink.
Result<std::optional<Joints>> where_it_stands(const LinkSpec& link, const MachineModel& machine);

}  // namespace tiltfeed::daemon
