#include "pathgen/linking/shank_collision.h"

namespace tiltfeed::pathgen {

ShankCollision::ShankCollision(const Mesh& mesh, double radius)
    : mesh_(mesh), radius_(radius), scene_(mesh.vertices.empty() ? Point<Part>{} : mesh.vertices.front()) {
  const double inside = radius - kShankMargin;
  scene_.add_triangles(mesh, inside);
  scene_.add_triangles(mesh, -inside);
  scene_.add_edges(mesh, inside);
  scene_.commit();
}

bool ShankCollision::touches(Point<Part> p) {
  if (!part_) {
    part_ = std::make_unique<RayScene>(mesh_.vertices.empty() ? Point<Part>{} : mesh_.vertices.front());
    part_->add_triangles(mesh_, 0.0);
    part_->commit();
  }
  return part_->within(p, radius_);
}

}  // namespace tiltfeed::pathgen
