#pragma once
// Finds the patches that a straight line of the flat space can meet, and where along it. (S1), (S6) in
// pathgen/surface/README.md.

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/surface/candidates.h"
#include "pathgen/surface/drop_bvh.h"
#include "pathgen/surface/flat_bins.h"
#include "pathgen/surface/flat_hulls.h"
#include "pathgen/surface/hull_along.h"
#include "pathgen/surface/hull_bvh.h"

namespace tiltfeed::pathgen {

class FlatIndex {
 public:
  /// Requires: at least one hull.
  FlatIndex(FlatHulls hulls, const Deformation& deformation);
  /// The same with the hulls of shank and holder, which only guards() and bounds() show. `numbers`: of the
  /// patches of `cutter`, as the surface with shank and holder has them.
  FlatIndex(const FlatIndex& cutter, std::span<const PatchId> numbers, FlatHulls guards,
            const Deformation& deformation);

  /// What one thread needs to ask; reused from question to question.
  struct Scratch {
    std::vector<std::uint32_t> seen;  ///< per hull: the question it was last seen in
    std::uint32_t question = 0;
    std::vector<Candidate> pieces;  ///< of patches with several hulls
    CandidateSorting sorting;
  };

  /// Properties: a patch that is the highest anywhere on the line is among the candidates there; intervals of
  /// one patch do not overlap; they are sorted by (from, patch, to) and lie within [0, line.length].
  void along(const FlatLine& line, Scratch& scratch, std::vector<Candidate>& candidates) const;
  /// As along() of the patches of the cutting part that may be higher than `low` on the line; the others are
  /// left out. For short lines. `middle`: the axis line there. `surface`: as for drops().
  void along_over(const FlatLine& line, const AxisLine& middle, double low, const ClSurface& surface,
                  const Deformation& deformation, Scratch& scratch, std::vector<Candidate>& candidates) const;
  /// The same from where the line meets each hull (row_candidates.h), by rising patch.
  static void along(const FlatLine& line, std::span<const Candidate> met, Scratch& scratch,
                    std::vector<Candidate>& candidates);
  std::size_t hulls() const { return hulls_.hulls.size(); }
  /// The box round a hull, pads and all.
  FlatBox box(std::uint32_t hull) const {
    const LooseBox& b = boxes_[hull];
    return {b.low_x, b.high_x, b.low_y, b.high_y};
  }
  /// The hull, moved by (shift_x, shift_y), as lines in the direction (dx, dy) see it.
  HullAlong seen_along(std::uint32_t hull, double dx, double dy, double shift_x, double shift_y) const {
    const FlatHull& c = hulls_.hulls[hull];
    return {c, hulls_.corners.data() + c.first, dx, dy, shift_x, shift_y};
  }
  /// Calls visit(shift_x, shift_y) for each turn on which the box may overlap `swept`: over the seam, or on a
  /// line that passes it, there may be more than one.
  template <class Visit>
  void each_turn(const FlatBox& box, const FlatBox& swept, Visit visit) const {
    const auto turns = [](double period, double low, double high, double to_low, double to_high,
                          double& first, double& last) {
      first = last = 0.0;
      if (period <= 0.0) return;
      first = std::ceil((to_low - high) / period), last = std::floor((to_high - low) / period);
    };
    double x0, x1, y0, y1;
    turns(period_x_, box.low_x, box.high_x, swept.low_x, swept.high_x, x0, x1);
    turns(period_y_, box.low_y, box.high_y, swept.low_y, swept.high_y, y0, y1);
    for (double tx = x0; tx <= x1; ++tx)
      for (double ty = y0; ty <= y1; ++ty) visit(tx * period_x_, ty * period_y_);
  }

  /// A patch may be the highest in `box` only.
  struct Nearby {
    FlatBox box;
    PatchId patch = 0;
    float top = std::numeric_limits<float>::infinity();  ///< as FlatHull::top
  };
  /// The patches that may be the highest somewhere in `box`, the one that may be highest of all first; some
  /// more than once.
  void near(const FlatBox& box, Scratch& scratch, std::vector<Nearby>& nearby) const;
  /// As along(), for a line in the box that `nearby` was found for; intervals are those of the boxes.
  static void along(const FlatLine& line, const std::vector<Nearby>& nearby, Scratch& scratch,
                    std::vector<Candidate>& candidates);
  /// About the distance of neighbouring hulls, mm.
  double spacing() const { return bins_.spacing(); }

