// Every place of the CL surface lies in a hull of its patch, and none is higher than the hull says: all
// patches asked on many axis lines, whatever the hulls say.
#include "pathgen/surface/flat_hulls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>

#include "kinematics/basics/units.h"
#include "pathgen/surface/flat_index.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kFar = 1e9;  ///< mm

struct Field {
  const char* name;
  AxisMode mode;
  Sense sense;
  CutterType cutter;
};

std::vector<Field> fields() {
  std::vector<Field> all;
  for (const CutterType cutter :
       {CutterType::kBall, CutterType::kBullNose, CutterType::kFlat, CutterType::kTaperBall}) {
    all.push_back({"fixed", AxisMode::kFixed, Sense::kOutward, cutter});
    all.push_back({"point out", AxisMode::kPoint, Sense::kOutward, cutter});
    all.push_back({"point in", AxisMode::kPoint, Sense::kInward, cutter});
    all.push_back({"line out", AxisMode::kLine, Sense::kOutward, cutter});
    all.push_back({"line in", AxisMode::kLine, Sense::kInward, cutter});
    all.push_back({"circle out", AxisMode::kCircle, Sense::kOutward, cutter});
    all.push_back({"circle in", AxisMode::kCircle, Sense::kInward, cutter});
  }
  return all;
}

PlanOptions options_of(CutterType type) {
  PlanOptions options;
  Cutter& c = options.cutter;
  c.type = type, c.diameter = 3.0, c.length = 60.0, c.shank_length = 20.0;
  if (type == CutterType::kBullNose) c.corner_radius = 0.6;
  if (type == CutterType::kTaperBall) c.taper = Angle::from_degrees(8.0), c.cutting_length = 12.0;
  return options;
}

/// Three facets that share edges, in some place of a box of +-half: a fan with one edge or corner that sticks
/// out or sinks in.
Mesh fan(std::mt19937& random, double half, double size) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  // Often near the point, the line, the circle's axis.
  const auto place = [&] {
    const double u = unit(random);
    return half * u * std::abs(u);
  };
  const Point<Part> centre{place(), place(), place()};
  const auto near = [&] { return centre + Vec3{unit(random), unit(random), unit(random)} * size; };
  Mesh mesh;
  mesh.vertices = {centre, near(), near(), near(), near()};
  mesh.facets = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}};
  mesh.source = {0, 1, 2};
  return mesh;
}

bool in_box(const FlatHulls& hulls, const FlatHull& hull, double x, double y, double period_x,
            double period_y) {
  double low_x = kFar, high_x = -kFar, low_y = kFar, high_y = -kFar;
  for (std::uint32_t i = hull.first; i < hull.first + hull.count; ++i) {
    const FlatCorner c = hulls.corners[i];
    low_x = std::min<double>(low_x, c.x), high_x = std::max<double>(high_x, c.x);
    low_y = std::min<double>(low_y, c.y), high_y = std::max<double>(high_y, c.y);
  }
  const auto within = [](double v, double low, double high, double pad, double period) {
    for (const double turned : {v, v - period, v + period, v - 2.0 * period, v + 2.0 * period})
      if (turned >= low - pad && turned <= high + pad) return true;
    return false;
  };
  return within(x, low_x, high_x, hull.pad_x, period_x) && within(y, low_y, high_y, hull.pad_y, period_y);
}

/// Nearer to the end of a column (mm) nothing is machined.
constexpr double kLeast = 0.1;

class CellsTest : public testing::TestWithParam<int> {};

