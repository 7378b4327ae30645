#include "tests/bench/height_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>

#include "sim/solid/distance.h"

namespace tiltfeed::bench {
using namespace pathgen;

namespace {

constexpr double kNothing = -sim::kInfinity;
/// Neighbouring patches overlap by this much (mm, or radius units), so that rounding leaves no gap.
constexpr double kSeam = 1e-9;
/// Of a step: where the first column lies. At round places columns would graze walls at round coordinates,
/// where the height is that of the top or of the bottom, as rounding has it.
constexpr double kFirstColumn = 0.381966;

/// A rectangle of the grid's plane.
struct Patch {
  double low_x = sim::kInfinity, high_x = -sim::kInfinity, low_y = sim::kInfinity, high_y = -sim::kInfinity;
  void add(Vec3 p) {
    low_x = std::min(low_x, p.x), high_x = std::max(high_x, p.x);
    low_y = std::min(low_y, p.y), high_y = std::max(high_y, p.y);
  }
  void widen(double by) { low_x -= by, high_x += by, low_y -= by, high_y += by; }
};

class Raiser {
 public:
  Raiser(const Mesh& mesh, const AxisFrame& frame, double radius, double step)
      : facets_(mesh.facets), radius_(radius) {
    const Vec3 b = cross(frame.n, frame.t);
    Patch whole;
    for (const Point<Part>& p : mesh.vertices) {
      const Vec3 v = p - frame.origin;
      vertices_.push_back({dot(v, frame.t), dot(v, b), dot(v, frame.n)});
      whole.add(vertices_.back());
    }
    whole.widen(radius);
    map_.step = step, map_.left = whole.low_x + kFirstColumn * step,
    map_.front = whole.low_y + kFirstColumn * step;
    map_.columns = static_cast<int>((whole.high_x - map_.left) / step) + 1;
    map_.rows = static_cast<int>((whole.high_y - map_.front) / step) + 1;
    map_.height.assign(static_cast<std::size_t>(map_.columns) * map_.rows, kNothing);
  }

  HeightMap raise() && {
    for (const auto& [a, b, c] : facets_)
      normals_.push_back(normalized(cross(vertices_[b] - vertices_[a], vertices_[c] - vertices_[a])));
    for (std::uint32_t f = 0; f < facets_.size(); ++f) raise_facet(f);
    pair_edges();
    for (const auto& [half, other] : pairs_) raise_edge(half, other);
    raise_vertices();
    return std::move(map_);
  }

 private:
  /// height(x, y) is the patch's z there, or kNothing beyond its border.
  template <class Height>
  void raise_under(const Patch& patch, const Height& height) {
    const int first = std::max(0, static_cast<int>(std::ceil((patch.low_x - kSeam - map_.left) / map_.step)));
    const int last = std::min(map_.columns - 1,
                              static_cast<int>(std::floor((patch.high_x + kSeam - map_.left) / map_.step)));
    const int front =
        std::max(0, static_cast<int>(std::ceil((patch.low_y - kSeam - map_.front) / map_.step)));
    const int back = std::min(map_.rows - 1,
                              static_cast<int>(std::floor((patch.high_y + kSeam - map_.front) / map_.step)));
    for (int row = front; row <= back; ++row) {
      double* line = map_.height.data() + static_cast<std::size_t>(row) * map_.columns;
      for (int i = first; i <= last; ++i)
        line[i] = std::max(line[i], height(map_.left + i * map_.step, map_.front + row * map_.step));
    }
  }

  void raise_facet(std::uint32_t f) {
    const Vec3 n = normals_[f];
    if (n.z <= 0.0) return;
    Vec3 v[3];
    Patch patch;
    for (int i = 0; i < 3; ++i) patch.add(v[i] = vertices_[facets_[f][i]] + n * radius_);
    raise_under(patch, [&](double x, double y) {
      for (int i = 0; i < 3; ++i) {
        const Vec3 a = v[i], e = v[(i + 1) % 3] - a;
        if (e.x * (y - a.y) - e.y * (x - a.x) < -kSeam) return kNothing;
      }
      return v[0].z - (n.x * (x - v[0].x) + n.y * (y - v[0].y)) / n.z;
    });
  }

  std::uint32_t from(std::uint32_t half) const { return facets_[half / 3][half % 3]; }
  std::uint32_t to(std::uint32_t half) const { return facets_[half / 3][(half + 1) % 3]; }
  std::uint32_t apex(std::uint32_t half) const { return facets_[half / 3][(half + 2) % 3]; }

  void pair_edges() {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> by_ends;
    for (std::uint32_t half = 0; half < 3 * facets_.size(); ++half) {
      const std::uint64_t a = from(half), b = to(half);
      by_ends.emplace_back(std::min(a, b) << 32 | std::max(a, b), half);
    }
    std::sort(by_ends.begin(), by_ends.end());
    for (std::size_t i = 0; i + 1 < by_ends.size(); i += 2) {
      assert(by_ends[i].first == by_ends[i + 1].first);
      pairs_.emplace_back(by_ends[i].second, by_ends[i + 1].second);
    }
  }

