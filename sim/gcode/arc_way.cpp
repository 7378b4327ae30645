#include "sim/gcode/arc_way.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::sim {
namespace {

constexpr double kCircle = 2.0 * std::numbers::pi;
constexpr int kMostPieces = 100'000;
// A place that differs by less is the same, mm.
constexpr double kSamePlace = 1e-9;
constexpr int kShown = 4;

constexpr std::array<ArcPlane, 3> kPlanes{
    {{&Joints::x, &Joints::y, &Joints::z, {'X', 'Y', 'Z'}, {'I', 'J', 'K'}},
     {&Joints::z, &Joints::x, &Joints::y, {'Z', 'X', 'Y'}, {'K', 'I', 'J'}},
     {&Joints::y, &Joints::z, &Joints::x, {'Y', 'Z', 'X'}, {'J', 'K', 'I'}}}};

}  // namespace

const ArcPlane& arc_plane(int plane) { return kPlanes[static_cast<std::size_t>(plane - 17)]; }

std::optional<std::string> arc_is_wrong(const Joints& from, const Joints& to, const ArcWords& words) {
  const ArcPlane& plane = arc_plane(words.plane);
  const auto far = [&](const Joints& at) {
    return std::hypot(at.*plane.first - words.first, at.*plane.second - words.second);
  };
  const double start = far(from), end = far(to);
  if (!(start > kArcRadiusError)) return "the arc has no radius: is its centre lost?";
  if (!(std::abs(end - start) <= kArcRadiusError))
    return "the arc begins " + decimal(start, kShown) + " mm from its centre and ends " +
           decimal(end, kShown) + " mm from it: is its centre, its plane or the block before it lost?";
  if (std::hypot(to.*plane.first - from.*plane.first, to.*plane.second - from.*plane.second) < kSamePlace)
    return "a full circle in one block is not understood";
  if (std::abs(to.*plane.third - from.*plane.third) > kSamePlace)
    return std::string("an arc that also moves ") + plane.letters[2] + " is not understood";
  if (to.a != from.a || to.c != from.c) return "an arc in which a rotary turns is not understood";
  return std::nullopt;
}

ArcWay::ArcWay(const Joints& from, const Joints& to, const ArcWords& words)
    : plane_(arc_plane(words.plane)), from_(from), to_(to), first_(words.first), second_(words.second) {
  const double u0 = from.*plane_.first - first_, v0 = from.*plane_.second - second_,
               u1 = to.*plane_.first - first_, v1 = to.*plane_.second - second_;
  radius_ = std::hypot(u0, v0);
  growth_ = std::hypot(u1, v1) - radius_;
  begin_ = std::atan2(v0, u0);
  sweep_ = std::atan2(v1, u1) - begin_;
  if (words.clockwise && sweep_ >= 0.0) sweep_ -= kCircle;
  if (!words.clockwise && sweep_ <= 0.0) sweep_ += kCircle;
}

Joints ArcWay::at(double share) const {
  if (share >= 1.0) return to_;
  Joints at = from_;
  const double angle = begin_ + share * sweep_, radius = radius_ + share * growth_;
  at.*plane_.first = first_ + radius * std::cos(angle);
  at.*plane_.second = second_ + radius * std::sin(angle);
  return at;
}

/// A chord of an arc of angle t leaves it by r (1 - cos(t / 2)), at most r t^2 / 8.
int ArcWay::pieces() const {
  const double most = std::sqrt(8.0 * kArcChord / (radius_ + std::abs(growth_)));
  return static_cast<int>(std::clamp(std::ceil(turn() / most), 1.0, static_cast<double>(kMostPieces)));
}

double ArcWay::length() const { return turn() * (radius_ + 0.5 * growth_); }
double ArcWay::turn() const { return std::abs(sweep_); }

}  // namespace tiltfeed::sim
