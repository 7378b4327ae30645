#pragma once
// Exact profiles of the envelope along two families of grid lines, x' and y', and its heights where they
// cross: what every level's contours are found from. (Z1) in pathgen/pattern/README.md.

#include <optional>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/envelope/heights.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

/// (Z1) So far inside its own column (mm) a level must be; the lowest level itself may lie just there.
inline constexpr double kLeastInColumn = kLeastAxisDistance * (1.0 - 1e-9);

/// Grid lines of one coordinate.
struct GridAxis {
  double low = 0.0, step = 1.0;  ///< mm
  int cells = 1;
  bool wraps = false;  ///< node `cells` is node 0
  int nodes() const { return wraps ? cells : cells + 1; }
  double at(int i) const { return low + step * i; }
  double period() const { return wraps ? step * cells : 0.0; }
};

inline constexpr double kMaxGridNodes = 20e6;

/// Where a coordinate does not wrap, the outermost lines lie outside the surface: no height, empty profile.
struct LevelGrid {
  GridAxis x, y;
  std::vector<double> node_heights;                ///< by node()
  std::vector<std::vector<HeightSample>> rows;     ///< by j: along x' at y.at(j), run from x.low
  std::vector<std::vector<HeightSample>> columns;  ///< by i: along y' at x.at(i), run from y.low
  int node(int i, int j) const {
    return (y.wraps ? j % y.cells : j) * x.nodes() + (x.wraps ? i % x.cells : i);
  }
};

/// How far the lines reach over a region: so much of it is followed to and fro across its border, in cells.
inline constexpr double kCellsBeyond = 6.0;

/// Lines evenly and at most `spacing` apart over `window` and kCellsBeyond cells more, or over all that there
/// is: where that would end at a seam, all round. Beyond the outermost lines nothing is looked at, as if
/// there were no surface. Errors: kLimit for more than kMaxGridNodes or kMaxCrossings, kCancelled.
Result<LevelGrid> make_level_grid(const ClField& field, double spacing, const EnvelopeOptions& options,
                                  const std::optional<FlatBounds>& window, const Progress& progress);

}  // namespace tiltfeed::pathgen
