#pragma once
// Of each patch of the CL surface the facets that may cut into it. (N4) in pathgen/free_slices/README.md.

#include <cstdint>
#include <span>
#include <vector>

#include "pathgen/free_slices/cl_sections.h"
#include "pathgen/mesh/facet_bvh.h"

namespace tiltfeed::pathgen {

class PatchObstacles {
 public:
  /// Of the patches that are not 0 in `asked`. In parallel; the same for any number of threads.
  PatchObstacles(const ClSections& sections, const FacetBvh& tree, const std::vector<std::uint8_t>& asked);

  /// Facets (indices into the mesh, ascending) that a centre of the patch may be nearer to than the radius;
  /// no other is, by more than rounding. None of a patch that was not asked for.
  std::span<const std::uint32_t> of(std::uint32_t patch) const {
    return {facets_.data() + first_[patch], first_[patch + 1] - first_[patch]};
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> facets_;
};

}  // namespace tiltfeed::pathgen