  /// The cylinder about the edge, where the contact normal lies between those of the two facets.
  void raise_edge(std::uint32_t half, std::uint32_t other) {
    const Vec3 n1 = normals_[half / 3], n2 = normals_[other / 3];
    const Vec3 p = vertices_[from(half)], q = vertices_[to(half)];
    if (dot(n1, vertices_[apex(other)] - p) >= 0.0 || (n1.z <= 0.0 && n2.z <= 0.0)) return;
    Patch patch;
    for (const Vec3 end : {p, q})
      for (const Vec3 n : {n1, n2}) patch.add(end + n * radius_);
    const Vec3 sum = n1 + n2;
    patch.widen(radius_ * (1.0 - 0.5 * length(sum)));
    const Vec3 u = normalized(q - p);
    const Vec3 into1 = cross(n1, u), into2 = cross(u, n2);
    const double along = length(q - p), square = 1.0 - u.z * u.z;
    raise_under(patch, [&](double x, double y) {
      // z of the ball's centre c: |c - p|^2 - (u.(c - p))^2 = R^2.
      const double dx = x - p.x, dy = y - p.y, s0 = u.x * dx + u.y * dy;
      const double half_b = -s0 * u.z, c = dx * dx + dy * dy - s0 * s0 - radius_ * radius_;
      const double root = half_b * half_b - square * c;
      if (root < 0.0 || square <= 0.0) return kNothing;
      const double dz = (-half_b + std::sqrt(root)) / square;
      const double s = s0 + u.z * dz;
      if (s < -kSeam || s > along + kSeam) return kNothing;
      const Vec3 m{dx - u.x * s, dy - u.y * s, dz - u.z * s};
      return dot(m, into1) <= kSeam && dot(m, into2) <= kSeam ? p.z + dz : kNothing;
    });
  }

  /// The sphere about a vertex, where the contact normal leads away from each of its edges.
  void raise_vertices() {
    std::vector<std::uint32_t> first(vertices_.size() + 1, 0), halves(3 * facets_.size());
    for (std::uint32_t half = 0; half < halves.size(); ++half) ++first[from(half) + 1];
    for (std::size_t v = 0; v < vertices_.size(); ++v) first[v + 1] += first[v];
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t half = 0; half < halves.size(); ++half) halves[next[from(half)]++] = half;
    for (std::size_t v = 0; v < vertices_.size(); ++v)
      raise_vertex(vertices_[v], {halves.data() + first[v], halves.data() + first[v + 1]});
  }

  void raise_vertex(Vec3 p, std::pair<const std::uint32_t*, const std::uint32_t*> star) {
    Vec3 sum;
    Patch patch;
    for (const std::uint32_t* half = star.first; half != star.second; ++half) {
      const Vec3 n = normals_[*half / 3];
      sum = sum + n;
      patch.add(p + n * radius_);
    }
    const Vec3 mean = length(sum) > kSeam ? normalized(sum) : Vec3{};
    double least = 1.0;
    for (const std::uint32_t* half = star.first; half != star.second; ++half)
      least = std::min(least, dot(mean, normals_[*half / 3]));
    if (least <= 0.0) patch.add(p);  // wider than a half space: the whole ball
    patch.widen(radius_ * (least <= 0.0 ? 1.0 : 1.0 - least));
    raise_under(patch, [&](double x, double y) {
      const double dx = x - p.x, dy = y - p.y, root = radius_ * radius_ - dx * dx - dy * dy;
      if (root < 0.0) return kNothing;
      const Vec3 m{dx, dy, std::sqrt(root)};
      for (const std::uint32_t* half = star.first; half != star.second; ++half)
        if (dot(m, vertices_[to(*half)] - p) > kSeam) return kNothing;
      return p.z + m.z;
    });
  }

  const std::vector<std::array<std::uint32_t, 3>>& facets_;
  const double radius_;
  std::vector<Vec3> vertices_, normals_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs_;
  HeightMap map_;
};

}  // namespace

HeightMap height_map(const Mesh& mesh, const AxisFrame& frame, double radius, double step) {
  return Raiser(mesh, frame, radius, step).raise();
}

double largest_error(const HeightMap& map, const Mesh& mesh, const AxisFrame& frame, double radius,
                     int samples) {
  const sim::PartDistance part(mesh);
  const Vec3 b = cross(frame.n, frame.t);
  double top = kNothing, largest = 0.0;
  for (const Point<Part>& p : mesh.vertices) top = std::max(top, dot(p - frame.origin, frame.n));
  top += 2.0 * radius;
  std::mt19937_64 random(20050101);
  for (int i = 0; i < samples; ++i) {
    const std::size_t column = random() % map.height.size();
    const double x = map.left + static_cast<double>(column % map.columns) * map.step;
    const double y = map.front + static_cast<double>(column / map.columns) * map.step;
    const Point<Part> start = frame.origin + frame.t * x + b * y + frame.n * top;
    const sim::Hit drop = part.first_touch(start, -frame.n, radius);
    const double height = drop.value == sim::kInfinity ? kNothing : top - drop.value;
    if (height != map.height[column]) largest = std::max(largest, std::abs(height - map.height[column]));
  }
  return largest;
}

}  // namespace tiltfeed::bench
