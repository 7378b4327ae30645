// Material removal: four cuts known in closed form.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

#include "sim/removal/swept_moves.h"
#include "sim/removal/tool_sweep.h"
#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

/// A block of stock from (-10, -10, -10) to (10, 10, 0), nothing of a part.
Stock block(double cell) { return stock_block({{-10, -10, -10}, {10, 10, 0}}, cell); }

void cut(Stock& stock, const Cutter& cutter, const Pose& from, const Pose& to) {
  const ToolSweep sweep(cutter);
  std::vector<SweptBody> bodies;
  sweep.cutter_bodies(
      from, to, [](Point<Part>) { return -1.0; }, bodies);
  for (Dexels& dexels : stock.bundles)
    for (int s = 0; s < Dexels::kStripes; ++s)
      for (const SweptBody& body : bodies) dexels.cut(s, body, false);
}

/// Largest distance of the stock's new borders from where `left` (signed: above 0 is material) is zero, and
/// of the stock's middles and gaps from being on their sides; the least number of new borders seen.
struct Compared {
  double border = 0.0;
  std::size_t borders = 0;
};
template <class Left>
Compared compare(const Stock& stock, const Left& left, double low, double high) {
  Compared result;
  for (const Dexels& dexels : stock.bundles) {
    for (int s = 0; s < Dexels::kStripes; ++s) {
      dexels.each(s, [&](Point<Part> foot, double from, double to) {
        std::array<double, 3> p{foot.x, foot.y, foot.z};
        const auto at = [&](double t) {
          p[dexels.axis()] = t;
          return left(Point<Part>{p[0], p[1], p[2]});
        };
        // No material where there must be none; every end inside of the block lies on the cut's surface.
        for (int i = 0; i <= 8; ++i)
          result.border = std::max(result.border, -at(from + (to - from) * i / 8.0));
        const double edge_low = dexels.axis() == 2 ? -10.0 : low, edge_high = dexels.axis() == 2 ? 0.0 : high;
        for (const double t : {from, to})
          if (t > edge_low + 1e-3 && t < edge_high - 1e-3)
            result.border = std::max(result.border, std::abs(at(t))), ++result.borders;
      });
    }
  }
  return result;
}

// (removal.h, property 2)
TEST(Removal, GrooveOfABallInAPlane) {
  for (const double cell : {0.5, 0.2}) {
    Stock stock = block(cell);
    cut(stock, {6, 100, 40}, {{-20, 0, -1.5}, {0, 0, 1}}, {{20, 0, -1.5}, {0, 0, 1}});
    const auto left = [](Point<Part> p) { return p.z > 1.5 ? -1.0 : std::hypot(p.y, p.z - 1.5) - 3.0; };
    const Compared c = compare(stock, left, -10, 10);
    EXPECT_LE(c.border, 2 * Dexels::kUnit) << cell;
    EXPECT_GT(c.borders, 100u);
    // The segment of the circle that lies below the plane, times the length; within half a cell over the cut.
    const double half = std::acos(1.5 / 3.0), area = 9.0 * (half - std::sin(half) * std::cos(half));
    EXPECT_NEAR(4000.0 - stock.volume(), area * 20.0, 0.5 * cell * 2 * half * 3.0 * 20.0 * 0.25) << cell;
  }
}

// (removal.h, property 2)
TEST(Removal, SlotOfAFlatMill) {
  Cutter flat{4, 100, 40};
  flat.type = CutterType::kFlat;
  for (const double cell : {0.5, 0.2}) {
    Stock stock = block(cell);
    cut(stock, flat, {{-20, 0.1, -2}, {0, 0, 1}}, {{20, 0.1, -2}, {0, 0, 1}});
    const auto left = [](Point<Part> p) { return std::max(std::abs(p.y - 0.1) - 2.0, -2.0 - p.z); };
    const Compared c = compare(stock, left, -10, 10);
    EXPECT_LE(c.border, 0.5 * cell);
    EXPECT_LE(c.border, 2e-5) << cell;
    EXPECT_NEAR(4000.0 - stock.volume(), 4.0 * 2.0 * 20.0, 0.5 * cell * 8.0 * 20.0) << cell;
  }
}

