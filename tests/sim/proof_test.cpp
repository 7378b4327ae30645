// Moves held against the part: gaps of convex bodies, cores of tools, how far a move strays from its chord,
// and the prover against looks at many places of each move.

#include "sim/proof/proof.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "sim/proof/convex_gap.h"
#include "tests/shapes/facet_soup.h"
#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

double random_in(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Vec3 random_unit(std::mt19937_64& random) {
  while (true) {
    const Vec3 v{random_in(random, -1, 1), random_in(random, -1, 1), random_in(random, -1, 1)};
    if (squared_length(v) > 0.01 && squared_length(v) < 1.0) return normalized(v);
  }
}

TEST(ConvexGap, IsTheDistanceOfSegmentAndTriangle) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 3000; ++i) {
    const auto place = [&] {
      return Point<Part>{random_in(random, -2, 2), random_in(random, -2, 2), random_in(random, -2, 2)};
    };
    const Segment s{place(), place()};
    const Corners t{place(), place(), place()};
    const double distance = std::sqrt(squared_distance(make_triangle(t[0], t[1], t[2], 0), s));
    const auto difference = [&](Vec3 u) {
      const Point<Part> p = dot(u, from_origin(s.from)) < dot(u, from_origin(s.to)) ? s.from : s.to;
      return p - *std::max_element(t.begin(), t.end(), [&](auto a, auto b) {
               return dot(u, from_origin(a)) < dot(u, from_origin(b));
             });
    };
    const Gap gap = gap_between(difference, random_unit(random), kInfinity, 1e-9);
    EXPECT_NEAR(gap.width, distance, 2e-7) << i;
    if (gap.width > 0.0) {
      EXPECT_NEAR(dot(gap.along, difference(gap.along)), gap.width, 1e-12);
    }
  }
}

std::vector<Cutter> cutters() {
  Cutter ball{4, 100, 40}, bull = ball, flat = ball, taper = ball, thick = ball;
  bull.type = CutterType::kBullNose, bull.corner_radius = 0.5;
  flat.type = CutterType::kFlat;
  taper.type = CutterType::kTaperBall, taper.taper = Angle::from_degrees(8), taper.cutting_length = 12;
  thick.cutting_length = 8, thick.shank_diameter = 7, thick.holder = {{12, 20, 10}, {25, 25, 15}};
  return {ball, bull, flat, taper, thick};
}

TEST(ToolCore, BoundsHowDeepAPointIsInThePiece) {
  std::mt19937_64 random(2);
  for (const Cutter& cutter : cutters()) {
    for (const double allowance : {0.0, 0.3}) {
      const ToolSolid solid(cutter, {allowance, 0.1 * allowance, 0.2 * allowance});
      double seen = 0.0;
      const auto cores = tool_cores(solid, 0.05);
      for (int i = 0; i < 4000; ++i) {
        const double r = random_in(random, 0, 15), h = random_in(random, -1, 70);
        double depth = -kInfinity, told = -kInfinity;
        for (const ToolPart part : kToolParts)
          for (const Revolved& piece : solid.pieces(part))
            depth = std::max(depth, -piece.distance(r, h).value);
        for (const ToolCore& core : cores) {
          const auto difference = [&](Vec3 u) { return core.furthest({0, 0, 1}, -u) - Vec3{r, 0, h}; };
          const Gap gap = gap_between(difference, {0, 0, 1}, kInfinity, 1e-9);
          if (core.sharpness == 1.0 || gap.width <= core.rounding)
            told = std::max(told, core.rounding - gap.width / core.sharpness);
          if (core.sharpness == 1.0 && gap.width > 1e-6) seen = std::max(seen, depth);
        }
        if (depth > 0.0 && depth < 0.05) {
          EXPECT_GE(told, depth - 1e-6) << r << " " << h;
        }
        if (depth > 0.05) {
          EXPECT_GE(told, 0.05 - 1e-6) << r << " " << h;
        }
        if (depth < -0.05) {
          EXPECT_LE(told, 0.0) << r << " " << h;
        }
      }
    }
  }
}

