#include "pathgen/index_order.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace tiltfeed {

namespace {

/// Nearer to `up` than this (rad) a direction has no turn of its own.
constexpr double kPole = 1e-9;

/// A frame about `up`: any x across it.
struct About {
  Vec3 up, x, y;
  explicit About(Vec3 u) : up(u) {
    x = normalized(cross(std::abs(u.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0}, u));
    y = cross(up, x);
  }
  double tilt(Vec3 d) const { return angle_between(d, up); }
  bool has_turn(Vec3 d) const { return tilt(d) > kPole && tilt(d) < kPi - kPole; }
  double turn(Vec3 d) const { return std::atan2(dot(d, y), dot(d, x)); }
  Vec3 at(double tilt, double turn) const {
    return normalized(up * std::cos(tilt) + (x * std::cos(turn) + y * std::sin(turn)) * std::sin(tilt));
  }
};

/// Both ways round: -pi..pi.
double short_turn(double from, double to) { return std::remainder(to - from, 2.0 * kPi); }

}  // namespace

Angle rotary_travel(Vec3 from, Vec3 to, Vec3 up) {
  const About about(up);
  const double tilt = std::abs(about.tilt(to) - about.tilt(from));
  const bool turns = about.has_turn(from) && about.has_turn(to);
  const double turn = turns ? std::abs(short_turn(about.turn(from), about.turn(to))) : 0.0;
  return Angle::from_radians(std::max(tilt, turn));
}

std::vector<std::uint32_t> order_by_travel(const std::vector<Vec3>& directions, Vec3 up) {
  const auto count = static_cast<std::uint32_t>(directions.size());
  assert(count <= kMostDirections);
  if (count == 0) return {};
  const std::uint32_t whole = (1u << count) - 1;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  // least[done * count + last]: over all of `done`, ending at `last`.
  std::vector<double> least(static_cast<std::size_t>(whole + 1) * count, kNever);
  std::vector<std::uint32_t> before(least.size(), 0);
  std::vector<double> travel(static_cast<std::size_t>(count) * count);
  for (std::uint32_t i = 0; i < count; ++i) {
    least[(1u << i) * std::size_t{count} + i] = rotary_travel(up, directions[i], up).radians();
    for (std::uint32_t j = 0; j < count; ++j)
      travel[i * count + j] = rotary_travel(directions[i], directions[j], up).radians();
  }
  for (std::uint32_t done = 1; done <= whole; ++done)
    for (std::uint32_t last = 0; last < count; ++last) {
      const double so_far = least[done * std::size_t{count} + last];
      if (so_far == kNever) continue;
      for (std::uint32_t next = 0; next < count; ++next) {
        if ((done >> next & 1u) != 0) continue;
        const std::size_t at = (done | 1u << next) * std::size_t{count} + next;
        if (so_far + travel[last * count + next] < least[at])
          least[at] = so_far + travel[last * count + next], before[at] = last;
      }
    }
  const auto row = least.begin() + static_cast<std::ptrdiff_t>(whole * std::size_t{count});
  auto last = static_cast<std::uint32_t>(std::min_element(row, row + count) - row);
  std::vector<std::uint32_t> order;
  for (std::uint32_t done = whole; order.size() < count;) {
    order.push_back(last);
    const std::uint32_t previous = before[done * std::size_t{count} + last];
    done &= ~(1u << last), last = previous;
  }
  std::reverse(order.begin(), order.end());
  return order;
}

std::vector<Vec3> turns_between(Vec3 from, Vec3 to, Vec3 up, Angle step) {
  const About about(up);
  const double tilt_from = about.tilt(from), tilt_to = about.tilt(to);
  const double turn_from = about.has_turn(from) ? about.turn(from) : about.turn(to);
  const double turn_to = about.has_turn(to) ? about.turn(to) : turn_from;
  const double tilt = tilt_to - tilt_from, turn = short_turn(turn_from, turn_to);
  // Tilt and turn are square to each other: together no step is longer than this.
  const int steps = std::max(1, static_cast<int>(std::ceil(std::hypot(tilt, turn) / step.radians())));
  std::vector<Vec3> all{from};
  for (int k = 1; k < steps; ++k)
    all.push_back(about.at(tilt_from + tilt * k / steps, turn_from + turn * k / steps));
  all.push_back(to);
  return all;
}

}  // namespace tiltfeed
