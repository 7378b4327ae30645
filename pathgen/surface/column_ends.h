#pragma once
// The features of the part that may cover the end of a column: those near to the point, line or circle, or to
// the axis of Theta. (E1) in pathgen/README.md.

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "pathgen/surface/cl_surface.h"

namespace tiltfeed::pathgen {

/// No place further than `reach` (mm) from the centre is covered by the patch.
struct NearFeature {
  PatchId patch = 0;
  Point<Part> centre;
  double reach = 0.0;
};

/// Such features in a tree of boxes.
class ColumnEnds {
 public:
  ColumnEnds() = default;
  explicit ColumnEnds(std::vector<NearFeature> all);

  bool empty() const { return entries_.empty(); }
  /// Gives each patch the number that `numbers` has for it.
  void renumber(std::span<const PatchId> numbers);

  /// The first, in the order they were given in, for which covers(patch) is true, of those whose reach is
  /// not too short.
  template <class Covers>
  std::optional<PatchId> first_over(Point<Part> p, const Covers& covers) const {
    Found found;
    if (!entries_.empty()) look(0, p, covers, found);
    return found.order == kNone ? std::nullopt : std::optional(found.patch);
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  struct Found {
    std::uint32_t order = kNone;
    PatchId patch = 0;
  };
  struct Entry {
    NearFeature feature;
    std::uint32_t order;
  };
  /// Of node i the halves are nodes 2 i + 1 and 2 i + 2.
  struct Node {
    Box box;
    std::uint32_t first, count;  ///< of the entries in it
    std::uint32_t least_order;
  };
  template <class Covers>
  void look(std::size_t at, Point<Part> p, const Covers& covers, Found& found) const {
    const Node& node = nodes_[at];
    const Box& b = node.box;
    if (node.least_order >= found.order || p.x < b.min.x || p.y < b.min.y || p.z < b.min.z || p.x > b.max.x ||
        p.y > b.max.y || p.z > b.max.z)
      return;
    if (const std::size_t left = 2 * at + 1; left < nodes_.size()) {
      look(left, p, covers, found);
      return look(left + 1, p, covers, found);
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const auto& [feature, order] = entries_[i];
      if (order < found.order && squared_length(p - feature.centre) <= feature.reach * feature.reach &&
          covers(feature.patch))
        found = {order, feature.patch};
    }
  }
  void build(std::size_t at, std::uint32_t first, std::uint32_t count);

  std::vector<Entry> entries_;  ///< leaf by leaf
  std::vector<Node> nodes_;
};

}  // namespace tiltfeed::pathgen