/// Straight up and down a leaning axis, and nearly so, what is left of a direction across it is rounding.
TEST(ToolCore, ItsFurthestPointIsItsOwnAlongTheAxisToo) {
  std::mt19937_64 random(5);
  for (const Cutter& cutter : cutters()) {
    const ToolSolid solid(cutter, {});
    for (const ToolCore& core : tool_cores(solid, 0.05)) {
      for (int i = 0; i < 2000; ++i) {
        const Vec3 axis =
            normalized(Vec3{random_in(random, -1, 1), random_in(random, -1, 1), random_in(random, -1, 1)});
        const double lean = i % 4 == 0 ? 0.0 : std::pow(10.0, random_in(random, -17, -1));
        const Vec3 aside{random_in(random, -1, 1), random_in(random, -1, 1), random_in(random, -1, 1)};
        const Vec3 u = normalized(axis * (i % 2 == 0 ? 1.0 : -1.0) + aside * lean),
                   p = core.furthest(axis, u);
        const double h = dot(p, axis), r = length(p - axis * h), c = dot(u, axis), s = length(cross(u, axis));
        EXPECT_GE(h, core.low - core.wide - 1e-9);
        EXPECT_LE(h, core.high + core.wide + 1e-9);
        EXPECT_LE(r, core.wide + 1e-9);
        double most = -kInfinity;
        for (const Corner& corner : core.corners)
          most = std::max(most, corner.r * s + corner.h * c + corner.radius);
        EXPECT_NEAR(dot(p, u), most, 1e-9) << "lean " << lean;
      }
    }
  }
}

/// A machine of each structure, with offsets that matter.
std::vector<MachineModel> machines() {
  MachineModel head = make_job().machine.model, table = head, both = head;
  head.table_centre = {10, 20, 30};
  table.structure = Structure::kTableTable, table.rotary_to_tilt = {3, -5, 40};
  both.structure = Structure::kHeadHead, both.rotary_to_tilt = {20, 1, -60};
  return {head, table, both};
}

Joints random_words(std::mt19937_64& random, const Joints& near, double linear, double turned) {
  return {near.x + random_in(random, -linear, linear), near.y + random_in(random, -linear, linear),
          near.z + random_in(random, -linear, linear), near.a + random_in(random, -turned, turned),
          near.c + random_in(random, -turned, turned)};
}

TEST(MoveFrames, NoPointOfTheToolStraysFurther) {
  std::mt19937_64 random(3);
  double most = 0.0;
  for (const MachineModel& machine : machines()) {
    tiltfeed::Setup setup{{7, -9, 25}, rotation_about({0, 0, 1}, 0.7), 100.0};
    const MoveFrames frames(machine, setup);
    for (int i = 0; i < 4000; ++i) {
      const double size = std::pow(10.0, random_in(random, -2, 2));
      ProgramMove move;
      move.from = random_words(random, {}, 100, 90),
      move.to = random_words(random, move.from, 0.5 * size, 0.3 * size);
      move.tcp = i % 2 == 0;
      const Pose from = frames.pose(move, 0.0), to = frames.pose(move, 1.0);
      const double reach = random_in(random, 1, 60), stray = frames.stray(move, from, to, reach);
      for (double share = 0.1; share < 0.95; share += 0.2) {
        const Pose pose = frames.pose(move, share);
        const Point<Part> way = lerp(from.tip + from.axis * reach, to.tip + to.axis * reach, share);
        const double off = std::max(distance(pose.tip + pose.axis * reach, way),
                                    distance(pose.tip, lerp(from.tip, to.tip, share)));
        EXPECT_LE(off, stray + 1e-9);
        if (stray > 0.0) most = std::max(most, off / stray);
      }
      // Over a share of it.
      const double begin = random_in(random, 0, 0.7), part = random_in(random, 0.05, 0.3);
      const Pose first = frames.pose(move, begin), last = frames.pose(move, begin + part),
                 middle = frames.pose(move, begin + 0.5 * part);
      for (const double up : {0.0, reach})
        EXPECT_LE(distance(middle.tip + middle.axis * up,
                           lerp(first.tip + first.axis * up, last.tip + last.axis * up, 0.5)),
                  part * part * stray + 1e-9);
    }
  }
  EXPECT_GT(most, 0.2);  // the bound is no empty one
}

