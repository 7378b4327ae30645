#include "pathgen/surface/hull_bvh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <limits>

namespace tiltfeed::pathgen {

namespace {

/// Hulls of a leaf, at most.
constexpr std::uint32_t kLeafHulls = 8;

}  // namespace

FlatBox box_of(const FlatHulls& hulls, const FlatHull& hull) {
  const FlatCorner* c = hulls.corners.data() + hull.first;
  FlatBox box{c->x, c->x, c->y, c->y};
  for (std::uint32_t i = 1; i < hull.count; ++i) {
    box.low_x = std::min<double>(box.low_x, c[i].x), box.high_x = std::max<double>(box.high_x, c[i].x);
    box.low_y = std::min<double>(box.low_y, c[i].y), box.high_y = std::max<double>(box.high_y, c[i].y);
  }
  box.low_x -= hull.pad_x, box.high_x += hull.pad_x;
  box.low_y -= hull.pad_y, box.high_y += hull.pad_y;
  return box;
}

HullBvh::HullBvh(const FlatHulls& hulls, const Deformation& deformation)
    : period_x_(deformation.period_x()), period_y_(deformation.period_y()) {
  const std::size_t count = hulls.hulls.size();
  if (count == 0) return;
  entries_.resize(count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kSideBySide), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const FlatHull& hull = hulls.hulls[i];
      entries_[i] = {loosened(box_of(hulls, hull)), hull.top, hull.patch, static_cast<std::uint32_t>(i)};
    }
  });
  std::size_t leaves = 1;
  while (leaves * kLeafHulls < count) leaves *= 2;
  nodes_.resize(2 * leaves - 1);
  build(0, 0, static_cast<std::uint32_t>(count));
}

/// Halves along whichever of x', y' and the height the hulls differ most in.
void HullBvh::build(std::size_t at, std::uint32_t first, std::uint32_t count) {
  const auto begin = entries_.begin() + first, end = begin + count;
  constexpr float kFar = std::numeric_limits<float>::infinity();
  Node node{{kFar, -kFar, kFar, -kFar}, -kFar, first, count};
  std::array<float, 3> low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
  const auto key = [](const Entry& e, std::size_t k) {
    return k == 0 ? e.box.low_x + e.box.high_x : k == 1 ? e.box.low_y + e.box.high_y : 2.0f * e.top;
  };
  for (auto e = begin; e != end; ++e) {
    node.box = {std::min(node.box.low_x, e->box.low_x), std::max(node.box.high_x, e->box.high_x),
                std::min(node.box.low_y, e->box.low_y), std::max(node.box.high_y, e->box.high_y)};
    node.top = std::max(node.top, e->top);
    for (std::size_t k = 0; k < 3; ++k)
      low[k] = std::min(low[k], key(*e, k)), high[k] = std::max(high[k], key(*e, k));
  }
  nodes_[at] = node;
  if (2 * at + 1 >= nodes_.size()) return;
  std::size_t along = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (high[k] - low[k] > high[along] - low[along]) along = k;
  const std::uint32_t half = count / 2;
  std::nth_element(begin, begin + half, end, [&](const Entry& a, const Entry& b) {
    const float ka = key(a, along), kb = key(b, along);
    return ka != kb ? ka < kb : a.hull < b.hull;
  });
  const auto left = [&] { build(2 * at + 1, first, half); };
  const auto right = [&] { build(2 * at + 2, first + half, count - half); };
  if (count < kSideBySide) {
    left(), right();
  } else {
    tbb::parallel_invoke(left, right);
  }
}

}  // namespace tiltfeed::pathgen
