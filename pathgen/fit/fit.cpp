#include "pathgen/fit/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "pathgen/fit/curved_form.h"
#include "pathgen/fit/fit_start.h"
#include "pathgen/fit/least_squares.h"

namespace tiltfeed::pathgen {

namespace {

/// Points further off than so many standard deviations are outliers; the deviation of which half of all
/// distances say this share [Rousseeuw, Leroy 1987].
constexpr double kOutlier = 4.0, kOfMedian = 1.4826;
/// Distances below this, in units of the points' spread, are rounding.
constexpr double kRounding = 1e-10;
/// So often the outliers are chosen again.
constexpr int kRounds = 12;

std::size_t fewest(FitKind kind) {
  switch (kind) {
    case FitKind::kPlane:
      return 3;
    case FitKind::kCircle:
      return 4;
    case FitKind::kSphere:
      return 5;
    case FitKind::kCylinder:
      return 6;
    case FitKind::kTorus:
      break;
  }
  return 8;
}

/// The points about zero, some 1 apart, and the way back.
struct Scaled {
  std::vector<FitPoint> points;
  Point<Part> middle;
  double unit = 1.0;  ///< mm
};

Scaled scaled(std::span<const FitPoint> points) {
  Scaled s;
  s.points.assign(points.begin(), points.end());
  const Point<Part> first = points.front().place;
  Vec3 sum;
  double weight = 0.0;
  for (const FitPoint& p : points) sum = sum + (p.place - first) * p.weight, weight += p.weight;
  s.middle = first + sum / weight;
  double spread = 0.0;
  for (const FitPoint& p : points) spread += p.weight * squared_length(p.place - s.middle);
  s.unit = std::sqrt(spread / weight);
  for (FitPoint& p : s.points) {
    p.weight *= static_cast<double>(points.size()) / weight;
    if (s.unit > 0.0) p.place = Point<Part>{} + (p.place - s.middle) / s.unit;
  }
  return s;
}

class Fitting {
 public:
  Fitting(FitKind kind, const Scaled& data, const Shape& start) : kind_(kind), data_(data) { adopt(start); }

  /// With the outliers of the shape so far left out; false: they are the same as before.
  bool leave_outliers(double parameters) {
    std::vector<double> off;
    for (const FitPoint& p : data_.points) off.push_back(std::abs(distance_to(shape_, p.place)));
    std::vector<double> sorted = off;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double free = std::max(1.0, static_cast<double>(off.size()) - parameters);
    const double limit = std::max(kRounding, kOutlier * kOfMedian * (1.0 + 5.0 / free) * *middle);
    std::vector<bool> taken;
    for (const double d : off) taken.push_back(d <= limit);
    const bool changed = taken != taken_;
    taken_ = std::move(taken);
    return changed;
  }
  void take_all() { taken_.assign(data_.points.size(), true); }

  /// Nothing where the points taken do not say the shape.
  bool solve() {
    std::vector<const FitPoint*> points;
    for (std::size_t i = 0; i < taken_.size(); ++i)
      if (taken_[i]) points.push_back(&data_.points[i]);
    if (points.size() < fewest(kind_)) return false;
    form_.emplace(kind_, as_shape(), from_origin(nearest_middle(points)));
    const std::size_t each = form_->residuals_each();
    found_ = least_squares(form_->start(), each * points.size(),
                           [&](std::span<const double> p, std::span<double> out) {
                             for (std::size_t i = 0; i < points.size(); ++i) {
                               const std::span<double> mine = out.subspan(i * each, each);
                               form_->residuals(p, from_origin(points[i]->place), mine);
                               for (double& r : mine) r *= std::sqrt(points[i]->weight);
                             }
                           });
    count_ = points.size();
    adopt(form_->shape(found_.at));
    return found_.settled && is_finite(shape_.centre) && is_finite(shape_.axis);
  }

  Fit result() const {
    Fit fit = shape_;
    const double unit = data_.unit;
    double squares = 0.0, weight = 0.0;
    for (std::size_t i = 0; i < taken_.size(); ++i) {
      if (!taken_[i]) continue;
      const double d = distance_to(shape_, data_.points[i].place);
      squares += data_.points[i].weight * d * d, weight += data_.points[i].weight;
      fit.worst = std::max(fit.worst, std::abs(d) * unit);
    }
    fit.rms = std::sqrt(squares / weight) * unit;
    fit.points = count_, fit.left_out = taken_.size() - count_;
    fit.doubt = doubt();
    fit.centre = data_.middle + from_origin(shape_.centre) * unit;
    fit.radius *= unit, fit.tube *= unit;
    return with_sign(fit);
  }
  std::size_t parameters() const { return form_ ? form_->start().size() : 0; }

 private:
  void adopt(const Shape& s) {
    shape_ = {};
    shape_.kind = kind_, shape_.centre = Point<Part>{} + s.centre, shape_.axis = s.axis;
    shape_.radius = s.radius, shape_.tube = s.tube;
  }
  Shape as_shape() const { return {from_origin(shape_.centre), shape_.axis, shape_.radius, shape_.tube}; }

  /// The point nearest to the middle of all: there the shape is described.
  static Point<Part> nearest_middle(const std::vector<const FitPoint*>& points) {
    return (*std::min_element(points.begin(), points.end(),
                              [](const FitPoint* a, const FitPoint* b) {
                                return squared_length(from_origin(a->place)) <
                                       squared_length(from_origin(b->place));
                              }))
        ->place;
  }

