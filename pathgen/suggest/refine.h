#pragma once
// A feature made exact by the mesh's corners. (Q2) in pathgen/suggest/README.md.

#include "pathgen/mesh/mesh.h"
#include "pathgen/suggest/feature.h"

namespace tiltfeed::pathgen {

/// The feature moved and turned so that the corners that lie round it at one distance, whatever that is, do
/// so best. `size`: of the part, mm.
Feature refined(Feature feature, const Mesh& mesh, double size);

}  // namespace tiltfeed::pathgen
