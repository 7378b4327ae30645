#include "sim/removal/probes.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tiltfeed::sim {
namespace {

// A patch holds about so many probes: few enough that a far one is not asked for, many enough to share the
// work per patch.
constexpr double kPatchProbes = 48.0;
// Steps of the two-dimensional low-discrepancy sequence (powers of the plastic number) [Roberts 2018].
constexpr double kStepA = 0.7548776662466927, kStepB = 0.5698402909980532;
// A line whose direction has a squared sine below this to the way runs along it.
constexpr double kAlongWay = 1e-14;
constexpr std::uint32_t kSign = 0x80000000;

std::uint32_t ordered(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return (bits & kSign) != 0 ? ~bits : bits | kSign;
}
float from_ordered(std::uint32_t bits) {
  return std::bit_cast<float>((bits & kSign) != 0 ? bits & ~kSign : ~bits);
}

/// The places of so many probes on a triangle, as shares of two of its sides.
std::vector<std::array<double, 2>> spread(std::uint64_t count) {
  std::vector<std::array<double, 2>> places;
  for (std::uint64_t i = 0; i < count; ++i) {
    double whole = 0.0, a = std::modf(1.0 / 3.0 + static_cast<double>(i) * kStepA, &whole),
           b = std::modf(1.0 / 3.0 + static_cast<double>(i) * kStepB, &whole);
    if (a + b > 1.0) a = 1.0 - a, b = 1.0 - b;
    places.push_back({a, b});
  }
  return places;
}

using Corners = std::array<Point<Part>, 3>;

/// Halves the triangle across its longest edge until it is small enough.
void divide(const Corners& p, double most, std::uint32_t source, pathgen::Mesh& mesh) {
  std::vector<Corners> waiting{p};
  while (!waiting.empty()) {
    const Corners t = waiting.back();
    waiting.pop_back();
    const double area = 0.5 * length(cross(t[1] - t[0], t[2] - t[0]));
    if (area <= most) {
      const auto at = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.insert(mesh.vertices.end(), t.begin(), t.end());
      mesh.facets.push_back({at, at + 1, at + 2});
      mesh.source.push_back(source);
      continue;
    }
    int longest = 0;
    for (int k = 1; k < 3; ++k)
      if (distance(t[k], t[(k + 1) % 3]) > distance(t[longest], t[(longest + 1) % 3])) longest = k;
    const Point<Part> a = t[longest], b = t[(longest + 1) % 3], c = t[(longest + 2) % 3];
    const Point<Part> middle = lerp(a, b, 0.5);
    waiting.push_back({middle, b, c});
    waiting.push_back({a, middle, c});
  }
}

Patches make_patches(const pathgen::Mesh& part, double spacing) {
  Patches patches;
  patches.first.push_back(0);
  const double cell = spacing * spacing;
  // Facets that are small enough keep their shared corners: the tree then looks at no edge twice.
  patches.mesh.vertices = part.vertices;
  patches.mesh.facets.reserve(part.facets.size()), patches.mesh.source.reserve(part.facets.size());
  for (std::size_t f = 0; f < part.facets.size(); ++f) {
    const auto& facet = part.facets[f];
    const Corners p{part.vertices[facet[0]], part.vertices[facet[1]], part.vertices[facet[2]]};
    const std::uint32_t source = f < part.source.size() ? part.source[f] : static_cast<std::uint32_t>(f);
    if (0.5 * length(cross(p[1] - p[0], p[2] - p[0])) <= kPatchProbes * cell) {
      patches.mesh.facets.push_back(facet);
      patches.mesh.source.push_back(source);
    } else {
      divide(p, kPatchProbes * cell, source, patches.mesh);
    }
  }
  const std::size_t count = patches.mesh.facets.size();
  patches.normal.reserve(count), patches.middle.reserve(count), patches.radius.reserve(count);
  patches.first.reserve(count + 1);
  for (const auto& facet : patches.mesh.facets) {
    const auto& v = patches.mesh.vertices;
    const Vec3 n = cross(v[facet[1]] - v[facet[0]], v[facet[2]] - v[facet[0]]);
    const Vec3 sum = from_origin(v[facet[0]]) + from_origin(v[facet[1]]) + from_origin(v[facet[2]]);
    const Point<Part> middle = Point<Part>{} + sum / 3.0;
    double radius = 0.0;
    for (const std::uint32_t c : facet) radius = std::max(radius, distance(v[c], middle));
    patches.normal.push_back(normalized(n));
    patches.middle.push_back(middle);
    patches.radius.push_back(static_cast<float>(radius * (1.0 + 1e-6)));
    const double probes = std::max(1.0, std::round(0.5 * length(n) / cell));
    patches.first.push_back(patches.first.back() + static_cast<std::uint64_t>(probes));
  }
  return patches;
}

}  // namespace

Probes::Probes(const pathgen::Mesh& part, double spacing, double reach)
    : spacing_(spacing),
      reach_(reach),
      patches_(make_patches(part, spacing)),
      surface_(patches_.mesh),
      values_(patches_.first.back(),
              std::uint64_t{ordered(std::numeric_limits<float>::infinity())} << 32 | kNever),
      highest_(patches_.mesh.facets.size(), std::numeric_limits<float>::infinity()),
      boxes_(surface_.box_count(), std::numeric_limits<float>::infinity()) {
  std::uint64_t most = 0;
  for (std::size_t p = 0; p + 1 < patches_.first.size(); ++p)
    most = std::max(most, patches_.first[p + 1] - patches_.first[p]);
  spread_ = spread(most);
}

