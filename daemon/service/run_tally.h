#pragma once
// What a run report counts while the run goes on.

#include <optional>

#include "daemon/protocol/session.h"

namespace tiltfeed::daemon {

/// Fed with each state of a run and with each order to hold; times are seconds on one clock, never backwards.
/// Properties: a hold counts once, from its first state to the first state after it, whoever holds; an order
/// to hold is answered by the first state in which the controller itself says that it holds. A stream tells
/// its state ten times a second, so times are up to 0.1 s too long.
class RunTally {
 public:
  void ask_hold(double now);
  void take(const SendState& state, double now);

  int holds() const { return holds_; }
  /// The one that lasts still not included.
  double held_seconds() const { return held_seconds_; }
  /// From the order to the controller's word; nothing: no order was answered.
  std::optional<double> slowest_hold() const { return slowest_hold_; }
  struct Percent {
    int least = 0, most = 0;
  };
  /// The feed override that was in force while blocks ran, as reported; nothing: the link does not tell.
  std::optional<Percent> feed_override() const { return feed_override_; }
  /// How long the controller had run out although blocks were left to send, each time up to one report too
  /// long; nothing: the link does not tell.
  std::optional<double> starved_seconds() const { return starved_seconds_; }

 private:
  int holds_ = 0;
  double held_seconds_ = 0.0;
  std::optional<double> held_since_, asked_, slowest_hold_, starved_since_, starved_seconds_;
  std::optional<Percent> feed_override_;
};

}  // namespace tiltfeed::daemon
