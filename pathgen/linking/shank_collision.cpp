#include "pathgen/linking/shank_collision.h"

#include <algorithm>
#include <limits>

namespace tiltfeed::pathgen {
namespace {

constexpr double kMostMargin = 2e-3;                                                 // mm
constexpr double kMarginShare = 64.0 * std::numeric_limits<float>::epsilon() / 2.0;  // of the part's size

}  // namespace

double ray_margin(const Mesh& mesh) {
  if (mesh.vertices.empty()) return kMostMargin;
  Point<Part> low = mesh.vertices.front(), high = low;
  for (const Point<Part> v : mesh.vertices) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
  }
  return std::min(kMostMargin, kMarginShare * distance(low, high));
}

ShankCollision::ShankCollision(const Mesh& mesh, double radius)
    : mesh_(mesh), radius_(radius), scene_(mesh.vertices.empty() ? Point<Part>{} : mesh.vertices.front()) {
  const double inside = radius - ray_margin(mesh);
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
