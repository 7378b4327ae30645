// The envelope of every slice against a ball let down along the axis by sphere tracing over all triangles: no
// patches, no slices, no closed forms in common.
#include "pathgen/envelope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include "kinematics/units.h"
#include "pathgen/mesh.h"

namespace tiltfeed {
namespace {

constexpr double kTouching = 1e-9;
/// Where the line only grazes the ball's track, a gap of kTouching leaves this much of z' open, for a 3 mm
/// ball.
constexpr double kGrazing = 2e-4;

double point_triangle(Point<Part> p, Point<Part> a, Point<Part> b, Point<Part> c) {
  const auto to_segment = [&](Point<Part> u, Point<Part> v) {
    const double f = std::clamp(dot(p - u, v - u) / squared_length(v - u), 0.0, 1.0);
    return distance(p, lerp(u, v, f));
  };
  const Vec3 n = normalized(cross(b - a, c - a));
  const bool over = dot(cross(n, b - a), p - a) >= 0 && dot(cross(n, c - b), p - b) >= 0 &&
                    dot(cross(n, a - c), p - c) >= 0;
  return over ? std::abs(dot(n, p - a)) : std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
}

double to_mesh(Point<Part> p, const Mesh& mesh) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& f : mesh.facets)
    nearest =
        std::min(nearest, point_triangle(p, mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]));
  return nearest;
}

/// z' at which the ball, coming down the line from `from_z`, first touches; nothing if it gets to `to_z`.
std::optional<double> drop(const AxisLine& line, const Mesh& mesh, double radius, double from_z,
                           double to_z) {
  for (double z = from_z; z > to_z;) {
    const double gap = to_mesh(line.base + line.axis * z, mesh) - radius;
    if (gap < kTouching) return z;
    z -= std::max(gap, kGrazing / 2);
  }
  return std::nullopt;
}

struct Case {
  const char* name;
  AxisFrame frame;
  Along along;
  Sides sides;
  double rho, bump;  ///< mean and variation of the height of the grid's corners, mm
};

/// A bumpy closed surface: a grid of columns by rows, wound round the axis feature (rows closed too, except
/// that in point and fixed mode it is a patch with open borders). Facets are large against the ball and the
/// curvature.
Mesh bumpy(const Case& c, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const Deformation map(c.frame, c.rho);
  const bool ring = c.frame.mode == AxisMode::kCircle || c.frame.mode == AxisMode::kLine;
  const int columns = 14, rows = 12;
  Mesh mesh;
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) {
      const double z = c.rho + c.bump * unit(random);
      const double u = 2 * kPi * i / columns, v = 2 * kPi * j / rows;
      Point<Flat> f{};
      if (c.frame.mode == AxisMode::kCircle)
        f = {map.scale_x() * (u - 2.9), map.scale_y() * (v - 3.0), map.s() * z};
      if (c.frame.mode == AxisMode::kLine)  // a ring whose section is a circle beside the line
        f = {14.0 * std::cos(v), map.scale_y() * (u - 2.9), map.s() * (z + 9.0 * std::sin(v))};
      if (c.frame.mode == AxisMode::kPoint)
        f = {map.scale_x() * (u - 3.1) * 0.8, map.scale_y() * (v - 3.1) * 0.35, map.s() * z};
      if (c.frame.mode == AxisMode::kFixed) f = {3.0 * i, 3.1 * j, z};
      mesh.vertices.push_back(map.unflatten(f));
    }
  for (int i = 0; i < columns - (ring ? 0 : 1); ++i)
    for (int j = 0; j < rows - (ring ? 0 : 1); ++j) {
      const auto at = [&](int a, int b) {
        return static_cast<std::uint32_t>((a % columns) * rows + b % rows);
      };
      mesh.facets.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.facets.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  double volume = 0.0;
  for (const auto& f : mesh.facets)
    volume += dot(from_origin(mesh.vertices[f[0]]),
                  cross(from_origin(mesh.vertices[f[1]]), from_origin(mesh.vertices[f[2]])));
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) {
    if (volume < 0.0) std::swap(mesh.facets[f][1], mesh.facets[f][2]);
    mesh.source.push_back(f);
  }
  return mesh;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  const Vec3 t = normalized(Vec3{0.2, 0.9, -0.3}), n = normalized(cross(t, Vec3{0.5, -0.2, 0.8}));
  const Point<Part> o{5.0, -8.0, 3.0};
  for (Along along : {Along::kX, Along::kY}) {
    all.push_back(
        {"fixed", {AxisMode::kFixed, Sense::kOutward, o, t, n, 0.0}, along, Sides::kBoth, 10.0, 3.0});
    all.push_back(
        {"point out", {AxisMode::kPoint, Sense::kOutward, o, t, n, 0.0}, along, Sides::kBoth, 40.0, 3.0});
    all.push_back(
        {"point in", {AxisMode::kPoint, Sense::kInward, o, t, n, 0.0}, along, Sides::kBoth, 40.0, 3.0});
    all.push_back(
        {"line out", {AxisMode::kLine, Sense::kOutward, o, t, n, 0.0}, along, Sides::kOutward, 40.0, 2.0});
    all.push_back(
        {"line in", {AxisMode::kLine, Sense::kInward, o, t, n, 0.0}, along, Sides::kOutward, 40.0, 2.0});
    all.push_back({"circle out",
                   {AxisMode::kCircle, Sense::kOutward, o, t, n, 120.0},
                   along,
                   Sides::kOutward,
                   40.0,
                   3.0});
    all.push_back(
        {"circle in", {AxisMode::kCircle, Sense::kInward, o, t, n, 120.0}, along, Sides::kBoth, 40.0, 3.0});
  }
  return all;
}

