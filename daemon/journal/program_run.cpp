#include "daemon/journal/program_run.h"

#include <cassert>
#include <random>

namespace tiltfeed::daemon {

Result<ProgramRun> prepare_run(const std::string& program, const LinkSpec& link, std::uint64_t job) {
  ProgramRun run{program, link, {}};
  const Result<ProgramSum> sum = sum_program(program, link.kind, link.axes);
  if (!sum) return tl::unexpected<Error>(sum.error());
  const Result<HostBoot> host = host_boot();
  if (!host) return tl::unexpected<Error>(host.error());
  std::random_device random;  // an old session's blocks can never be taken for this one's
  const auto session = static_cast<std::uint16_t>(1 + random() % 0xFFFF);
  run.subject = {job, sum->blocks, sum->hash, link.kind, session, *host};
  if (sum->waits > 0) {
    Result<std::vector<ToolChange>> changes = kept_changes(program, link);
    if (!changes) return tl::unexpected<Error>(changes.error());
    run.changes = std::move(*changes);
  }
  run.stand_at(0);
  return run;
}

void ProgramRun::stand_at(std::uint64_t executed) {
  const ProgramSpan span = span_at(changes, subject.total, executed);
  subject.after = span.after;
  subject.last = span.last;
}

Result<void> begin_journal(const std::string& path, const RunSubject& subject) {
  Result<JournalDisk> disk = journal_file(path);
  if (!disk) return tl::unexpected<Error>(disk.error());
  Result<Journal> journal = Journal::open(std::move(*disk));
  if (!journal) return tl::unexpected<Error>(journal.error());
  if (const auto begun = RunRecorder::begin(*journal, subject); !begun)
    return tl::unexpected<Error>(begun.error());
  return {};
}

Result<SendReport> run_job(const ProgramRun& run, const ResumeDecision& decision, Journal& journal,
                           Link& link, Clock& clock, StreamHooks hooks) {
  assert(decision.way != ResumeWay::kFinished && decision.way != ResumeWay::kUncertain);
  const bool continues = decision.way == ResumeWay::kContinue;
  Result<RunRecorder> recorder = continues ? RunRecorder::go_on(journal, run.subject, decision.may_have)
                                           : RunRecorder::begin(journal, run.subject);
  if (!recorder) return tl::unexpected<Error>(recorder.error());
  SendOptions options;
  options.program = run.subject.program;
  options.session_id = recorder->record().session_id;
  if (continues) options.attach = decision.ring;
  options.span = span_at(run.changes, run.subject.total, run.subject.after);

  CommandQueue own_commands;
  if (hooks.commands == nullptr) hooks.commands = &own_commands;
  SendState newest;
  Result<void> kept;  // by the journal
  bool woken = !continues;
  hooks.reserve = [&](std::uint64_t next, std::uint64_t) { return recorder->reserve(next, clock.now()); };
  hooks.progress = [&, owner = hooks.progress](const SendState& state) {
    newest = state;
    if (!woken && state.phase == Phase::kHold) {
      woken = true;
      hooks.commands->push({Order::kResume});
    }
    if (kept && !is_final(state.phase)) kept = recorder->progress(state, clock.now());
    return (!owner || owner(state)) && kept.has_value();
  };
  const Result<SendReport> report = send_over(run.program, run.link, link, clock, options, hooks);
  if (!kept) return tl::unexpected<Error>(kept.error());
  const RunEvent event = report && report->change          ? RunEvent::kToolChange
                         : newest.phase == Phase::kDone    ? RunEvent::kExecuted
                         : newest.phase == Phase::kStopped ? RunEvent::kStopped
                                                           : RunEvent::kFault;
  // A journal that failed has said so already, and holds what was durable.
  if (const Result<void> ended = recorder->end(event, newest); !ended && report)
    return tl::unexpected<Error>(ended.error());
  return report;
}

}  // namespace tiltfeed::daemon
