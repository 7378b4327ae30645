#include "tests/bench/z_map.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::bench {
using namespace pathgen;

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
/// Where the first grid line lies, of a step: at round places grid lines would graze walls.
constexpr double kFirst = 0.381966;
/// Rows of the grid that one task fills, and facets that one reads.
constexpr int kRows = 16;
constexpr std::size_t kGrain = 8192, kHead = 84, kFacet = 50;
/// Neighbouring patches overlap by this much (of an edge; mm), so that rounding leaves no gap.
constexpr double kSeam = 1e-9;

struct Corners {
  std::array<Vec3, 3> v;
};

/// The file's bytes, mapped.
class StlBytes {
 public:
  explicit StlBytes(const std::string& file) {
    const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat about {};
    if (fd >= 0 && fstat(fd, &about) == 0 && static_cast<std::size_t>(about.st_size) >= kHead) {
      size_ = static_cast<std::size_t>(about.st_size);
      void* at = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE | MAP_POPULATE, fd, 0);
      if (at != MAP_FAILED) bytes_ = static_cast<const char*>(at);
    }
    if (fd >= 0) close(fd);
  }
  StlBytes(const StlBytes&) = delete;
  StlBytes& operator=(const StlBytes&) = delete;
  ~StlBytes() {
    if (bytes_ != nullptr) munmap(const_cast<char*>(bytes_), size_);
  }
  std::size_t facets() const { return bytes_ == nullptr ? 0 : (size_ - kHead) / kFacet; }
  Corners at(std::size_t facet) const {
    float c[9];
    std::memcpy(c, bytes_ + kHead + kFacet * facet + 12, sizeof c);
    return {{Vec3{c[0], c[1], c[2]}, Vec3{c[3], c[4], c[5]}, Vec3{c[6], c[7], c[8]}}};
  }

 private:
  const char* bytes_ = nullptr;
  std::size_t size_ = 0;
};

struct Bounds {
  Vec3 low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
  void add(Vec3 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
};

/// Raises the rows [first, last) of a map.
class Rows {
 public:
  Rows(HeightMap& map, double radius, int first, int last)
      : map_(map), radius_(radius), first_(first), last_(last) {}

  /// The plane of the facet, moved by the radius.
  void drop_on_facet(const Corners& c) {
    const Vec3 normal = cross(c.v[1] - c.v[0], c.v[2] - c.v[0]);
    if (!(normal.z > 0.0)) return;
    const Vec3 n = normalized(normal), up = n * radius_;
    const std::array<Vec3, 3> v{c.v[0] + up, c.v[1] + up, c.v[2] + up};
    Bounds b;
    for (const Vec3& p : v) b.add(p);
    each(b.low, b.high, 0.0, [&](double x, double y, double& height) {
      for (int i = 0; i < 3; ++i) {
        const Vec3 a = v[i], e = v[(i + 1) % 3] - a;
        if (e.x * (y - a.y) - e.y * (x - a.x) < -kSeam) return;
      }
      height = std::max(height, v[0].z - (n.x * (x - v[0].x) + n.y * (y - v[0].y)) / n.z);
    });
  }

  /// The cylinder about the edge p q, and the balls about its ends.
  void drop_on_edge(Vec3 p, Vec3 q) {
    Bounds b;
    b.add(p), b.add(q);
    const Vec3 e = q - p;
    const double top = b.high.z, square2 = e.x * e.x + e.y * e.y, along2 = squared_length(e);
    const double r2 = radius_ * radius_;
    each(b.low, b.high, radius_, [&](double x, double y, double& height) {
      // No higher than the ball on a post as high as the edge's top, as near as its box.
      const double over = height - top;
      const double bx = std::max({b.low.x - x, x - b.high.x, 0.0}),
                   by = std::max({b.low.y - y, y - b.high.y, 0.0});
      const double near2 = bx * bx + by * by;
      if (near2 > r2 || (over > 0.0 && over * over + near2 >= r2)) return;
      const double dx = x - p.x, dy = y - p.y;
      double best = std::max(on_corner(dx, dy, p.z), on_corner(dx - e.x, dy - e.y, q.z));
      // |c - p|^2 - (e.(c - p))^2 / e^2 = R^2 for the centre c, square to the edge at s of its length.
      const double flat = e.x * dx + e.y * dy, aside = e.x * dy - e.y * dx;
      const double root = r2 * square2 - aside * aside;
      if (root > 0.0 && square2 > 0.0) {
        const double dz = (e.z * flat + std::sqrt(along2 * root)) / square2;
        const double s = (flat + e.z * dz) / along2;
        if (s >= -kSeam && s <= 1.0 + kSeam) best = std::max(best, p.z + dz);
      }
      height = std::max(height, best);
    });
  }

