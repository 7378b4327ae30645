#pragma once
// Patches found by how high a piece of the tool may come down on them: a tree of boxes in part space. It
// serves where hulls are wide, and most of the part may be the highest at each place: near the point, line or
// circle, and under a wide tool. (S8) in pathgen/surface/README.md.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "pathgen/mesh/fresh_memory.h"
#include "pathgen/surface/cl_surface.h"
#include "pathgen/surface/hull_bvh.h"

namespace tiltfeed::pathgen {

class DropBvh {
 public:
  /// Of the patches of one piece that have hulls, which are those from `first` up to `last`. A period of 0:
  /// the coordinate does not wrap. Requires: at least one hull. The same for any number of threads.
  DropBvh(const ClSurface& surface, const FlatHulls& hulls, std::size_t first, std::size_t last,
          double period_x, double period_y);

  /// No contact is further than this from there.
  double furthest_from(Point<Part> origin) const;
  PatchId first() const { return first_; }
  PatchId last() const { return last_; }

  struct Found {
    PatchId patch;
    std::uint32_t hull;  ///< the first of the patch
  };
  /// The heights of the CL reference that are asked for.
  struct Heights {
    double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  };
  /// A straight stretch of the flat space: its middle, half its extent, and how far (mm) what the tool meets
  /// may lie nearer at its ends than in the middle.
  struct Stretch {
    double x, y, half_x = 0.0, half_y = 0.0, slack = 0.0;
  };
  /// Calls take(Found) for each patch one of whose hulls may hold the place (x, y) and that may be touched
  /// there at heights `asked`, those that may be the highest first. `line`: that of the place. `take` may
  /// raise asked.low. Returns how many boxes were looked at.
  template <class Take>
  std::size_t each(double x, double y, const AxisLine& line, const Heights& asked, Take take) const {
    return each(Stretch{x, y}, line, asked, take);
  }
  /// The same for any place of the stretch; `line`: that of its middle.
  template <class Take>
  std::size_t each(const Stretch& stretch, const AxisLine& line, const Heights& asked, Take take) const {
    const Asked all{{wrapped(stretch.x, period_x_), wrapped(stretch.y, period_y_), stretch.half_x,
                     stretch.half_y, stretch.slack},
                    line,
                    asked};
    std::size_t boxes = 1;
    const double top = highest_of(nodes_[0], all);
    if (top >= asked.low && top > kNowhere) descend(0, all, take, boxes);
    return boxes;
  }

 private:
  /// Middle and half the size.
  struct Box {
    std::array<float, 3> middle, half;
  };
  static constexpr double kNowhere = -std::numeric_limits<double>::infinity();
  struct Entry {
    Box box;
    LooseBox flat;  ///< round all hulls of the patch
    Found found;
  };
  /// Of node i the halves are nodes 2 i + 1 and 2 i + 2.
  struct Node {
    Box box;
    LooseBox flat;
    std::uint32_t first, count;  ///< of the entries in it
  };
  struct Asked {
    Stretch at;
    const AxisLine& line;
    const Heights& heights;
  };
  static Box box_of(const ClSurface& surface, PatchId patch);
  static double wrapped(double v, double period) {
    return period > 0.0 ? v - period * std::round(v / period) : v;
  }
  static bool holds(double low, double high, double v, double half, double period) {
    low -= half, high += half;
    if (v >= low && v <= high) return true;
    return period > 0.0 &&
           ((v + period >= low && v + period <= high) || (v - period >= low && v - period <= high));
  }
  bool holds(const LooseBox& flat, const Asked& asked) const {
    return holds(flat.low_x, flat.high_x, asked.at.x, asked.at.half_x, period_x_) &&
           holds(flat.low_y, flat.high_y, asked.at.y, asked.at.half_y, period_y_);
  }
  /// No contact in the box leaves the CL reference higher; minus infinity where there is none.
  double highest(const Box& box, const Asked& asked) const;
  template <class Entries>
  double highest_of(const Entries& some, const Asked& asked) const {
    return holds(some.flat, asked) ? highest(some.box, asked) : kNowhere;
  }
  template <class Take>
  void descend(std::size_t at, const Asked& asked, Take& take, std::size_t& boxes) const {
    if (const std::size_t left = 2 * at + 1; left < nodes_.size()) {
      boxes += 2;
      const double tops[2]{highest_of(nodes_[left], asked), highest_of(nodes_[left + 1], asked)};
      const std::size_t first = tops[1] > tops[0] ? 1 : 0;
      for (const std::size_t half : {first, 1 - first})
        if (tops[half] >= asked.heights.low && tops[half] > kNowhere)
          descend(left + half, asked, take, boxes);
      return;
    }
    const Node& node = nodes_[at];
    boxes += node.count;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const double top = highest_of(entries_[i], asked);
      if (top >= asked.heights.low && top > kNowhere) take(entries_[i].found);
    }
  }
  void build(std::size_t at, std::uint32_t first, std::uint32_t count);

  ToolPiece piece_;
  PatchId first_ = 0, last_ = 0;
  double period_x_ = 0.0, period_y_ = 0.0;
  FreshVector<Entry> entries_;  ///< leaf by leaf
  std::vector<Node> nodes_;
};

}  // namespace tiltfeed::pathgen
