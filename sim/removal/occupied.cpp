#include "sim/removal/occupied.h"

#include <algorithm>

namespace tiltfeed::sim {
namespace {

// Size of a cube, in cells, and at least, mm.
constexpr double kCubeCells = 4.0, kLeastCube = 2.0;
constexpr std::uint16_t kFarCubes = 60000;  // more are not counted

}  // namespace

Occupied::Occupied(const Stock& stock, double reach)
    : origin_(from_origin(stock.box.min)), cube_(std::max(kLeastCube, kCubeCells * stock.cell)) {
  by_ = static_cast<int>(reach / cube_) + 1;
  const double wide = by_ * cube_;
  origin_ = origin_ - Vec3{wide, wide, wide};
  const Vec3 size = from_origin(stock.box.max) + Vec3{wide, wide, wide} - origin_;
  size_ = {static_cast<int>(size.x / cube_) + 1, static_cast<int>(size.y / cube_) + 1,
           static_cast<int>(size.z / cube_) + 1};
  end_ = origin_ + Vec3{size_[0] * cube_, size_[1] * cube_, size_[2] * cube_};
  cubes_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2], kFarCubes);
  for (const Dexels& dexels : stock.bundles) {
    for (int stripe = 0; stripe < Dexels::kStripes; ++stripe) {
      dexels.each(stripe, [&](Point<Part> foot, double low, double high) {
        std::array<double, 3> p{foot.x, foot.y, foot.z};
        p[dexels.axis()] = low;
        std::array<int, 3> from = index({p[0], p[1], p[2]});
        p[dexels.axis()] = high;
        const int last = index({p[0], p[1], p[2]})[dexels.axis()];
        for (int& k = from[dexels.axis()]; k <= last; ++k) cubes_[at(from[0], from[1], from[2])] = 0;
      });
    }
  }
  measure();
}

/// Forward and backward: a cube is at most one further than those of its neighbours that came before.
void Occupied::measure() {
  const auto look = [&](int x, int y, int z, int back) {
    std::uint16_t& here = cubes_[at(x, y, z)];
    const auto other = [&](int dx, int dy, int dz) {
      const int ox = x + dx, oy = y + dy, oz = z + dz;
      if (ox < 0 || oy < 0 || oz < 0 || ox >= size_[0] || oy >= size_[1] || oz >= size_[2]) return;
      here = std::min(here, static_cast<std::uint16_t>(cubes_[at(ox, oy, oz)] + 1));
    };
    for (int k = -1; k <= 1; ++k) {
      for (int l = -1; l <= 1; ++l) other(l, k, back);
      other(k, back, 0);
    }
    other(back, 0, 0);
  };
  for (int z = 0; z < size_[2]; ++z)
    for (int y = 0; y < size_[1]; ++y)
      for (int x = 0; x < size_[0]; ++x) look(x, y, z, -1);
  for (int z = size_[2]; z-- > 0;)
    for (int y = size_[1]; y-- > 0;)
      for (int x = size_[0]; x-- > 0;) look(x, y, z, 1);
}

std::array<int, 3> Occupied::index(Vec3 p) const {
  const auto cube = [&](double v, int size) {
    return static_cast<int>(std::clamp(v / cube_, 0.0, size - 1.0));
  };
  const Vec3 from = p - origin_;
  return {cube(from.x, size_[0]), cube(from.y, size_[1]), cube(from.z, size_[2])};
}

double Occupied::clear(Point<Part> p) const {
  const Vec3 q = from_origin(p), below = origin_ - q, above = q - end_;
  const double outside = std::max({below.x, below.y, below.z, above.x, above.y, above.z});
  if (outside > 0.0) return outside;
  const auto i = index(q);
  // Less than k cubes away from p is no further than k cubes from its own.
  const int cubes = cubes_[at(i[0], i[1], i[2])] - by_;
  return cubes > 0 ? (cubes - 1) * cube_ : -1.0;
}

}  // namespace tiltfeed::sim