  /// The covariance of the parameters, carried on to the shape by differences.
  FitDoubt doubt() const {
    const std::size_t n = found_.at.size();
    const double free = static_cast<double>(count_ * form_->residuals_each()) - static_cast<double>(n);
    const double variance = free > 0.0 ? found_.sum / free : 0.0;
    const Shape here = form_->shape(found_.at);
    std::vector<std::array<double, 8>> slope(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double own = std::sqrt(variance * found_.covariance[i * n + i]);
      const double step = std::max(1e-3 * own, 1e-9 * std::max(1e-3, std::abs(found_.at[i])));
      std::vector<double> there = found_.at;
      there[i] += step;
      const Shape s = form_->shape(there);
      const Vec3 c = (s.centre - here.centre) / step, a = (s.axis - here.axis) / step;
      slope[i] = {c.x, c.y, c.z, a.x, a.y, a.z, (s.radius - here.radius) / step, (s.tube - here.tube) / step};
    }
    std::array<double, 64> spread{};
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t k = 0; k < 64; ++k)
          spread[k] += slope[i][k / 8] * variance * found_.covariance[i * n + j] * slope[j][k % 8];
    const auto worst = [&](std::size_t at, std::size_t size) {
      std::vector<double> block;
      for (std::size_t i = 0; i < size * size; ++i)
        block.push_back(spread[(at + i / size) * 8 + at + i % size]);
      return std::sqrt(std::max(0.0, eigen_pairs(block, size).values.back()));
    };
    const bool has_axis = kind_ != FitKind::kSphere;
    return {worst(0, 3) * data_.unit, has_axis ? worst(3, 3) : 0.0, worst(6, 1) * data_.unit,
            worst(7, 1) * data_.unit};
  }

  Fit with_sign(Fit fit) const {
    const Vec3 a = fit.axis;
    const double x = std::abs(a.x), y = std::abs(a.y), z = std::abs(a.z);
    double side = x >= y && x >= z ? a.x : y >= z ? a.y : a.z;
    if (kind_ == FitKind::kPlane) {
      double seen = 0.0;
      for (std::size_t i = 0; i < taken_.size(); ++i)
        if (taken_[i]) seen += data_.points[i].weight * dot(data_.points[i].normal, a);
      if (seen != 0.0) side = seen;
    }
    if (side < 0.0) fit.axis = -fit.axis;
    return fit;
  }

  FitKind kind_;
  const Scaled& data_;
  Fit shape_;  ///< in the scaled points' coordinates
  std::vector<bool> taken_;
  std::optional<CurvedForm> form_;
  LeastSquares found_;
  std::size_t count_ = 0;
};

Result<Fit> cannot(FitKind kind, const std::string& why) {
  return fail(Code::kInput, std::string("no ") + word_of(kind) + " through these points: " + why);
}

}  // namespace

Result<Fit> fit(FitKind kind, std::span<const FitPoint> points, const FitOptions& options) {
  if (points.size() < fewest(kind))
    return cannot(kind, std::to_string(points.size()) + " are given, it takes " +
                            std::to_string(fewest(kind)) + " or more; pick more facets");
  if (kind == FitKind::kCylinder || kind == FitKind::kTorus)
    for (const FitPoint& p : points)
      if (squared_length(p.normal) == 0.0) return cannot(kind, "a point has no normal");
  const Scaled data = scaled(points);
  const std::optional<Shape> start = data.unit > 0.0 ? start_of(kind, data.points) : std::nullopt;
  if (!start)
    return cannot(kind, "they lie on a line or in one place, or their normals are all parallel; pick others");
  Fitting fitting(kind, data, *start);
  fitting.take_all();
  if (options.leave_outliers) fitting.leave_outliers(static_cast<double>(fewest(kind)));
  for (int round = 0; round < kRounds; ++round) {
    if (!fitting.solve()) return cannot(kind, "they do not say where it is; pick facets further apart");
    if (!options.leave_outliers || round + 1 == kRounds) break;
    if (!fitting.leave_outliers(static_cast<double>(fitting.parameters()))) break;
  }
  const Fit found = fitting.result();
  if (found.radius > kMostRadius || found.tube > kMostRadius)
    return cannot(kind, "they lie in a plane as far as can be told; pick facets further apart");
  return found;
}

std::vector<FitPoint> corners_of(const Mesh& mesh, std::span<const std::uint32_t> facets) {
  std::vector<std::pair<std::uint32_t, Vec3>> shares;  // vertex, and a third of twice the facet's area vector
  for (const std::uint32_t i : facets) {
    const auto& f = mesh.facets[i];
    const Vec3 twice =
        cross(mesh.vertices[f[1]] - mesh.vertices[f[0]], mesh.vertices[f[2]] - mesh.vertices[f[0]]);
    for (const std::uint32_t v : f) shares.emplace_back(v, twice);
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<FitPoint> points;
  for (std::size_t i = 0; i < shares.size();) {
    FitPoint point{mesh.vertices[shares[i].first], {}, 0.0};
    const std::uint32_t vertex = shares[i].first;
    for (; i < shares.size() && shares[i].first == vertex; ++i)
      point.normal = point.normal + shares[i].second, point.weight += length(shares[i].second) / 6.0;
    const double size = length(point.normal);
    point.normal = size > 0.0 ? point.normal / size : Vec3{};
    points.push_back(point);
  }
  return points;
}

}  // namespace tiltfeed::pathgen
