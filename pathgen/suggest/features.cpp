#include "pathgen/suggest/features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pathgen/fit/fit_start.h"
#include "pathgen/suggest/refine.h"

namespace tiltfeed::pathgen {

namespace {

/// Samples of normals, for an axis and for points.
constexpr int kAxisSamples = 3000, kPointSamples = 600;
constexpr std::size_t kAxisNormals = 5;
/// Places that a sample is held against.
constexpr std::size_t kAsked = 400;
/// kMeets of a place off the middle of a large facet: half the facet's breadth, but no more than this.
constexpr double kMostSlack = 0.02;
/// The normals of large facets miss a point by so many times that.
constexpr double kChords = 4.0;
/// Normals nearer to the axis' direction (sine) say nothing of where it is.
constexpr double kLateral = 0.2;
/// Less of the surface is no feature of the part.
constexpr double kLeastShare = 0.08, kLeastPoint = 0.15;
constexpr std::size_t kMostAxes = 3, kMostPoints = 2, kMostCircles = 2;
/// Rounds of fitting again to what meets.
constexpr int kRounds = 6;
/// A circle of a smaller radius, as a share of the part's size, is a point on the axis.
constexpr double kLeastRing = 0.03;

/// A place in sizes of the part; `slack`: the normal of a flat facet passes a feature by so much.
struct Seen : ReachPlace {
  double slack = kMeets;
};
using Places = std::vector<Seen>;

struct Lines {
  const Places& places;  ///< about zero, in sizes of the part
  double whole;          ///< area

