// From what was submitted to a program that can be started: planned in a process of its own, read and
// checked.

#include "daemon/files/sha256.h"
#include "daemon/service/job_service.h"

namespace tiltfeed::daemon {

namespace {

/// While it was planned or checked, which ends in this state, too, but has not yet.
bool given_up(const SpooledJob& job) { return job.state == JobState::kFailed; }

}  // namespace

void JobService::plan_failed(SpooledJob job, const std::string& why) {
  if (job.place > 0) stand_still(job.id, "job " + std::to_string(job.id) + " cannot be planned");
  job.place = 0;
  set(job, JobState::kFailed, why);
}

void JobService::take_plan_end() {
  // The program of another service's plan is in check: one at a time. The end stays until that is over.
  if (check_.busy()) return;
  const std::optional<Result<void>> ended = check_plan(plan_);
  if (!ended) return;
  Result<SpooledJob> job = spool_.find(plan_.job);
  if (!job || given_up(*job)) return;
  if (!*ended) return plan_failed(*job, ended->error().message);
  check_.start(spool_.file(job->id, "program.nc"), link_, job->id);
}

void JobService::take_check_end() {
  const std::optional<Result<ProgramRun>> run = check_.take();
  if (!run) return;
  Result<SpooledJob> job = spool_.find(check_.job());
  if (!job || given_up(*job)) return;  // removed meanwhile, or the shop has taken it back
  const PlanOrders::Order* const order = orders_.of(job->id);
  const std::string helper = order != nullptr ? order->standing.helper : "";
  if (!*run && order != nullptr)
    return plan_here(job->id, "the plan of " + helper + " is not taken: " + run->error().message);
  if (!*run) return plan_failed(*job, run->error().message);
  if (order != nullptr) ++counts_.orders["accepted"];
  job->total = (*run)->subject.total;
  job->hash = hex((*run)->subject.program);
  orders_.forget(job->id);
  set(*job, JobState::kReady,
      job->program     ? "checked"
      : helper.empty() ? "planned"
                       : "planned by " + helper + ", proved here");
}

void JobService::plan_next() {
  const bool free = !plan_.runs() && !check_.busy();
  if (!free && !shop_wake_) return;
  const auto jobs = spool_.received();
  if (!jobs) return;
  for (const SpooledJob& job : *jobs) {
    if (!job.program && is_planned_elsewhere(job, free)) continue;
    if (!free) continue;
    if (job.program) return check_.start(spool_.file(job.id, "program.nc"), link_, job.id);
    Result<PlanProcess> started = start_plan(job.id, spool_.folder_of(job.id), config_.machine.path);
    if (!started) return plan_failed(job, started.error().message);
    plan_ = std::move(*started);
    return set(job, JobState::kPlanning, "");
  }
}

}  // namespace tiltfeed::daemon
