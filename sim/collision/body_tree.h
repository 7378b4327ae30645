#pragma once
// A body's surface as a tree of boxes that answers whether another one is nearer than some distance, and
// stops at the first facets that are. Formula (CO1) is in sim/collision/README.md.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sim/solid/triangle.h"

namespace tiltfeed::sim {

/// Takes a point p to rotation p + shift.
struct Placement {
  Rotation rotation;
  Vec3 shift;

  Vec3 operator()(Vec3 p) const { return rotation * p + shift; }
};
/// The second, then the first.
Placement operator*(const Placement& a, const Placement& b);
Placement inverse(const Placement& a);

/// Facets of two bodies, and how far they are from each other, mm.
struct FacetPair {
  double distance = 0.0;
  std::uint32_t a = 0, b = 0;
};

class BodyTree {
 public:
  /// Facets count on from one call to the next.
  void add(const std::vector<Vec3>& vertices, const std::vector<std::array<std::uint32_t, 3>>& facets);
  /// Requires: at least one facet. To be called once, before anything is asked.
  void build();

  std::size_t facet_count() const { return facets_.size(); }
  const std::vector<Vec3>& vertices() const { return vertices_; }
  /// A point of each of its shells.
  const std::vector<Vec3>& shells() const { return shells_; }

  /// Whether this and `other`, standing at `pose` as this one sees it, are nearer than `distance`. "No" is
  /// exact, triangles to rounding; so is "yes" without `slack`, with it they may be further apart by that.
  /// After `patience` pairs of boxes the answer is "yes", too; 0: it has no end.
  bool nearer(const BodyTree& other, const Placement& pose, double distance, double slack = 0.0,
              std::uint32_t patience = 0) const;
  /// The nearest facets, if at most `bound` apart.
  std::optional<FacetPair> nearest(const BodyTree& other, const Placement& pose, double bound) const;
  /// Whether the point is in the box around it.
  bool in_box(Vec3 p) const;
  /// Whether the surface is round the point: most of three lines from it cross it an odd number of times.
  bool inside(Vec3 p) const;
  /// Distance of the surface from the point, mm.
  double distance(Vec3 p) const;

 private:
  struct Node {
    Vec3 centre, half;
    double radius = 0.0;      ///< of the ball round the box
    std::uint32_t first = 0;  ///< of the children (first, first + 1), or of the triangles
    std::uint32_t count = 0;  ///< of triangles; 0: an inner node
  };
  struct Key {
    Vec3 middle;
    std::uint32_t triangle = 0;
  };
  struct Query;
  void cut_up(const std::array<Vec3, 3>& corners, std::uint32_t facet, double thickest);
  static Node node_round(Vec3 low, Vec3 high, std::uint32_t first, std::uint32_t count);
  void split(std::uint32_t node, std::span<Key> keys, std::uint32_t begin);
  void find_shells();
  int crossings(Vec3 from, Vec3 along) const;

  std::vector<Vec3> vertices_, shells_;
  std::vector<std::array<std::uint32_t, 3>> facets_;
  std::vector<Triangle> triangles_;  ///< in the order of the leaves; `facet` as they were added
  std::vector<Node> nodes_;
};

}  // namespace tiltfeed::sim
