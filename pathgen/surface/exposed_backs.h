#pragma once
// A solid shows the tool only the outsides of its facets. Where shells cross or fold, a facet's inside can
// lie open to the tool even though every edge has its two facets; then orientation says nothing about where
// the material is.

#include <cstdint>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/progress/watch.h"
#include "pathgen/surface/cl_surface.h"
#include "pathgen/surface/flat_index.h"

namespace tiltfeed::pathgen {

/// Where, beside its centre, a facet is looked at: this share of the way from there to each corner.
inline constexpr double kBeside = 0.8;

/// Facets of the surface's mesh (indices, ascending) that turn their back to the tool although no patch of
/// the CL surface keeps the tool above them there. When the user stops it, not all of them.
std::vector<std::uint32_t> exposed_backs(const ClSurface& surface, const Deformation& deformation,
                                         const FlatIndex& index, double reference_height,
                                         const ReportShare& report = {});

}  // namespace tiltfeed::pathgen
