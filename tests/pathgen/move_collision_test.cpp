// The tool along a move past the corner of a facet, against how deep the corner comes into it at many poses.

#include "pathgen/tool/move_collision.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "kinematics/basics/tolerance_budget.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr int kMoves = 4000, kPoses = 400;
constexpr double kTolerance = 0.035;

/// A shank that is wider than the ball below it.
PlanOptions stepped() {
  PlanOptions options;
  options.cutter.diameter = 1.4;
  options.cutter.cutting_length = 2.8;
  options.cutter.shank_diameter = 3.7;
  options.cutter.shank_length = 6.0;
  options.cutter.length = 60.0;
  options.shank.reaction = Reaction::kTrim;
  options.tolerance = kTolerance;
  return options;
}

/// How deep a place is in the shank: the shorter way out, by the side or by the lower end.
double depth_in_shank(Point<Part> place, const Pose& pose, const Cutter& cutter) {
  const Vec3 d = place - pose.tip;
  const double height = dot(d, pose.axis), aside = length(d - pose.axis * height);
  return std::min(cutter.shank_radius() - aside, height - cutter.cutting_length);
}

// (O5) A corner comes in at the side of the shank's lower end and leaves through the bottom, all between two
// poses that are asked.
TEST(MoveCollision, NoCornerComesThroughASharpLowerEnd) {
  const PlanOptions options = stepped();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const auto vector = [&](double size) { return Vec3{any(random), any(random), any(random)} * size; };
  int clear = 0, near = 0;
  double worst = 0.0;
  for (int i = 0; i < kMoves; ++i) {
    // The corner of a needle that comes from outside, near the rim of the lower end half way along the move.
    const Vec3 axis = normalized(Vec3{0.0, 0.0, 1.0} + vector(0.2));
    const Vec3 out = normalized(cross(axis, vector(1.0) + Vec3{0.01, 0.0, 0.0}));
    const Point<Part> tip = Point<Part>{} + vector(1.0);
    const Point<Part> corner = tip + axis * (2.8 + 0.06 * any(random)) + out * (1.85 + 0.06 * any(random));
    const Vec3 away = out * 0.5 - axis * 0.05;
    Mesh mesh;
    mesh.vertices = {corner, corner + away + cross(axis, out) * 0.01,
                     corner + away - cross(axis, out) * 0.01};
    const Point<Part> below = tip - axis * 1.0;  // the part is as long as the tool is off its lower end
    for (const Vec3 at : {Vec3{}, Vec3{0.1, 0.0, 0.0}, Vec3{0.0, 0.1, 0.0}})
      mesh.vertices.push_back(below + at);
    mesh.facets = {{0, 1, 2}, {3, 4, 5}};
    const Vec3 half = out * (0.1 * any(random)) + axis * (0.1 * any(random));
    const Pose from{tip - half, axis}, to{tip + half, normalized(axis + vector(0.01))};
    double deepest = 0.0;
    for (int k = 0; k <= kPoses; ++k) {
      const double f = static_cast<double>(k) / kPoses;
      deepest = std::max(
          deepest,
          depth_in_shank(corner, {lerp(from.tip, to.tip, f), slerp(from.axis, to.axis, f)}, options.cutter));
    }
    near += deepest > 0.0;
    if (!MoveCollision(mesh, options).clear(from, to)) continue;
    ++clear;
    worst = std::max(worst, deepest);
    ASSERT_LE(deepest, ToleranceBudget(kTolerance).corner()) << "move " << i;
  }
  std::printf("%d of %d moves are clear, %d come in; the deepest of the clear ones %.4f mm\n", clear, kMoves,
              near, worst);
  EXPECT_GT(clear, kMoves / 20);
  EXPECT_GT(near, kMoves / 4);
}

}  // namespace
}  // namespace tiltfeed
