#include "daemon/protocol/position_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "daemon/program/numeric_block.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr int kPrinted = 3;

/// Codes that change neither places nor ways: planes, units and modes that a program begins with.
bool changes_nothing(double code) {
  constexpr double kPlain[] = {4, 17, 18, 19, 21, 40, 49, 54, 61, 61.1, 64, 80, 91.1, 93, 94, 95, 96, 97};
  return std::find(std::begin(kPlain), std::end(kPlain), code) != std::end(kPlain);
}

}  // namespace

PositionWatch::PositionWatch(const PositionLimits& limits)
    : limits_(limits), from_(no_axes()), at_(no_axes()) {}

void PositionWatch::begin(const AxisValues& at) {
  steps_.clear();
  from_ = at_ = at;
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (limits_.modulo[i]) from_[i] = at_[i] = kUnknown;
  lost_ = relative_ = arc_ = false;
}

/// False where nothing is known of what comes after it.
bool PositionWatch::take_code(double code) {
  if (code == 90.0 || code == 91.0) relative_ = code == 91.0;
  if (code == 0.0 || code == 1.0) arc_ = false;
  if (code == 2.0 || code == 3.0) arc_ = true;
  if (code == 28.0 || code == 30.0) home_ = true;
  if (home_ || code == 53.0) own_place_ = true;
  return code == 90.0 || code == 91.0 || (code >= 0.0 && code <= 3.0) || code == 28.0 || code == 30.0 ||
         code == 53.0 || changes_nothing(code);
}

void PositionWatch::push(std::uint64_t number, std::string_view text) {
  if (lost_) return;
  AxisValues words = no_axes();
  own_place_ = home_ = false;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::optional<GcodeWord> word = take_word(rest);
    if (!word || (word->letter == 'G' && !take_code(word->value))) {
      lost_ = true;
      return steps_.clear();
    }
    const std::size_t axis = kAxisLetters.find(word->letter);
    if (axis != kAxisLetters.npos && !limits_.modulo[axis]) words[axis] = word->value;
  }
  // G28, G30 and G53 lead to the machine's own places: where these are is not known.
  bool any = false;
  for (std::size_t i = 0; i < kMostAxes; ++i) {
    if (std::isnan(words[i])) continue;
    any = true;
    at_[i] = own_place_ ? kUnknown : relative_ ? at_[i] + words[i] : words[i];
  }
  if (own_place_ && !any) at_ = no_axes();
  steps_.push_back({number, at_, home_ || arc_});
}

void PositionWatch::executed(std::uint64_t number) {
  while (!steps_.empty() && steps_.front().number <= number) {
    from_ = steps_.front().to;
    steps_.pop_front();
  }
}

void PositionWatch::unsettle() {
  from_ = at_ = no_axes();
  for (Step& step : steps_) step.to = no_axes();
}

double PositionWatch::allowed(std::size_t axis, double rounding) const {
  return (is_linear_axis(axis) ? limits_.tolerance.mm : limits_.tolerance.deg) + rounding;
}

/// All axes move linearly together: one share of the way must fit every axis.
bool PositionWatch::passes(const AxisValues& from, const Step& step, const AxisValues& at,
                           double rounding) const {
  if (step.free) return true;
  double first = 0.0, last = 1.0;
  for (std::size_t i = 0; i < kMostAxes; ++i) {
    if (std::isnan(at[i]) || std::isnan(step.to[i]) || std::isnan(from[i])) continue;
    const double way = step.to[i] - from[i], left = at[i] - from[i], off = allowed(i, rounding);
    if (left < std::min(0.0, way) - off || left > std::max(0.0, way) + off) return false;
    if (std::abs(way) <= off) continue;
    const double a = (left - off) / way, b = (left + off) / way;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first <= last;
}

std::string PositionWatch::judge(const AxisValues& at, double rounding) const {
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (at[i] < limits_.low[i] - allowed(i, rounding) || at[i] > limits_.high[i] + allowed(i, rounding))
      return std::string(1, kAxisLetters[i]) + decimal(at[i], kPrinted) +
             " is beyond the machine's travel (" + decimal(limits_.low[i], kPrinted) + " to " +
             decimal(limits_.high[i], kPrinted) + ")";
  if (lost_) return "";
  if (steps_.empty()) return passes(from_, {0, from_, false}, at, rounding) ? "" : "no line leads there";
  const AxisValues* from = &from_;
  for (const Step& step : steps_) {
    if (passes(*from, step, at, rounding)) return "";
    from = &step.to;
  }
  return "no line that may be in execution (" + std::to_string(steps_.front().number) + " to " +
         std::to_string(steps_.back().number) + ") leads there";
}

bool PositionWatch::knows_end() const {
  return !lost_ && std::any_of(at_.begin(), at_.end(), [](double one) { return !std::isnan(one); });
}

bool PositionWatch::at_end(const AxisValues& at, double rounding) const {
  return passes(at_, {0, at_, false}, at, rounding);
}

LineRange PositionWatch::lines_at(const AxisValues& at, double rounding) const {
  LineRange range;
  const AxisValues* from = &from_;
  for (const Step& step : steps_) {
    if (passes(*from, step, at, rounding)) {
      if (range.first == 0) range.first = step.number;
      range.last = step.number;
    }
    from = &step.to;
  }
  return range;
}

}  // namespace tiltfeed::daemon
