// Lines through the tool, by places on them that a distance says to be in it.

#include "pathgen/stock/round_solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "kinematics/basics/units.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

class Draw {
 public:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Pose pose() {
    const Vec3 axis{between(-1, 1), between(-1, 1), between(-1, 1)};
    return {{between(-5, 5), between(-5, 5), between(-5, 5)}, normalized(axis)};
  }

 private:
  std::mt19937 random_{5};
};

/// How far a place of the tool (from the axis, over the tip) is in its cutting part; below 0 outside. Not a
/// distance, but of its sign.
double in_cutter(const Cutter& c, double r, double h) {
  const double end = c.cutting_end(), edge = c.nose_radius(), flat = c.radius() - edge;
  if (h > end || h < 0.0) return -1.0;
  double widest = c.radius();
  if (c.type == CutterType::kTaperBall) {
    const double w = c.taper.radians(), from = edge - edge * std::sin(w);
    if (h >= from) return edge * std::cos(w) + (h - from) * std::tan(w) - r;
  }
  if (h < edge) widest = flat + std::sqrt(edge * edge - (edge - h) * (edge - h));
  return widest - r;
}

std::vector<Cutter> cutters() {
  Cutter ball, bull, flat, taper;
  ball.type = CutterType::kBall, bull.type = CutterType::kBullNose, flat.type = CutterType::kFlat,
  taper.type = CutterType::kTaperBall;
  bull.corner_radius = 1.0, taper.taper = Angle::from_degrees(7.0);
  std::vector<Cutter> all{ball, bull, flat, taper};
  for (Cutter& c : all) {
    c.diameter = 6.0, c.cutting_length = 9.0, c.shank_length = 20.0, c.length = 60.0;
    c.shank_diameter = c.type == CutterType::kTaperBall ? 0.0 : 8.0;
    c.holder = {{12.0, 20.0, 10.0}, {30.0, 14.0, 6.0}, {14.0, 14.0, 4.0}};
  }
  return all;
}

/// The solids of a tool: how far a place is in each, by its sign.
double in_solid(const Cutter& c, std::size_t solid, double r, double h) {
  if (solid == 0) return in_cutter(c, r, h);
  if (solid == 1) return h < 9.0 || h > 20.0 ? -1.0 : c.shank_radius() - r;
  double from = 20.0;
  for (std::size_t i = 0; i + 2 < solid; ++i) from += c.holder[i].length;
  const HolderStep& step = c.holder[solid - 2];
  const double share = (h - from) / step.length;
  if (share < 0.0 || share > 1.0) return -1.0;
  return 0.5 * (step.lower_diameter + share * (step.upper_diameter - step.lower_diameter)) - r;
}

TEST(RoundSolid, ALineIsInItWhereItsPlacesAre) {
  Draw draw;
  std::size_t met = 0;
  for (const Cutter& cutter : cutters()) {
    const std::vector<RoundSolid> solids = round_solids(cutter);
    ASSERT_EQ(solids.size(), 5u);
    for (int i = 0; i < 600; ++i) {
      Pose pose = draw.pose();
      // Along the lines, and across them, too.
      if (i % 10 == 0) pose.axis = {0, 0, i % 20 == 0 ? 1.0 : -1.0};
      const int along = i % 3;
      for (std::size_t k = 0; k < solids.size(); ++k) {
        const PlacedSolid placed(solids[k], pose, along);
        // Through a place near the tool's axis.
        const Point<Part> near = pose.tip + pose.axis * draw.between(solids[k].lowest(), solids[k].highest());
        const LinePlace from = line_place(from_origin(near), along);
        const double u = from.u + draw.between(-6, 6), v = from.v + draw.between(-6, 6);
        const auto found = placed.on_line(u, v);
        double low = 1e9, high = -1e9, best = -1e9;
        constexpr double kStep = 0.01;
        for (double t = from.t - 40.0; t <= from.t + 40.0; t += kStep) {
          const Vec3 p = along == 0 ? Vec3{t, u, v} : along == 1 ? Vec3{v, t, u} : Vec3{u, v, t};
          const Vec3 w = p - from_origin(pose.tip);
          const double h = dot(w, pose.axis), r = std::sqrt(std::max(0.0, dot(w, w) - h * h));
          const double in = in_solid(cutter, k, r, h);
          if (in >= 0.0) low = std::min(low, t), high = std::max(high, t);
          best = std::max(best, in);
          // A rounded edge is a polygon within it.
          const double missing = k == 0 && cutter.type == CutterType::kBullNose ? 0.01 : 1e-9;
          if (in > missing) {
            ASSERT_TRUE(found);
          }
        }
        if (!found) continue;
        ++met;
        const LinePlace &least = placed.low(), &most = placed.high();
        EXPECT_LE(std::max({least.u - u, u - most.u, least.v - v, v - most.v}), 1e-9);
        EXPECT_LE(std::max(least.t - found->low, found->high - most.t), 1e-9);
        const double slack = k == 0 && cutter.type == CutterType::kBullNose ? 0.25 : 2.0 * kStep;
        if (low > high) {
          EXPECT_LT(found->high - found->low, 2.0 * kStep) << best;
          continue;
        }
        EXPECT_NEAR(found->low, low, slack) << "solid " << k << " along " << along;
        EXPECT_NEAR(found->high, high, slack) << "solid " << k << " along " << along;
        // Never beyond it.
        EXPECT_GT(found->low, low - 1.001 * kStep);
        EXPECT_LT(found->high, high + 1.001 * kStep);
      }
    }
  }
  EXPECT_GT(met, 2000u);
}

