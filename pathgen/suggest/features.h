#pragma once
// The points, lines and circles that a part's own surface is round about. (Q1) in
// pathgen/suggest/README.md.

#include <span>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "pathgen/reach/reach_scene.h"
#include "pathgen/suggest/feature.h"

namespace tiltfeed::pathgen {

/// The features that a good share of the surface is round about, the largest share first; each made exact by
/// the mesh's corners. `places`: an even sample of the surface.
std::vector<Feature> find_features(const Mesh& mesh, const Box& bounds, std::span<const ReachPlace> places);

}  // namespace tiltfeed::pathgen
