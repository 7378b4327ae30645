#include "daemon/service/plan_orders.h"

#include "daemon/shop/shop_record.h"

namespace tiltfeed::daemon {

const PlanOrders::Order* PlanOrders::of(std::uint64_t job) const {
  const auto found = orders_.find(job);
  return found == orders_.end() ? nullptr : &found->second;
}

std::optional<std::uint64_t> PlanOrders::job_of(const std::string& id) const {
  for (const auto& [job, order] : orders_)
    if (order.id == id) return job;
  return std::nullopt;
}

bool PlanOrders::may_ask(std::uint64_t job) const {
  return orders_.size() < kMost && !orders_.contains(job) && !own_.contains(job);
}

void PlanOrders::ask(std::uint64_t job, const std::string& name, Time now) {
  orders_[job] = {make_uuid(), name, {}, now, now};
}

std::optional<std::string> PlanOrders::hear(const std::string& id, const PlanStanding& standing, Time now) {
  const auto job = job_of(id);
  if (!job || orders_[*job].back) return std::nullopt;
  if (standing.state == PlanState::kFailed) {
    refuse(*job);
    return standing.note;
  }
  Order& order = orders_[*job];
  const bool was_taken = order.standing.state == PlanState::kTaken;
  if (was_taken && standing.state == PlanState::kOpen) order.since = now;  // for whoever else helps
  order.standing = standing;
  order.heard = now;
  return std::nullopt;
}

void PlanOrders::take_back(const std::string& id, const std::string& helper) {
  Order& order = orders_[*job_of(id)];
  order.standing.state = PlanState::kDone;
  order.standing.helper = helper;
  order.back = true;
}

void PlanOrders::hear_helpers(bool idle, Time now) {
  idle_helpers_ = idle;
  heard_helpers_ = now;
}

void PlanOrders::refuse(std::uint64_t job) {
  orders_.erase(job);
  own_.insert(job);
}

void PlanOrders::forget(std::uint64_t job) {
  orders_.erase(job);
  own_.erase(job);
}

bool PlanOrders::is_over(const Order& order, bool busy, Time now) const {
  if (order.back) return false;
  if (order.standing.state == PlanState::kTaken) return now - order.heard > kSilent;
  if (!busy) return true;
  // What was heard before it stood there says nothing of who has taken it since.
  const bool told = heard_helpers_ && *heard_helpers_ >= order.since;
  if (told && !idle_helpers_) return true;
  return now - order.since > (told ? kUntaken : kUnheard);
}

}  // namespace tiltfeed::daemon
