#pragma once
// The faces of the part that alone are to be machined.

#include <vector>

#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

struct ChosenFaces {
  Mesh mesh;                 ///< of them alone
  std::vector<bool> chosen;  ///< by facet of the part's mesh
  double beyond = 0.0;       ///< passes go on so far beyond their edges, on a plane, mm
};

}  // namespace tiltfeed::pathgen
