// Planning spread over the shop: which jobs other services are asked to plan, what is done with what comes
// back, and when this service plans for others.

#include <fcntl.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "daemon/service/job_service.h"
#include "daemon/shop/shop_files.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;
using std::chrono::steady_clock;

/// The shop's thread has asked lately: the database is there.
constexpr std::chrono::seconds kContact{30};
/// While a planner stands for want of knowing who has an order, the shop's thread looks again so soon.
constexpr std::chrono::seconds kSoonAsked{2};

/// SHA-256 of the profile's file, as an order of planning has it; empty: it cannot be read.
std::string digest_of(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return "";
  const Result<ShopFile> about = read_digest(file);
  ::close(file);
  return about ? about->sha256 : "";
}

/// The profile is one file: no body is in another.
bool goes_whole(const config::MachineProfile& machine) {
  for (const config::MachineBody& body : machine.solid.bodies)
    if (body.shape.kind == config::SolidKind::kStl) return false;
  return true;
}

}  // namespace

bool JobService::is_at_work() const {
  return runner_->busy() || worker_->busy() || reset_.valid() || errands_.machine() != 0 ||
         changing_.job != 0 || leaving_ || (queue_moves_ && !queue().empty());
}

/// A machine that nobody uses, with nothing to plan of its own.
bool JobService::may_help() const {
  return shop_wake_ && config_.queue.plans && !plan_.runs() && !check_.busy() && proofs_.empty() &&
         !is_at_work();
}

// ---- who asks --------------------------------------------------------------------------------------------

/// Another service plans it, or is asked to. `free`: this one could.
bool JobService::is_planned_elsewhere(const SpooledJob& job, bool free) {
  const auto now = steady_clock::now();
  const bool works = is_at_work();
  if (const PlanOrders::Order* order = orders_.of(job.id)) {
    if (free && order->standing.state == PlanState::kOpen && now - shop_asked_ > kSoonAsked) shop_wake_();
    if (!free || !orders_.is_over(*order, works, now)) return true;
    ++counts_.orders["not taken"];
    orders_.refuse(job.id);
    return false;
  }
  if ((free && !works) || !shop_wake_ || now - shop_asked_ > kContact || !orders_.may_ask(job.id) ||
      !goes_whole(config_.machine))
    return false;
  orders_.ask(job.id, job.name, now);
  shop_wake_();
  return true;
}

Result<LocalPlans> JobService::read_plans() {
  shop_asked_ = steady_clock::now();
  LocalPlans local;
  local.offers = may_help();
  local.help = help_.told();
  for (const auto& [job, order] : orders_.all())
    if (!order.back)
      local.asks.push_back(
          {order.id,
           order.name,
           {spool_.file(job, "job.yaml"), spool_.file(job, "part.stl"), config_.machine.path}});
  return local;
}

/// It is planned here after all. `why`: for people.
void JobService::plan_here(std::uint64_t id, const std::string& why) {
  ++counts_.orders["refused"];
  orders_.refuse(id);
  log(Severity::kWarning, id, why + "; it is planned here");
  const Result<SpooledJob> job = spool_.find(id);
  if (job && job->state == JobState::kPlanning) set(*job, JobState::kReceived, "");
}

Result<void> JobService::plan_told(const std::string& id, const PlanStanding& standing) {
  const auto number = orders_.job_of(id);
  if (!number) return {};
  const bool was_taken = orders_.of(*number)->standing.state == PlanState::kTaken;
  if (const auto failed = orders_.hear(id, standing, steady_clock::now())) {
    const std::string who = standing.helper.empty() ? "no other service" : standing.helper;
    plan_here(*number, who + " has no plan of it: " + *failed);
    return {};
  }
  const Result<SpooledJob> job = spool_.find(*number);
  if (!job) return {};
  if (!was_taken && standing.state == PlanState::kTaken && job->state == JobState::kReceived)
    set(*job, JobState::kPlanning, "by " + standing.helper);
  if (was_taken && standing.state == PlanState::kOpen && job->state == JobState::kPlanning)
    set(*job, JobState::kReceived, "whoever planned it has stopped");
  return {};
}

Result<void> JobService::plan_helpers(bool idle) {
  orders_.hear_helpers(idle, steady_clock::now());
  return {};
}

