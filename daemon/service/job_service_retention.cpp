// What of the past goes: jobs that ended long ago, or that the disk has no room for, and old runs.

#include <algorithm>
#include <chrono>
#include <ctime>

#include "daemon/service/job_service.h"

namespace tiltfeed::daemon {

namespace {

constexpr std::chrono::hours kTidyAgain{1};

}  // namespace

/// One job at a time, so that no order waits for long; none while a run or anything else is in work.
void JobService::tidy() {
  if (config_.retention.keeps_all() || busy() || in_work() || reset_.valid()) return;
  if (const auto now = std::chrono::steady_clock::now(); now >= tidy_due_) {
    tidy_due_ = now + kTidyAgain;
    find_outdated();
  }
  if (outdated_.empty()) return;
  const Outdated next = outdated_.back();
  outdated_.pop_back();
  const Result<SpooledJob> job = spool_.find(next.id);
  if (!job || !has_ended(*job)) return;  // somebody was faster
  const Result<std::string> removed = remove(*job);
  const std::string why = next.by_age ? "it ended more than " + std::to_string(config_.retention.days) +
                                            " days ago (retention.days)"
                                      : "all jobs together are more than " +
                                            std::to_string(config_.retention.mib) + " MiB (retention.mib)";
  log(removed ? Severity::kInfo : Severity::kWarning, job->id,
      removed ? "removed with its files: " + why : "cannot be removed: " + removed.error().message);
}

void JobService::find_outdated() {
  const std::int64_t now = std::time(nullptr);
  const auto kept = spool_.kept();
  if (!kept) return log(Severity::kWarning, 0, "what is to be removed is not known: " + kept.error().message);
  outdated_ = outdated(*kept, config_.retention, now);
  std::reverse(outdated_.begin(), outdated_.end());  // taken from the back
  if (config_.retention.history_days == 0) return;
  const auto forgotten = spool_.forget_runs(now - config_.retention.history_days * kDay);
  if (!forgotten) return log(Severity::kWarning, 0, "old runs stay: " + forgotten.error().message);
  if (*forgotten > 0)
    log(Severity::kInfo, 0,
        std::to_string(*forgotten) + " runs that ended more than " +
            std::to_string(config_.retention.history_days) + " days ago are forgotten");
}

}  // namespace tiltfeed::daemon
