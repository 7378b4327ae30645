#pragma once
// The raster pattern: straight rows side by side over a rectangle of flat space.

#include "kinematics/basics/result.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/surface/flat_index.h"

namespace tiltfeed::pathgen {

inline constexpr double kMaxRows = 1e6;
/// Patches met by all rows together; a path of so many points takes some 10 GB.
inline constexpr double kMaxCrossings = 100e6;

/// Row k runs in the direction (dx, dy), `step` further to its left than row k - 1; k may be a fraction, for
/// rows in between. Rows 0 and count - 1 are half a step inside the rectangle.
struct RowLayout {
  FlatBounds bounds;
  double dx = 1.0, dy = 0.0;
  double first = 0.0, step = 0.0;  ///< distance of row 0 to the left of the origin; mm
  double count = 0.0;
  double crossings = 0.0;  ///< of cells by all rows, about
  /// The piece of the row in the rectangle.
  FlatLine row(double k) const;
  /// Coordinate along the rows.
  double along(double x, double y) const { return x * dx + y * dy; }
};

/// Rows at most `side_step` apart, in the direction of the pattern.
/// Errors: kLimit when the side step asks for more than kMaxRows or kMaxCrossings; kUnreachable when the
/// rectangle is empty.
Result<RowLayout> lay_rows(const FlatIndex& index, const FlatBounds& bounds, const Pattern& pattern,
                           double side_step);

/// Cosine of 75 degrees: walls steeper than this across the passes keep the spacing of such a wall; they are
/// better cut by z-level contours.
inline constexpr double kSteepestAcross = 0.26;

}  // namespace tiltfeed::pathgen
