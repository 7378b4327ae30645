#pragma once
// The CL surface: every place of the cutter's reference in contact with the part. It is not tessellated: it
// is the union of the patches that each piece of the tool sweeps over each facet, each convex edge and each
// vertex that sticks out. Heights on it are exact for facets of any size (pathgen/tool/drop.h). (C1)..(C6) in
// pathgen/surface/README.md.

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/folds.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/topology.h"
#include "pathgen/tool/drop.h"

namespace tiltfeed::pathgen {

/// Piece of the tool * features() + feature of the part (facets first, then edges, then vertices).
using PatchId = std::uint32_t;

/// Properties: 1 The highest patch on an axis line is the height at which the tool, let down on the whole
/// mesh, stops, for facets of any size: within 2e-6 mm, but for a sharp edge that grazes within kSeam.
/// 2 Between neighbouring patches the tool sinks by no more than 2e-5 mm, however little the edge there is
/// bent. 3 Contact normals on an edge are square to it: within 3 kLevel (sine). 4 The features that a surface
/// of the first pieces needs are all among those of a surface of more pieces.
class ClSurface {
 public:
  /// `mesh` must outlive the surface. Its facets from `part_facets` on are those of fixtures. Requires: at
  /// least one piece; facets of the part and of fixtures share no vertex, and the part's vertices come first.
  ClSurface(const Mesh& mesh, Sides sides, std::vector<ToolPiece> pieces,
            std::size_t part_facets = std::numeric_limits<std::size_t>::max());

  PatchId features() const { return features_; }
  /// The patches of a surface of the same mesh for the first pieces alone, as this one numbers them: it may
  /// need fewer features, (C4).
  std::vector<PatchId> numbers_of(const ClSurface& first) const;
  PatchId patch_count() const { return features() * static_cast<PatchId>(pieces_.size()); }
  const ToolPiece& piece(PatchId patch) const {
    return patch < features_ ? pieces_.front() : pieces_[patch / features_];
  }
  bool is_face(PatchId patch) const { return feature_of(patch) < mesh_.facets.size(); }
  /// Facets of the part alone; those of fixtures come behind them.
  std::size_t part_facets() const { return part_facets_; }
  /// Is the patch one of a fixture that its piece is not asked about, or the other way round?
  bool is_idle(PatchId patch) const {
    return part_facets_ != mesh_.facets.size() && piece(patch).at_fixtures != is_fixture(feature_of(patch));
  }
  /// The facet of the STL file that the patch stands on; of a fixture its number.
  std::uint32_t facet_of(PatchId patch) const;

  /// The highest point of the patch on the axis line, if the line meets it. Points just outside the patch (by
  /// kSeam) are accepted, so that neighbouring patches leave no gap.
  /// One lower than `least` is not found.
  bool top(PatchId patch, const AxisLine& line, ClHit& hit, double least = kAnyHeight) const {
    return patch < features_ ? top(pieces_.front(), patch, line, hit, least)
                             : top(pieces_[patch / features_], feature_of(patch), line, hit, least);
  }

  /// The same of any other piece against a feature.
  bool top(const ToolPiece& piece, PatchId feature, const AxisLine& line, ClHit& hit,
           double least = kAnyHeight) const;

  /// Is a tool with its reference at p and this axis so near to the patch's feature that the piece's rounded
  /// edge may cut into it?
  bool covers(PatchId patch, Point<Part> p, Vec3 axis) const;

  /// The corners of the patch's feature: three, two or one.
  struct Core {
    std::array<Point<Part>, 3> corner;
    std::uint32_t count = 0;
    std::span<const Point<Part>> points() const { return {corner.data(), count}; }
  };
  // `side` below: which side of a facet or vertex is meant where both count, +1 along the facets' normals, -1
  // against them. An edge has a patch on its convex side only, whatever `side` says.
  Core core(PatchId patch) const;
  /// Asks for what the functions here need of the patch, for those who come to it soon.
  void fetch(PatchId patch) const;

  /// Contact normals in whose cone all those of the patch lie. Leaves `normals` empty where they cannot be
  /// told, or are as good as all directions. False if the patch has none: its feature is nowhere touched.
  bool normals(PatchId patch, int side, std::vector<Vec3>& normals) const;

  /// True if no contact normal of the patch leans to the tool's side of `axis` by more than `-spread` (sine):
  /// its points are nowhere the highest.
  bool faces_away(PatchId patch, int side, Vec3 axis, double spread) const;

  /// Normal of a facet on the part's outside.
  Vec3 facet_normal(std::uint32_t facet) const { return normals_[facet]; }
  const Mesh& mesh() const { return mesh_; }
  Sides sides() const { return sides_; }
  /// The cutting part first.
  const std::vector<ToolPiece>& pieces() const { return pieces_; }
  /// In the order of their ends.
  const std::vector<NarrowNotch>& notches() const { return notches_; }

 private:
  struct EdgePatch {
    std::uint32_t v0, v1;                 ///< ends
    std::uint32_t w0, w1;                 ///< third corners of the facets beside it; kNone: no facet there
    std::array<std::uint32_t, 2> facets;  ///< those facets; twice the same where there is one only
    bool nearly_flat = false;             ///< (C4) a ball needs no patch
    bool is_notch = false;                ///< concave, and narrower than a right angle
  };
  struct VertexPatch {
    std::uint32_t vertex;
    std::uint32_t first, last;  ///< its neighbours, in neighbours_
    bool oriented;              ///< its facets agree on what is outside
    bool nearly_flat;           ///< and so are all its edges
  };
  /// What is known of a vertex from its edges.
  struct VertexNotes {
    std::uint8_t disagree = 0;    ///< its facets, on what is outside
    std::uint8_t sticks_out = 0;  ///< an edge there has a patch
    std::uint8_t is_sharp = 0;    ///< one that is not nearly flat has
  };
  bool is_fixture(PatchId feature) const;
  PatchId feature_of(PatchId patch) const { return patch < features_ ? patch : patch % features_; }
  std::vector<VertexNotes> find_edges();
  bool edge_patch(std::span<const HalfEdge> halves, EdgePatch& edge) const;
  void find_vertices(const std::vector<VertexNotes>& notes);
  bool behind(const EdgePatch& edge, Vec3 normal) const;
  bool behind(const VertexPatch& patch, Vec3 normal) const;
  bool narrow(const EdgePatch& edge) const;
  std::array<Vec3, 2> convex_normals(const EdgePatch& edge) const;
  std::span<const std::uint32_t> fan(const VertexPatch& patch) const { return fans_.of(patch.vertex); }

  const Mesh& mesh_;
  Sides sides_;
  std::vector<ToolPiece> pieces_;
  std::size_t part_facets_;
  FreshVector<Vec3> normals_;
  std::vector<EdgePatch> edges_;
  std::vector<NarrowNotch> notches_;
  std::vector<VertexPatch> vertices_;
  std::vector<std::uint32_t> neighbours_;
  VertexFans fans_;
  double least_bend_ = kSeam;  ///< (C4) sine: an edge that is bent less has no patch
  PatchId features_ = 0;       ///< facets, edges and vertices
};

}  // namespace tiltfeed::pathgen
