#include "pathgen/surface/drop_bvh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// Patches of a leaf, at most.
constexpr std::uint32_t kLeafPatches = 4;
/// Boxes of slivers end here (mm).
constexpr double kEnd = 1e7;
/// A wall of the tool may stand this much nearer, and a contact lie this much higher (mm): rounding where the
/// tool just grazes a feature. They are bounds only.
constexpr double kGrazing = 1e-4, kRounding = 1e-6;

/// Over the contact at distance d from the axis, the ring centre.
double ring_over(const ToolPiece& piece, double d) {
  const double over = d - piece.flat;
  if (over <= 0.0) return piece.corner;
  if (over <= piece.corner * piece.taper_cos) return std::sqrt(piece.corner * piece.corner - over * over);
  return piece.has_cone() ? -piece.cone_height(std::min(d, piece.outer)) : 0.0;
}

constexpr float kFarFlat = std::numeric_limits<float>::infinity();
constexpr LooseBox kNothing{kFarFlat, -kFarFlat, kFarFlat, -kFarFlat};
LooseBox round_both(const LooseBox& a, const LooseBox& b) {
  return {std::min(a.low_x, b.low_x), std::max(a.high_x, b.high_x), std::min(a.low_y, b.low_y),
          std::max(a.high_y, b.high_y)};
}

struct Corners {
  std::array<double, 3> low{kEnd, kEnd, kEnd}, high{-kEnd, -kEnd, -kEnd};
  void add(Point<Part> p, double slack) {
    const std::array<double, 3> c{p.x, p.y, p.z};
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::max(-kEnd, std::min(low[k], c[k] - slack));
      high[k] = std::min(kEnd, std::max(high[k], c[k] + slack));
    }
  }
};

/// Where contacts with the feature are: (C4) its borders are `slack` further out. Of a facet that moves the
/// corners away from the middle of the inscribed circle.
Corners contacts_of(const ClSurface::Core& core, double slack) {
  Corners corners;
  for (const Point<Part>& p : core.points()) corners.add(p, slack);
  if (core.count < 3) return corners;
  const auto& [a, b, c] = core.corner;
  const double at_a = distance(b, c), at_b = distance(c, a), at_c = distance(a, b),
               round = at_a + at_b + at_c;
  const double radius = length(cross(b - a, c - a)) / round;
  const Point<Part> middle = a + (b - a) * (at_b / round) + (c - a) * (at_c / round);
  const double grown = radius * kEnd > slack ? slack / radius : kEnd;
  for (const Point<Part>& p : core.points()) corners.add(p + (p - middle) * grown, slack);
  return corners;
}

}  // namespace

DropBvh::Box DropBvh::box_of(const ClSurface& surface, PatchId patch) {
  const ToolPiece& piece = surface.piece(patch);
  const Corners corners = contacts_of(surface.core(patch), 2.0 * kSeam * (piece.flat + piece.corner));
  Box box;
  for (std::size_t k = 0; k < 3; ++k) {
    const double middle = 0.5 * (corners.low[k] + corners.high[k]);
    const double half = 0.5 * (corners.high[k] - corners.low[k]);
    box.middle[k] = static_cast<float>(middle);
    box.half[k] = static_cast<float>(half + kSingle * (half + std::abs(middle)));
  }
  return box;
}

DropBvh::DropBvh(const ClSurface& surface, const FlatHulls& hulls, std::size_t first, std::size_t last,
                 double period_x, double period_y)
    : piece_(surface.piece(hulls.hulls[first].patch)),
      first_(hulls.hulls[first].patch),
      last_(hulls.hulls[last - 1].patch),
      period_x_(period_x),
      period_y_(period_y) {
  const FlatHull* all = hulls.hulls.data();
  std::vector<std::uint32_t> firsts;
  for (std::size_t i = first; i < last; ++i)
    if (i == first || all[i].patch != all[i - 1].patch) firsts.push_back(static_cast<std::uint32_t>(i));
  entries_.resize(firsts.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, firsts.size(), kSideBySide), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const PatchId patch = all[firsts[i]].patch;
      LooseBox flat = kNothing;
      for (std::size_t k = firsts[i]; k < last && all[k].patch == patch; ++k)
        flat = round_both(flat, loosened(pathgen::box_of(hulls, all[k])));
      entries_[i] = {box_of(surface, patch), flat, {patch, firsts[i]}};
    }
  });
  std::size_t leaves = 1;
  while (leaves * kLeafPatches < firsts.size()) leaves *= 2;
  nodes_.resize(2 * leaves - 1);
  build(0, 0, static_cast<std::uint32_t>(firsts.size()));
}

