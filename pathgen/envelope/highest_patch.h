#pragma once
// The highest of some patches on one axis line, taken one by one or found in the tree by which the tool comes
// down. (E1) in pathgen/envelope/README.md, (S8) in pathgen/surface/README.md.

#include <algorithm>
#include <limits>
#include <optional>

#include "pathgen/axis/deformation.h"
#include "pathgen/surface/cl_surface.h"
#include "pathgen/surface/drop_bvh.h"

namespace tiltfeed::pathgen {

/// The highest of the patches on one axis line that are taken; equal heights: the lower patch number.
class HighestPatch {
 public:
  HighestPatch(const ClSurface& surface, const Deformation& map, const Deformation::Angles& angles,
               const AxisLine& line)
      : surface_(surface), map_(map), angles_(angles), line_(line) {}

  /// Only what is higher than `z` is asked for, and any patch that is will do.
  void ask_over(double z) { over_ = z; }

  bool found() const { return found_; }
  const ClHit& hit() const { return best_; }
  PatchId patch() const { return patch_.patch; }
  /// The same as the tree showed it; one that take() was given alone has no hull.
  const DropBvh::Found& best() const { return patch_; }
  /// Does it not matter what a patch is like that is no higher than `top`?
  bool is_over(float top) const {
    if (!over_) return found_ && static_cast<double>(top) < best_.z;
    return found_ || static_cast<double>(top) <= *over_;
  }

  /// What it took: the patches dropped on, and of the tree's boxes a quarter as many.
  std::size_t cost() const { return cost_; }

  void take(PatchId patch) {
    take({patch, 0}, [](const DropBvh::Found&) { return true; });
  }
  /// If is_there(found), asked last.
  template <class IsThere>
  void take(const DropBvh::Found& found, IsThere is_there) {
    ++cost_;
    ClHit hit;
    if (!surface_.top(found.patch, line_, hit, found_ ? best_.z : over_.value_or(kAnyHeight))) return;
    if (over_ && hit.z <= *over_) return;
    // Seen from its own column, all up to the ring that touches: beyond the column's end it has no hull.
    const double ring = std::max(0.0, surface_.piece(found.patch).above_reference);
    if (!map_.in_column(hit.z, angles_, 0.0) || !map_.in_column(hit.z + ring, angles_, 0.0)) return;
    if (found_ && (hit.z < best_.z || (hit.z == best_.z && found.patch > patch_.patch))) return;
    if (is_there(found)) best_ = hit, patch_ = found, found_ = true;
  }

  /// Those of a piece at the place (x, y), likewise.
  template <class IsThere>
  void take_from(const DropBvh& drops, double x, double y, IsThere is_there) {
    DropBvh::Heights asked = column();
    const double bottom = over_ ? std::max(asked.low, *over_) : asked.low;
    const auto raise = [&] {
      if (found_) asked.low = over_ ? std::numeric_limits<double>::infinity() : std::max(bottom, best_.z);
    };
    asked.low = bottom, raise();
    const std::size_t boxes = drops.each(x, y, line_, asked, [&](const DropBvh::Found& found) {
      take(found, is_there);
      raise();
    });
    cost_ += boxes / 4;
  }

 private:
  /// Share: more than the rounding of a quotient.
  static constexpr double kSpare = 1e-9;

  /// No height beyond is in the column (Deformation::in_column).
  DropBvh::Heights column() const {
    DropBvh::Heights heights;
    const AxisFrame& frame = map_.frame();
    if (frame.mode == AxisMode::kFixed) return heights;
    const bool outside = map_.s() > 0.0;
    (outside ? heights.low : heights.high) = 0.0;
    if (frame.mode != AxisMode::kCircle || !(angles_.cos_y < 0.0)) return heights;
    const double far = frame.circle_radius / -angles_.cos_y * (1.0 + kSpare);
    (outside ? heights.high : heights.low) = outside ? far : -far;
    return heights;
  }

  const ClSurface& surface_;
  const Deformation& map_;
  const Deformation::Angles& angles_;
  const AxisLine& line_;
  ClHit best_;
  DropBvh::Found patch_{};
  std::optional<double> over_;
  std::size_t cost_ = 0;
  bool found_ = false;
};

}  // namespace tiltfeed::pathgen
