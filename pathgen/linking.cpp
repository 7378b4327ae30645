#include "pathgen/linking.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {

namespace {

/// Share of the clearance that a straight travel move may dip below the clearance surface.
constexpr double kDipShare = 0.1;

class Linker {
 public:
  Linker(const ClSurface& surface, const Deformation& map, const Linking& options, FarSide& far_side)
      : surface_(surface), map_(map), options_(options), far_side_(far_side), clear_z_(options.clearance_z) {}

  /// Requires: pass is not empty. `reversed` runs it from back to front.
  void add(const Pass& pass, bool reversed) {
    const EnvelopePoint& first = reversed ? pass.back() : pass.front();
    const EnvelopePoint& last = reversed ? pass.front() : pass.back();
    if (!travel_to(first.flat)) {
      ++linked_.skipped_passes;
      return;
    }
    const double start = first.flat.z + options_.approach;
    if (start < clear_z_) push(pose_at({first.flat.x, first.flat.y, start}), MoveKind::kRapid, kNoFacet);
    push(pose_of(first), MoveKind::kPlunge, surface_.facet_of(first.patch));
    const auto cut = [&](const EnvelopePoint& p) {
      push(pose_of(p), MoveKind::kCut, surface_.facet_of(p.patch));
    };
    if (reversed) {
      std::for_each(pass.rbegin() + 1, pass.rend(), cut);
    } else {
      std::for_each(pass.begin() + 1, pass.end(), cut);
    }
    at_ = {last.flat.x, last.flat.y, clear_z_};
    push(pose_at(at_), MoveKind::kRapid, kNoFacet);
  }

  Linked take() { return std::move(linked_); }

 private:
  Pose pose_of(const EnvelopePoint& p) const {
    return {p.centre - p.axis * options_.reference_height, p.axis};
  }
  Pose pose_at(Point<Flat> f) const {
    const AxisLine line = map_.axis_line(f.x, f.y);
    return {line.base + line.axis * (f.z - options_.reference_height), line.axis};
  }
  void push(const Pose& pose, MoveKind kind, std::uint32_t facet) {
    linked_.moves.push_back({pose, kind, facet});
  }

  /// (L2) Along the clearance surface, the short way round, in steps whose chords dip at most kDipShare of
  /// the clearance: rho * turn^2 / 8. False, and nothing moved, if the far side is in the way.
  bool travel_to(Point<Flat> to) {
    const auto short_way = [](double from, double target, double period) {
      return period > 0.0 ? target + period * std::round((from - target) / period) : target;
    };
    if (linked_.moves.empty()) {
      push(pose_at({to.x, to.y, clear_z_}), MoveKind::kRapid, kNoFacet);
      return true;
    }
    const Point<Flat> target{short_way(at_.x, to.x, map_.period_x()), short_way(at_.y, to.y, map_.period_y()),
                             clear_z_};
    const double steps = travel_steps(target);
    const std::size_t before = linked_.moves.size();
    for (double i = 1.0; i <= steps; ++i) {
      const Pose from = linked_.moves.back().pose, pose = pose_at(lerp(at_, target, i / steps));
      if (!far_side_.travel_clear(from, pose)) {
        linked_.moves.resize(before);
        return false;
      }
      push(pose, MoveKind::kRapid, kNoFacet);
    }
    return true;
  }

  double travel_steps(Point<Flat> target) const {
    if (map_.frame().mode == AxisMode::kFixed) return 1.0;
    const double turn_x = map_.period_x() > 0.0 ? std::abs(target.x - at_.x) / map_.scale_x() : 0.0;
    const double turn_y = std::abs(target.y - at_.y) / map_.scale_y();
    const double rho = std::abs(clear_z_) + map_.frame().circle_radius_or_zero();
    return std::max(1.0,
                    std::ceil((turn_x + turn_y) / std::sqrt(8.0 * kDipShare * options_.clearance / rho)));
  }

  const ClSurface& surface_;
  const Deformation& map_;
  Linking options_;
  FarSide& far_side_;
  double clear_z_;
  Point<Flat> at_;
  Linked linked_;
};

}  // namespace

Linked link(const std::vector<std::vector<Pass>>& slices, const ClSurface& surface,
            const Deformation& deformation, const Linking& options, FarSide& far_side) {
  Linker linker(surface, deformation, options, far_side);
  bool reversed = false;
  for (const auto& passes : slices) {
    if (passes.empty()) continue;
    if (reversed) {
      std::for_each(passes.rbegin(), passes.rend(), [&](const Pass& pass) { linker.add(pass, true); });
    } else {
      std::for_each(passes.begin(), passes.end(), [&](const Pass& pass) { linker.add(pass, false); });
    }
    if (options.direction == Direction::kZigzag) reversed = !reversed;
  }
  return linker.take();
}

}  // namespace tiltfeed
