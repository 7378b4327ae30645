// Material on lines, by solids whose places and volumes are known.

#include "pathgen/stock/stock_lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "kinematics/basics/units.h"
#include "pathgen/options/fixtures.h"
#include "pathgen/tool/blank_solid.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

LinePlace at(Point<Part> p, int along) { return line_place(from_origin(p), along); }

TEST(StockLines, HoldWhatIsInside) {
  const Vec3 axis = normalized(Vec3{1, 2, -1});
  const Point<Part> base{1, -2, 3};
  const BlankSolid bar = BlankSolid::bar(base, axis, 6.0, 15.0);
  // A block with another in its hollow: lines with two pieces, and lines that pass corners and edges.
  Mesh nested = joined(BlankSolid::box({{0, 0, 0}, {16, 16, 16}}).mesh(),
                       BlankSolid::box({{6.25, 6.25, 6.25}, {10.25, 10.25, 10.25}}).mesh());
  Mesh hollow = BlankSolid::box({{2.25, 2.25, 2.25}, {14.25, 14.25, 14.25}}).mesh();
  for (auto& facet : hollow.facets) std::swap(facet[0], facet[1]);
  nested = joined(nested, hollow);
  const auto within = [](Point<Part> p, double low, double high) {
    return std::min({p.x - low, p.y - low, p.z - low, high - p.x, high - p.y, high - p.z});
  };
  std::mt19937 random(9);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int along = 0; along < 3; ++along) {
    SCOPED_TRACE(along);
    constexpr double kApart = 0.5;
    const StockLines bars(bar.mesh(), along, kApart), nests(nested, along, kApart);
    EXPECT_NEAR(nests.volume(), 16.0 * 16 * 16 - 12.0 * 12 * 12 + 4.0 * 4 * 4, 1e-6);
    EXPECT_NEAR(bars.volume(), kPi * 36.0 * 15.0, 30.0);
    std::size_t in = 0;
    for (int i = 0; i < 3000; ++i) {
      const Point<Part> p{draw(-12, 18), draw(-12, 18), draw(-12, 18)};
      const Vec3 w = p - base;
      const double h = dot(w, axis), deep = std::min({h, 15.0 - h, 6.0 - length(w - axis * h)});
      if (std::abs(deep) > kApart) {  // the line next to it may be half of their distance away
        EXPECT_EQ(bars.holds(at(p, along)), deep > 0.0);
      }
      const double outer = within(p, 0, 16), inner = within(p, 2.25, 14.25), core = within(p, 6.25, 10.25);
      if (std::min({std::abs(outer), std::abs(inner), std::abs(core)}) > kApart) {
        EXPECT_EQ(nests.holds(at(p, along)), (outer > 0.0 && inner < 0.0) || core > 0.0);
      }
      in += deep > 0.0;
    }
    EXPECT_GT(in, 50u);
  }
}

/// All rows.
void cut(StockLines& lines, const RoundSolid& solid, const Pose& pose) {
  const PlacedSolid placed(solid, pose, lines.along());
  for (std::size_t row = 0; row < lines.rows(); ++row)
    if (lines.in_row(row, placed)) lines.cut(row, placed);
}

double deepest(const StockLines& lines, const RoundSolid& solid, const Pose& pose) {
  const PlacedSolid placed(solid, pose, lines.along());
  double most = 0.0;
  for (std::size_t row = 0; row < lines.rows(); ++row)
    if (lines.in_row(row, placed)) most = std::max(most, lines.deepest(row, placed));
  return most;
}

TEST(StockLines, WhatASolidTakesIsItsVolume) {
  Cutter ball;
  ball.diameter = 10.0, ball.cutting_length = ball.shank_length = 14.0, ball.length = 60.0;
  const RoundSolid solid = round_solids(ball).front();
  const Mesh block = BlankSolid::box({{-20, -20, -20}, {20, 20, 20}}).mesh();
  const double capsule = kPi * 25.0 * 9.0 + 2.0 / 3.0 * kPi * 125.0;
  for (const Vec3 axis :
       {Vec3{0, 0, 1}, Vec3{1, 0, 0}, normalized(Vec3{1, -2, 3}), normalized(Vec3{-3, 1, -1})})
    for (int along = 0; along < 3; ++along) {
      StockLines lines(block, along, 0.2);
      cut(lines, solid, {{1.03, -2.01, 0.49}, axis});
      EXPECT_NEAR(lines.volume(), 40.0 * 40 * 40 - capsule, 8.0) << along;
      const double once = lines.volume();
      cut(lines, solid, {{1.03, -2.01, 0.49}, axis});
      EXPECT_EQ(lines.volume(), once);
      // Pieces below and above it are there, the middle is not.
      const Point<Part> middle = Point<Part>{1.03, -2.01, 0.49} + axis * 7.0;
      EXPECT_FALSE(lines.holds(at(middle, along)));
      EXPECT_TRUE(lines.holds(at(middle + axis * 8.0, along)));
      EXPECT_TRUE(lines.holds(at(middle - axis * 8.0, along)));
      // And lines that are cut again and again.
      for (int i = 0; i < 60; ++i)
        cut(lines, solid, {{-15.0 + 0.5 * i, 12.0 - 0.4 * i, -15.0 + 0.5 * i}, axis});
      EXPECT_LT(lines.volume(), once - 500.0);
      EXPECT_FALSE(lines.holds(at(Point<Part>{-5, 4, -5} + axis * 5.0, along)));
    }
}

