// sim/path_walk: poses near a path are followed in its order, where it turns back on itself and where it
// turns on the spot.

#include "sim/path_check/path_matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace tiltfeed::sim {
namespace {

TEST(PathMatching, PathsThatTurnBackOnThemselvesAreFollowed) {
  // Down and up the same line, to and fro in sharp folds, with deviations of up to 3 micrometres.
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> noise(-0.003, 0.003);
  ToolPath path;
  const Vec3 up{0, 0, 1};
  path.moves.push_back({{{0, 0, 10}, up}});
  for (int i = 0; i < 40; ++i) {
    path.moves.push_back({{{0.2 * i, 0, 0}, up}, MoveKind::kPlunge});
    path.moves.push_back({{{0.2 * i, 0, 0.5}, up}, MoveKind::kCut});
    path.moves.push_back({{{0.2 * i, 0, 0}, up}, MoveKind::kCut});
    path.moves.push_back({{{0.2 * i + 0.05, 0, 8}, up}, MoveKind::kCut});
  }
  PathMatching walk(path);
  double worst = 0.0;
  std::uint32_t last = 0;
  for (std::size_t m = 0; m < path.moves.size(); ++m) {
    const int steps = m == 0 ? 1 : 37;
    for (int i = 1; i <= steps; ++i) {
      Point<Part> tip =
          lerp(path.moves[m == 0 ? 0 : m - 1].pose.tip, path.moves[m].pose.tip, 1.0 * i / steps);
      tip = tip + Vec3{noise(random), noise(random), noise(random)};
      const PathPlace place = walk.step({tip, up});
      worst = std::max(worst, place.distance);
      EXPECT_GE(place.move, last);
      EXPECT_LE(place.move, m + 1) << "step " << i;
      EXPECT_GE(place.move + 1, m) << "step " << i;
      last = place.move;
    }
  }
  EXPECT_LT(worst, 0.0053);  // the noise's diagonal
  for (std::size_t m = 0; m < path.moves.size(); ++m) EXPECT_LT(walk.visited()[m], 0.0053) << "move " << m;
}

TEST(PathMatching, TurnsOnTheSpotAreTimedByTheirAxis) {
  ToolPath path;
  const Vec3 a{0, 0, 1}, b = normalized({0.1, 0, 1});
  path.moves = {{{{0, 0, 0}, a}}, {{{0, 0, 0}, b}, MoveKind::kCut}, {{{5, 0, 0}, b}, MoveKind::kCut}};
  PathMatching walk(path);
  walk.step({{0, 0, 0}, a});
  for (int i = 1; i <= 10; ++i) {
    const PathPlace place = walk.step({{0, 0, 0}, slerp(a, b, 0.1 * i)});
    EXPECT_LT(place.angle, 1e-5);
    EXPECT_EQ(place.distance, 0.0);
  }
  EXPECT_NEAR(walk.step({{2.5, 0, 0}, a}).angle, angle_between(a, b), 1e-9);
}

}  // namespace
}  // namespace tiltfeed::sim
