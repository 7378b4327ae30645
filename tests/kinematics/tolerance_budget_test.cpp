// The tolerance's shares: their sums, and the bows of ball and shank while the axis turns, by dense sampling.

#include <gtest/gtest.h>

#include <algorithm>

#include "kinematics/basics/tolerance_budget.h"
#include "kinematics/basics/tool_path.h"
#include "pathgen/options/axis_step.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr ToleranceBudget kWhole(1.0);
constexpr double kRounding = 1e-12;

TEST(ToleranceBudget, WhatAddsIsNoMoreThanTheTolerance) {
  const double all = kWhole.repair() + kWhole.joints();
  for (const double turning : {kWhole.turn(), kWhole.shank_turn()})  // at the ball, at the shank's end
    EXPECT_LE(all + kWhole.envelope() + kWhole.thinning() + turning, 1.0 + kRounding);
  EXPECT_LE(kWhole.joints_before_words() + kWhole.words(), kWhole.joints() + kRounding);
  EXPECT_LE(all + kWhole.chords() + kWhole.free_thinning() + kWhole.gaps() + kWhole.turn(), 1.0 + kRounding);
  EXPECT_LE(all + kWhole.flank() + kWhole.corner(), 1.0 + kRounding);
  EXPECT_LE(kWhole.joints_beside_pole() + kWhole.pole(), kWhole.joints() + kRounding);
  EXPECT_LE(kWhole.touch() + kWhole.corner(), kWhole.envelope() + kWhole.thinning());
  EXPECT_LE(kWhole.half_thinned(), kWhole.envelope() + kWhole.thinning());
}

/// The tip runs straight and the axis along its great circle; what is `up` the axis leaves its straight line.
double bow(double up, double turn) {
  const Vec3 a{0, 0, 1}, b{std::sin(turn), 0, std::cos(turn)};
  double most = 0.0;
  for (int k = 1; k < 100; ++k) {
    const Vec3 straight = a * (1.0 - k / 100.0) + b * (k / 100.0);
    most = std::max(most, up * length(slerp(a, b, k / 100.0) - straight));
  }
  return most;
}

TEST(ToleranceBudget, TheAxisTurnsNoFurtherInAMoveThanBallAndShankAllow) {
  for (const double shank : {1.6, 3.0, 8.0, 15.0, 60.0, 200.0}) {
    PlanOptions options;
    options.cutter = {3.0, 250.0, shank};
    const ToleranceBudget budget(options.tolerance);
    const double turn = largest_axis_step(options);
    const double ball = bow(options.cutter.radius(), turn) / budget.turn();
    const double end = bow(shank, turn) / budget.shank_turn();
    EXPECT_LE(ball, 1.001) << shank;
    EXPECT_LE(end, 1.001) << shank;
    EXPECT_GE(std::max(ball, end), 0.99) << shank;  // one of them is used up
  }
}

}  // namespace
}  // namespace tiltfeed
