#include "pathgen/exposure.h"

#include <tbb/parallel_for.h>

#include "pathgen/ray_scene.h"

namespace tiltfeed {

namespace {

/// Steeper facets (cosine against the axis) are walls: they carry no height, whichever way they face.
constexpr double kWall = 0.02;
/// Rays start this far off their facet (mm), more than their single precision on a part of up to 10 m.
constexpr double kOff = 2e-3;

/// Where else a facet is looked at: this share of the way from its centre to each corner.
constexpr double kBeside = 0.8;
/// Longer than any part and its distance from the axis feature, mm.
constexpr double kFar = 1e6;

}  // namespace

std::vector<std::uint32_t> exposed_backs(const Mesh& mesh, const Deformation& deformation) {
  RayScene scene(mesh.vertices.empty() ? Point<Part>{} : mesh.vertices.front());
  scene.add_triangles(mesh, 0.0);
  scene.commit();
  std::vector<std::uint8_t> exposed(mesh.facets.size(), 0);
  tbb::parallel_for(std::size_t{0}, mesh.facets.size(), [&](std::size_t f) {
    const Point<Part> a = mesh.vertices[mesh.facets[f][0]], b = mesh.vertices[mesh.facets[f][1]],
                      c = mesh.vertices[mesh.facets[f][2]];
    const Point<Part> centre = lerp(lerp(a, b, 0.5), c, 1.0 / 3.0);
    const Vec3 normal = normalized(cross(b - a, c - a));
    const auto open_at = [&](Point<Part> p) {
      const Point<Flat> flat = deformation.flatten(p);
      const Vec3 axis = deformation.axis_line(flat.x, flat.y).axis;
      return dot(normal, axis) < -kWall && !scene.hits(p + axis * kOff, axis, kFar);
    };
    exposed[f] = open_at(centre) || open_at(lerp(centre, a, kBeside)) || open_at(lerp(centre, b, kBeside)) ||
                 open_at(lerp(centre, c, kBeside));
  });
  std::vector<std::uint32_t> facets;
  for (std::uint32_t f = 0; f < exposed.size(); ++f)
    if (exposed[f] != 0) facets.push_back(f);
  return facets;
}

}  // namespace tiltfeed
