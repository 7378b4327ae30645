#include "pathgen/axis/direction_grid.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <utility>

namespace tiltfeed::pathgen {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

constexpr std::array<Triangle, 20> kIcosahedron{{{0, 4, 1},  {0, 9, 4},  {9, 5, 4},  {4, 5, 8},  {4, 8, 1},
                                                 {8, 10, 1}, {8, 3, 10}, {5, 3, 8},  {5, 2, 3},  {2, 7, 3},
                                                 {7, 10, 3}, {7, 6, 10}, {7, 11, 6}, {11, 0, 6}, {0, 1, 6},
                                                 {6, 1, 10}, {9, 0, 11}, {9, 11, 2}, {9, 2, 5},  {7, 2, 11}}};

std::vector<Vec3> icosahedron() {
  const double x = 0.525731112119133606, z = 0.850650808352039932;
  return {{-x, 0, z}, {x, 0, z},   {-x, 0, -z}, {x, 0, -z}, {0, z, x},  {0, z, -x},
          {0, -z, x}, {0, -z, -x}, {z, x, 0},   {-z, x, 0}, {z, -x, 0}, {-z, -x, 0}};
}

}  // namespace

DirectionGrid::DirectionGrid(int level) : level_(level), directions_(icosahedron()) {
  std::vector<Triangle> triangles(kIcosahedron.begin(), kIcosahedron.end());
  for (int i = 0; i < level; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
    const auto between = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] = middle.try_emplace(std::minmax(a, b), directions_.size());
      if (is_new) directions_.push_back(normalized(directions_[a] + directions_[b]));
      return at->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  for (int i = 0; i <= level; ++i) {
    std::vector<std::uint32_t>& order = rising_.emplace_back(count(i));
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
      return directions_[a].z < directions_[b].z;
    });
  }
}

double DirectionGrid::coverage(int level) {
  // The middle of an icosahedron's facet is 37.38 degrees from its corners; each cut a little over halves
  // that.
  return 0.6525 / static_cast<double>(1 << level) * (level > 0 ? 1.15 : 1.0);
}

DirectionNeighbours::DirectionNeighbours(const DirectionGrid& grid, int level, double chord)
    : chord_(chord), near_(DirectionGrid::count(level)) {
  for (std::uint32_t i = 0; i < near_.size(); ++i) {
    for (std::uint32_t k = 0; k < near_.size(); ++k) {
      const double square = squared_length(grid.directions()[i] - grid.directions()[k]);
      if (square <= chord * chord) near_[i].push_back({k, square});
    }
    std::stable_sort(near_[i].begin(), near_[i].end(),
                     [](const Neighbour& a, const Neighbour& b) { return a.square < b.square; });
  }
}

}  // namespace tiltfeed::pathgen