TEST_P(CellsTest, HoldWhateverTheToolTouches) {
  const Field field = fields()[static_cast<std::size_t>(GetParam())];
  SCOPED_TRACE(field.name);
  const PlanOptions options = options_of(field.cutter);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const AxisFrame frame{field.mode, field.sense, {}, {1, 0, 0}, {0, 0, 1}, 15.0};
  const Deformation map(frame, 12.0);
  std::size_t hits = 0, missed = 0, low = 0;
  double over = 0.0;  // mm
  for (int part = 0; part < 1500; ++part) {
    const Mesh mesh = fan(random, 22.0, std::exp(1.2 * unit(random)));
    const ClSurface surface(mesh, Sides::kBoth, tool_pieces(options));
    const FlatHulls hulls = make_flat_hulls(surface, map, 0.5);
    for (int line = 0; line < 60; ++line) {
      // A place that the tool may have, near the part.
      const Point<Part> centre = mesh.vertices[0] + Vec3{unit(random), unit(random), unit(random)} * 4.0;
      const Point<Flat> at = map.flatten(centre);
      const AxisLine axis = map.axis_line(at.x, at.y);
      for (PatchId patch = 0; patch < surface.patch_count(); ++patch) {
        ClHit hit;
        if (!surface.top(patch, axis, hit)) continue;
        // What a cone touches beyond its column's end is the opposite wall's matter.
        const double above = field.cutter == CutterType::kTaperBall ? options.cutter.cutting_length : 0.0;
        if (!map.in_column({at.x, at.y, hit.z}, kLeast) || map.column_length({at.x, at.y, hit.z}) < above)
          continue;
        ++hits;
        bool held = false;
        double top = -kFar;
        for (const FlatHull& hull : hulls.hulls) {
          if (hull.patch != patch || !in_box(hulls, hull, at.x, at.y, map.period_x(), map.period_y()))
            continue;
          held = true;
          top = std::max(top, static_cast<double>(hull.top));
        }
        missed += held ? 0 : 1;
        if (held && hit.z > top) ++low, over = std::max(over, hit.z - top);
      }
    }
  }
  EXPECT_GT(hits, 1000u);
  EXPECT_EQ(missed, 0u) << "of " << hits;
  EXPECT_EQ(low, 0u) << "of " << hits << ", by up to " << over << " mm";
}

/// The first of all patches, asked one after the other.
std::optional<PatchId> first_over(const ClSurface& surface, Point<Part> end, Vec3 axis) {
  for (PatchId patch = 0; patch < surface.patch_count(); ++patch)
    if (surface.covers(patch, end, axis)) return patch;
  return std::nullopt;
}

TEST_P(CellsTest, TellWhatCoversTheEndOfAColumn) {
  const Field field = fields()[static_cast<std::size_t>(GetParam())];
  SCOPED_TRACE(field.name);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Mesh mesh;
  for (int part = 0; part < 80; ++part) {
    const Mesh more = fan(random, 30.0, std::exp(1.2 * unit(random)));
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
    for (const auto& [a, b, c] : more.facets) mesh.facets.push_back({first + a, first + b, first + c});
  }
  const ClSurface surface(mesh, Sides::kBoth, {tool_pieces(options_of(field.cutter)).front()});
  const Deformation map({field.mode, field.sense, {}, {1, 0, 0}, {0, 0, 1}, 15.0}, 12.0);
  const FlatIndex index(make_flat_hulls(surface, map, 0.5), map);
  std::size_t ends = 0, covered = 0;
  for (int place = 0; place < 1000; ++place) {
    const Point<Part> near = mesh.vertices[static_cast<std::size_t>(place) % mesh.vertices.size()];
    const Point<Flat> at = map.flatten(near + Vec3{unit(random), unit(random), unit(random)} * 4.0);
    const std::optional<Point<Part>> end = map.column_end(at.x, at.y);
    if (!end) continue;
    const Vec3 axis = map.axis_line(at.x, at.y).axis;
    const std::optional<PatchId> expected = first_over(surface, *end, axis);
    ++ends, covered += expected ? 1 : 0;
    EXPECT_EQ(index.covering().first_over(*end, [&](PatchId p) { return surface.covers(p, *end, axis); }),
              expected);
  }
  const bool has_ends = field.sense == Sense::kInward || field.mode == AxisMode::kCircle;
  EXPECT_EQ(ends > 100, has_ends);
  if (has_ends && field.mode != AxisMode::kPoint) {
    EXPECT_GT(covered, 10u);
  }
}

INSTANTIATE_TEST_SUITE_P(Fields, CellsTest, testing::Range(0, 28));

}  // namespace
}  // namespace tiltfeed
