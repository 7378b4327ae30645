// The envelope against the tool let down along the axis line, by search over every point of every facet: no
// patches, no cells, no closed forms in common.
#include "pathgen/envelope/envelope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <random>
#include <tuple>
#include <vector>

#include "kinematics/basics/units.h"
#include "pathgen/envelope/thinning.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/pattern/row_layout.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kBeside = 1e-4;  ///< mm
constexpr double kExact = 2e-6;   ///< of a height found by search against one in closed form, mm

/// Height of the tool's underside over its CL reference at distance d from the axis; beyond the tool it
/// climbs without end, so that the search below stays on a concave function.
double underside(const Cutter& cutter, double d) {
  const double r = cutter.nose_radius(), e = cutter.radius() - r;
  const double taper = cutter.taper.radians(), touch = e + r * std::cos(taper);
  const double outer = cutter.cutting_top_radius();
  if (d > outer) return underside(cutter, outer) + 1e4 * (d - outer);
  if (d <= e) return -r;
  if (d <= touch) return -std::sqrt(std::max(0.0, r * r - (d - e) * (d - e)));
  return -r * std::sin(taper) + (d - touch) / std::tan(taper);
}

/// Place of the largest value of a concave function on [0, 1].
template <class Function>
double summit(Function f) {
  const double golden = 0.6180339887498949;
  double low = 0.0, high = 1.0, a = 1.0 - golden, b = golden, fa = f(a), fb = f(b);
  for (int i = 0; i < 50; ++i) {
    if (fa < fb) {
      low = a, a = b, fa = fb, b = low + golden * (high - low), fb = f(b);
    } else {
      high = b, b = a, fb = fa, a = high - golden * (high - low), fa = f(a);
    }
  }
  return (low + high) / 2.0;
}

/// z' of the CL reference of the tool let down on the whole mesh, by search over every facet; what would stop
/// it above `ceiling` or below `floor` is not in the column.
std::optional<double> drop(const AxisLine& line, const Mesh& mesh, const Cutter& cutter, double floor,
                           double ceiling) {
  const double outer = cutter.cutting_top_radius();
  std::optional<double> top;
  for (const auto& f : mesh.facets) {
    const Point<Part> a = mesh.vertices[f[0]], b = mesh.vertices[f[1]], c = mesh.vertices[f[2]];
    const Point<Part> centre = lerp(lerp(a, b, 0.5), c, 1.0 / 3.0);
    const Vec3 w = centre - line.base;
    const double size = std::max({distance(centre, a), distance(centre, b), distance(centre, c)});
    if (length(w - line.axis * dot(w, line.axis)) > outer + size) continue;
    double off = 0.0;
    const auto height = [&](double s, double t) {
      const Vec3 v = lerp(a, lerp(b, c, t), s) - line.base;
      const double h = dot(v, line.axis);
      off = length(v - line.axis * h);
      return h - underside(cutter, off);
    };
    const auto along = [&](double s) { return summit([&](double t) { return height(s, t); }); };
    const double s = summit([&](double at) { return height(at, along(at)); });
    const double z = height(s, along(s));
    if (off > outer + 1e-6 || z > ceiling || z < floor) continue;
    top = std::max(top.value_or(z), z);
  }
  return top;
}

struct Case {
  const char* name;
  AxisFrame frame;
  Along along;
  Sides sides;
  double rho, bump;      ///< mean and variation of the height of the grid's corners, mm
  double degrees = 0.0;  ///< of the lines
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
  all.push_back({"circle out, slanted",
                 {AxisMode::kCircle, Sense::kOutward, o, t, n, 120.0},
                 Along::kX,
                 Sides::kOutward,
                 40.0,
                 3.0,
                 31.0});
  return all;
}

std::vector<Cutter> cutters() {
  std::vector<Cutter> all(4);
  for (Cutter& cutter : all) cutter.length = 60.0, cutter.shank_length = 20.0;
  all[0].diameter = 6.0;
  all[1].diameter = 7.0, all[1].type = CutterType::kBullNose, all[1].corner_radius = 1.2;
  all[2].diameter = 5.0, all[2].type = CutterType::kFlat;
  all[3].diameter = 3.0, all[3].type = CutterType::kTaperBall, all[3].taper = Angle::from_degrees(12.0);
  all[3].cutting_length = 12.0;
  return all;
}

