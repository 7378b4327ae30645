#include "pathgen/exposure.h"

#include <tbb/parallel_for.h>

namespace tiltfeed {

namespace {

/// Steeper facets (cosine against the axis) are walls: they carry no height, whichever way they face.
constexpr double kWall = 0.02;
/// Where else a facet is looked at: this share of the way from its centre to each corner.
constexpr double kBeside = 0.8;
/// What keeps the tool less than this (mm) below a facet still covers it: rounding.
constexpr double kTouching = 1e-6;

}  // namespace

std::vector<std::uint32_t> exposed_backs(const ClSurface& surface, const Deformation& deformation,
                                         const FlatIndex& index, double reference_height) {
  const Mesh& mesh = surface.mesh();
  std::vector<std::uint8_t> exposed(mesh.facets.size(), 0);
  tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(mesh.facets.size()), [&](std::uint32_t f) {
    const Vec3 normal = surface.facet_normal(f);
    const Point<Part> a = mesh.vertices[mesh.facets[f][0]], b = mesh.vertices[mesh.facets[f][1]],
                      c = mesh.vertices[mesh.facets[f][2]];
    const Point<Part> centre = lerp(lerp(a, b, 0.5), c, 1.0 / 3.0);
    // Is the tool kept `margin` above p, on p's own axis line?
    const auto open_at = [&](Point<Part> p, double margin) {
      if (dot(normal, deformation.axis_at(p)) >= -kWall) return false;
      const Point<Flat> flat = deformation.flatten(p);
      const AxisLine line = deformation.axis_line(flat.x, flat.y);
      return !index.any_at(flat.x, flat.y, [&](PatchId patch) {
        ClHit hit;
        return surface.top(patch, line, hit) && hit.z - reference_height >= flat.z + margin - kTouching;
      });
    };
    const double size = std::max({distance(centre, a), distance(centre, b), distance(centre, c)});
    if (!open_at(centre, size)) return;  // well below the surface, all of it
    exposed[f] = open_at(centre, 0.0) || open_at(lerp(centre, a, kBeside), 0.0) ||
                 open_at(lerp(centre, b, kBeside), 0.0) || open_at(lerp(centre, c, kBeside), 0.0);
  });
  std::vector<std::uint32_t> facets;
  for (std::uint32_t f = 0; f < exposed.size(); ++f)
    if (exposed[f] != 0) facets.push_back(f);
  return facets;
}

}  // namespace tiltfeed