// (removal.h, property 2)
TEST(Removal, SphereCavity) {
  for (const double cell : {0.5, 0.2}) {
    Stock stock = block(cell);
    Cutter ball{8, 100, 4.0};
    cut(stock, ball, {{0.3, 0.2, -9}, {0, 0, 1}}, {{0.3, 0.2, -9}, {0, 0, 1}});
    const auto left = [](Point<Part> p) { return distance(p, Point<Part>{0.3, 0.2, -5}) - 4.0; };
    const Compared c = compare(stock, left, -10, 10);
    EXPECT_LE(c.border, 2 * Dexels::kUnit) << cell;
    EXPECT_GT(c.borders, 100u);
    EXPECT_NEAR(4000.0 - stock.volume(), 4.0 / 3.0 * kPi * 64.0, 0.5 * cell * 4.0 * kPi * 16.0) << cell;
  }
}

/// A bar of radius 9 turned by the program to radius 6 all round: largest distance of the new borders from
/// that, mm, and how many they are.
struct TurnedBar {
  double worst = 0.0;
  std::size_t borders = 0;
  Removal cut;
  double volume() const { return cut.stock_volume - cut.left_volume; }
};
TurnedBar turn_bar(const std::string& text, double cell) {
  TurnedBar bar;
  const Job job = make_job();
  // A thin core stands for the part.
  const CheckedMesh part = checked(box_mesh({{Vec3{-1, -1, -10}, Vec3{1, 1, 0}}}));
  const auto shape = parse_stock("cylinder:" + std::to_string(9.0 - std::sqrt(2.0)));
  EXPECT_TRUE(shape);
  auto stock = make_stock(*shape, part, job, cell, 2);
  EXPECT_TRUE(stock) << stock.error().message;
  std::istringstream in(text);
  const auto program = read_program(in, "p.nc", 'A', 'C');
  EXPECT_TRUE(program);
  const auto path = execute_program(*program, "p.nc", job.machine.model, job.setup);
  EXPECT_TRUE(path);
  Probes probes(part.mesh, cell, 0.5);
  const auto cut = remove_material(job, *path, *stock, probes, {}, {});
  EXPECT_TRUE(cut);
  bar.cut = *cut;
  for (const Dexels& dexels : stock->bundles) {
    for (int s = 0; s < Dexels::kStripes; ++s)
      dexels.each(s, [&](Point<Part> foot, double from, double to) {
        std::array<double, 3> p{foot.x, foot.y, foot.z};
        for (const double t : {from, to}) {
          p[dexels.axis()] = t;
          // The flanks reach from -30 + radius up; ends on the bar's own faces are not of the cut.
          if (std::abs(p[2] + 10.0 + 9.0 - std::sqrt(2.0)) < 0.5 || p[2] > 6.5) continue;
          bar.worst = std::max(bar.worst, std::abs(std::hypot(p[0], p[1]) - 6.0)), ++bar.borders;
        }
      });
  }
  return bar;
}

/// One turn of C after the other, each in so many blocks.
std::string turns(int count, int blocks) {
  std::ostringstream text;
  text << "G21 G90 G94\nG0 X20 Y0 Z-30 A0 C0\nG1 X8 F1000\nF3000\n";
  for (int i = 1; i <= count * blocks; ++i) text << "C" << i * 360.0 / blocks << "\n";
  text << "G0 X20\nM2\n";
  return text.str();
}

// (removal.h, property 2)
TEST(Removal, BarTurnedByTheTable) {
  for (const double cell : {0.5, 0.2}) {
    const TurnedBar one = turn_bar(turns(1, 1), cell);
    EXPECT_LE(one.worst, 0.125 * cell + 1e-3) << cell;
    EXPECT_GT(one.borders, 100u);
  }
}

// (removal.h, property 2)
TEST(Removal, ShortBlocksAreTakenTogetherByTheStock) {
  constexpr int kBlocks = 1250;
  const double kTolerance = RemovalOptions{}.tolerance;
  const TurnedBar once = turn_bar(turns(1, kBlocks), 0.2);
  EXPECT_EQ(once.cut.blocks, kBlocks + 2u);
  EXPECT_LE(once.worst, 0.5 * kTolerance + 1e-3);
  EXPECT_GT(once.borders, 100u);
  // The same way a second time is air, but for what is taken up at the seam.
  const TurnedBar twice = turn_bar(turns(2, kBlocks), 0.2);
  EXPECT_EQ(twice.worst, once.worst);
  EXPECT_NEAR(twice.volume(), once.volume(), 1e-4 * once.volume());
  const double turn = twice.cut.seconds - once.cut.seconds;
  EXPECT_LE(once.cut.air_seconds, 0.02 * turn);
  EXPECT_NEAR(twice.cut.air_seconds - once.cut.air_seconds, turn, 0.05 * turn);
  // What is taken together is told of all the blocks that took it: no span of time is left out.
  const auto& bins = once.cut.bins;
  const double mean = once.volume() / static_cast<double>(bins.size());
  for (std::size_t i = bins.size() * 4 / 10; i < bins.size() * 9 / 10; ++i)
    EXPECT_GT(bins[i].removed, 0.25 * mean) << i;
}

