// Shank and holder in stock that is left: depths and places that follow from the drawing.

#include "pathgen/stock/stock_on_cuts.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "kinematics/basics/units.h"
#include "pathgen/tool/blank_solid.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kFlutes = 8.0, kReach = 30.0;

Cutter cutter_of(double diameter, double shank, double holder = 0.0) {
  Cutter c;
  c.type = CutterType::kFlat, c.diameter = diameter, c.cutting_length = kFlutes, c.shank_length = kReach,
  c.shank_diameter = shank, c.length = 80.0;
  if (holder > 0.0) c.holder = {{holder, holder, 20.0}};
  return c;
}

/// A frame in which the block lies: the turned scene has the same contacts.
struct Scene {
  Vec3 x, y, z;
  Point<Part> place(double a, double b, double c) const { return Point<Part>{} + x * a + y * b + z * c; }
  Mesh block() const {
    Mesh mesh = BlankSolid::box({{-30, -20, -40}, {30, 20, 0}}).mesh();
    for (Point<Part>& v : mesh.vertices) v = place(v.x, v.y, v.z);
    return mesh;
  }
};

/// Straight grooves along x at these y, one after the other, each `deep` in layers of 2 mm.
std::vector<Move> grooves(const Scene& scene, const std::vector<double>& at, double deep, double from = -20.0,
                          double to = 20.0) {
  std::vector<Move> moves{{{scene.place(from, at.front(), 20), scene.z}, MoveKind::kRapid}};
  for (const double y : at)
    for (double z = 2.0; z <= deep + 1e-9; z += 2.0) {
      moves.push_back({{scene.place(from, y, 20), scene.z}, MoveKind::kRapid});
      moves.push_back({{scene.place(from, y, -z), scene.z}, MoveKind::kPlunge});
      moves.push_back({{scene.place(to, y, -z), scene.z}, MoveKind::kCut});
      moves.push_back({{scene.place(to, y, 20), scene.z}, MoveKind::kRapid});
    }
  return moves;
}

std::vector<StockOnCuts> run(const Mesh& blank, const std::vector<ToolMoves>& operations) {
  StockLeft left(blank, operations);
  std::vector<StockOnCuts> found;
  for (const ToolMoves& one : operations) found.push_back(*left.cut(one, {}));
  return found;
}

const std::array<Scene, 3> kScenes{Scene{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                   Scene{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}},
                                   Scene{{0.8, 0, 0.6}, {0, 1, 0}, {-0.6, 0, 0.8}}};

TEST(StockOnCuts, AWiderShankIsInTheWallsByWhatItIsWider) {
  for (const Scene& scene : kScenes) {
    const Cutter wide = cutter_of(10.0, 13.0), same = cutter_of(10.0, 10.0), narrow = cutter_of(10.0, 7.0);
    for (const double deep : {6.0, 14.0}) {
      const auto moves = grooves(scene, {-10.0, 10.0}, deep);
      const StockContact in = run(scene.block(), {{&wide, &moves, 0.01}}).front().shank;
      EXPECT_NEAR(in.depth, deep > kFlutes ? 1.5 : 0.0, 0.25);
      // In each groove the layers below the flutes.
      EXPECT_EQ(in.places, deep > kFlutes ? 6u : 0u);
      if (deep > kFlutes) {
        EXPECT_NEAR(in.length, 6.0 * 40.0, 40.0);
        EXPECT_LT(dot(in.at.tip - scene.place(0, 0, 0), scene.z), -kFlutes);
      }
      for (const Cutter* none : {&same, &narrow})
        EXPECT_EQ(run(scene.block(), {{none, &moves, 0.01}}).front().shank.places, 0u);
    }
  }
}

TEST(StockOnCuts, AHolderIsAsDeepAsItIsLowerThanTheTop) {
  for (const Scene& scene : kScenes) {
    const Cutter tool = cutter_of(10.0, 8.0, 30.0);
    const auto moves = grooves(scene, {0.0}, 34.0), shallow = grooves(scene, {0.0}, 30.0);
    const auto found = run(scene.block(), {{&tool, &moves, 0.01}}).front();
    EXPECT_NEAR(found.holder.depth, 4.0, 0.05);
    EXPECT_EQ(found.holder.places, 2u);  // the last two layers
    EXPECT_EQ(found.shank.places, 0u);
    EXPECT_EQ(run(scene.block(), {{&tool, &shallow, 0.01}}).front().holder.places, 0u);
    // From where a cut begins, too.
    const std::vector<Move> up{{{scene.place(0, 0, -34), scene.z}, MoveKind::kRapid},
                               {{scene.place(0, 0, 20), scene.z}, MoveKind::kCut}};
    Cutter drill = cutter_of(10.0, 10.0);
    drill.cutting_length = drill.shank_length = 60.0;
    const auto hole = grooves(scene, {0.0}, 36.0, 0.0, 0.0);
    EXPECT_NEAR(run(scene.block(), {{&drill, &hole, 0.01}, {&tool, &up, 0.01}}).back().holder.depth, 4.0,
                0.05);
  }
}