  /// Calls visit(patch) for each hull whose box holds (x, y), until it returns true; returns that.
  template <class Visit>
  bool any_at(double x, double y, Visit visit) const {
    return bins_.any_at(
        x, y, [&](std::uint32_t hull) { return holds(box(hull), x, y) && visit(hulls_.hulls[hull].patch); });
  }
  /// The same for the hulls of pieces for which wanted(piece) is true, until visit(patch) is. `line`: the
  /// axis line of the place. visit(patch) may be left out where the patch cannot be touched there at
  /// `heights`. Asked in the list; of many, once they have cost as much as the trees of drops() do, in those.
  template <class Wanted, class Visit>
  bool any_touched(double x, double y, const AxisLine& line, DropBvh::Heights heights,
                   const ClSurface& surface, Wanted wanted, Visit visit) const {
    std::size_t asked = 0;
    const auto in_list = [&](std::size_t most) {
      asked = 0;
      bool found = false;
      any_at(x, y, [&](PatchId patch) {
        if (++asked > most) return true;
        found = wanted(surface.piece(patch)) && visit(patch);
        return found;
      });
      return found;
    };
    bool found = in_list(kMostOfList);
    if (asked <= kMostOfList) return found;
    if (drops_after(asked, surface).empty()) {
      found = in_list(std::numeric_limits<std::size_t>::max());
      drops_after(asked, surface);
      return found;
    }
    for (const DropBvh& drops : cutter_drops(surface)) {
      if (!wanted(surface.piece(drops.first()))) continue;
      drops.each(x, y, line, heights, [&](const DropBvh::Found& one) {
        if (found || !holds(one, x, y) || !visit(one.patch)) return;
        found = true, heights.low = std::numeric_limits<double>::infinity();
      });
    }
    return found;
  }

  /// About how many hulls lines in the direction (dx, dy), `step` apart, cut in all.
  double crossings(double dx, double dy, double step) const;

  const FlatBounds& bounds() const { return bounds_; }
  /// About how far the CL surface is from the point, line or circle at most, mm.
  double furthest() const { return hulls_.furthest; }
  /// No CL point is higher than this (z'). Looks at all hulls.
  double top() const;
  const ColumnEnds& covering() const { return covering_; }
  const HullBvh& guards() const { return guards_; }
  /// A hull of guards() as lines in the direction (dx, dy) see it.
  HullAlong seen_along(const HullBvh::Found& guard, double dx, double dy) const {
    const FlatHull& c = guard_hulls_.hulls[guard.hull];
    return {c, guard_hulls_.corners.data() + c.first, dx, dy, guard.shift_x, guard.shift_y};
  }
  /// The hulls of the cutting part as such a tree.
  HullBvh tree(const Deformation& deformation) const { return {hulls_, deformation}; }

  /// The patches by how high each piece may come down on them, made when first asked for, by any thread.
  /// `surface`: that of the hulls, always the same.
  std::span<const DropBvh> drops(const ClSurface& surface) const;
  /// Those of the cutting part alone.
  std::span<const DropBvh> cutter_drops(const ClSurface& surface) const;
  /// The same once the patches dropped on have cost about as much as making it takes, else nothing;
  /// `dropped`: so many more.
  std::span<const DropBvh> drops_after(std::size_t dropped, const ClSurface& surface) const;
  /// Does a hull of the patch hold the place?
  bool holds(const DropBvh::Found& found, double x, double y) const;

 private:
  /// So many are asked one by one in any case.
  static constexpr std::size_t kMostOfList = 48;
  bool holds(const FlatBox& box, double x, double y) const {
    return holds_on_a_turn(box, x, y, period_x_, period_y_);
  }
  static bool holds_on_a_turn(const FlatBox& box, double x, double y, double period_x, double period_y) {
    const auto turned = [](double v, double low, double high, double period) {
      const double off = (low + high) / 2.0 - v;
      return period > 0.0 && std::abs(off) > period / 2.0 ? v + period * std::round(off / period) : v;
    };
    return box.holds(turned(x, box.low_x, box.high_x, period_x), turned(y, box.low_y, box.high_y, period_y));
  }
  bool has_siblings(std::uint32_t hull) const;
  void ask(Scratch& scratch) const;
  void add_hull(std::uint32_t hull, const FlatLine& line, const FlatBox& swept,
                std::vector<Candidate>& candidates) const;

  FlatHulls hulls_;
  FreshVector<LooseBox> boxes_;  ///< by hull
  /// Where a coordinate wraps and is covered past its seam, else 0.
  double period_x_ = 0.0, period_y_ = 0.0;
  FlatBounds bounds_;
  FlatBins bins_;
  ColumnEnds covering_;
  FlatHulls guard_hulls_;
  HullBvh guards_;
  double guard_period_x_ = 0.0, guard_period_y_ = 0.0;
  PatchId first_guard_ = std::numeric_limits<PatchId>::max();  ///< patches from here on are of guards
  struct Drops;
  std::shared_ptr<Drops> drops_;
};

}  // namespace tiltfeed::pathgen
