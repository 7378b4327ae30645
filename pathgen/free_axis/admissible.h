#pragma once
// The admissible set of a CL point: the directions of the tool axis at which cutter, shank and holder are
// clear of the part, the tool can be drawn back along its axis, and the machine's tilt suffices. (A1)..(A4)
// in pathgen/free_axis/README.md.

#include <array>
#include <cstdint>
#include <vector>

#include "kinematics/basics/units.h"
#include "pathgen/axis/direction_grid.h"
#include "pathgen/free_slices/cl_sections.h"
#include "pathgen/options/rest_reason.h"
#include "pathgen/tool/move_collision.h"
#include "pathgen/tool/swept_tool.h"

namespace tiltfeed::pathgen {

/// What a series of questions about one part remembers: along a pass a direction is mostly stopped by the
/// facet that stopped it a step before. No answer depends on it. One for each thread.
struct DirectionQuery {
  std::uint32_t hint = kNoFacet;  ///< the facet that stopped the last direction
  std::uint64_t tested = 0;       ///< directions held against the part
  /// For kCutterOnly to kWithFixtures (swept_tool.h), and each direction of the grid, the facet that stopped
  /// it last.
  std::array<std::vector<std::uint32_t>, 4> blockers;
  std::array<std::uint32_t, 4> clear{};  ///< and the direction that was clear when one was sought last
};

class Admissibility {
 public:
  /// `up`: the table's axis in part directions, unit. `tool` and `grid` must outlive the object.
  Admissibility(const SweptTool& tool, const DirectionGrid& grid, Vec3 up, Angle tilt_max);

  bool within_tilt(Vec3 axis) const { return tilt_.allows(axis); }
  bool within_tilt(Vec3 a, Vec3 b) const { return tilt_.allows(a, b); }
  /// Is the axis on the surface's side of the contact, and its angle to `up` at most tilt_max?
  bool within_limits(Vec3 normal, Vec3 axis) const;
  /// Is it in the admissible set of the point?
  bool admits(const ClPoint& point, Vec3 axis, DirectionQuery& query) const;
  /// The same for direction i of the grid.
  bool admits(const ClPoint& point, std::uint32_t i, DirectionQuery& query) const;
  /// Is direction i of the grid stopped by what stopped it last? Asks no other facet.
  bool still_stopped(const ClPoint& point, std::uint32_t i, DirectionQuery& query) const;

  /// Directions are of this level of the grid, and of the next finer one round what was chosen of them or
  /// where none of them is admissible.
  static constexpr int kAdmissibleLevel = 3;

  /// Why a point without admissible directions has none: the first of cutter, shank and holder without which
  /// there would be some, or the tilt limit.
  RestReason why_none(const ClPoint& point, DirectionQuery& query) const;

  /// The axis itself, or, further from `up` than a little less than the tilt limit, the nearest that is not.
  Vec3 nearest_tilt(Vec3 axis) const;

  const SweptTool& tool() const { return tool_; }
  const DirectionGrid& grid() const { return grid_; }
  /// Of its level kAdmissibleLevel.
  const DirectionNeighbours& near() const { return near_; }
  Vec3 up() const { return up_; }
  const TiltLimit& tilt() const { return tilt_; }
  double tilt_max() const { return tilt_max_; }  ///< rad

 private:
  bool stopped(const ClPoint& point, std::uint32_t i, int parts, DirectionQuery& query) const;
  bool any_clear(const ClPoint& point, int parts, DirectionQuery& query) const;

  const SweptTool& tool_;
  const DirectionGrid& grid_;
  DirectionNeighbours near_;
  Vec3 up_;
  double tilt_max_;
  TiltLimit tilt_;
};

}  // namespace tiltfeed::pathgen
