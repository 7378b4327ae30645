#pragma once
// Curves that cover a region of the flat plane from its border inwards. (Z6), (Z7) in
// pathgen/pattern/README.md.

#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/envelope/heights.h"
#include "pathgen/pattern/flat_offset.h"

namespace tiltfeed::pathgen {

struct CurveOptions {
  double side_step = 0.0;  ///< mm
  double tolerance = 0.0;  ///< of arcs, mm
  bool clockwise = true;   ///< of borders, seen from the tool: what is not yet cut lies on the right
  bool spiral = false;
};

struct RegionCurves {
  std::vector<std::vector<FlatCurve>> groups;  ///< each from the outside inwards
  std::uint64_t loops_in_spiral = 0;           ///< with `spiral`: curves that had to stay closed loops
};

inline constexpr double kCornerReach = 0.65;
inline constexpr double kMaxRings = 10e3;

/// The borders of what is further than side_step / 2, 3/2, 5/2... from the region's border; between two of
/// them one more, or a piece of it, where a part of the region (its middle, an arm, a neck) has no next one.
/// Every place of the region is within side_step / 2 of a curve, but within kCornerReach side steps on the
/// bisectors of corners, and within side_step / (2 sin(angle / 2)) in a corner of the region itself.
/// With `spiral`, each row of rings that follow each other one by one, without holes, is one curve from the
/// first to the last that comes inwards evenly; no place of it is further than side_step from the turn
/// before, or than a corner's next ring. Errors: kLimit for more than kMaxRings.
Result<RegionCurves> region_curves(const std::vector<FlatRegion>& regions, const CurveOptions& options);

}  // namespace tiltfeed::pathgen
