#pragma once
// Rows as far apart as the ridges between them allow, chosen of many that were traced near to each other.
// (R4) in pathgen/pattern/README.md.

#include <optional>
#include <vector>

#include "pathgen/pattern/point_rules.h"
#include "pathgen/pattern/row_layout.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed::pathgen {

/// So many rows are traced for each side step.
inline constexpr int kRowsPerStep = 4;
/// Of the surface: a little of it, at ends of passes or in a corner, does not say how high ridges may be
/// everywhere.
inline constexpr double kRidgeShare = 0.995;

/// What is cut of rows that were traced, each group one row's passes by rising run coordinate.
struct RidgeRows {
  std::vector<std::vector<Pass>> main;  ///< by rising row
  std::vector<std::vector<Pass>> fill;  ///< short ones between them, likewise
  double allowed = 0.0;                 ///< the ridge that is allowed anywhere, mm
};

/// `rows`: evenly spaced, by rising row, and the border of all as far from the first and the last as they are
/// from each other. Every kRowsPerStep-th, from `first_stated` on, is one of the raster's own. Properties: 1
/// No place at which one of the rows touches the part keeps more than the larger of `allowed` and what the
/// raster's own rows leave there, as far as the surface is flat between two of `rows`. 2 The same whatever
/// the threads. `allowed` is Pattern::scallop, if that is given; else what the raster's own rows leave at
/// most on kRidgeShare of the surface, where it leans over by at least kSteepestAcross. It is no more than
/// four times their ridge on a plane and half the tolerance. Nothing when `report` returns false. Requires:
/// a ball.
std::optional<RidgeRows> widest_rows(const std::vector<std::vector<Pass>>& rows, std::size_t first_stated,
                                     const ClField& field, const PlanOptions& options,
                                     const RowLayout& layout, const ReportShare& report);

}  // namespace tiltfeed::pathgen
