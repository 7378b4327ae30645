#include "daemon/job_run.h"

#include <cassert>

#include "daemon/sha256.h"

namespace tiltfeed {

Result<JobRun> prepare_run(const std::string& program, const LinkSpec& link, std::uint64_t job) {
  JobRun run{program, link, {}};
  const Result<Sha256> hash = sha256_of_file(program);
  if (!hash) return tl::unexpected<Error>(hash.error());
  const Result<std::uint64_t> blocks = count_blocks(program, link.kind);
  if (!blocks) return tl::unexpected<Error>(blocks.error());
  const Result<HostBoot> host = host_boot();
  if (!host) return tl::unexpected<Error>(host.error());
  run.subject = {job, *blocks, *hash, link.kind, new_session_id(), *host};
  return run;
}

Result<SendReport> run_job(const JobRun& run, const ResumeDecision& decision, Journal& journal, Link& link,
                           Clock& clock, const SendProgress& progress, SendHooks hooks) {
  assert(decision.way == ResumeWay::kFresh || decision.way == ResumeWay::kContinue);
  const bool continues = decision.way == ResumeWay::kContinue;
  Result<RunRecorder> recorder =
      continues ? RunRecorder::go_on(journal, run.subject) : RunRecorder::begin(journal, run.subject);
  if (!recorder) return tl::unexpected<Error>(recorder.error());
  if (continues) hooks.resume = decision.ring;

  SendState newest;
  bool asked_to_stop = false;
  hooks.before_wire = [&, owner = hooks.before_wire](const SendState& state,
                                                     std::uint64_t offered) -> Result<void> {
    newest = state;
    if (Result<void> told = recorder->before_wire(state, offered, clock.now()); !told) return told;
    return owner ? owner(state, offered) : Result<void>{};
  };
  const SendProgress watched = [&](const SendState& state) {
    newest = state;
    const bool more = !progress || progress(state);
    asked_to_stop = asked_to_stop || !more;
    return more;
  };
  Result<SendReport> report =
      send_over(run.program, run.link, link, clock, recorder->record().session_id, watched, hooks);
  const RunEvent event = report ? RunEvent::kExecuted : asked_to_stop ? RunEvent::kStopped : RunEvent::kFault;
  // A journal that failed has said so already, and holds what was durable.
  if (const Result<void> ended = recorder->end(event, newest); !ended && report)
    return tl::unexpected<Error>(ended.error());
  return report;
}

}  // namespace tiltfeed
