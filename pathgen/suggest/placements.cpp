#include "pathgen/suggest/placements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kinematics/basics/units.h"
#include "pathgen/fit/least_squares.h"

namespace tiltfeed::pathgen {

namespace {

const std::array<Vec3, 6> kSides{Vec3{0, 0, 1}, Vec3{1, 0, 0},  Vec3{-1, 0, 0},
                                 Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{0, 0, -1}};
/// Points above and below the part: so many sizes of it from its middle.
constexpr double kFar[] = {0.75, 1.5};
/// A line or circle tries so many places for its seam.
constexpr int kAzimuths = 24;
/// So near (rad) to seam or pole counts.
constexpr double kNearSeam = 0.08;

Vec3 any_square_to(Vec3 axis) {
  const double x = std::abs(axis.x), y = std::abs(axis.y), z = std::abs(axis.z);
  const Vec3 pick = x <= y && x <= z ? Vec3{1, 0, 0} : z <= y ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
  return normalized(pick - axis * dot(pick, axis));
}

/// Fitted numbers are told to this, mm and rad.
constexpr double kNeatLength = 1e-3, kNeatAngle = 2e-5;

struct Inertia {
  Point<Part> middle;
  std::array<Vec3, 3> axes;
};
Inertia inertia_of(std::span<const ReachPlace> places) {
  Vec3 sum;
  double area = 0.0;
  for (const ReachPlace& p : places) sum = sum + from_origin(p.place) * p.area, area += p.area;
  const Vec3 middle = sum / area;
  std::array<double, 9> spread{};
  for (const ReachPlace& p : places) {
    const Vec3 v = from_origin(p.place) - middle;
    const std::array<double, 3> c{v.x, v.y, v.z};
    for (std::size_t i = 0; i < 9; ++i) spread[i] += p.area * c[i / 3] * c[i % 3];
  }
  const EigenPairs pairs = eigen_pairs(spread, 3);
  Inertia inertia{Point<Part>{} + middle, {}};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 v{pairs.vectors[k][0], pairs.vectors[k][1], pairs.vectors[k][2]};
    const double x = std::abs(v.x), y = std::abs(v.y), z = std::abs(v.z);
    const double largest = x >= y && x >= z ? v.x : y >= z ? v.y : v.z;
    inertia.axes[k] = largest < 0.0 ? -v : v;
  }
  return inertia;
}

/// How much of the cut area lies near the seam or a pole.
double near_seam(const AxisFrame& frame, std::span<const ReachPlace> cut) {
  const Deformation map(frame, 1.0);
  double area = 0.0;
  for (const ReachPlace& p : cut) {
    const Point<Flat> at = map.flatten(p.place);
    const double theta = frame.mode == AxisMode::kLine ? at.y / map.scale_y() : at.x / map.scale_x();
    const bool pole =
        frame.mode == AxisMode::kPoint && std::abs(at.y / map.scale_y()) > kPi / 2.0 - 2.0 * kNearSeam;
    if (pole || std::abs(theta) > kPi - kNearSeam) area += p.area;
  }
  return area;
}

double to_step(double v, double step) { return step > 0.0 ? std::round(v / step) * step + 0.0 : v; }

}  // namespace

AxisFrame frame_about(AxisMode mode, Sense sense, Point<Part> origin, Vec3 axis, double radius) {
  AxisFrame frame{mode, sense, origin, {1, 0, 0}, {0, 0, 1}, mode == AxisMode::kCircle ? radius : 0.0};
  if (mode == AxisMode::kLine)
    frame.t = axis, frame.n = any_square_to(axis);
  else if (mode == AxisMode::kFixed)
    frame.n = axis, frame.t = any_square_to(axis);
  else if (mode == AxisMode::kCircle)
    frame.t = any_square_to(axis), frame.n = cross(axis, frame.t);
  return frame;
}

Vec3 axis_of(const AxisFrame& frame) {
  if (frame.mode == AxisMode::kLine) return frame.t;
  return frame.mode == AxisMode::kCircle ? cross(frame.t, frame.n) : frame.n;
}