/// A later tool makes the lines stand near to each other; the first begins its layers at other places.
TEST(StockOnCuts, AShankAsWideAsTheCutterMeetsNoRidges) {
  const Scene& scene = kScenes.front();
  const Cutter large = cutter_of(20.0, 20.0), small = cutter_of(2.0, 4.0);
  std::vector<Move> moves;
  for (int layer = 1; layer <= 8; ++layer) {
    const auto one = grooves(scene, {0.0}, 2.0, -20.0 + 0.7 * layer, 20.0 - 0.4 * layer);
    for (Move move : one) {
      if (move.pose.tip.z < 0.0) move.pose.tip.z = -2.0 * layer;
      moves.push_back(move);
    }
  }
  // The layers end nearer to each other; the walls there are those of the widest.
  const auto last = grooves(scene, {15.0}, 2.0);
  EXPECT_EQ(run(scene.block(), {{&large, &moves, 0.01}, {&small, &last, 0.01}}).front().shank.places, 0u);
}

TEST(StockOnCuts, WhatOperationsBeforeHaveClearedIsClear) {
  const Scene& scene = kScenes.front();
  const Cutter large = cutter_of(20.0, 16.0), slim = cutter_of(10.0, 13.0);
  const auto first = grooves(scene, {-10.0}, 14.0, -30.0, 30.0), second = grooves(scene, {-10.0, 10.0}, 14.0);
  const auto found = run(scene.block(), {{&large, &first, 0.01}, {&slim, &second, 0.01}});
  EXPECT_EQ(found[0].shank.places, 0u);
  EXPECT_EQ(found[1].shank.places, 3u);  // of the groove where nobody was
  EXPECT_NEAR(found[1].shank.at.tip.y, 10.0, 1e-9);
  // A rapid clears nothing.
  std::vector<Move> none = first;
  for (Move& move : none) move.kind = MoveKind::kRapid;
  EXPECT_EQ(run(scene.block(), {{&large, &none, 0.01}, {&slim, &second, 0.01}})[1].shank.places, 6u);
}

TEST(StockOnCuts, WhatAShankWentThroughIsToldOnce) {
  const Scene& scene = kScenes.front();
  const Cutter wide = cutter_of(10.0, 13.0);
  const auto moves = grooves(scene, {0.0}, 14.0);
  const auto found = run(scene.block(), {{&wide, &moves, 0.01}, {&wide, &moves, 0.01}});
  EXPECT_EQ(found[0].shank.places, 3u);
  EXPECT_EQ(found[1].shank.places, 0u);
}

/// Along the block's side, leaning over it: by places of the shank that are in the block.
TEST(StockOnCuts, ALeanedToolIsInTheBlockBesideItsCut) {
  const Scene& scene = kScenes.front();
  Cutter tool = cutter_of(6.0, 6.0);
  tool.type = CutterType::kBall;
  // Along the block's side, 1 mm under its top edge, the axis leaning out over the block by `lean`.
  for (const double lean : {0.3, 0.6, 0.9}) {
    const Vec3 axis{0.0, -std::sin(lean), std::cos(lean)};
    const Point<Part> tip = Point<Part>{0, 20, -6} - axis * 3.0;  // the ball's centre is on the side
    const std::vector<Move> moves{{{tip + Vec3{-60, 0, 0}, axis}, MoveKind::kRapid},
                                  {{tip + Vec3{-25, 0, 0}, axis}, MoveKind::kCut},
                                  {{tip + Vec3{25, 0, 0}, axis}, MoveKind::kCut}};
    const StockContact found = run(scene.block(), {{&tool, &moves, 0.01}}).front().shank;
    // The shank's lower end is kFlutes - 3 over the ball's centre along the axis: there and above it the
    // part of it under the top is in the block.
    double deep = 0.0;
    for (double h = kFlutes - 3.0; h < kReach - 3.0; h += 0.05)
      for (int k = 0; k < 90; ++k)
        for (double r = 0.0; r < 2.6; r += 0.05) {  // less deep than 0.4 mm is not told
          const double turn = 2.0 * kPi * k / 90;
          const Vec3 u{1, 0, 0}, v = cross(axis, u);
          const Point<Part> p =
              Point<Part>{0, 20, -6} + axis * h + u * (r * std::cos(turn)) + v * (r * std::sin(turn));
          if (p.z < 0.0 && p.y < 20.0) deep = std::max(deep, 3.0 - r);
        }
    if (deep == 0.0) {
      EXPECT_EQ(found.places, 0u) << lean;
    } else {
      EXPECT_NEAR(found.depth, deep, 0.3) << lean;
      EXPECT_EQ(found.places, 1u) << lean;
    }
  }
}

TEST(StockOnCuts, ItCanBeStopped) {
  const Cutter tool = cutter_of(10.0, 13.0);
  const auto moves = grooves(kScenes.front(), {0.0}, 14.0);
  StockLeft left(kScenes.front().block(), {{&tool, &moves, 0.01}});
  EXPECT_FALSE(left.cut({&tool, &moves, 0.01}, [](double) { return false; }));
}

}  // namespace
}  // namespace tiltfeed
