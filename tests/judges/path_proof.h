#pragma once
// Holds a planned path against the part by brute force: the exact distances of sim/ and nothing of the
// planner's but its map of directions. Dense poses along every move: cutter, shank and holder do not gouge,
// the cutter stays in contact, rapids keep clear.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "pathgen/plan/plan.h"
#include "sim/solid/tool_solid.h"

namespace tiltfeed {
using namespace pathgen;

struct Measured {
  std::size_t poses = 0, rapid_poses = 0;
  double gouge = 0.0, contact = 0.0, rapid_overlap = 0.0;
  std::array<double, 3> gouge_by{};  ///< cutter, shank, holder (sim::kToolParts)
  double plain_drop = 0.0;           ///< largest drop straight along the axis
  std::size_t plain_over = 0;        ///< poses whose drop straight along the axis is over the tolerance
  Pose gouge_at, contact_at, rapid_at;
};

inline Pose between(const Pose& a, const Pose& b, double f) {
  return {lerp(a.tip, b.tip, f), slerp(a.axis, b.axis, f)};
}

inline std::string pasteable(const Pose& p) {
  char text[256];
  std::snprintf(text, sizeof text, "Pose{{%.9f, %.9f, %.9f}, {%.12f, %.12f, %.12f}}", p.tip.x, p.tip.y,
                p.tip.z, p.axis.x, p.axis.y, p.axis.z);
  return text;
}

class PathProof {
 public:
  /// `checked` and `path` must outlive the proof. `growth`: the stock that shall stay.
  PathProof(const AxisFrame& axis, Along, const Cutter& cutter, double tolerance, const CheckedMesh& checked,
            const ToolPath& path, const sim::Growth& growth = {})
      : axis_(axis),
        tolerance_(tolerance),
        bounds_(checked.bounds),
        path_(path),
        part_(checked.mesh),
        tool_(cutter, growth),
        nose_(cutter.nose_radius()),
        map_(axis, 1.0) {}

  /// Poses on the whole path, `least_poses` or more of them on cutting moves; every `stride`th move.
  Measured measure(std::size_t least_poses, std::size_t stride = 1) const {
    Measured m;
    std::size_t cuts = 0;
    for (const Move& move : path_.moves) cuts += move.kind == MoveKind::kCut ? 1 : 0;
    const auto per_cut =
        static_cast<int>(std::max<std::size_t>(3, least_poses * stride / std::max<std::size_t>(cuts, 1) + 1));
    Hints hints{kNoFacet, kNoFacet, kNoFacet, kNoFacet};
    for (std::size_t i = 1; i < path_.moves.size(); i += stride) {
      const Pose &from = path_.moves[i - 1].pose, &to = path_.moves[i].pose;
      const MoveKind kind = path_.moves[i].kind;
      if (kind == MoveKind::kCut) {
        for (int k = 1; k <= per_cut; ++k)
          measure_cut(between(from, to, static_cast<double>(k) / per_cut), hints, m);
        continue;
      }
      // In steps that no corner of the part slips through.
      const double way = distance(from.tip, to.tip) + tool_.top() * angle_between(from.axis, to.axis);
      const int steps = std::max(2, static_cast<int>(way / (0.25 * tool_.narrowest())) + 1);
      for (int k = 1; k <= steps; ++k) measure_rapid(between(from, to, static_cast<double>(k) / steps), m);
    }
    return m;
  }

  /// A contour goes round walls: there the straight side of the cutter touches, however far up, and round the
  /// outline of what overhangs, as if the tool had no end.
  void let_sides_touch(Cutter cutter, const sim::Growth& growth) {
    cutter.cutting_length = cutter.cutting_end(), cutter.shank_diameter = 0.0, cutter.holder.clear();
    cutter.shank_length += distance(bounds_.min, bounds_.max);
    endless_.emplace(cutter, growth);
  }

  /// Along the axis to the axis feature (inside work), or to where the part is left behind.
  double way_out(Point<Part> p) const {
    const bool inward = axis_.mode != AxisMode::kFixed && axis_.sense == Sense::kInward;
    return inward ? std::abs(map_.flatten(p).z) : distance(bounds_.min, bounds_.max);
  }