TEST(MoveFrames, WordsUnderTcpAndBack) {
  std::mt19937_64 random(4);
  for (const MachineModel& machine : machines()) {
    const MoveFrames frames(machine, {{7, -9, 25}, rotation_about({1, 0, 0}, 0.4), 80.0});
    for (int i = 0; i < 50; ++i) {
      const Joints words = random_words(random, {}, 200, 100), tip = frames.tip_words(words),
                   back = frames.slide_words(tip);
      EXPECT_LT(distance(frames.pose(tip, true).tip, frames.pose(words, false).tip), 1e-9);
      EXPECT_NEAR(back.x, words.x, 1e-9);
      EXPECT_NEAR(back.y, words.y, 1e-9);
      EXPECT_NEAR(back.z, words.z, 1e-9);
    }
  }
}

/// The deepest that any part of the tool is in the part, at many places of each move; at most `most`.
double looked_at(const Prover& prover, const PartDistance& surface, const ToolSolid& solid,
                 const std::vector<ProgramMove>& moves, int places) {
  double deepest = 0.0;
  for (const ProgramMove& move : moves)
    for (int i = 0; i <= places; ++i)
      for (const ToolPart part : kToolParts)
        for (const Revolved& piece : solid.pieces(part))
          deepest = std::max(
              deepest,
              -clearance(surface, piece, prover.frames().pose(move, 1.0 * i / places), -deepest).value);
  return deepest;
}

/// Short random moves near random facets, the part far enough off that little or nothing is cut.
// (proof.h, properties 1, 2 and 4)
TEST(Prover, FindsTheDeepestPlaceOfRandomMoves) {
  std::mt19937_64 random(5);
  int cut = 0, tolerated = 0;
  for (const Cutter& cutter : cutters()) {
    for (int round = 0; round < 60; ++round) {
      Job job = make_job();
      job.machine.model = machines()[static_cast<std::size_t>(round) % 3];
      job.plan.cutter = cutter;
      job.plan.tolerance = 0.4;
      job.plan.allowance = round % 2 == 0 ? 0.0 : 0.2;
      const Prover probe(checked(mesh_of({{Point<Part>{1e5, 0, 0}, {1e5, 1, 0}, {1e5, 0, 1}}})), job);
      ProgramMove move;
      move.from = random_words(random, {}, 50, 60), move.to = random_words(random, move.from, 3, 3);
      move.tcp = round % 5 == 0;
      const Pose there = probe.frames().pose(move, 0.5);
      // A facet beside the tool: at a random height, its nearest corner a little more or less than clear.
      std::vector<Corners> soup;
      const double height = random_in(random, 0, 50), out = random_in(random, 0.5, 14);
      const Point<Part> near =
          there.tip + there.axis * height + normalized(cross(there.axis, random_unit(random))) * out;
      for (int k = 0; k < 6; ++k)
        soup.push_back({near, near + random_unit(random) * 3.0, near + random_unit(random) * 3.0});
      const CheckedMesh part = checked(mesh_of(soup));
      CheckedMesh sourced = part;
      for (std::uint32_t f = 0; f < part.mesh.facets.size(); ++f) sourced.mesh.source.push_back(f);
      const Prover prover(sourced, job);
      const std::vector<ProgramMove> moves{move};
      const Proof proof = prover.hold(moves);
      const ToolSolid solid(cutter, {job.plan.allowance, 0, 0});
      const double seen = looked_at(prover, PartDistance(part.mesh), solid, moves, 400);
      EXPECT_EQ(proof.moves, 1u);
      EXPECT_EQ(proof.deepest.has_value(), seen > job.plan.tolerance * 1.015)
          << seen << " " << proof.gouge << " " << height;
      // Told that moves before cut as deep as `known`, it looks for what is deeper.
      const double known = random_in(random, 0, job.plan.tolerance);
      const Proof deeper = prover.hold(moves, known);
      EXPECT_EQ(deeper.deepest.has_value(), proof.deepest.has_value()) << known;
      if (seen <= job.plan.tolerance) {
        EXPECT_GE(deeper.gouge, std::max(known, seen - 1e-4)) << round;
        EXPECT_LE(deeper.gouge, std::max(known, seen + 0.45 * job.plan.tolerance)) << round;
        EXPECT_GE(proof.gouge, seen - 1e-4) << round;
        // At sharp rims what is told may be more, by a third of the tolerance at most.
        EXPECT_LE(proof.gouge, seen + 0.45 * job.plan.tolerance) << round;
        if (seen > 0.0) ++tolerated;
      } else {
        ++cut;
      }
    }
  }
  EXPECT_GT(cut, 10);
  EXPECT_GT(tolerated, 2);
}