TEST(StockLines, APieceThatIsGoneLeavesTheOthers) {
  Cutter flat;
  flat.type = CutterType::kFlat, flat.diameter = 8.0, flat.cutting_length = flat.shank_length = 60.0;
  const RoundSolid solid = round_solids(flat).front();
  StockLines lines(BlankSolid::box({{-20, -3, 0}, {20, 3, 30}}).mesh(), 2, 0.5);
  // Lying along x: bores through the middle, then all below, all between, and all.
  const auto bore = [&](double z) { cut(lines, solid, {{-30, 0, z}, {1, 0, 0}}); };
  const auto holds = [&](double z) { return lines.holds({0.0, 0.0, z}); };
  bore(12), bore(22);
  EXPECT_TRUE(holds(4) && !holds(12) && holds(17) && !holds(22) && holds(28));
  bore(2), bore(6);
  EXPECT_TRUE(!holds(1) && !holds(4) && !holds(8) && holds(17) && holds(28));
  bore(17);
  EXPECT_TRUE(!holds(15) && !holds(17) && !holds(19) && holds(28));
  bore(27), bore(29);
  EXPECT_FALSE(holds(28));
  bore(15);
  EXPECT_NEAR(lines.volume(), 0.0, 40.0 * 6.0 * 1.5);
}

/// Material is told up to a line's distance early, and never too late.
TEST(StockLines, WhatStandsAboutAPlaceIsTold) {
  Cutter ball;
  ball.diameter = 10.0, ball.cutting_length = ball.shank_length = 60.0;
  const RoundSolid solid = round_solids(ball).front();
  std::mt19937 random(4);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int along = 0; along < 3; ++along) {
    StockLines lines(BlankSolid::box({{-20, -20, -20}, {20, 20, 20}}).mesh(), along, 0.5);
    cut(lines, solid, {{1, 2, -3}, {0, 0, 1}});
    std::size_t clear = 0;
    for (int i = 0; i < 4000; ++i) {
      const Point<Part> p{draw(-19, 19), draw(-19, 19), draw(-19, 19)};
      const double off = distance_to_segment(p, {1, 2, 2}, {1, 2, 90}) - 5.0;
      if (off > 0.0) {
        EXPECT_TRUE(lines.stands_about(at(p, along)));
      } else if (off < -0.5 * std::sqrt(3.0) - 0.3) {
        EXPECT_FALSE(lines.stands_about(at(p, along)));
        ++clear;
      }
    }
    EXPECT_GT(clear, 50u);
    // Beyond the stock the nearest place counts.
    EXPECT_TRUE(lines.stands_about(at({-30, 10, 5}, along)) && lines.stands_about(at({10, 10, 25}, along)) &&
                lines.stands_about(at({25, -25, -25}, along)));
    EXPECT_FALSE(lines.stands_about(at({1, 2, 25}, along)));
  }
}

TEST(StockLines, ASolidIsAsDeepInThemAsItComes) {
  Cutter tool;
  tool.diameter = 4.0, tool.cutting_length = 5.0, tool.shank_length = 12.0, tool.shank_diameter = 4.0,
  tool.length = 60.0, tool.holder = {{20.0, 20.0, 30.0}};
  const std::vector<RoundSolid> solids = round_solids(tool);
  for (int along = 0; along < 3; ++along) {
    StockLines lines(BlankSolid::box({{-30, -30, -30}, {30, 30, 0}}).mesh(), along, 0.4);
    Cutter bore;
    bore.type = CutterType::kFlat, bore.diameter = 8.0, bore.cutting_length = bore.shank_length = 90.0;
    cut(lines, round_solids(bore).front(), {{0.1, 0.2, -40}, {0, 0, 1}});
    for (const double down : {-1.0, 0.5, 2.5, 7.0}) {  // the holder's lower end under the block's top
      const Pose upright{{0.1, 0.2, -12.0 - down}, {0, 0, 1}};
      EXPECT_NEAR(deepest(lines, solids[2], upright), std::clamp(down, 0.0, 6.0), 0.2) << along;
    }
    // No deeper than from the bore's wall to its own side.
    EXPECT_NEAR(deepest(lines, solids[2], {{0, 0, -42.0}, {0, 0, 1}}), 6.0, 0.4);
    // Lying on the block: by its side. The uppermost lines are half of their distance under the top.
    EXPECT_NEAR(deepest(lines, solids[2], {{-20, 0, 8.5}, {1, 0, 0}}), 1.5, along == 2 ? 0.01 : 0.21)
        << along;
    EXPECT_EQ(deepest(lines, solids[2], {{-20, 0, 10.1}, {1, 0, 0}}), 0.0);
  }
}

}  // namespace
}  // namespace tiltfeed
