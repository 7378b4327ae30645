#include "pathgen/fit/fit_start.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pathgen/fit/least_squares.h"

namespace tiltfeed::pathgen {

namespace {

/// So many samples of either size: with a third of outliers some are free of them, but for a torus' large
/// ones.
constexpr int kSamples = 300;
/// So many points are asked how good a start is.
constexpr std::size_t kAsked = 500;
/// An eigenvalue below this share of the largest is zero.
constexpr double kZero = 1e-14;

using Points = std::span<const FitPoint>;

std::array<double, 9> scatter(Points points, Vec3 middle, bool normals) {
  std::array<double, 9> m{};
  for (const FitPoint& p : points) {
    const Vec3 v = normals ? p.normal : from_origin(p.place) - middle;
    const std::array<double, 3> c{v.x, v.y, v.z};
    for (std::size_t i = 0; i < 9; ++i) m[i] += p.weight * c[i / 3] * c[i % 3];
  }
  return m;
}

Vec3 as_vec(const std::vector<double>& v, std::size_t at = 0) { return {v[at], v[at + 1], v[at + 2]}; }

Vec3 middle_of(Points points) {
  Vec3 sum;
  double weight = 0.0;
  for (const FitPoint& p : points) sum = sum + from_origin(p.place) * p.weight, weight += p.weight;
  return sum / weight;
}

/// Least squares of rows [a..., right] in n unknowns; nothing where they do not say them.
std::optional<std::vector<double>> solve(const std::vector<std::vector<double>>& rows, std::size_t n) {
  std::vector<double> normal(n * n), right(n);
  for (const auto& row : rows)
    for (std::size_t i = 0; i < n; ++i) {
      right[i] += row[i] * row[n];
      for (std::size_t j = 0; j < n; ++j) normal[i * n + j] += row[i] * row[j];
    }
  const EigenPairs pairs = eigen_pairs(normal, n);
  if (pairs.values.front() <= kZero * pairs.values.back()) return std::nullopt;
  std::vector<double> x(n);
  for (std::size_t k = 0; k < n; ++k) {
    double along = 0.0;
    for (std::size_t i = 0; i < n; ++i) along += pairs.vectors[k][i] * right[i];
    for (std::size_t i = 0; i < n; ++i) x[i] += pairs.vectors[k][i] * along / pairs.values[k];
  }
  return x;
}

struct FlatCircle {
  double u = 0.0, v = 0.0, radius = 0.0;
};
/// [Kasa 1976] u^2 + v^2 = 2 (u c + v d) + e.
std::optional<FlatCircle> circle_through(const std::vector<std::array<double, 2>>& places) {
  std::vector<std::vector<double>> rows;
  for (const auto& [u, v] : places) rows.push_back({2.0 * u, 2.0 * v, 1.0, u * u + v * v});
  const auto x = solve(rows, 3);
  if (!x) return std::nullopt;
  const double square = (*x)[2] + (*x)[0] * (*x)[0] + (*x)[1] * (*x)[1];
  if (!(square > 0.0)) return std::nullopt;
  return FlatCircle{(*x)[0], (*x)[1], std::sqrt(square)};
}

std::optional<Shape> plane_through(Points points) {
  const Vec3 middle = middle_of(points);
  const EigenPairs pairs = eigen_pairs(scatter(points, middle, false), 3);
  if (pairs.values[1] <= kZero * pairs.values[2]) return std::nullopt;
  return Shape{middle, as_vec(pairs.vectors[0]), 0.0, 0.0};
}

/// The circle of the points as seen along `axis`, about `middle`.
std::optional<Shape> round_about(Points points, Vec3 middle, Vec3 axis) {
  const Vec3 pick = std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = normalized(cross(axis, pick)), v = cross(axis, u);
  std::vector<std::array<double, 2>> flat;
  for (const FitPoint& p : points) {
    const Vec3 from = from_origin(p.place) - middle;
    flat.push_back({dot(from, u), dot(from, v)});
  }
  const auto circle = circle_through(flat);
  if (!circle) return std::nullopt;
  return Shape{middle + u * circle->u + v * circle->v, axis, circle->radius, 0.0};
}

std::optional<Shape> sphere_through(Points points) {
  std::vector<std::vector<double>> rows;
  for (const FitPoint& p : points)
    rows.push_back(
        {2.0 * p.place.x, 2.0 * p.place.y, 2.0 * p.place.z, 1.0, squared_length(from_origin(p.place))});
  const auto x = solve(rows, 4);
  if (!x) return std::nullopt;
  const Vec3 centre = as_vec(*x);
  const double square = (*x)[3] + squared_length(centre);
  if (!(square > 0.0)) return std::nullopt;
  return Shape{centre, {0, 0, 1}, std::sqrt(square), 0.0};
}

std::optional<Shape> cylinder_through(Points points) {
  const EigenPairs pairs = eigen_pairs(scatter(points, {}, true), 3);
  if (pairs.values[1] <= kZero * pairs.values[2]) return std::nullopt;
  return round_about(points, middle_of(points), as_vec(pairs.vectors[0]));
}

std::optional<Shape> torus_through(Points points) {
  const std::optional<Axis> axis = revolution_axis(points);
  if (!axis) return std::nullopt;
  std::vector<std::array<double, 2>> flat;
  for (const FitPoint& p : points) {
    const Vec3 from = from_origin(p.place) - axis->place;
    const double z = dot(from, axis->direction);
    flat.push_back({length(from - axis->direction * z), z});
  }
  const auto circle = circle_through(flat);
  if (!circle) return std::nullopt;
  return Shape{axis->place + axis->direction * circle->v, axis->direction, std::abs(circle->u),
               circle->radius};
}

std::optional<Shape> through(FitKind kind, Points points) {
  switch (kind) {
    case FitKind::kPlane:
      return plane_through(points);
    case FitKind::kCircle: {
      const auto plane = plane_through(points);
      return plane ? round_about(points, plane->centre, plane->axis) : std::nullopt;
    }
    case FitKind::kSphere:
      return sphere_through(points);
    case FitKind::kCylinder:
      return cylinder_through(points);
    case FitKind::kTorus:
      break;
  }
  return torus_through(points);
}

/// The distance from which half of the points are nearer.
double half_within(FitKind kind, const Shape& shape, Points points) {
  Fit fit;
  fit.kind = kind, fit.centre = Point<Part>{} + shape.centre, fit.axis = shape.axis;
  fit.radius = shape.radius, fit.tube = shape.tube;
  std::vector<double> off;
  const std::size_t step = std::max<std::size_t>(1, points.size() / kAsked);
  for (std::size_t i = 0; i < points.size(); i += step)
    off.push_back(std::abs(distance_to(fit, points[i].place)));
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return *middle;
}

}  // namespace

std::size_t sample_size(FitKind kind) {
  switch (kind) {
    case FitKind::kPlane:
    case FitKind::kCircle:
    case FitKind::kCylinder:
      return 3;
    case FitKind::kSphere:
      return 4;
    case FitKind::kTorus:
      break;
  }
  return 6;
}

std::optional<Axis> revolution_axis(Points points) {
  // [Pottmann, Randrup 1998] The line with direction n and moment m = p x n meets the one with a and b where
  // n.b + m.a = 0. For each a the best b is -B^-1 C a, which leaves a matrix of three rows.
  std::array<double, 9> moments{}, mixed{}, normals{};
  for (const FitPoint& p : points) {
    const Vec3 m = cross(from_origin(p.place), p.normal);
    const std::array<double, 3> mm{m.x, m.y, m.z}, nn{p.normal.x, p.normal.y, p.normal.z};
    for (std::size_t i = 0; i < 9; ++i) {
      moments[i] += p.weight * mm[i / 3] * mm[i % 3];
      mixed[i] += p.weight * nn[i / 3] * mm[i % 3];
      normals[i] += p.weight * nn[i / 3] * nn[i % 3];
    }
  }
  const EigenPairs of_normals = eigen_pairs(normals, 3);
  if (of_normals.values[1] <= kZero * of_normals.values[2]) return std::nullopt;  // all parallel
  std::array<double, 9> inverse{}, back{};                                        // B^-1; B^-1 C
  for (std::size_t k = 0; k < 3; ++k) {
    if (of_normals.values[k] <= kZero * of_normals.values[2]) continue;
    for (std::size_t i = 0; i < 9; ++i)
      inverse[i] += of_normals.vectors[k][i / 3] * of_normals.vectors[k][i % 3] / of_normals.values[k];
  }
  for (std::size_t i = 0; i < 9; ++i)
    for (std::size_t k = 0; k < 3; ++k) back[i] += inverse[i / 3 * 3 + k] * mixed[k * 3 + i % 3];
  std::array<double, 9> left = moments;
  for (std::size_t i = 0; i < 9; ++i)
    for (std::size_t k = 0; k < 3; ++k) left[i] -= mixed[k * 3 + i / 3] * back[k * 3 + i % 3];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < i; ++j)
      left[i * 3 + j] = left[j * 3 + i] = 0.5 * (left[i * 3 + j] + left[j * 3 + i]);
  const EigenPairs pairs = eigen_pairs(left, 3);
  const Vec3 a = as_vec(pairs.vectors[0]);
  const auto row = [&](std::size_t i) { return -(back[i] * a.x + back[i + 1] * a.y + back[i + 2] * a.z); };
  const Axis axis{cross(a, Vec3{row(0), row(3), row(6)}), a};
  if (!is_finite(axis.place) || !is_finite(axis.direction)) return std::nullopt;
  return axis;
}

std::optional<Shape> start_of(FitKind kind, Points points) {
  std::optional<Shape> best;
  double nearest = 0.0;
  const auto offer = [&](Points through_these) {
    const std::optional<Shape> shape = through(kind, through_these);
    if (!shape || !is_finite(shape->centre) || !is_finite(shape->axis)) return;
    const double half = half_within(kind, *shape, points);
    if (!best || half < nearest) best = shape, nearest = half;
  };
  offer(points);
  Sequence sequence;
  std::vector<FitPoint> sample;
  for (const std::size_t size : {sample_size(kind), 2 * sample_size(kind)})
    for (int k = 0; k < kSamples && size <= points.size(); ++k) {
      sample.clear();
      for (std::size_t i = 0; i < size; ++i) sample.push_back(points[sequence.below(points.size())]);
      offer(sample);
    }
  return best;
}

}  // namespace tiltfeed::pathgen
