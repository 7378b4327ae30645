// Hollow sphere with three bores. Built in the frame of the bore axes, on a cube lattice whose lines are
// equal angles: on the three cube faces a bore goes through, rings run from the face's edge to the bore.

#include <cmath>
#include <numbers>

#include "sim/parts/facet_mesh.h"

namespace tiltfeed::sim {
namespace {

constexpr std::size_t kSphereFacets = 4'446;
constexpr double kOuterRadius = 50.0, kInnerRadius = 40.0, kHoleRadius = 18.0;
constexpr int kCells = 12;             ///< along a cube edge
constexpr int kSegments = 4 * kCells;  ///< of a bore's rim
constexpr int kOuterRings = 4, kInnerRings = 3;
constexpr int kLattice = kCells + 1;

using Rim = std::array<std::uint32_t, kSegments>;

/// The bores' axes, mutually perpendicular and right-handed, at equal angles from +z.
Vec3 to_part(Vec3 v) {
  const double tall = std::sqrt(1.0 / 3.0), half = std::sqrt(0.5), sixth = std::sqrt(1.0 / 6.0);
  const Vec3 axis_x{0.0, 2.0 * sixth, tall}, axis_y{-half, -sixth, tall}, axis_z{half, -sixth, tall};
  return v.x * axis_x + v.y * axis_y + v.z * axis_z;
}

/// The frame of a cube face: `normal` is one of the three axes or its opposite, u x v = normal.
struct Face {
  int axis = 0;
  int sign = 1;
  std::array<int, 3> lattice(int u, int v) const {
    std::array<int, 3> p{};
    p[axis] = sign > 0 ? kCells : 0;
    p[(axis + 1) % 3] = sign > 0 ? u : v;
    p[(axis + 2) % 3] = sign > 0 ? v : u;
    return p;
  }
};

Vec3 direction(const std::array<int, 3>& p) {
  const auto coordinate = [](int i) {
    return std::tan(0.25 * std::numbers::pi * (2 * i - kCells) / static_cast<double>(kCells));
  };
  return normalized({coordinate(p[0]), coordinate(p[1]), coordinate(p[2])});
}

Vec3 unit(int axis) { return {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0}; }

/// Lattice points around a face's edge, counter-clockwise seen from outside.
std::array<int, 3> edge_point(const Face& face, int segment) {
  const int along = segment % kCells;
  switch (segment / kCells) {
    case 0:
      return face.lattice(along, 0);
    case 1:
      return face.lattice(kCells, along);
    case 2:
      return face.lattice(kCells - along, kCells);
    default:
      return face.lattice(0, kCells - along);
  }
}

/// One spherical shell with its three round openings; facets face away from the centre, or towards it.
class Shell {
 public:
  Shell(FacetMesh& mesh, double radius, bool outward) : mesh_(mesh), radius_(radius), outward_(outward) {
    lattice_.fill(kNone);
  }

  void add_closed_face(const Face& face) {
    for (int u = 0; u < kCells; ++u)
      for (int v = 0; v < kCells; ++v)
        quad(node(face.lattice(u, v)), node(face.lattice(u + 1, v)), node(face.lattice(u + 1, v + 1)),
             node(face.lattice(u, v + 1)));
  }

  /// Returns the opening's rim.
  Rim add_open_face(const Face& face, int rings) {
    Rim outer, inner;
    for (int segment = 0; segment < kSegments; ++segment) outer[segment] = node(edge_point(face, segment));
    const Vec3 axis = unit(face.axis);
    const double opening = std::asin(kHoleRadius / radius_);
    for (int ring = 1; ring <= rings; ++ring) {
      for (int segment = 0; segment < kSegments; ++segment) {
        const Vec3 far = direction(edge_point(face, segment));
        const double away = dot(far, axis);
        const Vec3 sideways = normalized(far - away * axis);
        const double reach = std::atan2(std::sqrt(1.0 - away * away), away);
        const double angle = reach + (opening - reach) * ring / rings;
        inner[segment] = add(std::cos(angle) * axis + std::sin(angle) * sideways);
      }
      for (int segment = 0; segment < kSegments; ++segment) {
        const int next = (segment + 1) % kSegments;
        quad(outer[segment], outer[next], inner[next], inner[segment]);
      }
      outer = inner;
    }
    return inner;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffff'ffff;

  std::uint32_t add(Vec3 unit_direction) { return add_vertex(mesh_, to_part(radius_ * unit_direction)); }

  std::uint32_t node(const std::array<int, 3>& p) {
    std::uint32_t& vertex = lattice_[(p[0] * kLattice + p[1]) * kLattice + p[2]];
    if (vertex == kNone) vertex = add(direction(p));
    return vertex;
  }

  void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    if (outward_)
      add_quad(mesh_, a, b, c, d);
    else
      add_quad(mesh_, a, d, c, b);
  }

  FacetMesh& mesh_;
  double radius_;
  bool outward_;
  std::array<std::uint32_t, kLattice * kLattice * kLattice> lattice_{};
};

/// Two rows of quadrilaterals between the rims of one bore.
void add_bore(FacetMesh& mesh, const Rim& outer, const Rim& inner) {
  Rim middle;
  for (int segment = 0; segment < kSegments; ++segment)
    middle[segment] = add_vertex(mesh, straight_midpoint(mesh, outer[segment], inner[segment]));
  for (int segment = 0; segment < kSegments; ++segment) {
    const int next = (segment + 1) % kSegments;
    add_quad(mesh, outer[segment], outer[next], middle[next], middle[segment]);
    add_quad(mesh, middle[segment], middle[next], inner[next], inner[segment]);
  }
}

}  // namespace

Triangles hollow_sphere() {
  FacetMesh mesh;
  Shell outer(mesh, kOuterRadius, true), inner(mesh, kInnerRadius, false);
  for (int axis = 0; axis < 3; ++axis) {
    outer.add_closed_face({axis, -1});
    inner.add_closed_face({axis, -1});
    const Rim outer_rim = outer.add_open_face({axis, 1}, kOuterRings);
    const Rim inner_rim = inner.add_open_face({axis, 1}, kInnerRings);
    add_bore(mesh, outer_rim, inner_rim);
  }
  // Both ends on one shell: the middle goes out to that shell; bore edges are straight.
  const auto midpoint = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 middle = straight_midpoint(mesh, a, b);
    const double at_a = length(from_origin(mesh.vertices[a])), at_b = length(from_origin(mesh.vertices[b]));
    constexpr double kOnShell = 1e-3;  // float32 rounding at 50 mm is 2e-6; no bore row is this close
    for (const double radius : {kOuterRadius, kInnerRadius})
      if (std::abs(at_a - radius) < kOnShell && std::abs(at_b - radius) < kOnShell)
        return middle * (radius / length(middle));
    return middle;
  };
  split_longest_edges(mesh, kSphereFacets, midpoint);
  return to_triangles(mesh);
}

}  // namespace tiltfeed::sim
