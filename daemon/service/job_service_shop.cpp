// Jobs of the shop's queue: they come as submissions do, and wait for an operator. None is started here. And
// what the machine is at, for the shop's page.

#include <unistd.h>

#include <filesystem>

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

/// Of the machine's states at most one a second is kept; a sign of life all half minutes.
constexpr std::uint64_t kStateMs = 1000, kAliveMs = 30000;

std::uint64_t now_ms() {
  using std::chrono::duration_cast;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(duration_cast<std::chrono::milliseconds>(now).count());
}

/// /etc/tiltfeed/NAME.yaml is the service of the machine NAME; service.yaml says nothing.
std::string shop_name(const std::string& config) {
  const std::string stem = std::filesystem::path(config).stem().string();
  return stem.empty() || stem == "service" ? std::string() : plain_name(stem);
}

}  // namespace

void JobService::on_shop_news(std::function<void()> wake) {
  shop_wake_ = std::move(wake);
  if (const auto jobs = spool_.list())
    for (const SpooledJob& job : *jobs) note_settled(job);
  if (const auto begun = spool_.shop_states().begin(now_ms()); !begun)
    log(Severity::kWarning, 0, "the shop's page will lack what this machine did: " + begun.error().message);
}

void JobService::note_settled(const SpooledJob& job) {
  if (job.state == JobState::kInterrupted || job.state == JobState::kUncertain)
    unsettled_[job.id] = name_of(job.id) + " is " + state_name(job.state) + ": " + job.note;
  else
    unsettled_.erase(job.id);
}

const char* JobService::shop_word() const {
  if (runner_->busy()) {
    const Phase phase = runner_->view().state.phase;
    if (phase == Phase::kAlarm || phase == Phase::kFault) return kShopFault;
    const bool stands = phase == Phase::kHold || phase == Phase::kToolChange || phase == Phase::kStop ||
                        phase == Phase::kStopped;
    return stands ? kShopHeld : kShopRunning;
  }
  if (worker_->busy() || reset_.valid()) return kShopSetup;
  if (changing_.job != 0) return kShopHeld;
  return unsettled_.empty() ? kShopIdle : kShopFault;
}

ShopLive JobService::shop_live() const {
  ShopLive live;
  live.state = shop_word();
  live.clock = now_ms();
  std::uint64_t number = changing_.job;
  if (runner_->busy()) {
    const RunView view = runner_->view();
    number = view.job;
    live.alarm = view.state.held;
    live.blocks = view.state.total;
    live.executed = view.state.executed;
    if (view.machine_seconds > 0.0) live.remaining_seconds = view.remaining_seconds;
  } else if (changing_.job != 0) {
    live.alarm = "tool change: " + tool_text(changing_.change);
  } else if (!unsettled_.empty()) {
    live.alarm = unsettled_.rbegin()->second;
  }
  if (number == 0) return live;
  if (const Result<SpooledJob> job = spool_.find(number)) live.job = job->name;
  return live;
}

/// True: it is another than before, and on record now.
bool JobService::note_shop_state(const std::string& word) {
  const std::uint64_t now = now_ms();
  // A disk without room is not tried more often either.
  if (now - shop_alive_ > kAliveMs) {
    static_cast<void>(spool_.shop_states().live(now));
    shop_alive_ = now;
  }
  if (word == shop_state_ || now - shop_noted_ < kStateMs) return false;
  shop_noted_ = now;
  if (const auto noted = spool_.shop_states().note(now, word); !noted) return false;
  shop_state_ = word;
  return true;
}

void JobService::tell_shop() {
  if (!shop_wake_) return;
  const bool other = note_shop_state(shop_word());
  if (other || spool_.shop().has_news()) shop_wake_();
}

void JobService::leave_shop() {
  if (!shop_wake_ || busy()) return;
  static_cast<void>(spool_.shop_states().note(now_ms(), kShopOff));
}

Result<LocalShop> JobService::read_shop() {
  Result<LocalShop> local = spool_.shop().read(config_.queue.ahead);
  if (!local) return local;
  local->offer = offer_of(config_.machine);
  local->name = shop_name(config_.path);
  local->status = status();
  local->live = live_json(shop_live());
  auto states = spool_.shop_states().untold();
  if (!states) return tl::unexpected<Error>(states.error());
  local->states = std::move(*states);
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
  forget_plan(job.id);
  if (job.place > 0) stand_still(job.id, name_of(job.id) + " was taken back by the shop");
  SpooledJob over = job;
  over.place = 0;
  if (job.state != JobState::kFailed) set(over, JobState::kFailed, "not this machine's any more: " + why);
  return {};
}

}  // namespace tiltfeed::daemon