/// Of any place in shank or holder, by places all along the drawing of the tool.
TEST(RoundSolid, DepthIsTheDistanceFromTheToolsOutline) {
  Draw draw;
  Cutter cutter = cutters().front();
  cutter.holder = {{12.0, 20.0, 10.0}, {20.0, 20.0, 2.0}, {24.0, 24.0, 2.0}, {10.0, 30.0, 6.0}};
  const std::vector<std::array<double, 2>> corners{{3, 3},   {3, 9},   {4, 9},   {4, 20}, {6, 20},  {10, 30},
                                                   {10, 32}, {12, 32}, {12, 34}, {5, 34}, {15, 40}, {0, 40}};
  const std::vector<RoundSolid> solids = round_solids(cutter);
  for (int i = 0; i < 600; ++i) {
    const Pose pose = draw.pose();
    const std::size_t solid = 1 + static_cast<std::size_t>(i) % (solids.size() - 1);
    const PlacedSolid placed(solids[solid], pose, i % 3);
    const RoundSolid::Rim &lower = solids[solid].rims.front(), &upper = solids[solid].rims.back();
    const double share = draw.between(0.0, 1.0), h = lower.height + share * (upper.height - lower.height);
    const double r = draw.between(0.0, 1.0) * (lower.radius + share * (upper.radius - lower.radius));
    const Vec3 u = normalized(cross(pose.axis, Vec3{0.3, -0.5, 0.8})), v = cross(pose.axis, u);
    const double turn = draw.between(0.0, 2.0 * kPi);
    const Point<Part> p = pose.tip + pose.axis * h + u * (r * std::cos(turn)) + v * (r * std::sin(turn));
    double nearest = 1e9;
    for (std::size_t c = 1; c < corners.size(); ++c)
      for (double s = 0.0; s <= 1.0; s += 0.001)
        nearest = std::min(nearest, std::hypot(r - corners[c - 1][0] * (1.0 - s) - corners[c][0] * s,
                                               h - corners[c - 1][1] * (1.0 - s) - corners[c][1] * s));
    EXPECT_NEAR(placed.depth(line_place(from_origin(p), i % 3)), nearest, 0.01)
        << solid << ' ' << r << ' ' << h;
  }
}

TEST(RoundSolid, ABoxThatItMeetsIsNeverPassedOver) {
  Draw draw;
  std::size_t met = 0, passed = 0;
  const std::vector<RoundSolid> solids = round_solids(cutters().front());
  for (int i = 0; i < 12000; ++i) {
    const PlacedSolid placed(solids[1 + i % 4], draw.pose(), i % 3);
    const LinePlace low{draw.between(-18, 18), draw.between(-18, 18), draw.between(-18, 18)};
    const LinePlace high{low.u + draw.between(0, 6), low.v + draw.between(0, 6), low.t + draw.between(0, 20)};
    bool meets = false;
    for (int k = 0; k < 12 && !meets; ++k)
      for (int j = 0; j < 12 && !meets; ++j) {
        const auto on =
            placed.on_line(low.u + (high.u - low.u) * k / 11.0, low.v + (high.v - low.v) * j / 11.0);
        meets = on && on->low <= high.t && on->high >= low.t;
      }
    met += meets;
    if (meets) {
      EXPECT_TRUE(placed.may_meet(low, high));
    }
    passed += !placed.may_meet(low, high);
  }
  EXPECT_GT(met, 200u);
  EXPECT_GT(passed, 3000u);
}

}  // namespace
}  // namespace tiltfeed