  /// The share of the area whose normals pass; by every `step`-th place.
  template <class Passes>
  double share(const Passes& passes, std::size_t step) const {
    double area = 0.0, all = 0.0;
    for (std::size_t i = 0; i < places.size(); i += step) {
      all += places[i].area;
      if (passes(places[i])) area += places[i].area;
    }
    return all > 0.0 ? area / all : 0.0;
  }
  std::size_t step() const { return std::max<std::size_t>(1, places.size() / kAsked); }
};

bool meets_axis(const Seen& p, const Axis& axis) {
  const Vec3 across = cross(p.normal, axis.direction);
  const double sine = length(across);
  return sine > kLateral && std::abs(dot(from_origin(p.place) - axis.place, across)) < p.slack * sine;
}

bool meets_point(const Seen& p, Vec3 point, double times = 1.0) {
  const double within = times * p.slack;
  return squared_length(cross(point - from_origin(p.place), p.normal)) < within * within;
}

/// A place in the half-plane through the axis: distance from it and height, and its normal there.
struct Flat2 {
  double r, z, nr, nz, slack;
};
std::optional<Flat2> in_section(const Seen& p, const Axis& axis) {
  const Vec3 from = from_origin(p.place) - axis.place;
  const double z = dot(from, axis.direction);
  const Vec3 out = from - axis.direction * z;
  const double r = length(out);
  if (r < kMeets) return std::nullopt;
  const double nr = dot(p.normal, out) / r, nz = dot(p.normal, axis.direction), n = std::hypot(nr, nz);
  if (n < 0.99) return std::nullopt;  // does not meet the axis
  return Flat2{r, z, nr / n, nz / n, p.slack};
}
bool meets_ring(const Flat2& p, double r, double z) {
  return std::abs((r - p.r) * p.nz - (z - p.z) * p.nr) < p.slack;
}

std::optional<Axis> best_axis(const Lines& lines) {
  if (lines.places.size() < 3 * kAxisNormals) return std::nullopt;
  Sequence sequence;
  std::optional<Axis> best;
  double most = kLeastShare / 2.0;
  std::vector<FitPoint> sample;
  const auto fit_to = [&](const Axis& axis) {
    sample.clear();
    for (const Seen& p : lines.places)
      if (meets_axis(p, axis)) sample.push_back({p.place, p.normal, p.area});
    return sample.size() >= kAxisNormals ? revolution_axis(sample) : std::nullopt;
  };
  for (int k = 0; k < kAxisSamples; ++k) {
    sample.clear();
    for (std::size_t i = 0; i < kAxisNormals; ++i) {
      const Seen& p = lines.places[sequence.below(lines.places.size())];
      sample.push_back({p.place, p.normal, 1.0});
    }
    const auto axis = revolution_axis(sample);
    if (!axis || length(axis->place) > 5.0) continue;
    const double share = lines.share([&](const Seen& p) { return meets_axis(p, *axis); }, lines.step());
    if (share > most) most = share, best = axis;
  }
  for (int round = 0; best && round < kRounds; ++round)
    if (const auto again = fit_to(*best)) best = again;
  return best;
}

/// The point nearest to the lines of these places, by least squares.
std::optional<Vec3> nearest_to_lines(const Places& places) {
  std::array<Vec3, 3> rows{};
  Vec3 right;
  for (const Seen& p : places) {
    const Vec3 n = p.normal, at = from_origin(p.place);
    const auto square = [&](Vec3 v) { return (v - n * dot(v, n)) * p.area; };
    rows[0] = rows[0] + square({1, 0, 0}), rows[1] = rows[1] + square({0, 1, 0});
    rows[2] = rows[2] + square({0, 0, 1}), right = right + square(at);
  }
  const double det = dot(rows[0], cross(rows[1], rows[2]));
  const double scale = length(rows[0]) * length(rows[1]) * length(rows[2]);
  if (!(std::abs(det) > 1e-9 * scale)) return std::nullopt;
  return Vec3{dot(right, cross(rows[1], rows[2])), dot(rows[0], cross(right, rows[2])),
              dot(rows[0], cross(rows[1], right))} /
         det;
}

std::optional<Vec3> best_point(const Lines& lines) {
  if (lines.places.size() < 8) return std::nullopt;
  Sequence sequence;
  std::optional<Vec3> best;
  double most = kLeastPoint / 2.0;
  for (int k = 0; k < kPointSamples; ++k) {
    const Seen &a = lines.places[sequence.below(lines.places.size())],
               &b = lines.places[sequence.below(lines.places.size())];
    if (length(cross(a.normal, b.normal)) < 0.1) continue;
    const auto point = nearest_to_lines({a, b});
    if (!point || length(*point) > 5.0 || !meets_point(a, *point)) continue;
    const double share = lines.share([&](const Seen& p) { return meets_point(p, *point); }, lines.step());
    if (share > most) most = share, best = point;
  }
  for (int round = 0; best && round < kRounds; ++round) {
    Places meeting;
    for (const Seen& p : lines.places)
      if (meets_point(p, *best)) meeting.push_back(p);
    if (const auto again = nearest_to_lines(meeting)) best = again;
  }
  return best;
}

struct Ring {
  double r, z, share;
};
std::optional<Ring> best_ring(const std::vector<std::pair<Flat2, double>>& section, double whole) {
  if (section.size() < 8) return std::nullopt;
  Sequence sequence;
  std::optional<Ring> best;
  for (int k = 0; k < kPointSamples; ++k) {
    const Flat2 a = section[sequence.below(section.size())].first,
                b = section[sequence.below(section.size())].first;
    const double det = a.nr * b.nz - a.nz * b.nr;
    if (std::abs(det) < 0.1) continue;
    const double along = ((b.r - a.r) * b.nz - (b.z - a.z) * b.nr) / det;
    const double r = a.r + along * a.nr, z = a.z + along * a.nz;
    if (r < kLeastRing || r > 5.0 || std::abs(z) > 5.0) continue;
    double area = 0.0;
    for (const auto& [p, weight] : section)
      if (meets_ring(p, r, z)) area += weight;
    if (!best || area / whole > best->share) best = Ring{r, z, area / whole};
  }
  return best;
}

template <class Passes>
double area_of(const Places& places, const Passes& passes) {
  double area = 0.0;
  for (const Seen& p : places) area += passes(p) ? p.area : 0.0;
  return area;
}

template <class Passes>
void leave(Places& places, const Passes& passes) {
  places.erase(std::remove_if(places.begin(), places.end(), passes), places.end());
}

}  // namespace

std::vector<Feature> find_features(const Mesh& mesh, const Box& bounds, std::span<const ReachPlace> sample) {
  const double size = distance(bounds.min, bounds.max);
  const Point<Part> middle = lerp(bounds.min, bounds.max, 0.5);
  Places places;
  double whole = 0.0;
  for (const ReachPlace& p : sample) {
    const double slack = facet_slack(mesh, p.facet) / size;
    places.push_back({p, std::clamp(slack, kMeets, kMostSlack)});
    places.back().place = Point<Part>{} + (p.place - middle) / size, whole += p.area;
  }
  const Lines all{places, whole};
  const auto back = [&](Vec3 v) { return middle + v * size; };
  std::vector<Feature> found;
  Places rest = places;
  for (std::size_t k = 0; k < kMostPoints; ++k) {
    const auto start = best_point({rest, whole});
    if (!start || area_of(rest, [&](const Seen& p) { return meets_point(p, *start); }) < kLeastPoint * whole)
      break;
    const Feature point = refined({AxisMode::kPoint, back(*start), {0, 0, 1}, 0.0, 0.0, 0.0}, mesh, size);
    const Vec3 exact = (point.centre - middle) / size;
    const auto meets = [&](const Seen& p) { return meets_point(p, exact, kChords); };
    found.push_back(point);
    found.back().share = all.share(meets, 1);
    // What is round about a point is round about every line through it.
    leave(rest, meets);
  }
  for (std::size_t k = 0; k < kMostAxes; ++k) {
    const auto axis = best_axis({rest, whole});
    if (!axis) break;
    const double share = area_of(rest, [&](const Seen& p) { return meets_axis(p, *axis); }) / whole;
    if (share < kLeastShare) break;
    found.push_back(
        refined({AxisMode::kLine, back(axis->place), axis->direction, 0.0, share, 0.0}, mesh, size));
    std::vector<std::pair<Flat2, double>> section;
    for (const Seen& p : rest)
      if (meets_axis(p, *axis))
        if (const auto flat = in_section(p, *axis)) section.emplace_back(*flat, p.area);
    for (std::size_t c = 0; c < kMostCircles; ++c) {
      const auto ring = best_ring(section, whole);
      if (!ring || ring->share < kLeastShare) break;
      const Feature circle = refined({AxisMode::kCircle, back(axis->place + axis->direction * ring->z),
                                      axis->direction, ring->r * size, ring->share, 0.0},
                                     mesh, size);
      if (circle.radius > kLeastRing * size) found.push_back(circle);
      std::erase_if(section, [&](const auto& p) { return meets_ring(p.first, ring->r, ring->z); });
    }
    leave(rest, [&](const Seen& p) { return meets_axis(p, *axis); });
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Feature& a, const Feature& b) { return a.share > b.share; });
  return found;
}

}  // namespace tiltfeed::pathgen
