#include "tests/bench/height_field.h"

#include <cmath>
#include <cstdint>

namespace tiltfeed::bench {

namespace {

constexpr double kSide = 100.0, kBottom = -20.0;  // mm

double height(double x, double y) {
  return 4.0 * std::sin(0.13 * x) * std::cos(0.11 * y) + 1.5 * std::sin(0.5 * x + 0.3 * y) +
         0.6 * std::cos(0.9 * y - 0.4 * x) + 0.15 * std::sin(2.3 * x) * std::sin(1.9 * y);
}

}  // namespace

sim::Triangles height_field(std::size_t facets) {
  const auto n = std::lround(std::sqrt(static_cast<double>(facets) / 2.0));
  const auto at = [&](long i) { return kSide * static_cast<double>(i) / static_cast<double>(n); };
  const auto top = [&](long i, long j) { return Point<Part>{at(i), at(j), height(at(i), at(j))}; };
  const auto below = [&](long i, long j) { return Point<Part>{at(i), at(j), kBottom}; };
  sim::Triangles out;
  for (long j = 0; j < n; ++j)
    for (long i = 0; i < n; ++i) {
      const Point<Part> a = top(i, j), b = top(i + 1, j), c = top(i + 1, j + 1), d = top(i, j + 1);
      if ((i + j) % 2 == 0)
        out.push_back({a, b, d}), out.push_back({b, c, d});
      else
        out.push_back({a, b, c}), out.push_back({a, c, d});
    }
  const Point<Part> middle{kSide / 2.0, kSide / 2.0, kBottom};
  const auto wall = [&](long i0, long j0, long i1, long j1) {
    out.push_back({below(i0, j0), below(i1, j1), top(i1, j1)});
    out.push_back({below(i0, j0), top(i1, j1), top(i0, j0)});
    out.push_back({below(i1, j1), below(i0, j0), middle});
  };
  for (long i = 0; i < n; ++i)
    wall(i, 0, i + 1, 0), wall(n, i, n, i + 1), wall(i + 1, n, i, n), wall(0, i + 1, 0, i);
  return out;
}

}  // namespace tiltfeed::bench