class EnvelopeTest : public testing::TestWithParam<int> {};

TEST_P(EnvelopeTest, EqualsABallLetDownOnTheWholeMesh) {
  const Case c = cases()[static_cast<std::size_t>(GetParam())];
  SCOPED_TRACE(c.name);
  const double radius = 3.0;
  const Mesh mesh = bumpy(c, 7);
  const ClSurface surface(mesh, c.sides, radius);
  const Deformation map(c.frame, c.rho);
  const auto slices = slice(surface, map, c.along, 4.0);
  ASSERT_TRUE(slices) << slices.error().message;
  ASSERT_GT(slices->count(), 3u);
  const EnvelopeOptions options{0.004, 0.03};
  const double above = map.s() > 0 ? c.rho + 40.0 : -1e-3, below = map.s() > 0 ? 1e-3 : -c.rho - 40.0;
  std::mt19937 random(11);
  std::size_t points = 0, columns = 0;
  for (std::size_t k = 0; k < slices->count(); k += 1 + slices->count() / 6) {
    const std::vector<Pass> passes = upper_envelope(surface, map, *slices, k, options).passes;
    const auto run_of = [&](Point<Flat> f) { return c.along == Along::kX ? f.x : f.y; };
    for (const Pass& pass : passes)
      for (std::size_t i = 0; i + 1 < pass.size(); i += 1 + pass.size() / 12) {
        ++points;
        const AxisLine line = map.axis_line(pass[i].flat.x, pass[i].flat.y);
        const auto z = drop(line, mesh, radius, above, below);
        ASSERT_TRUE(z) << "slice " << k << " point " << i;
        EXPECT_NEAR(to_mesh(pass[i].centre, mesh), radius, 1e-8) << "slice " << k << " point " << i;
        EXPECT_NEAR(pass[i].flat.z, *z, kGrazing) << "slice " << k << " point " << i;
        EXPECT_LT(distance(pass[i].centre, line.base + line.axis * pass[i].flat.z), 1e-9);
        // The straight move to the next point stays on the envelope: no deeper, and in contact, or on a
        // flank.
        const Point<Part> middle = lerp(pass[i].centre, pass[i + 1].centre, 0.5);
        EXPECT_GT(to_mesh(middle, mesh), radius - options.tolerance) << "slice " << k << " point " << i;
        if (std::abs(run_of(pass[i + 1].flat) - run_of(pass[i].flat)) > options.tolerance) {
          EXPECT_LT(to_mesh(middle, mesh), radius + options.tolerance) << "slice " << k << " point " << i;
        }
      }
    // Columns anywhere on the slice: either inside a run or free of the part.
    std::uniform_real_distribution<double> along(slices->run_min, slices->run_max);
    for (int i = 0; i < 5; ++i) {
      ++columns;
      const double at = along(random), level = slices->level(k);
      const auto z = drop(c.along == Along::kX ? map.axis_line(at, level) : map.axis_line(level, at), mesh,
                          radius, above, below);
      bool inside = false;
      for (const Pass& pass : passes)
        inside = inside || (at >= run_of(pass.front().flat) - 1e-3 && at <= run_of(pass.back().flat) + 1e-3);
      EXPECT_EQ(z.has_value(), inside) << "slice " << k << " at " << at;
    }
  }
  EXPECT_GT(points, 30u);
  EXPECT_GT(columns, 10u);
}

INSTANTIATE_TEST_SUITE_P(Modes, EnvelopeTest, testing::Range(0, 14));

TEST(Thinned, KeepsCornersAndDropsWhatAStraightMovePasses) {
  Pass pass;
  for (int i = 0; i <= 100; ++i) {
    EnvelopePoint p;
    p.axis = {0, 0, 1};
    p.centre = {i * 0.1, 0.0, std::abs(i - 50) * 0.05};
    pass.push_back(p);
  }
  const Pass kept = thinned(pass, 0.001, 0.1);
  EXPECT_LT(kept.size(), 8u);
  EXPECT_TRUE(
      std::any_of(kept.begin(), kept.end(), [](const EnvelopePoint& p) { return p.centre.z == 0.0; }));
  EXPECT_EQ(kept.front().centre, pass.front().centre);
  EXPECT_EQ(kept.back().centre, pass.back().centre);
}

TEST(Thinned, NeverTurnsTheAxisFurtherThanAllowed) {
  Pass pass;
  for (int i = 0; i <= 200; ++i) {
    EnvelopePoint p;
    p.axis = {std::sin(i * 0.001), 0, std::cos(i * 0.001)};
    p.centre = {i * 0.1, 0.0, 0.0};
    pass.push_back(p);
  }
  const Pass kept = thinned(pass, 0.01, 0.02);
  for (std::size_t i = 0; i + 1 < kept.size(); ++i)
    EXPECT_LE(angle_between(kept[i].axis, kept[i + 1].axis), 0.0201);
  EXPECT_GT(kept.size(), 9u);
  EXPECT_LT(kept.size(), 20u);
}

}  // namespace
}  // namespace tiltfeed
