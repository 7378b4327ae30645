#include "pathgen/free_axis/axis_evening.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tiltfeed::pathgen {

namespace {

/// How often directions are evened out between their neighbours.
constexpr int kRounds = 6;
/// Directions that would turn by less than this (rad) are even.
constexpr double kEven = 0.005;
/// A turn is spread over at most so many times the way that it needs at the limit.
constexpr double kWidestSpread = 6.0;
/// Turns are spread to this share of the limit: rounding.
constexpr double kWithinLimit = 0.9999;

/// Turns are told to this, rad.
constexpr double kRounding = 1e-9;

double share(const AxisStretch& s, std::size_t i) {
  const double before = i > 0 ? s[i].way - s[i - 1].way : 0.0;
  const double after = i + 1 < s.size() ? s[i + 1].way - s[i].way : 0.0;
  return (before + after) / 2.0;
}

bool turn_allowed(const AxisAt& a, Vec3 axis, const AxisAt& b, double max_turn) {
  return angle_between(axis, b.axis) <= max_turn * std::abs(b.way - a.way) + kRounding;
}

/// With the axis of station i changed.
bool turns_allowed(const AxisStretch& s, std::size_t i, Vec3 axis, double max_turn) {
  return (i == 0 || turn_allowed(s[i], axis, s[i - 1], max_turn)) &&
         (i + 1 == s.size() || turn_allowed(s[i], axis, s[i + 1], max_turn));
}

/// The axes strictly between stations a and b on the great circle from one to the other, if all are
/// admissible.
bool spread(AxisStretch& s, std::size_t a, std::size_t b, const Admissibility& admissible,
            DirectionQuery& query) {
  std::vector<Vec3> axes;
  for (std::size_t i = a + 1; i < b; ++i) {
    axes.push_back(slerp(s[a].axis, s[b].axis, (s[i].way - s[a].way) / (s[b].way - s[a].way)));
    if (!admissible.admits(s[i].point, axes.back(), query)) return false;
  }
  for (std::size_t i = a + 1; i < b; ++i) s[i].axis = axes[i - a - 1];
  return true;
}

/// Spreads the turn from station i to the next; false: it cannot be.
bool spread_turn(AxisStretch& s, std::size_t i, double max_turn, const Admissibility& admissible,
                 DirectionQuery& query) {
  const double widest = kWidestSpread * angle_between(s[i].axis, s[i + 1].axis) / max_turn;
  std::size_t a = i, b = i + 1;
  while (a > 0 || b + 1 < s.size()) {
    // To the nearer side.
    const bool back = a > 0 && (b + 1 == s.size() || s[i].way - s[a - 1].way <= s[b + 1].way - s[i + 1].way);
    if (back)
      --a;
    else
      ++b;
    const double way = s[b].way - s[a].way;
    if (way > widest) return false;
    if (angle_between(s[a].axis, s[b].axis) <= kWithinLimit * max_turn * way &&
        spread(s, a, b, admissible, query))
      return true;
  }
  return false;
}

}  // namespace

void even_out(AxisStretch& s, const EveningLimits& limits, const Admissibility& admissible,
              DirectionQuery& query) {
  if (std::all_of(s.begin(), s.end(), [](const AxisAt& at) { return at.is_wish; })) return;
  const double turn_price = limits.scale * limits.scale;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < s.size(); ++i) {
      // The least of the costs of (O3), to the second order, with the neighbours held.
      Vec3 pull = s[i].wished * share(s, i);
      if (i > 0) pull = pull + s[i - 1].axis * (turn_price / (s[i].way - s[i - 1].way));
      if (i + 1 < s.size()) pull = pull + s[i + 1].axis * (turn_price / (s[i + 1].way - s[i].way));
      if (squared_length(pull) < 1e-12) continue;
      const Vec3 aim = normalized(pull);
      for (const double part : {1.0, 0.5, 0.25}) {
        const Vec3 axis = slerp(s[i].axis, aim, part);
        if (angle_between(axis, s[i].axis) < kEven) break;
        if (!turns_allowed(s, i, axis, limits.max_turn)) continue;
        if (!admissible.admits(s[i].point, axis, query)) continue;
        s[i].axis = axis;
        break;
      }
    }
  }
}

std::vector<AxisStretch> spread_turns(AxisStretch s, const EveningLimits& limits,
                                      const Admissibility& admissible, DirectionQuery& query) {
  std::vector<AxisStretch> stretches;
  std::size_t begin = 0;
  const auto cut = [&](std::size_t end) {
    stretches.emplace_back(s.begin() + static_cast<std::ptrdiff_t>(begin),
                           s.begin() + static_cast<std::ptrdiff_t>(end));
    begin = end;
  };
  for (std::size_t i = 0; i + 1 < s.size(); ++i)
    if (!turn_allowed(s[i], s[i].axis, s[i + 1], limits.max_turn))
      spread_turn(s, i, limits.max_turn, admissible, query);
  for (std::size_t i = 0; i + 1 < s.size(); ++i)
    if (!turn_allowed(s[i], s[i].axis, s[i + 1], limits.max_turn)) cut(i + 1);
  cut(s.size());
  return stretches;
}

}  // namespace tiltfeed::pathgen