/// Halves by whichever border of the patches' boxes differs most, so that what is long is kept from what is
/// short.
void DropBvh::build(std::size_t at, std::uint32_t first, std::uint32_t count) {
  const auto begin = entries_.begin() + first, end = begin + count;
  constexpr float kFar = std::numeric_limits<float>::infinity();
  const auto border = [](const Entry& e, std::size_t k) {
    return k < 3 ? e.box.middle[k] - e.box.half[k] : e.box.middle[k - 3] + e.box.half[k - 3];
  };
  std::array<float, 6> low{kFar, kFar, kFar, kFar, kFar, kFar},
      high{-kFar, -kFar, -kFar, -kFar, -kFar, -kFar};
  Node node{{}, kNothing, first, count};
  for (auto e = begin; e != end; ++e) {
    node.flat = round_both(node.flat, e->flat);
    for (std::size_t k = 0; k < 6; ++k)
      low[k] = std::min(low[k], border(*e, k)), high[k] = std::max(high[k], border(*e, k));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const double from = low[k], to = high[k + 3], middle = 0.5 * (from + to), half = 0.5 * (to - from);
    node.box.middle[k] = static_cast<float>(middle);
    node.box.half[k] = static_cast<float>(half + 2.0 * kSingle * (half + std::abs(middle)));
  }
  if (count == 0) node.box = {{}, {-1.0f, -1.0f, -1.0f}};
  nodes_[at] = node;
  if (2 * at + 1 >= nodes_.size()) return;
  std::size_t by = 0;
  for (std::size_t k = 1; k < 6; ++k)
    if (high[k] - low[k] > high[by] - low[by]) by = k;
  const std::uint32_t half = count / 2;
  std::nth_element(begin, begin + half, end, [&](const Entry& a, const Entry& b) {
    const float ka = border(a, by), kb = border(b, by);
    return ka != kb ? ka < kb : a.found.patch < b.found.patch;
  });
  const auto left = [&] { build(2 * at + 1, first, half); };
  const auto right = [&] { build(2 * at + 2, first + half, count - half); };
  if (count < kSideBySide) {
    left(), right();
  } else {
    tbb::parallel_invoke(left, right);
  }
}

double DropBvh::furthest_from(Point<Part> origin) const {
  const Box& all = nodes_.front().box;
  const Vec3 off = Point<Part>{all.middle[0], all.middle[1], all.middle[2]} - origin;
  return length(off) + length(Vec3{all.half[0], all.half[1], all.half[2]});
}

double DropBvh::highest(const Box& box, const Asked& asked) const {
  const AxisLine& line = asked.line;
  const double most = asked.heights.high;
  if (box.half[0] < 0.0f) return kNowhere;
  const Vec3 half{box.half[0], box.half[1], box.half[2]};
  const auto reach = [&](Vec3 way) {
    return std::abs(way.x) * half.x + std::abs(way.y) * half.y + std::abs(way.z) * half.z;
  };
  const Vec3 off = Point<Part>{box.middle[0], box.middle[1], box.middle[2]} - line.base;
  const double height = dot(off, line.axis), up = reach(line.axis) + asked.at.slack;
  // No place of the piece is higher over its contact than over that of its bottom.
  const double top = height + up - piece_.above_reference + kRounding;
  if (top + piece_.corner < asked.heights.low) return kNowhere;
  const Vec3 aside = off - line.axis * height;
  const double away = length(aside);
  const double near = away > 0.0 ? away - reach(aside) / away - asked.at.slack - kGrazing : 0.0;
  if (near > piece_.outer) return kNowhere;
  if (most < std::numeric_limits<double>::infinity()) {
    const double far = std::min(piece_.outer, away + length(half) + asked.at.slack);
    const double least = height - up + ring_over(piece_, far) - piece_.above_reference - kRounding;
    if (least > most) return kNowhere;
  }
  return top + ring_over(piece_, near);
}

}  // namespace tiltfeed::pathgen
