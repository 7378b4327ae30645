#pragma once
// G-code blocks: joint path -> program text in the machine's dialect.

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/job.h"
#include "daemon/post/posting.h"
#include "kinematics/basics/path_event.h"
#include "kinematics/basics/result.h"
#include "kinematics/basics/tool_path.h"
#include "kinematics/joints/joint_path.h"

namespace tiltfeed::daemon {

/// Writes the program in the profile's dialect: header comments (TILTFEED ...: part, machine, tool, tool
/// length and set-up that are baked in, blocks, time), safe start words, tool change, motion with all words
/// that changed (all five in the first block of an operation, a rapid), F as the profile's feed mode has it
/// (G93: 1/T on every feed block), end.
/// Properties: 1 The printed words are the joints, to the last digit. 2 F is within kFeedError of what the
/// feed mode asks for, or at the control's limit and counted in clamped_feeds. 3 The text is ASCII, without
/// "-0" or an exponent, and no name leaves its comment. 4 No line, number of blocks or file is longer than
/// the control takes. 5 The bytes are the same on any number of threads.
/// After an error `out` holds a part of it: write into an OutputFile, which then leaves nothing.
/// Errors: kLimit when a line, the blocks or the file are longer than the control takes; kInput when there is
/// no block, or TCP needs a tool number; kIo; kCancelled.
Result<ProgramReport> write_program(const Posting& posting, std::ostream& out,
                                    const StageProgress& progress = {});

/// As PathEvent::value. Requires: not kOff.
double coolant_value(config::Coolant coolant);

/// A job's program as a posting, and the words that it points to, where they are not the path's own.
struct PlannedProgram {
  std::vector<std::unique_ptr<JointPath>> words;
  Posting posting;

  /// Puts the next operation's behind it; their machine and header are this one's.
  void add(PlannedProgram next);
};

/// Of one operation. `runs`: of `path`, each in a tilted plane of its own; none: the whole path. Requires:
/// `path` rounded to the profile's decimals (under TCP and in planes: not rounded coarser than that); it
/// outlives what is returned.
PlannedProgram planned_program(const JointPath& path, const std::vector<AxisRun>& runs,
                               const config::Job& job, const HeaderFacts& header);

/// The same, written at once.
Result<ProgramReport> write_program(const JointPath& path, const config::Job& job, std::ostream& out,
                                    const StageProgress& progress = {});

}  // namespace tiltfeed::daemon
