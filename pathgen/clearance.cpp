#include "pathgen/clearance.h"

namespace tiltfeed {

Clearance::Clearance(const Mesh& mesh, double radius)
    : scene_(mesh.vertices.empty() ? Point<Part>{} : mesh.vertices.front()) {
  const double inside = radius - kClearanceMargin;
  scene_.add_triangles(mesh, inside);
  scene_.add_triangles(mesh, -inside);
  scene_.add_edges(mesh, inside);
  scene_.commit();
}

}  // namespace tiltfeed