std::vector<Placement> first_placements(std::span<const Feature> features, const Box& bounds,
                                        std::span<const ReachPlace> places) {
  std::vector<Placement> all;
  const double size = distance(bounds.min, bounds.max);
  const auto both = [&](AxisMode mode, Point<Part> at, Vec3 axis, double radius, const char* source,
                        double rms = 0.0) {
    for (const Sense sense : {Sense::kOutward, Sense::kInward})
      all.push_back({frame_about(mode, sense, at, axis, radius), source, rms});
  };
  for (const Feature& f : features) {
    Point<Part> at = f.centre;
    // Along its line a feature may lie anywhere: next to the part's zero, if that is near.
    if (f.mode == AxisMode::kLine) {
      const Point<Part> next = at - f.axis * dot(from_origin(at), f.axis);
      if (distance(next, lerp(bounds.min, bounds.max, 0.5)) < 2.0 * size) at = next;
    }
    const AxisFrame neat =
        rounded(frame_about(f.mode, Sense::kOutward, at, f.axis, f.radius), kNeatLength, kNeatAngle);
    both(f.mode, neat.origin, axis_of(neat), neat.circle_radius, "fitted", f.rms);
  }
  const Point<Part> middle = lerp(bounds.min, bounds.max, 0.5);
  for (const Vec3 side : kSides)
    all.push_back({frame_about(AxisMode::kFixed, Sense::kOutward, {}, side, 0.0), "box"});
  const Inertia inertia = inertia_of(places);
  both(AxisMode::kPoint, middle, {0, 0, 1}, 0.0, "box");
  both(AxisMode::kPoint, inertia.middle, {0, 0, 1}, 0.0, "inertia");
  for (const Vec3 side : kSides)
    for (const double far : kFar) both(AxisMode::kPoint, middle + side * (far * size), {0, 0, 1}, 0.0, "box");
  for (const Vec3 axis : {kSides[0], kSides[1], kSides[3]}) both(AxisMode::kLine, middle, axis, 0.0, "box");
  for (const Vec3 axis : {kSides[0], kSides[1], kSides[3]})
    both(AxisMode::kLine, inertia.middle, axis, 0.0, "inertia");
  for (const Vec3 axis : inertia.axes) both(AxisMode::kLine, inertia.middle, axis, 0.0, "inertia");
  for (const Vec3 axis : {kSides[0], kSides[1], kSides[3]}) {
    const Vec3 half = (bounds.max - bounds.min) / 2.0, flat = half - axis * dot(half, axis);
    for (const double share : {0.4, 0.8})
      both(AxisMode::kCircle, middle, axis, share * length(flat) / std::sqrt(2.0), "box");
  }
  return all;
}

AxisFrame well_turned(AxisFrame frame, std::span<const ReachPlace> cut) {
  if (cut.empty() || frame.mode == AxisMode::kFixed) return frame;
  Vec3 sum;
  for (const ReachPlace& p : cut) {
    const Vec3 from = p.place - frame.origin;
    if (squared_length(from) > 0.0) sum = sum + normalized(from) * p.area;
  }
  AxisFrame best = frame;
  double least = std::numeric_limits<double>::infinity(), most = 0.0, whole = 0.0;
  for (const ReachPlace& p : cut) whole += p.area;
  const auto offer = [&](Vec3 n, Vec3 t) {
    AxisFrame turned = frame;
    turned.n = n, turned.t = t;
    const double area = near_seam(turned, cut), towards = dot(n, sum);
    if (area < least - 1e-3 * whole || (area < least + 1e-3 * whole && towards > most + 1e-6 * length(sum)))
      best = turned, least = std::min(area, least), most = towards;
  };
  if (frame.mode == AxisMode::kPoint) {
    for (const Vec3 n : kSides)
      for (const Vec3 t : kSides)
        if (dot(n, t) == 0.0) offer(n, t);
    return best;
  }
  const Vec3 axis = axis_of(frame), u = any_square_to(axis), v = cross(axis, u);
  for (int k = 0; k < kAzimuths; ++k) {
    const double turn = 2.0 * kPi * k / kAzimuths;
    const Vec3 n = u * std::cos(turn) + v * std::sin(turn);
    offer(n, frame.mode == AxisMode::kLine ? frame.t : cross(n, axis));
  }
  return best;
}

AxisFrame rounded(AxisFrame frame, double length_step, double angle) {
  const auto snapped = [&](Vec3 axis) {
    for (const Vec3 side : kSides)
      if (angle_between(side, axis) <= angle) return side;
    return axis;
  };
  frame.origin = {to_step(frame.origin.x, length_step), to_step(frame.origin.y, length_step),
                  to_step(frame.origin.z, length_step)};
  if (frame.mode == AxisMode::kPoint) return frame;
  return frame_about(frame.mode, frame.sense, frame.origin, snapped(axis_of(frame)),
                     std::max(length_step, to_step(frame.circle_radius, length_step)));
}

}  // namespace tiltfeed::pathgen
