#pragma once
// A closed mesh under construction: vertices already rounded to the STL's float32, so that what is decided
// here (lengths, diagonals, welding) is decided on exactly the numbers that are written.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "kinematics/basics/geometry.h"
#include "sim/parts/parts.h"

namespace tiltfeed::sim {

struct FacetMesh {
  std::vector<Point<Part>> vertices;                 ///< float32 values, no negative zeros
  std::vector<std::array<std::uint32_t, 3>> facets;  ///< counter-clockwise seen from outside
};

/// Rounds to float32 and appends; returns the new vertex.
std::uint32_t add_vertex(FacetMesh& mesh, Vec3 position);

/// Two facets for the quadrilateral a b c d (counter-clockwise), cut along its shorter diagonal; a-c on a
/// tie.
void add_quad(FacetMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);

/// Where the middle of edge a-b lies on the true surface. Called once per split, in the order of the new
/// vertices: the vertex it makes becomes number mesh.vertices.size().
using Midpoint = std::function<Vec3(std::uint32_t a, std::uint32_t b)>;

/// Splits the longest edge (the smaller vertex numbers on a tie) until the mesh has `facet_count` facets;
/// each split adds two. Requires: closed and manifold; facet_count - facets.size() even and not negative.
void split_longest_edges(FacetMesh& mesh, std::size_t facet_count, const Midpoint& midpoint);

/// The middle of the straight edge.
Vec3 straight_midpoint(const FacetMesh& mesh, std::uint32_t a, std::uint32_t b);

Triangles to_triangles(const FacetMesh& mesh);

}  // namespace tiltfeed::sim
