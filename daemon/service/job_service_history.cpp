// The record of every run: begun when the controller is about to be given it, ended with what became of it.

#include <ctime>

#include "daemon/service/job_service.h"

namespace tiltfeed::daemon {

/// A run that cannot be put on record runs all the same: the journal is what decides about it.
void JobService::begin_run(const SpooledJob& job, std::uint64_t first) {
  RunReport run;
  run.job = job.id;
  run.name = job.name;
  run.hash = job.hash;
  run.link = describe(link_);
  if (const auto asked = asked_by_.find(job.id); asked != asked_by_.end()) run.user = asked->second;
  run.began = std::time(nullptr);
  run.first = first;
  run.blocks = job.total;
  run.executed = job.executed;
  if (const auto begun = spool_.begin_run(run); !begun)
    log(Severity::kWarning, job.id, "this run is not in the history: " + begun.error().message);
}

/// Of a run that goes on, if one does: the job is in another state now.
void JobService::end_run(const SpooledJob& job, const std::string& note) {
  if (job.state == JobState::kRunning) return;
  RunReport end;
  end.job = job.id;
  end.executed = job.executed;
  end.outcome = job.state == JobState::kReady ? "nothing sent" : state_name(job.state);
  end.note = note;
  if (ended_ && ended_->job == job.id) {
    ++counts_.runs[end.outcome];
    const RunTally& tally = ended_->tally;
    end.ended = std::time(nullptr);
    end.figures = {ended_->state.sent,    ended_->state.resends,  ended_->seconds,
                   tally.holds(),         tally.held_seconds(),   tally.slowest_hold(),
                   tally.feed_override(), tally.starved_seconds()};
  }
  spool_.end_run(end);
}

Result<std::string> JobService::history(std::uint64_t job, std::uint64_t after) const {
  constexpr std::size_t kPage = 1000;
  const auto runs = spool_.runs(after, job, kPage);
  if (!runs) return tl::unexpected<Error>(runs.error());
  return R"({"v":1,"ok":true,"runs":)" + runs_json(*runs) + (runs->size() == kPage ? R"(,"more":true)" : "") +
         "}\n";
}

}  // namespace tiltfeed::daemon