  const sim::PartDistance& part() const { return part_; }
  const Deformation& map() const { return map_; }
  const sim::ToolSolid& tool() const { return tool_; }

 private:
  using Hints = std::array<std::uint32_t, 4>;  ///< of the tool's parts and of the drop

  void measure_cut(const Pose& pose, Hints& hints, Measured& m) const {
    ++m.poses;
    for (std::size_t i = 0; i < sim::kToolParts.size(); ++i) {
      const sim::Hit hit = tool_.clearance(part_, pose, sim::kToolParts[i], -m.gouge_by[i], hints[i]);
      if (hit.facet == kNoFacet) continue;
      hints[i] = hit.facet, m.gouge_by[i] = -hit.value;
      if (-hit.value > m.gouge) m.gouge = -hit.value, m.gouge_at = pose;
    }
    const sim::Hit drop = tool_.drop(part_, pose, sim::kInfinity, hints[3], std::min(m.contact, tolerance_));
    if (drop.facet != kNoFacet) hints[3] = drop.facet;
    double contact = drop.value;
    if (drop.value > tolerance_) {
      ++m.plain_over;
      m.plain_drop = std::max(m.plain_drop, drop.value);
      contact = tool_.gap(part_, pose).value;
      if (contact > tolerance_) contact = std::min(contact, above_envelope(pose));
      if (contact > tolerance_ && endless_) contact = std::min(contact, side_gap(pose));
    }
    if (contact > m.contact) m.contact = contact, m.contact_at = pose;
  }

  double side_gap(const Pose& pose) const {
    const double cutter = endless_->clearance(part_, pose, sim::ToolPart::kCutter).value;
    return std::max(0.0, std::min(cutter, endless_->clearance(part_, pose, sim::ToolPart::kShank).value));
  }

  /// Where the straight drop is no measure (steep walls, edges), the tool is in contact when its gap is
  /// within the tolerance; or else how far it is above the true envelope, when a place on the pass may be out
  /// by the tolerance in any direction of the flat space: beside a wall or past an edge the drop straight
  /// along the axis is as deep as the wall is high. Each place is measured from above: the drop of a tool
  /// that comes from beyond the part.
  double above_envelope(const Pose& pose) const {
    constexpr double kStep = 1e-5;
    constexpr int kDirections = 8;
    const Point<Part> centre = pose.tip + pose.axis * nose_;
    const Point<Flat> flat = map_.flatten(centre);
    const double high = way_out(centre);
    double least = std::max(0.0, tool_.drop(part_, {pose.tip + pose.axis * high, pose.axis}).value - high);
    for (int i = 0; i < kDirections && least > tolerance_; ++i) {
      const double turn = 2.0 * kPi * i / kDirections;
      const Point<Flat> ahead{flat.x + kStep * std::cos(turn), flat.y + kStep * std::sin(turn), flat.z};
      const Point<Part> beside = centre + normalized(map_.unflatten(ahead) - centre) * tolerance_;
      const Vec3 axis = map_.axis_at(beside);
      const double above = way_out(beside);
      const Pose start{beside + axis * (above - nose_), axis};
      least = std::min(least, std::max(0.0, tool_.drop(part_, start).value - above));
    }
    return least;
  }

  void measure_rapid(const Pose& pose, Measured& m) const {
    ++m.rapid_poses;
    for (const sim::ToolPart part : sim::kToolParts) {
      const sim::Hit hit = tool_.clearance(part_, pose, part, -m.rapid_overlap);
      if (hit.facet != kNoFacet) m.rapid_overlap = -hit.value, m.rapid_at = pose;
    }
  }

  const AxisFrame axis_;
  double tolerance_;
  Box bounds_;
  const ToolPath& path_;
  sim::PartDistance part_;
  sim::ToolSolid tool_;
  double nose_;
  Deformation map_;
  std::optional<sim::ToolSolid> endless_;
};

}  // namespace tiltfeed
