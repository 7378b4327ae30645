#include "pathgen/indexed/indexed_regions.h"

#include <cmath>
#include <limits>

namespace tiltfeed::pathgen {

IndexedRegions::IndexedRegions(const std::vector<SurfaceCell>& cells, double size,
                               const std::vector<Vec3>& directions,
                               const std::vector<std::vector<std::uint8_t>>& sets, double overlap)
    : cells_(cells), size_(size), wanted_(cells.size(), 0), area_(directions.size(), 0.0) {
  constexpr std::uint32_t kNone = 32;
  const double near = std::max(size, overlap);
  std::vector<std::uint32_t> owner(cells.size(), kNone);
  std::unordered_map<Key, std::uint32_t, Hash> owners;
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    double best = -1.0;
    for (std::uint32_t d = 0; d < directions.size(); ++d) {
      const double facing = dot(directions[d], cells[c].normal);
      if (sets[d][c] != 0 && facing > best) best = facing, owner[c] = d;
    }
    at_[key(cells[c].place, size_)].push_back(c);
    if (owner[c] == kNone) continue;
    area_[owner[c]] += cells[c].area;
    owners[key(cells[c].place, near)] |= 1u << owner[c];
  }
  for (std::uint32_t c = 0; c < cells.size(); ++c) {
    if (owner[c] == kNone) {
      wanted_[c] = ~0u;
      continue;
    }
    wanted_[c] = 1u << owner[c];
    std::uint32_t beside = 0;
    each_near(cells[c].place, near, [&](const Key& k) {
      if (const auto found = owners.find(k); found != owners.end()) beside |= found->second;
    });
    for (std::uint32_t d = 0; d < directions.size(); ++d)
      if (sets[d][c] != 0 && (beside >> d & 1u) != 0) wanted_[c] |= 1u << d;
  }
}

bool IndexedRegions::wants(std::size_t d, Point<Part> p, std::uint32_t facet) const {
  double least = std::numeric_limits<double>::infinity();
  std::uint32_t wanted = ~0u;
  // A place lies nearer to the middle of its own cell than a cell is long.
  each_near(p, size_, [&](const Key& k) {
    const auto found = at_.find(k);
    if (found == at_.end()) return;
    for (const std::uint32_t c : found->second) {
      const double away = squared_length(cells_[c].place - p);
      if (cells_[c].facet == facet && away < least) least = away, wanted = wanted_[c];
    }
  });
  return (wanted >> d & 1u) != 0;
}

std::size_t IndexedRegions::Hash::operator()(const Key& k) const {
  return static_cast<std::size_t>(k[0] * 73'856'093 ^ k[1] * 19'349'663 ^ k[2] * 83'492'791);
}

IndexedRegions::Key IndexedRegions::key(Point<Part> p, double edge) {
  return {std::llround(p.x / edge), std::llround(p.y / edge), std::llround(p.z / edge)};
}

template <class Visit>
void IndexedRegions::each_near(Point<Part> p, double edge, const Visit& visit) {
  const Key middle = key(p, edge);
  for (std::int64_t x = -1; x <= 1; ++x)
    for (std::int64_t y = -1; y <= 1; ++y)
      for (std::int64_t z = -1; z <= 1; ++z) visit(Key{middle[0] + x, middle[1] + y, middle[2] + z});
}

}  // namespace tiltfeed::pathgen