/// Proved in a process of its own before anything of it counts.
Result<void> JobService::plan_returned(const std::string& id, const std::string& helper,
                                       const std::string& from, const std::vector<int>& files) {
  const auto number = orders_.job_of(id);
  if (!number) return {};
  const Result<SpooledJob> job = spool_.find(*number);
  if (!job || (job->state != JobState::kPlanning && job->state != JobState::kReceived)) {
    orders_.forget(*number);
    return {};
  }
  if (!from.ends_with(" " + digest_of(config_.machine.path))) {
    plan_here(*number, "the machine profile has changed since " + helper + " was asked for its plan");
    return {};
  }
  const std::string folder = spool_.folder_of(*number);
  const Result<void> named = name_files(folder, files, plan_outputs());
  Result<PlanProcess> proof =
      named ? start_proof(*number, folder, config_.machine.path) : tl::unexpected<Error>(named.error());
  if (!proof) {
    plan_here(*number, "the plan of " + helper + " cannot be taken: " + proof.error().message);
    return {};
  }
  orders_.take_back(id, helper);
  proofs_.push_back(std::move(*proof));
  set(*job, JobState::kPlanning, "planned by " + helper + ", being proved here");
  return {};
}

void JobService::take_proof_ends() {
  for (auto proof = proofs_.begin(); proof != proofs_.end() && !check_.busy();) {
    const std::optional<Result<void>> ended = check_plan(*proof);
    if (!ended) {
      ++proof;
      continue;
    }
    const std::uint64_t number = proof->job;
    proof = proofs_.erase(proof);
    const PlanOrders::Order* order = orders_.of(number);
    if (order == nullptr) continue;  // removed meanwhile, or the shop has taken it back
    const Result<void> taken = *ended ? compare_figures(spool_.folder_of(number)) : *ended;
    if (taken)
      check_.start(spool_.file(number, "program.nc"), link_, number);
    else
      plan_here(number, "the plan of " + order->standing.helper + " is not taken: " + taken.error().message);
  }
}

/// Orders that were taken, and of which nothing is heard any more.
void JobService::give_up_silent() {
  std::vector<std::uint64_t> silent;
  for (const auto& [job, order] : orders_.all())
    if (order.standing.state == PlanState::kTaken && orders_.is_over(order, true, steady_clock::now()))
      silent.push_back(job);
  for (const std::uint64_t job : silent)
    plan_here(job, "nothing is heard of the plan that " + orders_.of(job)->standing.helper + " makes");
}

void JobService::forget_plan(std::uint64_t job) {
  orders_.forget(job);
  std::erase_if(proofs_, [&](const PlanProcess& proof) { return proof.job == job; });
}

/// Without a queue nothing is told of plans.
std::string JobService::counts_json() const {
  ordered_json json = {{"runs", counts_.runs}};
  if (config_.queue.url.empty()) return json.dump();
  std::map<std::string, int> now = {{"open", 0}, {"taken", 0}, {"proving", 0}};
  for (const auto& [job, order] : orders_.all())
    ++now[order.back ? "proving" : order.standing.state == PlanState::kTaken ? "taken" : "open"];
  json["plans_asked"] = now;
  json["plans_asked_ended"] = counts_.orders;
  json["plans_for_others"] = help_.text().empty() ? 0 : 1;
  json["plans_for_others_ended"] = counts_.helped;
  return json.dump();
}

// ---- who helps -------------------------------------------------------------------------------------------

Result<bool> JobService::plan_take(const PlanTaken& order, const std::vector<int>& files) {
  if (!may_help() || help_.has_order()) return false;
  if (Result<void> begun = help_.begin(order, files); !begun) return tl::unexpected<Error>(begun.error());
  log(Severity::kInfo, 0, help_.text());
  return true;
}

void JobService::tend_help() {
  if (!shop_wake_ || !help_.has_order()) return;
  const bool plans = !help_.text().empty();
  const std::string text = help_.text();
  if (plans && !may_help()) {
    help_.give_back();
    ++counts_.helped["given back"];
    log(Severity::kInfo, 0, text + " is given back: this machine needs its processor");
    shop_wake_();
  }
  if (!help_.tick()) return;
  ++counts_.helped[help_.told()->state == HelpState::kDone ? "done" : "failed"];
  shop_wake_();
}

void JobService::plan_settled(const std::string& id) { help_.settle(id); }

}  // namespace tiltfeed::daemon