/// Where a cone turns, the hull of both ends holds more than the cone on its way: here it turns about its
/// middle, where a corner of a facet stands beside it.
// (proof.h, properties 2 and 4)
TEST(Prover, ATurningConeIsNotToldDeeperThanItIs) {
  std::mt19937_64 random(7);
  Job job = make_job();
  Cutter& cutter = job.plan.cutter;
  cutter.type = CutterType::kTaperBall, cutter.taper = Angle::from_degrees(8), cutter.cutting_length = 40;
  job.plan.tolerance = 0.004;
  const ToolSolid solid(cutter, {});
  const MoveFrames frames(job.machine.model, job.setup);
  const double lean = cutter.taper.radians(), middle = 20.0;
  int near = 0;
  for (int round = 0; round < 100; ++round) {
    const Joints at = random_words(random, {0, 0, 0, 30, 20}, 0, 20);
    const auto about_middle = [&](double turned) {
      const Pose pose = frames.pose(Joints{0, 0, 0, at.a + turned, at.c}, true);
      const Point<Part> tip = pose.tip - pose.axis * middle;
      return Joints{tip.x, tip.y, tip.z, at.a + turned, at.c};
    };
    const ProgramMove move{about_middle(-0.05), about_middle(0.05), false, true, 1, 1};
    const Pose there = frames.pose(move, 0.5);
    const Vec3 radial = normalized(cross(there.axis, random_unit(random)));
    const Vec3 out = radial * std::cos(lean) - there.axis * std::sin(lean);
    const double up = middle - kRadius;  // over the ball's centre
    const Point<Part> corner = there.tip + there.axis * middle +
                               radial * (kRadius / std::cos(lean) + up * std::tan(lean)) +
                               out * random_in(random, -0.001, 0.01);
    CheckedMesh part =
        checked(mesh_of({{corner, corner + out * 5.0, corner + out * 5.0 + random_unit(random)}}));
    part.mesh.source = {0};
    const Prover prover(part, job);
    const Proof proof = prover.hold({&move, 1});
    const double seen = looked_at(prover, PartDistance(part.mesh), solid, {move}, 40);
    if (seen > job.plan.tolerance) continue;
    ++near;
    EXPECT_FALSE(proof.deepest) << round << " " << seen << " " << proof.gouge;
    EXPECT_LE(proof.gouge, seen + 0.45 * job.plan.tolerance) << round;
  }
  EXPECT_GT(near, 50);
}