Point<Part> Probes::place(std::uint32_t patch, std::uint64_t probe) const {
  const auto& facet = patches_.mesh.facets[patch];
  const auto& v = patches_.mesh.vertices;
  const auto [a, b] = spread_[probe - patches_.first[patch]];
  const Point<Part> o = v[facet[0]];
  return o + (v[facet[1]] - o) * a + (v[facet[2]] - o) * b;
}

Probes::Value Probes::value(std::uint64_t probe) const {
  // Other threads may lower it meanwhile; any of its values does then.
  const std::uint64_t bits = std::atomic_ref<std::uint64_t>(const_cast<std::uint64_t&>(values_[probe]))
                                 .load(std::memory_order_relaxed);
  return {static_cast<double>(from_ordered(static_cast<std::uint32_t>(bits >> 32))),
          static_cast<std::uint32_t>(bits)};
}

void Probes::take(std::uint64_t probe, double left, std::uint32_t move) {
  const std::uint64_t bits = std::uint64_t{ordered(static_cast<float>(left))} << 32 | move;
  const std::atomic_ref<std::uint64_t> value(values_[probe]);
  std::uint64_t old = value.load(std::memory_order_relaxed);
  while (bits < old && !value.compare_exchange_weak(old, bits, std::memory_order_relaxed)) {
  }
}

void Probes::collect(std::uint32_t patch, std::vector<Live>& live) const {
  for (std::uint64_t i = patches_.first[patch]; i < patches_.first[patch + 1]; ++i) {
    const double left = value(i).left;
    live.push_back({place(patch, i), i, left, bound(left)});
  }
}

void Probes::settle(std::uint32_t patch) {
  double highest = -kInfinity;
  for (std::uint64_t i = patches_.first[patch]; i < patches_.first[patch + 1]; ++i)
    highest = std::max(highest, value(i).left);
  // Rounded up: a bound. What other threads have lowered meanwhile only makes it wider than need be.
  const auto bound = std::nextafter(static_cast<float>(highest), std::numeric_limits<float>::infinity());
  std::atomic_ref<float>(highest_[patch]).store(bound, std::memory_order_relaxed);
}

namespace {

/// (W1), (W5) Where the line from w (seen from the way's start) along n enters what the ball sweeps: the
/// way's cylinder, or the ball at that end which the line passes the cylinder's wall beyond. Below w it
/// counts only as far as w itself is inside.
struct BallLine {
  explicit BallLine(const BallWay& the_way, Vec3 normal)
      : way(the_way),
        n(normal),
        along(dot(n, way.unit)),
        square(squared_length(n - way.unit * along)),
        r2(way.radius * way.radius) {}

  static double enter(double b, double gap, double s) {
    const double root2 = b * b - s * gap;
    return root2 < 0.0 ? kInfinity : (-b - std::sqrt(root2)) / s;
  }
  /// Not more than any value over a flat patch of `radius` round w: beside its way a ball of radius R hangs
  /// over the facet by R - sqrt(R^2 - x^2), at least x^2 / 2 R, at x.
  double least(Vec3 w, double radius) const {
    const double rise = dot(w, n), across = dot(w, way.unit) - rise * along;
    const double on = square > kAlongWay ? std::clamp(across / square, 0.0, way.whole) : 0.0;
    const double beside2 = squared_length(w) - rise * rise + on * (on * square - 2.0 * across);
    const double beside = std::max(0.0, std::sqrt(std::max(0.0, beside2)) - radius);
    if (beside >= way.radius) return kInfinity;
    return -rise + std::min(0.0, along * way.whole) - way.radius + beside * beside / (2.0 * way.radius);
  }
  double operator()(Vec3 w) const {
    const double rise = dot(w, n), height = dot(w, way.unit), ww = squared_length(w);
    double at = along < 0.0 ? kInfinity : -kInfinity, t = kInfinity;  // on the way; along the line
    if (square > kAlongWay) {
      t = enter(rise - height * along, ww - height * height - r2, square);
      at = height + t * along;
    }
    if (at < 0.0)
      t = enter(rise, ww - r2, 1.0);
    else if (at > way.whole)
      t = enter(rise - along * way.whole, ww + way.whole * (way.whole - 2.0 * height) - r2, 1.0);
    if (t >= 0.0) return t;
    const double on = std::clamp(height, 0.0, way.whole), d2 = ww + on * (on - 2.0 * height);
    return d2 >= r2 ? kInfinity : std::max(t, std::sqrt(std::max(0.0, d2)) - way.radius);
  }

  const BallWay& way;
  Vec3 n;
  double along, square, r2;
};

}  // namespace

double least_left(const BallWay& way, Point<Part> middle, Vec3 normal, double radius) {
  return BallLine(way, normal).least(middle - way.from, radius);
}

double Probes::pass_ball(std::uint32_t patch, const BallWay& way, std::uint32_t move, std::span<Live> live) {
  const BallLine line(way, patches_.normal[patch]);
  double most = -kInfinity;
  for (Live& l : live) {
    const double enter = line(l.place - way.from);
    if (takes(enter, l.left)) {
      l.left = std::min(l.left, enter), l.bound = bound(l.left);
      take(l.probe, l.left, move);
    }
    most = std::max(most, l.bound);
  }
  return most;
}

double Probes::patch_area(std::uint32_t patch) const {
  const auto& f = patches_.mesh.facets[patch];
  const auto& v = patches_.mesh.vertices;
  return 0.5 * length(cross(v[f[1]] - v[f[0]], v[f[2]] - v[f[0]]));
}

std::size_t Probes::bytes() const {
  const std::size_t patches = patches_.mesh.facets.size();
  // Per patch: corners, middle, normal and a triangle with its share of the tree.
  return values_.size() * sizeof(std::uint64_t) + patches * (sizeof(Triangle) + 160);
}

}  // namespace tiltfeed::sim
