#include "pathgen/indexed/index_order.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace tiltfeed::pathgen {

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

namespace {

std::vector<std::uint32_t> exact_order(const std::vector<Vec3>& directions, Vec3 up) {
  const auto count = static_cast<std::uint32_t>(directions.size());
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

/// From `up` on.
double travel_of(const std::vector<std::uint32_t>& order, const std::vector<Vec3>& directions, Vec3 up) {
  double sum = 0.0;
  Vec3 at = up;
  for (const std::uint32_t i : order)
    sum += rotary_travel(at, directions[i], up).radians(), at = directions[i];
  return sum;
}

/// The nearest next each time; then stretches turned round and directions moved while that helps.
std::vector<std::uint32_t> good_order(const std::vector<Vec3>& directions, Vec3 up) {
  constexpr double kGain = 1e-9;  // rad
  std::vector<std::uint32_t> left(directions.size()), order;
  std::iota(left.begin(), left.end(), 0u);
  for (Vec3 at = up; !left.empty(); at = directions[order.back()]) {
    const auto next = std::min_element(left.begin(), left.end(), [&](std::uint32_t a, std::uint32_t b) {
      return rotary_travel(at, directions[a], up) < rotary_travel(at, directions[b], up);
    });
    order.push_back(*next);
    left.erase(next);
  }
  double best = travel_of(order, directions, up);
  const auto take = [&](const std::vector<std::uint32_t>& other) {
    const double sum = travel_of(other, directions, up);
    if (sum >= best - kGain) return false;
    order = other, best = sum;
    return true;
  };
  for (bool better = true; better;) {
    better = false;
    for (std::size_t i = 0; i < order.size(); ++i)
      for (std::size_t k = 0; k < order.size(); ++k) {
        std::vector<std::uint32_t> other = order;
        if (i < k) {
          std::reverse(other.begin() + static_cast<std::ptrdiff_t>(i),
                       other.begin() + static_cast<std::ptrdiff_t>(k) + 1);
          better |= take(other);
          other = order;
        }
        const std::uint32_t moved = other[i];
        other.erase(other.begin() + static_cast<std::ptrdiff_t>(i));
        other.insert(other.begin() + static_cast<std::ptrdiff_t>(k), moved);
        better |= take(other);
      }
  }
  return order;
}

}  // namespace

std::vector<std::uint32_t> order_by_travel(const std::vector<Vec3>& directions, Vec3 up) {
  assert(directions.size() <= kMostDirections);
  if (directions.empty()) return {};
  return directions.size() <= kMostExact ? exact_order(directions, up) : good_order(directions, up);
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

}  // namespace tiltfeed::pathgen