class EnvelopeTest : public testing::TestWithParam<std::tuple<int, int>> {};

// (cl_surface.h, property 1; envelope.h, properties 2 and 5)
TEST_P(EnvelopeTest, EqualsTheToolLetDownOnTheWholeMesh) {
  const Case c = cases()[static_cast<std::size_t>(std::get<0>(GetParam()))];
  PlanOptions options;
  options.cutter = cutters()[static_cast<std::size_t>(std::get<1>(GetParam()))];
  SCOPED_TRACE(c.name);
  const Mesh mesh = bumpy(c, 7);
  const ClSurface surface(mesh, c.sides, tool_pieces(options));
  const Deformation map(c.frame, c.rho);
  const FlatIndex index(make_flat_hulls(surface, map, 1.0), map);
  Pattern pattern;
  pattern.along = c.along, pattern.side_step = 9.0;
  pattern.angle = Angle::from_degrees(c.degrees);
  const auto raster = lay_rows(index, index.bounds(), pattern, pattern.side_step);
  ASSERT_TRUE(raster) << raster.error().message;
  ASSERT_GT(raster->count, 3.0);
  const EnvelopeOptions limits{0.004, 0.03};
  Envelope envelope(surface, map, index, limits);
  // The rim of a sharp edge may catch a feature up to kSeam beyond its end, on a line that just grazes it.
  const bool sharp = options.cutter.type == CutterType::kFlat;
  const double aside = sharp ? 40.0 * kBeside : kBeside, near = sharp ? 1e-3 : kExact;
  const bool bent = c.frame.mode != AxisMode::kFixed;
  const double floor = bent && map.s() > 0 ? 0.0 : -1e9, ceiling = map.s() > 0 ? c.rho + 40.0 : 0.0;
  const auto height_at = [&](double x, double y) {
    return drop(map.axis_line(x, y), mesh, options.cutter, floor, ceiling);
  };
  std::mt19937 random(11);
  std::size_t points = 0, columns = 0, hits = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(raster->count);
       k += 1 + static_cast<std::size_t>(raster->count) / 3) {
    const FlatLine line = raster->row(static_cast<double>(k));
    const std::vector<Pass> passes = envelope.along(line).passes;
    const auto run_of = [&](Point<Flat> f) { return (f.x - line.x) * line.dx + (f.y - line.y) * line.dy; };
    for (const Pass& pass : passes)
      for (std::size_t i = sharp ? pass.size() / 4 : 0; i + 1 < pass.size(); i += 1 + pass.size() / 6) {
        ++points;
        const EnvelopePoint& p = pass[i];
        // A flank may be as steep as a wall: the height is one between those of the places beside it.
        double lowest = 1e9, highest = -1e9;
        for (double shift : {0.0, -aside, aside}) {
          const auto z = height_at(p.flat.x + line.dx * shift, p.flat.y + line.dy * shift);
          if (z) lowest = std::min(lowest, *z), highest = std::max(highest, *z);
          if (z && shift == 0.0 && std::abs(*z - p.flat.z) < kExact) break;
        }
        EXPECT_GT(p.flat.z, lowest - near) << "line " << k << " point " << i << " of " << pass.size();
        EXPECT_LT(p.flat.z, highest + near) << "line " << k << " point " << i << " of " << pass.size();
        EXPECT_LT(distance(p.centre, map.unflatten(p.flat)), 1e-9);
        // The straight move to the next point stays on the envelope, of this place or of one within the
        // tolerance.
        if (run_of(pass[i + 1].flat) - run_of(p.flat) < 2.0 * limits.tolerance) continue;
        const Point<Flat> middle = map.flatten(lerp(p.centre, pass[i + 1].centre, 0.5));
        double low = 1e9, high = -1e9;
        for (double shift : {-limits.tolerance, 0.0, limits.tolerance}) {
          const auto beside = height_at(middle.x + line.dx * shift, middle.y + line.dy * shift);
          if (beside) low = std::min(low, *beside), high = std::max(high, *beside);
        }
        // The tolerance is square to the surface: more along the axis where it is steep.
        const auto there = envelope.at(middle.x, middle.y);
        const double facing = there ? std::max(0.1, dot(there->normal, there->axis)) : 1.0;
        EXPECT_GT(middle.z, low - limits.tolerance / facing) << "line " << k << " point " << i;
        EXPECT_LT(middle.z, high + limits.tolerance / facing) << "line " << k << " point " << i;
      }
    // Columns anywhere on the line: either inside a run, at the right height, or free of the part.
    std::uniform_real_distribution<double> along(0.0, line.length);
    for (int i = 0; i < 6; ++i) {
      ++columns;
      const double at = along(random);
      const auto z = height_at(line.x_at(at), line.y_at(at));
      const auto found = envelope.at(line.x_at(at), line.y_at(at));
      bool inside = false;
      for (const Pass& pass : passes)
        inside = inside || (at >= run_of(pass.front().flat) - 1e-3 && at <= run_of(pass.back().flat) + 1e-3);
      EXPECT_EQ(z.has_value(), inside) << "line " << k << " at " << at;
      ASSERT_EQ(z.has_value(), found.has_value()) << "line " << k << " at " << at;
      if (!z) continue;
      ++hits;
      EXPECT_NEAR(found->flat.z, *z, kExact) << "line " << k << " at " << at;
      // The normal is that of the surface as it lies in part space, whatever the axis does.
      constexpr double kStep = 1e-5;
      for (const auto& [dx, dy] : {std::pair{1.0, 0.0}, std::pair{0.0, 1.0}}) {
        const auto next = envelope.at(found->flat.x + kStep * dx, found->flat.y + kStep * dy);
        if (!next || next->patch != found->patch || dot(found->normal, found->axis) < 0.1) continue;
        EXPECT_LT(std::abs(dot(found->normal, normalized(next->centre - found->centre))), 2e-4)
            << "line " << k << " at " << at << " patch " << found->patch;
      }
    }
  }
  EXPECT_GT(points, 4u);
  EXPECT_GT(columns, 10u);
  EXPECT_GT(hits, 3u);
}

