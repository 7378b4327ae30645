// sim/tool_solid and sim/revolved against the outline of a cutter written down point by point, closed forms
// (planes, edges, corners), the capsule of a ball end mill, and nested search over triangles.

#include "sim/solid/tool_solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/shapes/whole_tool.h"

namespace tiltfeed::sim {
using namespace pathgen;
namespace {

Cutter ball(double diameter, double shank_length) { return {diameter, 100.0, shank_length}; }

double nearest_piece(const ToolSolid& tool, double r, double h) {
  double least = kInfinity;
  for (const ToolPart part : kToolParts)
    for (const Revolved& piece : tool.pieces(part)) least = std::min(least, piece.distance(r, h).value);
  return least;
}

TEST(ToolSolid, OutlineIsTheCutters) {
  // The distance from the outline drawn point by point, for points outside; inside and outside agree.
  constexpr double kStep = 2e-3;
  for (const CutterType type : kTypes) {
    const Cutter cutter = full(type);
    const ToolSolid tool(cutter);
    std::vector<std::array<double, 2>> outline;
    double last = 0.0;
    for (double h = 0.0; h < 48.0; h += kStep) {
      const double r = radius_of(cutter, h);
      for (double x = std::min(last, r); x < std::max(last, r); x += kStep) outline.push_back({x, h});
      outline.push_back({r, h}), last = r;
    }
    for (double x = 0.0; x < last; x += kStep) outline.push_back({x, 48.0});
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> any_r(0, 20), any_h(-4, 52);
    for (int i = 0; i < 1500; ++i) {
      const double r = any_r(random), h = any_h(random);
      double expected = kInfinity;
      for (const auto& p : outline) expected = std::min(expected, std::hypot(p[0] - r, p[1] - h));
      const bool inside = h > 0.0 && h < 48.0 && r < radius_of(cutter, h);
      const double found = nearest_piece(tool, r, h);
      if (expected < 2 * kStep) continue;
      if (inside) {
        ASSERT_LT(found, 0.0) << r << ", " << h;
        // A union of pieces never shows more depth than there is.
        ASSERT_GE(found, -expected - 2 * kStep) << r << ", " << h;
      } else {
        ASSERT_NEAR(found, expected, 2 * kStep) << static_cast<int>(type) << ": " << r << ", " << h;
      }
    }
    EXPECT_NEAR(tool.top(), 48.0, 1e-12);
  }
}

TEST(ToolSolid, DepthAtAJointIsThatOfTheWholeTool) {
  // Just at the joint of two parts the depth is measured as anywhere else, up to kJointOverlap; in front of a
  // concave corner it may be less by sqrt(2).
  for (const CutterType type : kTypes) {
    const Cutter cutter = full(type);
    const ToolSolid tool(cutter);
    for (const double joint : {12.0, 30.0, 40.0}) {
      const double r = std::min(radius_of(cutter, joint - 1e-9), radius_of(cutter, joint + 1e-9));
      for (const double h : {joint - 0.02, joint - 1e-6, joint + 1e-6, joint + 0.02}) {
        double depth = kInfinity, last = radius_of(cutter, joint - 0.2);
        for (double at = joint - 0.2; at < joint + 0.2; at += 1e-4) {
          const double next = radius_of(cutter, at);
          for (double x = std::min(last, next); x <= std::max(last, next); x += 1e-4)
            depth = std::min(depth, std::hypot(x - (r - 0.05), at - h));
          last = next;
        }
        ASSERT_GT(depth, 0.03);
        const double found = -nearest_piece(tool, r - 0.05, h);
        EXPECT_LE(found, depth + 2e-4) << joint << " " << h;
        EXPECT_GE(found, depth * std::sqrt(0.5) - 2e-4) << joint << " " << h;
      }
    }
  }
}

TEST(ToolSolid, LowerBorderIsTheCutters) {
  for (const CutterType type : kTypes) {
    Cutter cutter = full(type);
    const ToolSolid tool(cutter);
    const Revolved& solid = tool.cutting();
    const double widest = radius_of(cutter, cutter.cutting_length - 1e-12);
    EXPECT_NEAR(solid.widest(), widest, 1e-9);
    for (double h = 0.01; h < solid.widest_height(); h += 0.05) {
      const double r = radius_of(cutter, h);
      if (r < widest) {
        EXPECT_NEAR(solid.lower_border(r).value, h, 1e-9) << r;
      }
      if (r < widest) {
        // The slope by differences.
        const double slope = (solid.lower_border(r + 1e-7).value - solid.lower_border(r - 1e-7).value) / 2e-7;
        EXPECT_NEAR(solid.lower_border(r).along_r, slope, 1e-3 * (1 + slope * slope)) << r;
      }
    }
    EXPECT_EQ(solid.lower_border(widest + 1e-6).value, kInfinity);
  }
}

TEST(ToolSolid, ClearanceEqualsTheCapsules) {
  // A ball end mill rounded at both ends is all points within the radius of a segment.
  std::mt19937_64 random(12);
  const Revolved capsule({{0, 2, 2, kPi / 2}, {0, 9, 2, kPi}});
  int overlaps = 0;
  for (int i = 0; i < 400; ++i) {
    const PartDistance part(mesh_of(random_soup(random, i % 4 == 0 ? 40 : 3, 12, 4)));
    std::uniform_real_distribution<double> place(-10, 10);
    const Pose pose{{place(random), place(random), place(random)}, random_axis(random)};
    const double expected =
        part.nearest(Segment{pose.tip + pose.axis * 2.0, pose.tip + pose.axis * 9.0}).value - 2.0;
    const Hit hit = clearance(part, capsule, pose);
    ASSERT_NEAR(hit.value, expected, 1e-8) << i;
    overlaps += expected < 0.0;
    EXPECT_EQ(clearance(part, capsule, pose, hit.value - 1e-6).facet, kNoFacet);
    EXPECT_EQ(clearance(part, capsule, pose, hit.value + 1e-6, 0).value, hit.value);
  }
  EXPECT_GT(overlaps, 60);
}

/// Least of f over the triangle: f is convex, so golden sections within golden sections find it.
template <class F>
double nested_least(const F& f, Point<Part> a, Point<Part> b, Point<Part> c) {
  constexpr double kGolden = 0.6180339887498949;
  const auto least = [&](const auto& g) {
    double low = 0.0, high = 1.0, p = 1 - kGolden, q = kGolden, gp = g(p), gq = g(q);
    for (int i = 0; i < 44; ++i) {
      if (gp <= gq)
        high = q, q = p, gq = gp, p = high - kGolden * (high - low), gp = g(p);
      else
        low = p, p = q, gp = gq, q = low + kGolden * (high - low), gq = g(q);
    }
    return std::min({gp, gq, g(0.0), g(1.0)});
  };
  return least([&](double v) { return least([&](double w) { return f(lerp(lerp(a, b, v), c, w)); }); });
}

TEST(ToolSolid, TriangleClearanceEqualsNestedSearch) {
  std::mt19937_64 random(14);
  std::uniform_real_distribution<double> place(-6, 6), up(-4, 16);
  int face = 0, deep = 0;
  for (int i = 0; i < 240; ++i) {
    const ToolSolid tool(full(kTypes[i % 4]));
    const Pose pose{{0, 0, 0}, random_axis(random)};
    const Point<Part> at = pose.tip + pose.axis * up(random);
    const auto corner = [&] { return at + Vec3{place(random), place(random), place(random)}; };
    const Point<Part> a = corner(), b = corner(), c = corner();
    const PartDistance part(mesh_of({{a, b, c}}));
    const Revolved& solid = i % 8 < 4 ? tool.cutting() : tool.pieces(ToolPart::kHolder)[0];
    const auto value = [&](Point<Part> q) {
      const Vec3 m = q - pose.tip;
      const double h = dot(m, pose.axis);
      return solid.distance(length(m - pose.axis * h), h).value;
    };
    const double expected = nested_least(value, a, b, c);
    ASSERT_NEAR(clearance(part, solid, pose).value, expected, 2e-7) << i;
    face += expected < std::min({value(a), value(b), value(c)}) - 1e-3;
    deep += expected < 0.0;
  }
  EXPECT_GT(face, 100);
  EXPECT_GT(deep, 60);
}

TEST(ToolSolid, EveryPartFindsItsOwnOverlap) {
  const Cutter cutter = full(CutterType::kBullNose);
  const ToolSolid tool(cutter);
  const Pose pose{{5, -3, 2}, normalized({0.3, -0.2, 0.9})};
  const Vec3 out = normalized(cross(pose.axis, {0, 0, 1}));
  const struct {
    ToolPart part;
    double height, radius;
  } kRows[] = {{ToolPart::kCutter, 6.0, 3.0}, {ToolPart::kShank, 20.0, 2.5}, {ToolPart::kHolder, 44.0, 14.0}};
  for (const auto& row : kRows)
    for (const double depth : {0.004, 0.3, -0.2}) {
      // A pin's point that reaches into that part from the side.
      const Point<Part> at = pose.tip + pose.axis * row.height + out * (row.radius - depth);
      const PartDistance pin(mesh_of({{at, at + out * 30.0, at + out * 30.0 + pose.axis}}));
      const double lean = row.part == ToolPart::kHolder ? std::cos(std::atan(2.0 / 8.0)) : 1.0;
      EXPECT_NEAR(tool.clearance(pin, pose, row.part).value, -depth * lean, 1e-9);
      for (const ToolPart other : kToolParts)
        if (other != row.part) {
          EXPECT_GT(tool.clearance(pin, pose, other).value, 0.0);
        }
    }
}

TEST(ToolSolid, SharpRimsAndFacesGiveTheirDepth) {
  const ToolSolid flat(full(CutterType::kFlat));
  // Face on a plane: the depth itself. Rim at 45 degrees: 1 / sqrt(2) of it, as the header says.
  const PartDistance floor(plane_at({0, 0, 0}, {0, 0, 1}));
  EXPECT_NEAR(flat.clearance(floor, {{0, 0, -0.02}, {0, 0, 1}}, ToolPart::kCutter).value, -0.02, 1e-9);
  const double s = std::sqrt(0.5);
  EXPECT_NEAR(flat.clearance(floor, {{0, 0, 3 * s - 0.02}, {s, 0, s}}, ToolPart::kCutter).value, -0.02 * s,
              1e-9);
  EXPECT_NEAR(flat.gap(floor, {{0, 0, 3 * s + 0.02}, {s, 0, s}}).value, 0.02, 1e-9);
  EXPECT_NEAR(flat.drop(floor, {{0, 0, 3 * s + 0.02}, {s, 0, s}}).value, 0.02 / s, 1e-8);
}

TEST(ToolSolid, GrowsByStockAndAllowance) {
  const PartDistance floor(plane_at({0, 0, 0}, {0, 0, 1}));
  const PartDistance wall(plane_at({10, 0, 0}, {1, 0, 0}));
  const Vec3 z{0, 0, 1};
  for (const CutterType type : kTypes) {
    const double r = type == CutterType::kTaperBall ? 6.0 : 3.0;  // the widest, up to the shank
    const ToolSolid tool(full(type), {0.2, 0.3, 0.5});
    EXPECT_NEAR(tool.clearance(floor, {{0, 0, 4}, z}, ToolPart::kCutter).value, 4 - 0.7, 1e-9);
    EXPECT_NEAR(tool.drop(floor, {{0, 0, 4}, z}).value, 4 - 0.7, 1e-9);
    const double side = std::min(tool.clearance(wall, {{0, 0, 4}, z}, ToolPart::kCutter).value,
                                 tool.clearance(wall, {{0, 0, 4}, z}, ToolPart::kShank).value);
    EXPECT_NEAR(side, 10 - r - 0.5, 1e-9);
    EXPECT_NEAR(tool.clearance(wall, {{-9, 0, 4}, z}, ToolPart::kHolder).value, 19 - 15 - 0.5, 1e-9);
  }
  // A capsule grows by the allowance alone; a ball with stock at the side gets a flat end.
  EXPECT_NEAR(ToolSolid(ball(4, 30), {0.2}).clearance(floor, {{0, 0, 4}, z}, ToolPart::kCutter).value, 3.8,
              1e-12);
  const double s = std::sin(0.5), c = std::cos(0.5);
  const PartDistance tilted(plane_at({0, 0, 0}, {s, 0, c}));
  EXPECT_NEAR(ToolSolid(ball(4, 30), {0, 0.3, 0}).drop(tilted, {{0, 0, 20}, z}).value,
              20 - (2 + 0.3 * s) / c + 2, 1e-7);
}

TEST(ToolSolid, PlainBallIsTheCapsuleWithAFlatTop) {
  // All of the tool is in the capsule up to its length, and holds that which ends at its length.
  std::mt19937_64 random(16);
  std::uniform_real_distribution<double> place(-10, 10);
  int at_top = 0;
  for (const double allowance : {0.0, 0.3}) {
    const ToolSolid tool(ball(4, 20), {allowance});
    const Revolved& piece = tool.pieces(ToolPart::kCutter).front();
    EXPECT_FALSE(tool.has(ToolPart::kShank) || tool.has(ToolPart::kHolder));
    for (int i = 0; i < 200; ++i) {
      const PartDistance part(mesh_of(random_soup(random, 10, 12, 4)));
      const Vec3 axis = random_axis(random);
      // Every other time its upper end is in the soup.
      const Point<Part> at{place(random), place(random), place(random)};
      const Pose pose{i % 2 == 0 ? at : at - axis * 20.0, axis};
      const Point<Part> centre = pose.tip + pose.axis * 2.0;
      const double radius = 2.0 + allowance, found = tool.clearance(part, pose, ToolPart::kCutter).value;
      const double whole = part.nearest(Segment{centre, pose.tip + pose.axis * 20.0}).value - radius;
      const double inner = part.nearest(Segment{centre, pose.tip + pose.axis * 18.0}).value - radius;
      if (inner == whole) {
        EXPECT_EQ(found, whole);
      } else {
        EXPECT_NEAR(found, clearance(part, piece, pose).value, 1e-9);
        ++at_top;
      }
      EXPECT_EQ(tool.gap(part, pose).value, part.nearest(centre).value - radius);
      EXPECT_EQ(tool.drop(part, pose).value, part.first_touch(centre, -pose.axis, radius).value);
    }
  }
  EXPECT_GT(at_top, 20);
}

TEST(ToolSolid, NothingStandsOverTheUpperEnd) {
  // A ceiling over a ball end mill without holder, and its allowance: for any length of the tool.
  const Vec3 z{0, 0, 1};
  for (const double length : {2.0, 3.0, 4.0, 20.0})
    for (const double room : {0.5, 0.3 + 1e-6, 0.1}) {
      const PartDistance ceiling(plane_at({0, 0, length + room}, z));
      const ToolSolid tool(ball(4, length), {0.3});
      EXPECT_NEAR(tool.clearance(ceiling, {{0, 0, 0}, z}, ToolPart::kCutter).value, room - 0.3, 1e-9)
          << length;
    }
}

}  // namespace
}  // namespace tiltfeed::sim