/// The tool passes a facet in the middle of a move that is much longer than the part.
// (proof.h, property 3)
TEST(Prover, APlaceOnALongMoveIsToldWhereTheToolIs) {
  for (const Cutter& cutter : cutters()) {
    Job job = make_job();
    job.plan.cutter = cutter;
    job.plan.tolerance = 0.02;
    ProgramMove move;
    move.from = {0, 0, -1733, 0, 0}, move.to = {0, 0, 4000, 0, 0}, move.tcp = true;
    CheckedMesh part = checked(mesh_of({{Point<Part>{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}}}));
    part.mesh.source = {0};
    const Prover prover(part, job);
    const Proof proof = prover.hold({&move, 1});
    ASSERT_TRUE(proof.deepest);
    const ToolSolid solid(cutter, {});
    double there = 0.0;
    for (const ToolPart tool : kToolParts)
      if (const Hit hit = solid.clearance(PartDistance(part.mesh), proof.deepest->pose, tool);
          hit.facet != kNoFacet)
        there = std::max(there, -hit.value);
    EXPECT_NEAR(there, proof.deepest->depth, 0.01 * proof.deepest->depth);
    EXPECT_GT(there, 1.0);
  }
}

/// The words of the plate's program as moves.
std::vector<ProgramMove> plate_moves(const Shop& shop) {
  std::vector<ProgramMove> moves;
  for (std::size_t i = 1; i < shop.poses.size(); ++i)
    moves.push_back({joints_for(shop.poses[i - 1]), joints_for(shop.poses[i]), shop.lines[i + 1][1] == '0',
                     false, static_cast<std::uint32_t>(i + 1), i});
  return moves;
}

// (proof.h, properties 2 and 3)
TEST(Prover, PlateIsClearAndEveryLoweredMoveIsNamed) {
  const Shop shop;
  CheckedMesh part = shop.part;
  part.mesh.source.clear();
  for (std::uint32_t f = 0; f < part.mesh.facets.size(); ++f) part.mesh.source.push_back(f + 1000);
  const Prover prover(part, shop.job);
  const std::vector<ProgramMove> sound = plate_moves(shop);
  const Proof proof = prover.hold(sound);
  EXPECT_FALSE(proof.deepest);
  EXPECT_LT(proof.gouge, 0.01);
  std::mt19937_64 random(6);
  for (int i = 0; i < 40; ++i) {
    const std::size_t at = random() % (sound.size() - 1);
    std::vector<ProgramMove> bad = sound;
    if (sound[at].rapid || sound[at + 1].rapid) continue;
    bad[at].to.z -= 0.05, bad[at + 1].from.z -= 0.05;
    const Proof found = prover.hold(bad);
    ASSERT_TRUE(found.deepest) << at;
    EXPECT_NEAR(found.deepest->depth, 0.05, 0.01) << at;
    EXPECT_TRUE(found.deepest->line == bad[at].line || found.deepest->line == bad[at + 1].line) << at;
    EXPECT_GE(found.deepest->facet, 1000u);
  }
  // In the middle of one long move, where both ends are clear: the table swings the plate through the tool.
  ProgramMove swing = sound.front();
  swing.from = joints_for({{0, -6.5, -3}, {0, 0, 1}}), swing.to = swing.from;
  swing.to.c += 180.0;
  EXPECT_TRUE(prover.hold({&swing, 1}).deepest);
}

TEST(Prover, ToolInsideTheMaterialIsSeen) {
  const Shop shop;
  Job job = shop.job;
  const Prover prover(shop.part, job);
  EXPECT_TRUE(prover.inside({{0, 0, -3}, {0, 0, 1}}));
  EXPECT_FALSE(prover.inside({{0, 0, 3}, {0, 0, 1}}));
  EXPECT_FALSE(prover.inside({{100, 0, 3}, {0, 0, 1}}));
}

TEST(Prover, TheSameMovesInPiecesAreTheSame) {
  const Shop shop;
  const Prover prover(shop.part, shop.job);
  const std::vector<ProgramMove> moves = plate_moves(shop);
  const Proof whole = prover.hold(moves);
  Proof pieces;
  for (std::size_t i = 0; i < moves.size(); i += 7)
    pieces.add(prover.hold(std::span(moves).subspan(i, std::min<std::size_t>(7, moves.size() - i))));
  EXPECT_EQ(pieces.moves, whole.moves);
  EXPECT_NEAR(pieces.gouge, whole.gouge, 1e-6);
}

}  // namespace
}  // namespace tiltfeed::sim