 private:
  double on_corner(double dx, double dy, double z) const {
    const double root = radius_ * radius_ - dx * dx - dy * dy;
    return root < 0.0 ? -kFar : z + std::sqrt(root);
  }
  /// Calls visit(x, y, height) for the grid points of these rows within `reach` of the rectangle.
  template <class Visit>
  void each(Vec3 low, Vec3 high, double reach, const Visit& visit) {
    const auto cut = [&](double at, double from) { return (at - from) / map_.step; };
    const int left = std::max(0, static_cast<int>(std::ceil(cut(low.x - reach, map_.left)))),
              right =
                  std::min(map_.columns - 1, static_cast<int>(std::floor(cut(high.x + reach, map_.left)))),
              front = std::max(first_, static_cast<int>(std::ceil(cut(low.y - reach, map_.front)))),
              back = std::min(last_ - 1, static_cast<int>(std::floor(cut(high.y + reach, map_.front))));
    for (int k = front; k <= back; ++k) {
      double* row = map_.height.data() + static_cast<std::size_t>(k) * map_.columns;
      for (int i = left; i <= right; ++i)
        visit(map_.left + i * map_.step, map_.front + k * map_.step, row[i]);
    }
  }

  HeightMap& map_;
  double radius_;
  int first_, last_;
};

/// Each edge of a closed part is named twice, once each way.
bool is_named_here(Vec3 p, Vec3 q) { return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z; }

}  // namespace

Result<HeightMap> z_map(const std::string& stl, double radius, double step) {
  const StlBytes bytes(stl);
  const std::size_t facets = bytes.facets();
  if (facets == 0) return fail(Code::kIo, stl + " is no binary STL file");
  const Bounds bounds = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, facets, kGrain), Bounds{},
      [&](const auto& range, Bounds b) {
        for (std::size_t f = range.begin(); f < range.end(); ++f)
          for (const Vec3& v : bytes.at(f).v) b.add(v);
        return b;
      },
      [](Bounds a, const Bounds& b) { return a.add(b.low), a.add(b.high), a; });
  HeightMap map;
  map.step = step;
  map.left = bounds.low.x - radius + kFirst * step, map.front = bounds.low.y - radius + kFirst * step;
  map.columns = static_cast<int>((bounds.high.x + radius - map.left) / step) + 1;
  map.rows = static_cast<int>((bounds.high.y + radius - map.front) / step) + 1;
  map.height.assign(static_cast<std::size_t>(map.columns) * map.rows, -kFar);
  // The facets that each band of rows may meet: a counting sort.
  const int bands = (map.rows + kRows - 1) / kRows;
  const auto each_band = [&](std::size_t f, const auto& visit) {
    Bounds b;
    for (const Vec3& v : bytes.at(f).v) b.add(v);
    const auto band = [&](double y) {
      return std::clamp(static_cast<int>(std::floor((y - map.front) / step)) / kRows, 0, bands - 1);
    };
    for (int k = band(b.low.y - radius); k <= band(b.high.y + radius); ++k) visit(k);
  };
  const std::size_t blocks = (facets + kGrain - 1) / kGrain;
  std::vector<std::size_t> next(blocks * static_cast<std::size_t>(bands));  // band by band, each by blocks
  const auto each_block = [&](const auto& visit) {
    tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
      for (std::size_t f = b * kGrain; f < std::min(facets, (b + 1) * kGrain); ++f)
        each_band(f, [&](int k) { visit(f, next[static_cast<std::size_t>(k) * blocks + b]); });
    });
  };
  each_block([](std::size_t, std::size_t& at) { ++at; });
  std::vector<std::size_t> start;
  std::size_t sum = 0;
  for (std::size_t i = 0; i < next.size(); ++i) {
    if (i % blocks == 0) start.push_back(sum);
    sum += std::exchange(next[i], sum);
  }
  start.push_back(sum);
  std::vector<std::uint32_t> of_band(sum);
  each_block([&](std::size_t f, std::size_t& at) { of_band[at++] = static_cast<std::uint32_t>(f); });
  tbb::parallel_for(0, bands, [&](int k) {
    Rows rows(map, radius, k * kRows, std::min(map.rows, (k + 1) * kRows));
    for (std::size_t i = start[k]; i < start[k + 1]; ++i) rows.drop_on_facet(bytes.at(of_band[i]));
    for (std::size_t i = start[k]; i < start[k + 1]; ++i) {
      const Corners c = bytes.at(of_band[i]);
      for (int e = 0; e < 3; ++e)
        if (is_named_here(c.v[e], c.v[(e + 1) % 3])) rows.drop_on_edge(c.v[e], c.v[(e + 1) % 3]);
    }
  });
  return map;
}

}  // namespace tiltfeed::bench
