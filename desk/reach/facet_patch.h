#pragma once
// The smooth piece of the surface about facets that were picked, and the shapes that it may be.

#include <cstdint>
#include <span>
#include <vector>

#include "pathgen/fit/fit.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::desk {

struct FacetPatch {
  std::vector<std::uint32_t> facets;   ///< of the mesh, ascending
  std::vector<std::uint32_t> sources;  ///< of the STL file, ascending, each once
};

/// The facets that came from these of the file, and those beyond each edge that turns by at most
/// `spread_deg`, as far as they go; 0: none besides.
FacetPatch smooth_patch(const pathgen::Mesh& mesh, std::span<const std::uint32_t> sources, double spread_deg);

/// The shapes that can be fitted through the corners of the facets: the smallest residual first, and of those
/// that fit as well the simplest.
std::vector<pathgen::Fit> fits_of(const pathgen::Mesh& mesh, std::span<const std::uint32_t> facets);

}  // namespace tiltfeed::desk
