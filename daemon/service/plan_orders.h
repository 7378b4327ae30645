#pragma once
// Jobs whose plans other services are asked for. Pure: it knows neither files nor clocks.

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "daemon/shop/shop_plans.h"

namespace tiltfeed::daemon {

/// Properties: 1 A job of which something went wrong is asked for no more: it is planned here. 2 What is
/// heard of an order that is none of these changes nothing.
class PlanOrders {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// A machine that is at work waits so long to hear whether somebody idle is there, and plans by itself
  /// then.
  static constexpr std::chrono::seconds kUnheard{15};
  /// Likewise where somebody idle is there, who takes others' orders first.
  static constexpr std::chrono::seconds kUntaken{60};
  /// Of an order that was taken nothing is heard for so long: the database is away.
  static constexpr std::chrono::seconds kSilent{90};
  static constexpr std::size_t kMost = 8;

  struct Order {
    std::string id, name;
    PlanStanding standing;
    Time since, heard;
    bool back = false;  ///< what came back is being proved
  };

  /// Nothing: the job is no order.
  const Order* of(std::uint64_t job) const;
  std::optional<std::uint64_t> job_of(const std::string& id) const;
  const std::map<std::uint64_t, Order>& all() const { return orders_; }
  bool may_ask(std::uint64_t job) const;
  /// Requires: may_ask(job).
  void ask(std::uint64_t job, const std::string& name, Time now);
  /// It is taken, open, or has failed, whose reason is returned: it is none of these then.
  std::optional<std::string> hear(const std::string& id, const PlanStanding& standing, Time now);
  /// Requires: job_of(id).
  void take_back(const std::string& id, const std::string& helper);
  /// Whether an idle machine is there that would take an order.
  void hear_helpers(bool idle, Time now);
  /// It is planned here, this time and after.
  void refuse(std::uint64_t job);
  /// The job is gone, or is planned.
  void forget(std::uint64_t job);
  /// Nobody has taken it, and this machine is idle or nobody else is. Or nobody knows any more who has it.
  /// `busy`: this machine is at work, and would rather not plan.
  bool is_over(const Order& order, bool busy, Time now) const;

 private:
  std::map<std::uint64_t, Order> orders_;  ///< by job
  std::set<std::uint64_t> own_;            ///< jobs that are planned here
  std::optional<Time> heard_helpers_;
  bool idle_helpers_ = false;
};

}  // namespace tiltfeed::daemon
