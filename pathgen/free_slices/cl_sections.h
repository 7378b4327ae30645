#pragma once
// Where a plane cuts the swept-sphere CL surface, exactly: straight across moved facets, along arcs round
// convex edges and round vertices that stick out. (N1)..(N3) in pathgen/free_slices/README.md.

#include <array>
#include <cstdint>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/free_slices/normal_cap.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

/// A place of the ball's centre in contact with the part.
struct ClPoint {
  Point<Part> centre;
  Vec3 normal;                     ///< unit, from the contact to the centre
  std::uint32_t facet = kNoFacet;  ///< index into the mesh: one that is touched
};

/// Straight moves of the centre from point to point.
using ClStrand = std::vector<ClPoint>;

/// What bounds a patch: its centres are at feet + r n, the feet in the hull of `foot`, n in `normals` and
/// near <= r <= far.
struct PatchHull {
  std::array<Point<Part>, 3> foot;
  int feet = 0;
  NormalCap normals;
  std::array<Vec3, 3> support;  ///< all normals lie between these, if there are any
  int supports = 0;
  bool is_vertex = false;
  double near = 0.0, far = 0.0;
  Point<Part> middle;  ///< of a ball about all centres
  double reach = 0.0;  ///< its radius
};

class ClSections {
 public:
  /// `radius`: of the ball with the allowance, mm. `sagitta`: by how much chords stand off their arcs,
  /// outwards, mm: a chord touches its arc in its middle, so that no centre is too near to the part. `part`
  /// must outlive the object.
  ClSections(const CheckedMesh& part, double radius, double sagitta);

  /// A facet, convex edge or vertex.
  std::uint32_t patches() const {
    return static_cast<std::uint32_t>(faces_.size() + edges_.size() + vertices_.size());
  }
  /// Heights along the unit `normal` between which the patch lies.
  std::array<double, 2> extent(std::uint32_t patch, Vec3 normal) const;
  /// Holds all normals of the patch.
  const NormalCap& normals(std::uint32_t patch) const { return caps_[patch]; }
  /// Is it the patch of a facet, with one normal?
  bool is_face(std::uint32_t patch) const { return patch < faces_.size(); }
  PatchHull hull(std::uint32_t patch) const;
  /// Appends where the plane cuts the patch. Strands run along plane normal x surface normal; those of
  /// neighbouring patches meet end to end. What is inside the offset is not left out.
  void cut(std::uint32_t patch, Vec3 normal, double height, std::vector<ClStrand>& strands) const;

  double radius() const { return radius_; }
  const CheckedMesh& part() const { return part_; }

 private:
  struct Face {
    std::array<Point<Part>, 3> corner;  ///< moved by the radius
    Vec3 normal;
    std::uint32_t facet;
  };
  /// All edges' normals are n(q) = p cos q + w sin q, from <= q <= to.
  struct Edge {
    Point<Part> start;
    Vec3 along;  ///< unit
    double length;
    Vec3 p, w;
    double from, to;
    std::uint32_t facet;
  };
  struct Vertex {
    Point<Part> at;
    std::uint32_t first, last;  ///< in spokes_
    Vec3 outward;               ///< where the material is not; zero: both sides count
    std::uint32_t facet;
  };
  void add_faces();
  std::vector<std::uint8_t> add_edges();
  void add_vertices(const std::vector<std::uint8_t>& sticks_out);
  void cut_face(const Face& face, Vec3 normal, double height, std::vector<ClStrand>& strands) const;
  void cut_edge(const Edge& edge, Vec3 normal, double height, std::vector<ClStrand>& strands) const;
  void cut_vertex(const Vertex& vertex, Vec3 normal, double height, std::vector<ClStrand>& strands) const;

  const CheckedMesh& part_;
  double radius_, sagitta_;
  std::vector<Face> faces_;
  std::vector<Edge> edges_;
  std::vector<Vertex> vertices_;
  std::vector<NormalCap> caps_;  ///< of each patch
  std::vector<Vec3> spokes_;     ///< unit directions of the edges from each vertex
};

}  // namespace tiltfeed::pathgen
