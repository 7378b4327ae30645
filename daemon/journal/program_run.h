#pragma once
// One job's program over one wire, with its journal: starts it, or goes on where it was cut off.

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/journal/run_recorder.h"

namespace tiltfeed::daemon {

/// What is to be run; the figures of `subject` belong to the file as it is now.
struct ProgramRun {
  std::string program;
  LinkSpec link;
  RunSubject subject;
  std::vector<ToolChange> changes = {};  ///< that the operator makes

  /// The part of the program in which a run stands that has executed so many blocks.
  void stand_at(std::uint64_t executed);
  /// That comes at the end of it; nothing: the program's end does.
  std::optional<ToolChange> next_change() const {
    return span_at(changes, subject.total, subject.after).next;
  }
};
/// Reads the program once for its hash and its number of blocks. Errors: as `send_program` before it sends.
Result<ProgramRun> prepare_run(const std::string& program, const LinkSpec& link, std::uint64_t job);

/// The journal of a run that begins, durable before anybody says that it was begun. Errors: kIo.
Result<void> begin_journal(const std::string& path, const RunSubject& subject);

/// Streams as `decision` says, and keeps the journal. A controller that holds because nobody fed its watchdog
/// is resumed once: who calls this has the operator's word. Ends at the next tool change: SendReport::change.
/// Requires: decision.way is kFresh, kContinue, or kToolChange with the change made and run.stand_at() it.
/// Errors: kIo of the journal (nothing left after it), else as `send_program`.
Result<SendReport> run_job(const ProgramRun& run, const ResumeDecision& decision, Journal& journal,
                           Link& link, Clock& clock, StreamHooks hooks);

}  // namespace tiltfeed::daemon
