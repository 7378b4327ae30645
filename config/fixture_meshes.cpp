#include "config/fixture_meshes.h"

#include <algorithm>
#include <cmath>

#include "pathgen/linking/opposite_wall.h"
#include "pathgen/mesh/mesh_check.h"

namespace tiltfeed::config {
namespace {

/// By so much, mm, a round body's sides may stand out of it.
constexpr double kStandOut = 0.02;
constexpr int kFewestSides = 24, kMostSides = 720;
/// What the check of the program adds to a clearance at most, mm: meshes of round bodies, the way under TCP,
/// its own error; and as much again.
constexpr double kSpare = 0.1;

using Facets = std::vector<std::array<Point<Part>, 3>>;

void add_quad(Facets& facets, Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) {
  facets.push_back({a, b, c});
  facets.push_back({a, c, d});
}

Facets box(Vec3 size) {
  const auto at = [&](double x, double y, double z) {
    return Point<Part>{(x - 0.5) * size.x, (y - 0.5) * size.y, z * size.z};
  };
  Facets facets;
  add_quad(facets, at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0));
  add_quad(facets, at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1));
  add_quad(facets, at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
  add_quad(facets, at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0));
  add_quad(facets, at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0));
  add_quad(facets, at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1));
  return facets;
}

/// Sides touch the cone from outside.
Facets cone(double lower, double upper, double height) {
  const double widest = std::max(lower, upper);
  const double half = std::acos(widest / (widest + kStandOut));
  const int sides = std::clamp(static_cast<int>(std::ceil(kPi / half)), kFewestSides, kMostSides);
  const double out = 1.0 / std::cos(kPi / sides);
  const auto at = [&](int i, double radius, double z) {
    const double angle = 2.0 * kPi * (i % sides) / sides;
    return Point<Part>{radius * out * std::cos(angle), radius * out * std::sin(angle), z};
  };
  Facets facets;
  for (int i = 0; i < sides; ++i) {
    const Point<Part> a = at(i, lower, 0.0), b = at(i + 1, lower, 0.0), c = at(i + 1, upper, height),
                      d = at(i, upper, height);
    facets.push_back({a, b, c});
    if (upper > 0.0) facets.push_back({a, c, d});
    facets.push_back({Point<Part>{0, 0, 0}, b, a});
    if (upper > 0.0) facets.push_back({Point<Part>{0, 0, height}, d, c});
  }
  return facets;
}

Result<Facets> facets_of(const SolidShape& shape) {
  if (shape.kind == SolidKind::kBox) return box(shape.size);
  if (shape.kind != SolidKind::kStl)
    return cone(0.5 * shape.diameter, 0.5 * shape.upper_diameter, shape.height);
  auto stl = pathgen::read_stl(shape.stl, shape.stl_unit_mm);
  if (!stl) return tl::unexpected(stl.error());
  return std::move(stl->facets);
}

}  // namespace

Result<std::shared_ptr<const pathgen::Fixtures>> fixture_meshes(const Job& job) {
  if (job.fixtures.empty()) return nullptr;
  pathgen::Fixtures all;
  const Rotation back = transposed(job.setup.fixture);
  for (const Fixture& fixture : job.fixtures) {
    const auto failed = [&](const Error& error) {
      return fail(error.code, job.path + ": fixture " + fixture.name + ": " + error.message);
    };
    auto facets = facets_of(fixture.shape);
    if (!facets) return failed(facets.error());
    for (auto& facet : *facets)
      for (Point<Part>& corner : facet) {
        Vec3 p = fixture.shape.rotation * from_origin(corner) + fixture.shape.at;
        if (!fixture.on_part) p = back * (p - job.setup.part_zero);
        corner = Point<Part>{} + p;
      }
    pathgen::Stl stl;
    stl.facets = std::move(*facets);
    auto checked = pathgen::check_mesh(stl, {kStandOut}, {});
    if (!checked) return failed(checked.error());
    if (checked->sides == pathgen::Sides::kBoth) all.sides = pathgen::Sides::kBoth;
    std::fill(checked->mesh.source.begin(), checked->mesh.source.end(),
              static_cast<std::uint32_t>(all.names.size()));
    all.mesh = pathgen::joined(all.mesh, checked->mesh);
    all.names.push_back(fixture.name);
  }
  return std::make_shared<const pathgen::Fixtures>(std::move(all));
}

pathgen::FixtureRoom fixture_room(const Job& job) {
  const Clearances& c = job.machine.solid.clearances;
  const double strays = pathgen::stray_of_rapids(job.plan.tolerance) + kSpare;
  return {c.rapid_factor * c.cutter + strays, c.rapid_factor * c.shank + strays,
          c.rapid_factor * c.holder + strays};
}

}  // namespace tiltfeed::config