INSTANTIATE_TEST_SUITE_P(Modes, EnvelopeTest, testing::Combine(testing::Range(0, 15), testing::Range(0, 4)));

TEST(Thinned, KeepsCornersAndDropsWhatAStraightMovePasses) {
  Pass pass;
  for (int i = 0; i <= 100; ++i) {
    EnvelopePoint p;
    p.axis = {0, 0, 1};
    p.centre = {i * 0.1, 0.0, std::abs(i - 50) * 0.05};
    pass.push_back(p);
  }
  const Pass kept = thinned(pass, 0.001, {.max_axis_step = 0.1});
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
  const Pass kept = thinned(pass, 0.01, {.max_axis_step = 0.02});
  for (std::size_t i = 0; i + 1 < kept.size(); ++i)
    EXPECT_LE(angle_between(kept[i].axis, kept[i + 1].axis), 0.0201);
  EXPECT_GT(kept.size(), 9u);
  EXPECT_LT(kept.size(), 20u);
}

TEST(Thinned, C17WhatIsLeftOutLiesWithinTheShareOfItsMove) {
  constexpr double kShare = 0.01;
  Pass pass;
  std::mt19937 random(17);
  std::uniform_real_distribution<double> turn(-0.02, 0.02);
  double heading = 0.0;
  Point<Part> at;
  for (int i = 0; i < 2000; ++i) {
    EnvelopePoint p;
    p.axis = {0, 0, 1};
    p.centre = at;
    p.lever = static_cast<float>(1 + i % 3);
    pass.push_back(p);
    heading += turn(random);
    at = at + Vec3{0.1 * std::cos(heading), 0.0, 0.1 * std::sin(heading)};
  }
  const Pass kept = thinned(pass, kShare, {});
  EXPECT_LT(kept.size(), pass.size() / 3);
  double most = 0.0;
  std::size_t move = 0;
  for (const EnvelopePoint& p : pass) {
    if (p.centre == kept[move + 1].centre && move + 2 < kept.size()) ++move;
    const Point<Part> from = kept[move].centre, to = kept[move + 1].centre;
    double nearest = distance(p.centre, to);
    for (int k = 0; k < 400; ++k)
      nearest = std::min(nearest, distance(p.centre, from + (to - from) * (k / 400.0)));
    most = std::max(most, nearest * static_cast<double>(p.lever));
  }
  EXPECT_LE(most, kShare * 1.1) << "sampled to a hundredth of a move";
  EXPECT_GT(most, kShare * 0.5) << "the share is not used";
}

}  // namespace
}  // namespace tiltfeed
