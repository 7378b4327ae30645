// How far a tool comes down along its axis before it touches: against closed forms (planes, edges, corners),
// the first touch of a ball, and the clearance on the way.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/shapes/whole_tool.h"

namespace tiltfeed::sim {
using namespace pathgen;
namespace {

constexpr double kDegree = kPi / 180.0;

TEST(ToolSolid, BallDropsAsInClosedForm) {
  std::mt19937_64 random(13);
  const Revolved solid({{0, 2, 2, kPi / 2}, {2, 9, 0, kPi}});
  std::uniform_real_distribution<double> place(-10, 10);
  int touched = 0;
  for (int i = 0; i < 600; ++i) {
    const PartDistance part(mesh_of(random_soup(random, i % 4 == 0 ? 40 : 3, 10, 4)));
    const Vec3 axis = random_axis(random);
    const Point<Part> target{0.3 * place(random), 0.3 * place(random), 0.3 * place(random)};
    const Pose pose{target + axis * 30.0, axis};
    const Hit expected = part.first_touch(pose.tip + axis * 2.0, -axis, 2.0), hit = drop(part, solid, pose);
    ASSERT_EQ(hit.facet == kNoFacet, expected.facet == kNoFacet) << i;
    if (hit.facet == kNoFacet) continue;
    ++touched;
    ASSERT_NEAR(hit.value, expected.value, 1e-6) << i;
  }
  EXPECT_GT(touched, 150);
}

TEST(ToolSolid, DroppedToolJustTouches) {
  // Lowered by the drop it touches; half way and a little above it does not.
  std::mt19937_64 random(15);
  std::uniform_real_distribution<double> place(-3, 3);
  int touched = 0;
  for (int i = 0; i < 400; ++i) {
    const ToolSolid tool(full(kTypes[i % 4]));
    const PartDistance part(mesh_of(random_soup(random, 6, 6, 4)));
    const Vec3 axis = random_axis(random);
    const Pose pose{Point<Part>{place(random), place(random), place(random)} + axis * 40.0, axis};
    const Hit hit = drop(part, tool.cutting(), pose);
    const auto at = [&](double s) {
      return clearance(part, tool.cutting(), {pose.tip - axis * s, axis}).value;
    };
    if (hit.facet == kNoFacet) {
      for (double s = 0.0; s < 80.0; s += 2.5) ASSERT_GT(at(s), -1e-9) << i;
      continue;
    }
    ++touched;
    ASSERT_NEAR(at(hit.value), 0.0, 1e-6) << i;
    ASSERT_LE(at(hit.value + 1e-3), 0.0) << i;
    for (double f = 0.05; f < 1.0; f += 0.05) ASSERT_GT(at(f * hit.value), 0.0) << i;
    ASSERT_NEAR(drop(part, tool.cutting(), {pose.tip - axis * 5.0, axis}).value, hit.value - 5.0, 1e-8);
    EXPECT_EQ(drop(part, tool.cutting(), pose, hit.value - 1e-6).facet, kNoFacet);
    EXPECT_EQ(drop(part, tool.cutting(), pose, kInfinity, kNoFacet, hit.value - 1e-6).value, hit.value);
    EXPECT_LE(drop(part, tool.cutting(), pose, kInfinity, kNoFacet, hit.value + 2.0).value, hit.value + 2.0);
  }
  EXPECT_GT(touched, 150);
}

TEST(ToolSolid, DropsOntoATiltedPlane) {
  // The height of the tip over a plane tilted by theta, where the tool touches it, in closed form.
  for (const double degrees : {0.0, 0.001, 5.0, 30.0, 60.0, 82.5, 88.0}) {
    const double theta = degrees * kDegree, s = std::sin(theta), c = std::cos(theta);
    const Vec3 normal{s, 0, c};
    const PartDistance plane(plane_at({0, 0, 0}, normal));
    const Pose pose{{0, 0, 400}, {0, 0, 1}};
    const double r = 3.0, k = 1.25;
    const auto height = [&](CutterType type) {
      return 400.0 - ToolSolid(full(type)).drop(plane, pose).value;
    };
    EXPECT_NEAR(height(CutterType::kFlat), r * s / c, 1e-6);
    EXPECT_NEAR(height(CutterType::kBullNose), ((r - k) * s + k) / c - k, 1e-6);
    EXPECT_NEAR(height(CutterType::kBall), r / c - r, 1e-6);
    const double t = 7.0 * kDegree, top = full(CutterType::kTaperBall).cutting_length;
    const double top_r = radius_of(full(CutterType::kTaperBall), top - 1e-12);
    // Steeper than the cone it stands on the cone's upper rim.
    EXPECT_NEAR(height(CutterType::kTaperBall), degrees > 83.0 ? top_r * s / c - top : r / c - r, 1e-5) << t;
  }
}

TEST(ToolSolid, DropsOntoEdgesAndCorners) {
  const Cutter bull = full(CutterType::kBullNose), flat = full(CutterType::kFlat),
               taper = full(CutterType::kTaperBall);
  const Vec3 z{0, 0, 1};
  // A level edge at distance 2.6: on the rounding of the bull-nose, on the face of the flat end.
  const PartDistance ridge(
      mesh_of({{Point<Part>{2.6, -50, 1}, Point<Part>{2.6, 50, 1}, Point<Part>{50, 0, -80}}}));
  EXPECT_NEAR(ToolSolid(flat).drop(ridge, {{0, 0, 20}, z}).value, 19.0, 1e-9);
  EXPECT_NEAR(ToolSolid(bull).drop(ridge, {{0, 0, 20}, z}).value,
              19.0 + (1.25 - std::sqrt(1.25 * 1.25 - 0.85 * 0.85)), 1e-7);
  // An edge rising by 45 degrees past the axis at distance 2: it meets the flat end's rim.
  const PartDistance slope(
      mesh_of({{Point<Part>{2, -50, -50}, Point<Part>{2, 50, 50}, Point<Part>{60, 0, -300}}}));
  EXPECT_NEAR(ToolSolid(flat).drop(slope, {{0, 0, 20}, z}).value, 20.0 - std::sqrt(5.0), 1e-7);
  // A needle's point on the cone.
  const PartDistance needle(
      mesh_of({{Point<Part>{3.4, 0, 0}, Point<Part>{3.5, 0, -90}, Point<Part>{3.4, 0.1, -90}}}));
  const double t = 7.0 * kDegree;
  EXPECT_NEAR(ToolSolid(taper).drop(needle, {{0, 0, 20}, z}).value,
              20.0 + 3.4 / std::tan(t) + 3.0 - 3.0 / std::sin(t), 1e-7);
  EXPECT_EQ(ToolSolid(bull).drop(needle, {{0, 0, 20}, z}).facet, kNoFacet);  // passes by
  // What hangs above its widest place does not stop it.
  EXPECT_EQ(ToolSolid(flat).drop(needle, {{1, 0, -95}, z}).facet, kNoFacet);
  const PartDistance beam(mesh_of({{Point<Part>{0, 0, 20}, Point<Part>{30, 0, -5}, Point<Part>{30, 1, -5}}}));
  EXPECT_EQ(ToolSolid(flat).drop(beam, {{0, 0, 0}, z}).facet, kNoFacet);
  EXPECT_NEAR(ToolSolid(flat).drop(beam, {{0, 0, 30}, z}).value, 10.0, 1e-9);
}

}  // namespace
}  // namespace tiltfeed::sim
