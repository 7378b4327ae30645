#include "pathgen/mesh/winding_number.h"

#include <cmath>

#include "kinematics/basics/units.h"

namespace tiltfeed::pathgen {

double winding_number(const Mesh& mesh, Point<Part> p) {
  double sum = 0.0;
  for (const auto& f : mesh.facets) {
    const Vec3 a = mesh.vertices[f[0]] - p, b = mesh.vertices[f[1]] - p, c = mesh.vertices[f[2]] - p;
    const double la = length(a), lb = length(b), lc = length(c);
    sum += 2.0 *
           std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (4.0 * kPi);
}

}  // namespace tiltfeed::pathgen
