#pragma once
// Bodies to facets, within a measured distance of their surfaces.

#include <vector>

#include "cad/shape/loaded_part.h"
#include "kinematics/basics/result.h"
#include "pathgen/part_file/cad_stream.h"

namespace tiltfeed::cad {

/// OpenCASCADE is asked for facets within this many times what is allowed; the rest is split_within()'s. Its
/// own figure is no bound, and the time that it takes grows with the square of its facets.
inline constexpr double kAskedShare = 16.0;
/// Where facets would fold, or a face has none, it is asked again for this many times finer ones, this often.
inline constexpr double kFiner = 2.0;
inline constexpr int kMostRounds = 6;

struct Tessellated {
  pathgen::PartModel model;                 ///< without facets
  std::vector<pathgen::FaceFacets> facets;  ///< by face
};

/// Properties: 1 No facet is further than `allowed` (mm) from its face's surface, at its corners and at seven
/// places inside, nor the middle of its sides on an edge from that edge. The largest distance found is in
/// each face's `deviation`. 2 Faces of a body have the same corners along an edge that they share. 3 Facets
/// are turned, and normals point, out of the material. 4 The same bytes each time. Errors: kMesh with body
/// and entity: a face without facets, or that cannot be had within `allowed`; kLimit over
/// pathgen::kMaxFacets.
Result<Tessellated> tessellate(const LoadedPart& part, double allowed, const std::string& file);

}  // namespace tiltfeed::cad
