#pragma once
// Where in flat space each patch of the CL surface may be the highest: hulls of a few corners, widened by
// pads. (S2), (S3) in pathgen/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/cl_surface.h"
#include "pathgen/deformation.h"

namespace tiltfeed {

/// Part of a patch in flat space: the hull of its points, in (cross, run), widened by the pads.
struct Cell {
  PatchId patch = 0;
  std::uint32_t first = 0, count = 0;  ///< corners; count 2: the corners of a box
  double cross_pad = 0.0, run_pad = 0.0;
};

struct FlatCorner {
  double cross, run;
};

struct CellBlock {
  std::vector<Cell> cells;
  std::vector<FlatCorner> corners;
  std::vector<PatchId> near;  ///< patches that may cover the end of a column (Deformation::column_end)
};

/// The cells of all patches that can face the tool, in the order of the patches, for any number of threads.
/// Coordinates that wrap are those nearest to a cell's first corner, and may lie past the seam. Cells are not
/// made smaller than a share of `side_step` (mm).
std::vector<CellBlock> make_cells(const ClSurface& surface, const Deformation& deformation, Along along,
                                  double side_step);

}  // namespace tiltfeed
