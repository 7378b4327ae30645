#pragma once
// The CL surface of a ball: every place of the ball's centre in contact with the part. It is not tessellated:
// it is the union of the patches that a sphere of the offset radius sweeps over the mesh: an offset triangle
// for each facet, a cylinder for each convex edge, a sphere for each vertex that sticks out. Heights on it
// are closed forms, exact for facets of any size. (C1)..(C4) in pathgen/README.md.

#include <array>
#include <cstdint>
#include <vector>

#include "pathgen/deformation.h"
#include "pathgen/mesh.h"

namespace tiltfeed {

using PatchId = std::uint32_t;

/// A point of the CL surface on an axis line.
struct ClHit {
  double z = 0.0;  ///< z' along the line, mm
  Vec3 normal;     ///< unit, from the contact point to the ball's centre
};

class ClSurface {
 public:
  /// `mesh` must outlive the surface. `radius`: ball radius plus allowance, mm, > 0.
  ClSurface(const Mesh& mesh, Sides sides, double radius);

  PatchId patch_count() const {
    return static_cast<PatchId>(mesh_.facets.size() + edges_.size() + vertices_.size());
  }
  bool is_face(PatchId patch) const { return patch < mesh_.facets.size(); }
  /// The facet of the STL file that the patch stands on.
  std::uint32_t facet_of(PatchId patch) const;

  /// The highest point of the patch on the axis line, if the line meets it. Points of the same offset body
  /// just outside the patch (by kSeam) are accepted, so that neighbouring patches leave no gap.
  bool top(PatchId patch, const AxisLine& line, ClHit& hit) const;

  /// Is p within radius() of what the patch is swept round: facet, edge or vertex?
  bool covers(PatchId patch, Point<Part> p) const;

  /// The part feature that the patch is swept round: an edge from p to q, or a vertex (p = q).
  struct Core {
    Point<Part> p, q;
  };
  // `side` below: which side of a facet or vertex is meant where both count, +1 along the facets' normals, -1
  // against them. An edge has a patch on its convex side only, whatever `side` says.
  Core core(PatchId patch) const;  ///< Requires: not is_face(patch)

  /// Points whose convex hull contains the patch of an edge (three at p, then three at q) or of a vertex.
  /// Leaves `points` empty where the patch is too wide for that: then it is somewhere within radius() of its
  /// core.
  void hull(PatchId patch, int side,
            std::vector<Point<Part>>& points) const;  ///< Requires: not is_face(patch)

  /// True if no contact normal of the patch leans to the tool's side of `axis` by more than `-spread` (sine):
  /// its points are nowhere the highest.
  bool faces_away(PatchId patch, int side, Vec3 axis, double spread) const;

  /// Normal of a facet on the part's outside.
  Vec3 facet_normal(std::uint32_t facet) const { return normals_[facet]; }
  const Mesh& mesh() const { return mesh_; }
  Sides sides() const { return sides_; }
  double radius() const { return radius_; }

 private:
  struct EdgePatch {
    std::uint32_t v0, v1;  ///< ends
    std::uint32_t w0, w1;  ///< third corners of the facets beside it; kNone: no facet there
    std::uint32_t f0, f1;  ///< those facets (f1 = f0 where there is one only)
  };
  struct VertexPatch {
    std::uint32_t vertex;
    std::uint32_t first, last;              ///< its neighbours, in neighbours_
    std::uint32_t first_facet, last_facet;  ///< its facets, in fans_
    bool oriented;                          ///< its facets agree on what is outside
  };
  /// Returns a flag for each vertex: do its facets disagree on what is outside?
  std::vector<std::uint8_t> find_edges();
  void find_vertices(const std::vector<std::uint8_t>& disagree);
  bool face_top(std::uint32_t facet, const AxisLine& line, ClHit& hit) const;
  bool edge_top(const EdgePatch& edge, const AxisLine& line, ClHit& hit) const;
  bool vertex_top(const VertexPatch& patch, const AxisLine& line, ClHit& hit) const;
  bool narrow(const EdgePatch& edge) const;
  std::array<Vec3, 2> convex_normals(const EdgePatch& edge) const;
  void edge_hull(const EdgePatch& edge, std::vector<Point<Part>>& points) const;
  void vertex_hull(const VertexPatch& patch, int side, std::vector<Point<Part>>& points) const;

  const Mesh& mesh_;
  Sides sides_;
  double radius_;
  std::vector<Vec3> normals_;
  std::vector<EdgePatch> edges_;
  std::vector<VertexPatch> vertices_;
  std::vector<std::uint32_t> neighbours_, fans_;
};

/// Slack of the patch borders: an angle (rad) on the ball, and as a share of the radius a length. Wide enough
/// to close the seams that rounding and skipped nearly flat edges leave; it raises the surface by R kSeam^2 /
/// 8, less than 1e-9 mm.
inline constexpr double kSeam = 2e-5;

}  // namespace tiltfeed
