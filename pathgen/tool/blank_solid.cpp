#include "pathgen/tool/blank_solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kinematics/basics/units.h"
#include "pathgen/tool/swept_tool.h"

namespace tiltfeed::pathgen {

namespace {

constexpr int kFewestSides = 24, kMostSides = 720;
/// Along no edge that anyone would draw.
const Vec3 kRay = normalized(Vec3{0.8191520442, 0.3420201433, 0.4617486132});

void add(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  mesh.source.push_back(static_cast<std::uint32_t>(mesh.facets.size()));
  mesh.facets.push_back({a, b, c});
}

Mesh box_mesh(const Box& box) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 8; ++i)
    mesh.vertices.push_back(
        {i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z});
  for (const std::array<std::uint32_t, 4>& q : {std::array<std::uint32_t, 4>{0, 2, 3, 1},
                                                {4, 5, 7, 6},
                                                {0, 1, 5, 4},
                                                {2, 6, 7, 3},
                                                {0, 4, 6, 2},
                                                {1, 3, 7, 5}})
    add(mesh, q[0], q[1], q[2]), add(mesh, q[0], q[2], q[3]);
  return mesh;
}

Mesh bar_mesh(Point<Part> base, Vec3 axis, double radius, double height) {
  const double half = std::acos(radius / (radius + BlankSolid::kStandOut));
  const int sides = std::clamp(static_cast<int>(std::ceil(kPi / half)), kFewestSides, kMostSides);
  const double out = radius / std::cos(kPi / sides);
  const Vec3 u = normalized(cross(axis, std::abs(axis.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0})),
             v = cross(axis, u);
  Mesh mesh;
  for (const double h : {0.0, height})
    for (int i = 0; i < sides; ++i) {
      const double turn = 2.0 * kPi * i / sides;
      mesh.vertices.push_back(base + axis * h + u * (out * std::cos(turn)) + v * (out * std::sin(turn)));
    }
  mesh.vertices.push_back(base), mesh.vertices.push_back(base + axis * height);
  const auto n = static_cast<std::uint32_t>(sides);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    add(mesh, i, next, n + next), add(mesh, i, n + next, n + i);
    add(mesh, 2 * n, next, i), add(mesh, 2 * n + 1, n + i, n + next);
  }
  return mesh;
}

}  // namespace

BlankSolid::BlankSolid(Kind kind, Mesh mesh) : kind_(kind), mesh_(std::move(mesh)) {
  bounds_ = {mesh_.vertices.front(), mesh_.vertices.front()};
  for (const Point<Part>& v : mesh_.vertices) bounds_ = grown(bounds_, v);
}

BlankSolid BlankSolid::box(const Box& box) { return {Kind::kBox, box_mesh(box)}; }

BlankSolid BlankSolid::bar(Point<Part> base, Vec3 axis, double radius, double height) {
  BlankSolid blank(Kind::kBar, bar_mesh(base, axis, radius, height));
  blank.base_ = base, blank.axis_ = axis, blank.radius_ = radius, blank.height_ = height;
  return blank;
}

BlankSolid BlankSolid::closed(Mesh mesh) {
  BlankSolid blank(Kind::kMesh, std::move(mesh));
  blank.tree_ = std::make_shared<const FacetBvh>(blank.mesh_);
  return blank;
}

bool BlankSolid::holds(Point<Part> p, double margin) const {
  if (kind_ == Kind::kBar) {
    const Vec3 w = p - base_;
    const double h = dot(w, axis_);
    return h >= -margin && h <= height_ + margin && length(w - axis_ * h) <= radius_ + margin;
  }
  const auto off = [](double v, double low, double high) { return std::max(low - v, v - high); };
  if (std::max({off(p.x, bounds_.min.x, bounds_.max.x), off(p.y, bounds_.min.y, bounds_.max.y),
                off(p.z, bounds_.min.z, bounds_.max.z)}) > margin)
    return false;
  return kind_ == Kind::kBox || inside_mesh(p) ||
         (margin > 0.0 &&
          tree_->any_along(p, kRay, 0.0, 0.0, margin, [&](std::uint32_t, const PlacedFacet& facet) {
            return distance(p, nearest_point(p, facet.corners)) <= margin;
          }));
}

/// A ray crosses the surface an odd number of times.
bool BlankSolid::inside_mesh(Point<Part> p) const {
  bool inside = false;
  const double far = distance(bounds_.min, bounds_.max) + distance(p, bounds_.min);
  tree_->any_along(p, kRay, 0.0, far, 1e-6, [&](std::uint32_t, const PlacedFacet& facet) {
    const auto side = [&](std::size_t k) {
      return dot(cross(facet.corners[k] - p, facet.corners[(k + 1) % 3] - p), kRay) > 0.0;
    };
    const bool first = side(0);
    if (side(1) != first || side(2) != first) return false;
    const double steep = dot(facet.normal, kRay), over = dot(facet.normal, facet.corners[0] - p);
    if (steep != 0.0 && over / steep > 0.0) inside = !inside;
    return false;
  });
  return inside;
}

std::vector<Point<Part>> BlankSolid::places(double apart) const {
  std::vector<Point<Part>> all = mesh_.vertices;
  for (const auto& [a, b, c] : mesh_.facets) {
    const Point<Part> p = mesh_.vertices[a];
    const Vec3 u = mesh_.vertices[b] - p, v = mesh_.vertices[c] - p;
    const double steps = std::ceil(std::max({length(u), length(v), length(u - v)}) / apart);
    for (double i = 0.0; i <= steps; ++i)
      for (double j = 0.0; i + j <= steps; ++j) all.push_back(p + u * (i / steps) + v * (j / steps));
  }
  return all;
}

}  // namespace tiltfeed::pathgen
