// The order that leads out of every state of the machine, beside the loop that answers.

#include "daemon/machine/machine_place.h"
#include "daemon/service/job_service.h"
#include "daemon/wire/open_link.h"
#include "daemon/wire/steady_clock.h"

namespace tiltfeed::daemon {

namespace {

Result<std::string> reset_over(const LinkSpec& link) {
  const Result<std::unique_ptr<Link>> wire = open_link(link);
  if (!wire) return tl::unexpected<Error>(wire.error());
  SteadyClock clock;
  return reset_machine(link, **wire, clock);
}

}  // namespace

Result<void> JobService::may_reset() const {
  if (runner_->busy())
    return fail(Code::kUsage, "job " + std::to_string(runner_->view().job) +
                                  " is on the machine; hold it, resume it or stop it");
  if (const std::uint64_t job = errands_.machine(); job != 0)
    return fail(Code::kUsage, "the machine is about to be given to job " + std::to_string(job));
  if (reset_.valid()) return fail(Code::kUsage, "the machine is being reset already");
  if (worker_->busy())
    return fail(Code::kUsage, worker_->name() + " is in work on the machine; `tiltfeed stop` ends it");
  return {};
}

/// First the operator sees what would happen; said again with the confirmation it begins, and `list` tells
/// how it ended.
Result<std::string> JobService::reset(const ApiRequest& request) {
  if (const Result<void> may = may_reset(); !may) return tl::unexpected<Error>(may.error());
  if (!request.confirmed) return write_text(reset_preview(link_), "confirm");
  begin_reset(0);
  return write_text("the machine is being reset");
}

/// `stopped`: the interrupted job that an operator ends by it; 0: none.
void JobService::begin_reset(std::uint64_t stopped) {
  queue_moves_ = false;
  stopped_ = stopped;
  reset_ = std::async(std::launch::async, reset_over, link_);
}

/// A stop of an interrupted job: the controller holds, and still has blocks of it.
Result<std::string> JobService::forget_run(const SpooledJob& job) {
  if (const Result<void> may = may_reset(); !may) return tl::unexpected<Error>(may.error());
  begin_reset(job.id);
  return write_text("the controller is told to forget it; `tiltfeed list` says how that ends");
}

/// What the controller had of an interrupted run is gone: it cannot go on by itself any more.
void JobService::take_reset_end() {
  if (!reset_.valid() || reset_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  const Result<std::string> ended = reset_.get();
  reset_text_ = ended ? "done: " + *ended : "failed: " + ended.error().message;
  log(ended ? Severity::kWarning : Severity::kError, 0, "reset " + reset_text_);
  if (changing_.job != 0) changing_.parked = "after a reset, " + reset_text_;
  const auto jobs = spool_.list();
  if (!ended || !jobs) return;
  const std::string since = "the machine was reset since; ";
  for (const SpooledJob& job : *jobs) {
    // Its note may advise the reset that has been made.
    if (job.state == JobState::kUncertain && !job.note.starts_with(since))
      set(job, JobState::kUncertain, since + job.note);
    if (job.state != JobState::kInterrupted) continue;
    const bool stopped = job.id == stopped_;
    set(job, stopped ? JobState::kStopped : JobState::kUncertain,
        (stopped ? "stopped; the machine was reset; " : since) +
            job.note.substr(0, job.note.find(kResumeAsks)));
  }
}

}  // namespace tiltfeed::daemon
