#include "daemon/protocol/planner_lines.h"

#include <algorithm>
#include <cmath>

#include "daemon/program/numeric_block.h"

namespace tiltfeed::daemon {

namespace {

/// A full circle may state nothing else.
constexpr std::string_view kArcLetters = "IJKR";

/// Codes after which an axis word means the same place as before.
bool keeps_places(double code) {
  constexpr double kKeeping[] = {0,  1,  2,  3,  4,    17, 18, 19, 40, 61, 61.1,
                                 64, 80, 90, 91, 91.1, 93, 94, 95, 96, 97};
  return std::find(std::begin(kKeeping), std::end(kKeeping), code) != std::end(kKeeping);
}

}  // namespace

PlannerLines::Settled PlannerLines::read(std::uint64_t number, std::string_view text) {
  Settled line{number, false, false};
  AxisValues words = no_axes();
  bool known = true;
  for (std::string_view rest = text; !rest.empty();) {
    const std::optional<GcodeWord> word = take_word(rest);
    if (word && word->letter == 'G') {
      if (word->value == 90.0 || word->value == 91.0) relative_ = word->value == 91.0;
      line.moves = line.moves || word->value == 28.0 || word->value == 30.0;
      known = known && keeps_places(word->value);
    } else if (word) {
      const std::size_t axis = kAxisLetters.find(word->letter);
      if (axis != kAxisLetters.npos) words[axis] = word->value;
      line.moves =
          line.moves || axis != kAxisLetters.npos || kArcLetters.find(word->letter) != kArcLetters.npos;
    } else {
      line.moves = true;
      known = false;
      break;
    }
  }
  if (!known) {
    at_ = counted_ = no_axes();
    return line;
  }
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (!std::isnan(words[i])) at_[i] = (relative_ && !std::isnan(at_[i]) ? at_[i] : 0.0) + words[i];
  line.block = leads_on();
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (line.block || std::isnan(counted_[i])) counted_[i] = at_[i];
  return line;
}

bool PlannerLines::leads_on() const {
  for (std::size_t i = 0; i < kMostAxes; ++i) {
    const double step = is_linear_axis(i) ? limits_.tolerance.mm : limits_.tolerance.deg;
    if (!limits_.modulo[i] && std::abs(at_[i] - counted_[i]) > step) return true;
  }
  return false;
}

void PlannerLines::forget_oldest() {
  blocks_ -= lines_.front().block;
  lines_.pop_front();
}

void PlannerLines::take_back() {
  if (lines_.empty()) return;
  blocks_ -= lines_.back().block;
  lines_.pop_back();
}

void PlannerLines::clear() {
  lines_.clear();
  blocks_ = 0;
}

std::optional<std::size_t> PlannerLines::before(std::uint64_t number) const {
  const auto found =
      std::lower_bound(lines_.begin(), lines_.end(), number,
                       [](const Settled& line, std::uint64_t wanted) { return line.number < wanted; });
  if (found == lines_.end() || found->number != number) return std::nullopt;
  return static_cast<std::size_t>(found - lines_.begin());
}

}  // namespace tiltfeed::daemon
