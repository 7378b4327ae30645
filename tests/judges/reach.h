#pragma once
// Which places of a part a tool can touch, and in which directions, by brute force: the exact distances of
// sim/ and an own sampling of directions, nothing of the planner's.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "kinematics/basics/units.h"
#include "sim/solid/tool_solid.h"

namespace tiltfeed {
using namespace pathgen;

/// Unit vectors spread evenly over the sphere, each for the same solid angle [Swinbank, Purser 2006].
inline std::vector<Vec3> even_directions(int count) {
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  std::vector<Vec3> all;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    all.push_back({r * std::cos(golden * i), r * std::sin(golden * i), z});
  }
  return all;
}

struct ReachOptions {
  Cutter cutter;  ///< ball or taper ball
  double tolerance = 0.01;
  std::array<double, 3> clearance{};  ///< that cutter, shank and holder must keep, mm
  Vec3 up{0, 0, 1};
  Angle tilt_max = Angle::from_degrees(180.0);
  /// Of a direction against the surface's normal; past 90 degrees: where the ball touches an edge.
  Angle steepest = Angle::from_degrees(91.2);
  int directions = 800;  ///< on the whole sphere, besides the coordinate axes and each place's own normal
};

/// The room that a tool sweeps when it is drawn out along its axis by `way`: each part at least as wide as
/// what comes below it, and as much again above.
inline Cutter drawn_out(const Cutter& cutter, double way) {
  Cutter room = cutter;
  double widest = std::max(cutter.cutting_top_radius(), cutter.shank_radius());
  room.shank_diameter = 2.0 * widest;
  for (HolderStep& step : room.holder) {
    step.lower_diameter = std::max(step.lower_diameter, 2.0 * widest);
    step.upper_diameter = std::max(step.upper_diameter, step.lower_diameter);
    widest = step.upper_diameter / 2.0;
  }
  room.holder.push_back({2.0 * widest, 2.0 * widest, way});
  return room;
}

class Reach {
 public:
  /// `part` must outlive the object; the normals of its facets point outwards.
  Reach(const sim::PartDistance& part, const Box& bounds, const ReachOptions& options)
      : part_(part),
        options_(options),
        tool_(options.cutter),
        room_(drawn_out(options.cutter, distance(bounds.min, bounds.max))),
        radius_(options.cutter.radius()),
        directions_(even_directions(options.directions)) {
    for (const Vec3 d : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
      directions_.insert(directions_.end(), {d, -d});
    std::erase_if(directions_, [&](Vec3 d) { return !tilts(d); });
  }

  const std::vector<Vec3>& directions() const { return directions_; }
  double radius() const { return radius_; }

  bool tilts(Vec3 d) const {
    return options_.tilt_max.radians() >= kPi || angle_between(d, options_.up) <= options_.tilt_max.radians();
  }

  /// Where the ball's centre stands when it touches p, lifted along the normal by the tolerance at most so
  /// that it is free; none where it does not fit.
  std::optional<Point<Part>> seat(Point<Part> p, Vec3 normal) const {
    const Point<Part> high = p + normal * (radius_ + options_.tolerance);
    if (part_.nearest(high, radius_ - kRounding).facet != kNoFacet) return std::nullopt;
    const double down = part_.first_touch(high, -normal, radius_ - kRounding).value;
    return high - normal * std::clamp(down - kRounding, 0.0, options_.tolerance);
  }

  /// The whole tool stands free there with its axis in this direction and can be drawn out along it.
  bool admits(Point<Part> centre, Vec3 direction) const {
    const Pose pose{centre - direction * radius_, direction};
    for (int i = 2; i >= 0; --i) {
      const sim::ToolPart part = sim::kToolParts[i];
      if (blocked(tool_, pose, part, options_.clearance[i], 0) || blocked(room_, pose, part, 0.0, 1))
        return false;
    }
    return true;
  }

  /// A direction in which the ball may stand there, the first found; the normal and those near it are tried
  /// first.
  std::optional<Vec3> direction_at(Point<Part> centre, Vec3 normal) const {
    if (tilts(normal) && admits(centre, normal)) return normal;
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < directions_.size(); ++i) {
      const double facing = dot(directions_[i], normal);
      if (facing > std::cos(options_.steepest.radians())) order.emplace_back(-facing, i);
    }
    std::sort(order.begin(), order.end());
    for (const auto& [facing, i] : order)
      if (admits(centre, directions_[i])) return directions_[i];
    return std::nullopt;
  }

 private:
  bool blocked(const sim::ToolSolid& tool, const Pose& pose, sim::ToolPart part, double clearance,
               int which) const {
    std::uint32_t& hint = hints_[which][static_cast<int>(part)];
    const sim::Hit hit = tool.clearance(part_, pose, part, clearance - kRounding, hint);
    if (hit.facet != kNoFacet) hint = hit.facet;
    return hit.facet != kNoFacet;
  }

  /// Coordinates of a seat are off by their rounding, mm.
  static constexpr double kRounding = 1e-6;
  const sim::PartDistance& part_;
  ReachOptions options_;
  sim::ToolSolid tool_, room_;
  double radius_;
  std::vector<Vec3> directions_;
  mutable std::array<std::array<std::uint32_t, 3>, 2> hints_{
      {{kNoFacet, kNoFacet, kNoFacet}, {kNoFacet, kNoFacet, kNoFacet}}};
};

}  // namespace tiltfeed
