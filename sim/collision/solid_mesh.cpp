#include "sim/collision/solid_mesh.h"

#include <algorithm>
#include <cmath>

#include "pathgen/mesh/stl.h"

namespace tiltfeed::sim {
namespace {

constexpr int kFewestSides = 12, kMostSides = 720;

/// Sides of a circle of that radius, by its sagitta.
int sides_of(double radius) {
  if (radius <= kSagitta) return kFewestSides;
  const double sides = kPi / std::acos(1.0 - kSagitta / radius);
  return std::clamp(static_cast<int>(std::ceil(sides)), kFewestSides, kMostSides);
}

/// The flat end inside a ring from its vertex `begin` to `end`: large triangles in the middle, small ones at
/// the rim, so that boxes are small where there are many.
void fill(SolidMesh& mesh, std::uint32_t first, std::uint32_t count, std::uint32_t begin, std::uint32_t end,
          bool up) {
  if (end - begin < 2) return;
  const std::uint32_t middle = begin + (end - begin) / 2;
  const std::uint32_t a = first + begin % count, b = first + middle % count, c = first + end % count;
  mesh.facets.push_back(up ? std::array{a, b, c} : std::array{a, c, b});
  fill(mesh, first, count, begin, middle, up);
  fill(mesh, first, count, middle, end, up);
}

void fill(SolidMesh& mesh, std::uint32_t first, std::uint32_t count, bool up) {
  const std::uint32_t one = count / 3, two = 2 * count / 3;
  const std::uint32_t a = first, b = first + one, c = first + two;
  mesh.facets.push_back(up ? std::array{a, b, c} : std::array{a, c, b});
  fill(mesh, first, count, 0, one, up);
  fill(mesh, first, count, one, two, up);
  fill(mesh, first, count, two, count, up);
}

double sagitta_of(double radius, int sides) { return radius * (1.0 - std::cos(kPi / sides)); }

}  // namespace

void SolidMesh::place(const Rotation& rotation, Vec3 shift) {
  for (Vec3& v : vertices) v = rotation * v + shift;
  centre = rotation * centre + shift, axis = rotation * axis;
}

SolidMesh block_mesh(Vec3 size) {
  SolidMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back(
        {(i & 1 ? 0.5 : -0.5) * size.x, (i & 2 ? 0.5 : -0.5) * size.y, i & 4 ? size.z : 0.0});
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kSides{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& [a, b, c, d] : kSides) {
    mesh.facets.push_back({a, b, c});
    mesh.facets.push_back({a, c, d});
  }
  return mesh;
}

SolidMesh round_mesh(const std::vector<std::array<double, 2>>& outline) {
  SolidMesh mesh;
  mesh.round = true;
  double widest = 0.0;
  for (const auto& [r, h] : outline) widest = std::max(widest, r);
  const int sides = sides_of(widest);
  mesh.sagitta = sagitta_of(widest, sides);
  const auto count = static_cast<std::uint32_t>(sides);
  std::vector<std::uint32_t> first;  // of each ring; those on the axis have one vertex
  for (const auto& [r, h] : outline) {
    first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    for (std::uint32_t i = 0; i < (r > 0.0 ? count : 1); ++i) {
      const double angle = 2.0 * kPi * i / sides;
      mesh.vertices.push_back({r * std::cos(angle), r * std::sin(angle), h});
    }
  }
  for (std::size_t ring = 0; ring + 1 < outline.size(); ++ring) {
    const bool low = outline[ring][0] > 0.0, high = outline[ring + 1][0] > 0.0;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t k = (i + 1) % count, a = first[ring] + (low ? i : 0),
                          b = first[ring] + (low ? k : 0), c = first[ring + 1] + (high ? i : 0),
                          d = first[ring + 1] + (high ? k : 0);
      if (low) mesh.facets.push_back({a, b, d});
      if (high) mesh.facets.push_back({a, d, c});
    }
  }
  if (outline.front()[0] > 0.0) fill(mesh, first.front(), count, false);
  if (outline.back()[0] > 0.0) fill(mesh, first.back(), count, true);
  return mesh;
}

SolidMesh mesh_of(const Revolved& solid) {
  std::vector<std::array<double, 2>> outline;
  double before = 0.0, arc_sagitta = 0.0;
  for (const Corner& corner : solid.corners()) {
    const double turn = corner.turn - before;
    const int steps =
        corner.radius > 0.0
            ? std::max(1, static_cast<int>(std::ceil(turn / (2.0 * kPi) * sides_of(corner.radius))))
            : 0;
    if (steps > 0) arc_sagitta = std::max(arc_sagitta, corner.radius * (1.0 - std::cos(0.5 * turn / steps)));
    for (int i = 0; i <= steps; ++i) {
      const double angle = steps > 0 ? before + turn * i / steps : 0.0;
      const std::array<double, 2> point{std::max(0.0, corner.r + corner.radius * std::sin(angle)),
                                        corner.h - corner.radius * std::cos(angle)};
      if (outline.empty() || outline.back() != point) outline.push_back(point);
    }
    before = corner.turn;
  }
  SolidMesh mesh = round_mesh(outline);
  mesh.sagitta += arc_sagitta;
  return mesh;
}

Result<SolidMesh> mesh_of(const config::SolidShape& shape) {
  SolidMesh mesh;
  switch (shape.kind) {
    case config::SolidKind::kBox:
      mesh = block_mesh(shape.size);
      break;
    case config::SolidKind::kCylinder:
    case config::SolidKind::kCone:
      mesh = round_mesh({{0.5 * shape.diameter, 0.0}, {0.5 * shape.upper_diameter, shape.height}});
      break;
    case config::SolidKind::kStl: {
      const auto stl = pathgen::read_stl(shape.stl, shape.stl_unit_mm);
      if (!stl) return tl::unexpected(stl.error());
      for (const auto& facet : stl->facets) {
        const auto at = static_cast<std::uint32_t>(mesh.vertices.size());
        for (const auto& corner : facet) mesh.vertices.push_back(from_origin(corner));
        mesh.facets.push_back({at, at + 1, at + 2});
      }
      break;
    }
  }
  mesh.place(shape.rotation, shape.at);
  return mesh;
}

}  // namespace tiltfeed::sim