TEST(Removal, ShankWithoutItsBallAndTheBallAreTheWhole) {
  // A material's line is cut alike by a piece with its ball, and by the ball's way and then the rest.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto any = [&](double size) { return Vec3{unit(random), unit(random), unit(random)} * size; };
  const Box box{{-8, -8, -8}, {8, 8, 8}};
  std::size_t met = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 along = i % 7 == 0 ? Vec3{0, 0, 2} : any(3.0), way = i % 5 == 0 ? Vec3{} : any(2.0);
    const Point<Part> foot = Point<Part>{} + any(4.0);
    const SweptBody whole = SweptBody::round(foot, along, way, 1.5, ToolPart::kCutter);
    const SweptBody ball = SweptBody::round(foot, {}, way, 1.5, ToolPart::kCutter);
    const int axis = i % 3;
    std::array<Dexels, 2> lines{Dexels(axis, box, 0.4), Dexels(axis, box, 0.4)};
    for (int s = 0; s < Dexels::kStripes; ++s) {
      for (Dexels& d : lines) d.fill(s, box), d.settle(s);
      met += lines[0].cut(s, whole, false).removed > 0 ? 1 : 0;
      lines[1].cut(s, ball, false), lines[1].cut(s, whole.without_ball(), false);
      // Each of the two cuts may round an end by a unit.
      EXPECT_NEAR(static_cast<double>(lines[0].length(s)), static_cast<double>(lines[1].length(s)), 200.0)
          << i;
    }
  }
  EXPECT_GT(met, 500u);
}

TEST(Removal, OnlyWhatIsBelowTheBallsPlaneAllAlongTheWayIsLeftToIt) {
  const auto body = [](Vec3 way) {
    return SweptBody::round({1, 2, 3}, {0, 0, 4}, way, 0.5, ToolPart::kCutter);
  };
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-4.0, 8.0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 way{place(random), place(random), place(random)};
    const Point<Part> p{place(random), place(random), place(random)};
    bool below = true;
    for (int k = 0; k <= 100; ++k) below = below && p.z < 3.0 + way.z * k / 100.0;
    EXPECT_EQ(body(way).without_ball().leaves_to_ball(p), below);
    EXPECT_FALSE(body(way).leaves_to_ball(p));  // the ball is its own
  }
}

TEST(Removal, WhatIsClearOfStockIsNotNearIt) {
  constexpr double kReach = 2.5;
  // A bar in one corner of a block of air.
  const Box box{{-10, -10, -10}, {10, 10, 0}}, bar{{-9, -3, -9}, {-6, 2, -4}};
  Stock stock{{}, box, 0.5};
  stock.bundles.emplace_back(2, box, 0.5);
  for (int s = 0; s < Dexels::kStripes; ++s) stock.bundles.back().fill(s, bar);
  const Occupied occupied(stock, kReach);
  const auto from_bar = [&](Point<Part> p) {
    return length({std::max({bar.min.x - p.x, p.x - bar.max.x, 0.0}),
                   std::max({bar.min.y - p.y, p.y - bar.max.y, 0.0}),
                   std::max({bar.min.z - p.z, p.z - bar.max.z, 0.0})});
  };
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int clear = 0, far = 0;
  for (int i = 0; i < 20000; ++i) {
    const Point<Part> p{18 * any(random), 18 * any(random), 18 * any(random)};
    const double mm = occupied.clear(p);
    if (from_bar(p) <= kReach) {
      ASSERT_LT(mm, 0.0) << to_string(p);
    }
    if (mm < 0.0) continue;
    ++clear, far += mm > 4.0 ? 1 : 0;
    ASSERT_GE(from_bar(p), kReach + mm) << to_string(p);
    const Vec3 way = normalized({any(random), any(random), any(random)}) * (mm * 0.999);
    ASSERT_GE(occupied.clear(p + way), 0.0) << to_string(p);
  }
  EXPECT_GT(clear, 10000);
  EXPECT_GT(far, 5000);
}

}  // namespace
}  // namespace tiltfeed::sim
