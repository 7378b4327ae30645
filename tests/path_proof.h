#pragma once
// Holds a planned path against the part by brute force: the exact distances of sim/ and nothing of the
// planner's but its map of directions. Dense poses along every move: ball and shank do not gouge, the ball
// stays in contact, rapids keep clear.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "pathgen/plan.h"
#include "sim/distance.h"

namespace tiltfeed {

struct Measured {
  std::size_t poses = 0, rapid_poses = 0;
  double gouge = 0.0, contact = 0.0, rapid_overlap = 0.0;
  double plain_drop = 0.0;     ///< largest drop straight along the axis
  std::size_t plain_over = 0;  ///< poses whose drop straight along the axis is over the tolerance
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
  /// `checked`, `path` and `cutter` must outlive the proof.
  PathProof(const AxisFrame& axis, Along along, const Cutter& cutter, double tolerance,
            const CheckedMesh& checked, const ToolPath& path)
      : axis_(axis),
        along_(along),
        cutter_(cutter),
        tolerance_(tolerance),
        bounds_(checked.bounds),
        path_(path),
        part_(checked.mesh),
        radius_(cutter.radius()),
        map_(axis, 1.0) {}

  /// Poses on the whole path, `least_poses` or more of them on cutting moves; every `stride`th move.
  Measured measure(std::size_t least_poses, std::size_t stride = 1) const {
    Measured m;
    std::size_t cuts = 0;
    for (const Move& move : path_.moves) cuts += move.kind == MoveKind::kCut ? 1 : 0;
    const auto per_cut =
        static_cast<int>(std::max<std::size_t>(3, least_poses * stride / std::max<std::size_t>(cuts, 1) + 1));
    std::uint32_t hint = kNoFacet;
    for (std::size_t i = 1; i < path_.moves.size(); i += stride) {
      const Pose &from = path_.moves[i - 1].pose, &to = path_.moves[i].pose;
      const MoveKind kind = path_.moves[i].kind;
      if (kind == MoveKind::kCut) {
        for (int k = 1; k <= per_cut; ++k)
          measure_cut(between(from, to, static_cast<double>(k) / per_cut), hint, m);
        continue;
      }
      // In steps that no corner of the part slips through.
      const double way =
          distance(from.tip, to.tip) + cutter_.shank_length * angle_between(from.axis, to.axis);
      const int steps = std::max(2, static_cast<int>(way / (0.25 * radius_)) + 1);
      for (int k = 1; k <= steps; ++k) measure_rapid(between(from, to, static_cast<double>(k) / steps), m);
    }
    return m;
  }

  /// Along the axis to the axis feature (inside work), or to where the part is left behind.
  double way_out(Point<Part> p) const {
    const bool inward = axis_.mode != AxisMode::kFixed && axis_.sense == Sense::kInward;
    return inward ? std::abs(map_.flatten(p).z) : distance(bounds_.min, bounds_.max);
  }

  const sim::PartDistance& part() const { return part_; }
  const Deformation& map() const { return map_; }

 private:
  void measure_cut(const Pose& pose, std::uint32_t& hint, Measured& m) const {
    ++m.poses;
    const sim::Hit tool = part_.nearest(sim::tool_segment(pose.tip, pose.axis, radius_, cutter_.shank_length),
                                        radius_ - m.gouge, hint);
    if (tool.facet != kNoFacet && radius_ - tool.value > m.gouge)
      m.gouge = radius_ - tool.value, m.gouge_at = pose;
    const Point<Part> centre = pose.tip + pose.axis * radius_;
    const sim::Hit drop = part_.first_touch(centre, -pose.axis, radius_, sim::kInfinity, hint);
    if (drop.facet != kNoFacet) hint = drop.facet;
    double contact = drop.value;
    if (drop.value > tolerance_) {
      ++m.plain_over;
      m.plain_drop = std::max(m.plain_drop, drop.value);
      contact = std::min(part_.nearest(centre).value - radius_, above_envelope(centre));
    }
    if (contact > m.contact) m.contact = contact, m.contact_at = pose;
  }

  /// Where the straight drop is no measure (steep walls, edges), the ball is in contact when its gap is
  /// within the tolerance; or else how far its centre is above the true envelope, when a place on the pass
  /// may be out by the tolerance: beside a wall or past an edge the drop straight along the axis is as deep
  /// as the wall is high. Each place is measured from above: the drop of a ball that comes from beyond the
  /// part.
  double above_envelope(Point<Part> centre) const {
    constexpr double kStep = 1e-5;
    const Point<Flat> flat = map_.flatten(centre);
    const Point<Flat> ahead = along_ == Along::kX ? Point<Flat>{flat.x + kStep, flat.y, flat.z}
                                                  : Point<Flat>{flat.x, flat.y + kStep, flat.z};
    const Vec3 along = normalized(map_.unflatten(ahead) - map_.unflatten(flat));
    double least = sim::kInfinity;
    for (const double shift : {0.0, tolerance_, -tolerance_}) {
      const Point<Part> beside = centre + along * shift;
      const Vec3 axis = map_.axis_at(beside);
      const double high = way_out(beside);
      const double drop = part_.first_touch(beside + axis * high, -axis, radius_).value - high;
      least = std::min(least, std::max(0.0, drop));
    }
    return least;
  }

  void measure_rapid(const Pose& pose, Measured& m) const {
    ++m.rapid_poses;
    const sim::Hit tool = part_.nearest(sim::tool_segment(pose.tip, pose.axis, radius_, cutter_.shank_length),
                                        radius_ - m.rapid_overlap);
    if (tool.facet != kNoFacet && radius_ - tool.value > m.rapid_overlap)
      m.rapid_overlap = radius_ - tool.value, m.rapid_at = pose;
  }

  const AxisFrame axis_;
  Along along_;
  const Cutter& cutter_;
  double tolerance_;
  Box bounds_;
  const ToolPath& path_;
  sim::PartDistance part_;
  double radius_;
  Deformation map_;
};

}  // namespace tiltfeed
