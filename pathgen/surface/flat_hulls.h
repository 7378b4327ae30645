#pragma once
// Where in flat space each patch of the CL surface may be the highest: hulls of a few corners, widened by
// pads. (S1)..(S3) in pathgen/surface/README.md.

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/fresh_memory.h"
#include "pathgen/progress/watch.h"
#include "pathgen/surface/cl_surface.h"
#include "pathgen/surface/column_ends.h"

namespace tiltfeed::pathgen {

/// Largest relative rounding of a coordinate in single precision, doubled.
inline constexpr double kSingle = 1.2e-7;

/// A place (x', y'), mm; single precision suffices for a bound, and its rounding is in the pads.
struct FlatCorner {
  float x = 0.0f, y = 0.0f;
};

/// Part of a patch in flat space: the hull of its corners, widened by the pads. Coordinates that wrap are
/// those nearest to the hull's middle, and may lie past the seam.
struct FlatHull {
  PatchId patch = 0;
  std::uint32_t first = 0;  ///< corner
  std::uint32_t count = 0;  ///< of corners; 2: opposite corners of a box
  float pad_x = 0.0f, pad_y = 0.0f;
  float top = std::numeric_limits<float>::infinity();  ///< no CL point of the hull is higher (z')
};

struct FlatHulls {
  FreshVector<FlatHull> hulls;  ///< in the order of the patches
  FreshVector<FlatCorner> corners;
  double furthest = 0.0;          ///< of their places from the point, line or circle, mm, about
  std::vector<NearFeature> near;  ///< what may cover the end of a column (Deformation::column_end)
};

/// (G2) No CL point of the patch is higher than this (z').
double highest_reference(const ClSurface& surface, const Deformation& map, PatchId patch);

/// The hulls of all patches that can face the tool; the same for any number of threads. Hulls are not made
/// smaller than `smallest` (mm) to follow the deformation. `wanted`: of these patches only, asked from
/// several threads at a time. When the user stops it, hulls are missing.
FlatHulls make_flat_hulls(const ClSurface& surface, const Deformation& deformation, double smallest,
                          const ReportShare& report = {},
                          const std::function<bool(PatchId)>& wanted = nullptr);

}  // namespace tiltfeed::pathgen
