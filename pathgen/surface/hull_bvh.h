#pragma once
// Hulls found by how high they reach: a tree of boxes, each with the highest CL point of what is in it. Most
// of shank and holder lies far below the passes, and is never looked at one by one. (G3) in
// pathgen/pattern/README.md.

#include <cmath>
#include <cstdint>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/fresh_memory.h"
#include "pathgen/surface/flat_bins.h"
#include "pathgen/surface/flat_hulls.h"

namespace tiltfeed::pathgen {

/// Round a hull's corners, with its pads.
FlatBox box_of(const FlatHulls& hulls, const FlatHull& hull);

/// Of fewer entries of a tree one thread sees to both halves.
inline constexpr std::uint32_t kSideBySide = 4096;

class HullBvh {
 public:
  HullBvh() = default;
  /// The same for any number of threads.
  HullBvh(const FlatHulls& hulls, const Deformation& deformation);

  bool empty() const { return entries_.empty(); }

  /// A hull as a question meets it: on the turn of its place.
  struct Found {
    std::uint32_t hull;
    PatchId patch;
    double shift_x, shift_y;
  };
  /// Calls visit(Found) for each hull whose box overlaps `round` and, as all boxes of the tree that hold it,
  /// is wanted: wanted(box, top), `top` being the highest of the hulls in the box. The higher half comes
  /// first, so that what is found there may settle the lower.
  template <class Wanted, class Visit>
  void each(const FlatBox& round, Wanted wanted, Visit visit) const {
    if (entries_.empty()) return;
    const auto turns = [](double period, double low, double high, double to_low, double to_high,
                          double& first, double& last) {
      first = last = 0.0;
      if (period <= 0.0) return;
      first = std::ceil((to_low - high) / period), last = std::floor((to_high - low) / period);
    };
    const LooseBox& all = nodes_[0].box;
    double x0, x1, y0, y1;
    turns(period_x_, all.low_x, all.high_x, round.low_x, round.high_x, x0, x1);
    turns(period_y_, all.low_y, all.high_y, round.low_y, round.high_y, y0, y1);
    for (double tx = x0; tx <= x1; ++tx)
      for (double ty = y0; ty <= y1; ++ty) descend(0, round, tx * period_x_, ty * period_y_, wanted, visit);
  }

 private:
  struct Entry {
    LooseBox box;
    float top;
    PatchId patch;
    std::uint32_t hull;
  };
  /// Of node i the halves are nodes 2 i + 1 and 2 i + 2.
  struct Node {
    LooseBox box;
    float top;
    std::uint32_t first, count;  ///< of the entries in it
  };
  static FlatBox moved(const LooseBox& b, double x, double y) {
    return {b.low_x + x, b.high_x + x, b.low_y + y, b.high_y + y};
  }
  template <class Wanted, class Visit>
  void descend(std::size_t at, const FlatBox& round, double x, double y, Wanted& wanted, Visit& visit) const {
    const Node& node = nodes_[at];
    const FlatBox box = moved(node.box, x, y);
    if (!box.overlaps(round) || !wanted(box, node.top)) return;
    if (const std::size_t left = 2 * at + 1; left < nodes_.size()) {
      const bool right_first = nodes_[left + 1].top > nodes_[left].top;
      descend(right_first ? left + 1 : left, round, x, y, wanted, visit);
      descend(right_first ? left : left + 1, round, x, y, wanted, visit);
      return;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Entry& entry = entries_[i];
      const FlatBox own = moved(entry.box, x, y);
      if (own.overlaps(round) && wanted(own, entry.top)) visit(Found{entry.hull, entry.patch, x, y});
    }
  }
  void build(std::size_t at, std::uint32_t first, std::uint32_t count);

  FreshVector<Entry> entries_;  ///< leaf by leaf
  std::vector<Node> nodes_;
  double period_x_ = 0.0, period_y_ = 0.0;
};

}  // namespace tiltfeed::pathgen
