#include "daemon/service/run_tally.h"

#include <algorithm>

namespace tiltfeed::daemon {

void RunTally::ask_hold(double now) {
  if (!asked_ && !held_since_) asked_ = now;
}

void RunTally::take(const SendState& state, double now) {
  const bool held = state.phase == Phase::kHold;
  if (held && !held_since_) ++holds_, held_since_ = now;
  if (!held && held_since_) held_seconds_ += now - *held_since_, held_since_.reset();
  if (asked_ && state.machine.starts_with("Hold")) {
    slowest_hold_ = std::max(slowest_hold_.value_or(0.0), now - *asked_);
    asked_.reset();
  }
  if (is_final(state.phase)) asked_.reset();
  if (starved_since_) *starved_seconds_ += now - *starved_since_;
  if (state.starved && !starved_seconds_) starved_seconds_ = 0.0;
  starved_since_ = state.starved.value_or(false) ? std::optional(now) : std::nullopt;
  if (state.phase != Phase::kRun || state.feed_override == 0) return;
  if (!feed_override_) feed_override_ = {state.feed_override, state.feed_override};
  feed_override_->least = std::min(feed_override_->least, state.feed_override);
  feed_override_->most = std::max(feed_override_->most, state.feed_override);
}

}  // namespace tiltfeed::daemon
