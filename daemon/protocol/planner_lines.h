#pragma once
// The newest lines that a firmware has answered and may still have in its planner. Pure.

#include <cstdint>
#include <deque>
#include <optional>
#include <string_view>

#include "daemon/protocol/session.h"
#include "daemon/wire/axis_values.h"
#include "daemon/wire/position_limits.h"

namespace tiltfeed::daemon {

/// An answered line that moves holds a block of the planner until it has run. One that moves by less than a
/// step holds none, and what a step is only the controller knows; the profile's tolerance is at least one. So
/// a line counts as a block when it leads further than the tolerance from where the one before it that
/// counted led. The others may hold a block, too, and never push an older one out.
class PlannerLines {
 public:
  explicit PlannerLines(const PositionLimits& limits) : limits_(limits) {}

  /// A line was answered. Those that no planner of `depth` blocks can still hold are forgotten, and told to
  /// `ran`, oldest first.
  template <class Ran>
  void settle(std::uint64_t number, std::string_view text, std::size_t depth, const Ran& ran) {
    lines_.push_back(read(number, text));
    blocks_ += lines_.back().block;
    while (!lines_.empty() && (blocks_ > depth || !lines_.front().moves)) {
      ran(lines_.front().number);
      forget_oldest();
    }
  }
  void forget_oldest();
  /// The newest was not answered after all.
  void take_back();
  void clear();

  bool empty() const { return lines_.empty(); }
  std::size_t size() const { return lines_.size(); }
  std::uint64_t number(std::size_t place) const { return lines_[place].number; }
  std::uint64_t first() const { return lines_.front().number; }
  std::uint64_t last() const { return lines_.back().number; }
  /// How many lines stand before `number`; nothing where it is not among them.
  std::optional<std::size_t> before(std::uint64_t number) const;

 private:
  struct Settled {
    std::uint64_t number = 0;
    bool moves = false;  // it may hold a block
    bool block = false;  // it has held one
  };

  Settled read(std::uint64_t number, std::string_view text);
  bool leads_on() const;

  PositionLimits limits_;
  std::deque<Settled> lines_;  // oldest first
  std::size_t blocks_ = 0;
  AxisValues at_ = no_axes(),
             counted_ = no_axes();  // where the newest line leads, and the newest that counted
  bool relative_ = false;
};

}  // namespace tiltfeed::daemon
