#pragma once
// The axes as a controller reports them against the blocks that may be in execution: a machine that is where
// no block leads has read another program than the one that was sent. Pure.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/protocol/session.h"
#include "daemon/wire/axis_values.h"
#include "daemon/wire/position_limits.h"

namespace tiltfeed::daemon {

/// Properties: a place is told as wrong only where every axis of it is known and no block between the oldest
/// that may be in execution and the newest that was pushed passes within the tolerance of it. A word that is
/// not understood (arcs aside, whose ways are not looked at) ends the comparison for good.
class PositionWatch {
 public:
  explicit PositionWatch(const PositionLimits& limits);

  /// The program begins: the axes stand there.
  void begin(const AxisValues& at);
  /// A line that will be sent after those before it.
  void push(std::uint64_t number, std::string_view text);
  /// Lines up to `number` have run.
  void executed(std::uint64_t number);
  /// The operator may have moved the axes, or the offsets have changed: no place is known before it is stated
  /// again.
  void unsettle();

  /// What is wrong with a reported place, "" where nothing is. `rounding`: of the report.
  std::string judge(const AxisValues& at, double rounding) const;
  /// Where the newest line leads to, as far as it is known.
  const AxisValues& end() const { return at_; }
  /// Some axis that the program has moved has a known end.
  bool knows_end() const;
  /// `at` is that end.
  bool at_end(const AxisValues& at, double rounding) const;
  /// Numbers of the first and the last line that may be in execution and pass there; 0, 0: none is known to.
  LineRange lines_at(const AxisValues& at, double rounding) const;

 private:
  struct Step {
    std::uint64_t number = 0;
    AxisValues to;
    bool free = false;  // the way to its end is not known
  };

  double allowed(std::size_t axis, double rounding) const;
  bool passes(const AxisValues& from, const Step& step, const AxisValues& at, double rounding) const;
  bool take_code(double code);

  PositionLimits limits_;
  std::deque<Step> steps_;  // the oldest may be in execution
  AxisValues from_, at_;    // before the oldest, after the newest
  bool lost_ = false, relative_ = false, arc_ = false;
  bool own_place_ = false, home_ = false;  // the line that is read leads to a place of the machine's; by way
                                           // of another one
};

}  // namespace tiltfeed::daemon
