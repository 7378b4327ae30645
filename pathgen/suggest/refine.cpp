#include "pathgen/suggest/refine.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pathgen/fit/least_squares.h"

namespace tiltfeed::pathgen {

namespace {

/// Facets that lean from the feature's rays by less (rad) are round it.
constexpr double kAligned = 0.05;
/// Corners at one distance from the feature lie within this share of the part's size, round after round.
constexpr double kGaps[] = {2e-3, 5e-4, 1e-4, 2e-5};
/// Corners taken at most, and of one distance at least.
constexpr std::size_t kMostCorners = 6000, kLeastCluster = 12;

struct Corner {
  Vec3 place;  ///< from the feature, in sizes of the part
  double distance = 0.0, weight = 0.0;
  std::uint32_t cluster = 0;
};

/// The feature, moved and turned by parameters of the order of 1.
struct Moved {
  AxisMode mode;
  Vec3 axis, u, v;  ///< right-handed, of the feature as it was
  double radius;    ///< in sizes

  std::vector<double> start() const {
    return std::vector<double>(mode == AxisMode::kPoint ? 3 : mode == AxisMode::kLine ? 4 : 6, 0.0);
  }
  Vec3 direction(std::span<const double> p) const { return normalized(axis + u * p[2] + v * p[3]); }
  /// Of the place from the feature.
  double distance(std::span<const double> p, Vec3 place) const {
    if (mode == AxisMode::kPoint) return length(place - Vec3{p[0], p[1], p[2]});
    const Vec3 a = direction(p), from = place - u * p[0] - v * p[1];
    const double along = dot(from, a), off = length(from - a * along);
    if (mode == AxisMode::kLine) return off;
    return std::hypot(off - radius - p[4], along - p[5]);
  }
  Vec3 offset(std::span<const double> p) const {
    if (mode == AxisMode::kPoint) return {p[0], p[1], p[2]};
    const Vec3 flat = u * p[0] + v * p[1];
    return mode == AxisMode::kCircle ? flat + direction(p) * p[5] : flat;
  }
};

Moved moved(const Feature& f, double size) {
  const Vec3 pick = std::abs(f.axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = normalized(cross(f.axis, pick));
  return {f.mode, f.axis, u, cross(f.axis, u), f.radius / size};
}

/// The corners of facets that are round the feature.
std::vector<Corner> corners_round(const Feature& f, const Mesh& mesh, double size) {
  const Moved form = moved(f, size);
  const std::vector<double> zero = form.start();
  AxisFrame frame{f.mode, Sense::kOutward, f.centre, form.u, form.v, f.radius};
  if (f.mode == AxisMode::kLine) frame.t = f.axis, frame.n = form.u;
  const Deformation map(frame, 1.0);
  std::vector<Corner> corners;
  for (const auto& facet : mesh.facets) {
    const Point<Part> a = mesh.vertices[facet[0]], b = mesh.vertices[facet[1]], c = mesh.vertices[facet[2]];
    const Vec3 twice = cross(b - a, c - a);
    const Deformation::Aim aim = map.aim(lerp(lerp(a, b, 0.5), c, 1.0 / 3.0));
    if (std::min(aim.away.rho, aim.away.r) < 1e-6 * size) continue;
    if (length(cross(twice, aim.axis)) > kAligned * length(twice)) continue;
    for (const Point<Part> p : {a, b, c}) {
      Corner corner{(p - f.centre) / size, 0.0, length(twice)};
      corner.distance = form.distance(zero, corner.place);
      corners.push_back(corner);
    }
  }
  if (corners.size() > kMostCorners) {
    const double step = static_cast<double>(corners.size()) / static_cast<double>(kMostCorners);
    for (std::size_t i = 0; i < kMostCorners; ++i)
      corners[i] = corners[static_cast<std::size_t>(step * static_cast<double>(i))];
    corners.resize(kMostCorners);
  }
  return corners;
}

/// Sorts the corners by their distance and numbers those that lie within `gap` of the next; drops the few
/// that stand alone. How many clusters there are.
std::uint32_t cluster(std::vector<Corner>& corners, double gap) {
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.distance < b.distance; });
  std::vector<Corner> kept;
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < corners.size();) {
    std::size_t end = i + 1;
    while (end < corners.size() && corners[end].distance - corners[end - 1].distance < gap / 8.0 &&
           corners[end].distance - corners[i].distance < 4.0 * gap)
      ++end;
    if (end - i >= kLeastCluster) {
      for (std::size_t k = i; k < end; ++k) kept.push_back(corners[k]), kept.back().cluster = count;
      ++count;
    }
    i = end;
  }
  corners = std::move(kept);
  return count;
}

/// [Beaton, Tukey 1974] How much what lies that far off, in gaps, has to say.
double biweight(double off) { return std::abs(off) < 1.0 ? (1.0 - off * off) * (1.0 - off * off) : 0.0; }

}  // namespace

Feature refined(Feature feature, const Mesh& mesh, double size) {
  for (const double gap : kGaps) {
    std::vector<Corner> corners = corners_round(feature, mesh, size);
    const std::uint32_t clusters = cluster(corners, gap);
    const Moved form = moved(feature, size);
    if (corners.size() < 4 * form.start().size()) break;
    std::vector<double> weight(clusters), mean(clusters);
    for (const Corner& c : corners) weight[c.cluster] += c.weight, mean[c.cluster] += c.weight * c.distance;
    for (std::uint32_t k = 0; k < clusters; ++k) mean[k] /= weight[k];
    double heaviest = 0.0;
    for (Corner& c : corners) {
      c.weight *= biweight((c.distance - mean[c.cluster]) / (3.0 * gap));
      heaviest = std::max(heaviest, c.weight);
    }
    if (!(heaviest > 0.0)) break;
    std::fill(weight.begin(), weight.end(), 0.0);
    for (const Corner& c : corners) weight[c.cluster] += c.weight;
    const LeastSquares found =
        least_squares(form.start(), corners.size(), [&](std::span<const double> p, std::span<double> out) {
          std::fill(mean.begin(), mean.end(), 0.0);
          for (std::size_t i = 0; i < corners.size(); ++i) {
            out[i] = form.distance(p, corners[i].place);
            if (weight[corners[i].cluster] > 0.0)
              mean[corners[i].cluster] += corners[i].weight * out[i] / weight[corners[i].cluster];
          }
          for (std::size_t i = 0; i < corners.size(); ++i)
            out[i] = (out[i] - mean[corners[i].cluster]) * std::sqrt(corners[i].weight / heaviest);
        });
    const Vec3 offset = form.offset(found.at);
    if (!is_finite(offset) || length(offset) > 20.0 * gap) break;
    feature.centre = feature.centre + offset * size;
    if (feature.mode != AxisMode::kPoint) feature.axis = form.direction(found.at);
    if (feature.mode == AxisMode::kCircle) feature.radius += found.at[4] * size;
    double sum = 0.0;
    for (const Corner& c : corners) sum += c.weight / heaviest;
    feature.rms = std::sqrt(found.sum / sum) * size;
  }
  return feature;
}

}  // namespace tiltfeed::pathgen
