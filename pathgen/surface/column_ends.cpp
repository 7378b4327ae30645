#include "pathgen/surface/column_ends.h"

#include <algorithm>

namespace tiltfeed::pathgen {

namespace {

/// Features of a leaf, at most.
constexpr std::size_t kLeafFeatures = 8;
/// By how much rounding may shorten a reach, as a share of it, and mm.
constexpr double kSpareShare = 1e-9, kSpare = 1e-9;

double coordinate(Point<Part> p, int k) { return k == 0 ? p.x : k == 1 ? p.y : p.z; }

}  // namespace

ColumnEnds::ColumnEnds(std::vector<NearFeature> all) {
  if (all.empty()) return;
  for (NearFeature& feature : all) {
    feature.reach += kSpareShare * feature.reach + kSpare;
    entries_.push_back({feature, static_cast<std::uint32_t>(entries_.size())});
  }
  std::size_t leaves = 1;
  while (leaves * kLeafFeatures < entries_.size()) leaves *= 2;
  nodes_.resize(2 * leaves - 1);
  build(0, 0, static_cast<std::uint32_t>(entries_.size()));
}

void ColumnEnds::renumber(std::span<const PatchId> numbers) {
  for (Entry& entry : entries_) entry.feature.patch = numbers[entry.feature.patch];
}

/// Halves along the coordinate in which the centres differ most.
void ColumnEnds::build(std::size_t at, std::uint32_t first, std::uint32_t count) {
  const auto begin = entries_.begin() + first, end = begin + count;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Box centres{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  Node node{centres, first, count, kNone};
  for (auto e = begin; e != end; ++e) {
    const auto& [patch, centre, reach] = e->feature;
    const Vec3 room{reach, reach, reach};
    centres = grown(centres, centre);
    node.box = grown(grown(node.box, centre - room), centre + room);
    node.least_order = std::min(node.least_order, e->order);
  }
  nodes_[at] = node;
  if (2 * at + 1 >= nodes_.size()) return;
  const Vec3 wide = centres.max - centres.min;
  const int k = wide.x >= wide.y && wide.x >= wide.z ? 0 : wide.y >= wide.z ? 1 : 2;
  const std::uint32_t half = count / 2;
  std::nth_element(begin, begin + half, end, [k](const Entry& a, const Entry& b) {
    return coordinate(a.feature.centre, k) < coordinate(b.feature.centre, k);
  });
  build(2 * at + 1, first, half);
  build(2 * at + 2, first + half, count - half);
}

}  // namespace tiltfeed::pathgen
