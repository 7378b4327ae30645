// Jobs of the shop's queue: they come as submissions do, and wait for an operator. None is started here.

#include <unistd.h>

#include "daemon/service/job_service.h"

namespace tiltfeed::daemon {

namespace {

/// It moved, or may have: only who stands at the machine can end it.
bool has_moved(const SpooledJob& job) {
  switch (job.state) {
    case JobState::kReceived:
    case JobState::kPlanning:
    case JobState::kReady:
    case JobState::kFailed:
      return false;
    default:
      return true;
  }
}

}  // namespace

Result<LocalShop> JobService::read_shop() {
  Result<LocalShop> local = spool_.shop().read(config_.queue.ahead);
  if (!local) return local;
  local->offer = offer_of(config_.machine);
  local->status = status();
  local->wants = local->wants && !leaving_;
  return local;
}

void JobService::take_from_shop(const ShopJob& job, HandedFiles files, Done done) {
  const std::string& id = job.ticket.job;
  const Result<std::string> state = spool_.shop().state(id);
  if (!state) return done(tl::unexpected<Error>(state.error()));
  if (*state != "accepted") return done(std::string());  // it is here already, or is not this machine's
  const auto before = spool_.find_shop(id);
  if (!before) return done(tl::unexpected<Error>(before.error()));
  if (*before) {
    // Its files were cut off with the service before this one.
    if (arrivals_.is_arriving((*before)->id))
      return done(fail(Code::kIo, name_of((*before)->id) + " is coming in"));
    if (const Result<void> removed = spool_.remove((*before)->id); !removed)
      return done(tl::unexpected<Error>(removed.error()));
  }
  SpooledJob taken;
  taken.name = job.name;
  taken.program = job.program;
  taken.user = ::getuid();
  taken.shop = id;
  arrivals_.add(std::move(taken), std::move(files),
                [this, id, number = job.number, done = std::move(done)](const Result<std::string>& arrived) {
                  const auto here = spool_.find_shop(id);
                  if (arrived && here && *here)
                    log(Severity::kInfo, (*here)->id,
                        "came from the shop, where it is job " + std::to_string(number) + " (" + id +
                            "); it waits for its start here");
                  done(arrived);
                });
}

Result<void> JobService::overrule(const std::string& shop_job, const std::string& why) {
  if (const Result<void> kept = spool_.shop().overrule(shop_job); !kept) return kept;
  const auto found = spool_.find_shop(shop_job);
  if (!found) return tl::unexpected<Error>(found.error());
  if (!*found) return {};
  const SpooledJob& job = **found;
  if (has_moved(job)) {
    log(Severity::kError, job.id,
        "the shop's queue says otherwise than this machine, where it is " +
            std::string(state_name(job.state)) + ": " + why +
            "; look at both machines before anything of it is started again");
    return {};
  }
  errands_.withdraw(job.id);
  arrivals_.drop(job.id);
  if (plan_.job == job.id) stop_plan(plan_);
  if (job.place > 0) stand_still(job.id, name_of(job.id) + " was taken back by the shop");
  SpooledJob over = job;
  over.place = 0;
  if (job.state != JobState::kFailed) set(over, JobState::kFailed, "not this machine's any more: " + why);
  return {};
}

}  // namespace tiltfeed::daemon
