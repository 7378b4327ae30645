// What CL files ask of the tool besides straight lines: holes, arcs, frames of points, units; points worked
// out by hand, and closed forms.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kinematics/basics/decimal.h"
#include "tests/texts/apt_text.h"

namespace tiltfeed {
namespace {

struct Hop {
  double x, y, z;
  bool rapid;
};

void expect_hops(const AptOperation& op, const std::vector<Hop>& want) {
  ASSERT_EQ(op.path.moves.size(), want.size());
  for (std::size_t i = 0; i < want.size(); ++i) {
    const Move& move = op.path.moves[i];
    EXPECT_NEAR(distance(move.pose.tip, {want[i].x, want[i].y, want[i].z}), 0.0, 1e-12)
        << i << ": " << move.pose.tip.x << " " << move.pose.tip.y << " " << move.pose.tip.z;
    EXPECT_EQ(move.kind == MoveKind::kRapid, want[i].rapid) << i;
  }
}

const std::string kStart = "UNITS/MM\nLOADTL/1,LENGTH,100\nSPINDL/1000,CLW\nRAPID\nGOTO/0,0,25\n";

TEST(AptCycle, DrillsFromAboveEachPoint) {
  const std::vector<Hop> want{{0, 0, 25, true},  {10, 0, 25, true}, {10, 0, 3, true}, {10, 0, -8, false},
                              {10, 0, 20, true}, {10, 5, 20, true}, {10, 5, 3, true}, {10, 5, -8, false},
                              {10, 5, 20, true}, {10, 5, 39, true}, {0, 0, 39, true}, {0, 0, 22, true},
                              {0, 0, 11, false}, {0, 0, 39, true},  {9, 9, 9, false}};
  const std::string points =
      "GOTO/10,0,0\nGOTO/10,5,0\nGOTO/0,0,19\nCYCLE/OFF\nFEDRAT/77\nGOTO/9,9,9\nFINI\n";
  for (const char* cycle :
       {"CYCLE/INIT\nCYCLE/DRILL,FEDTO,8.,MMPM,300.,RAPTO,3.,RTRCTO,20.,DWELL,0\n",
        "CYCLE/DRILL,RAPTO,3,FEDTO,-8,RTRCTO,20,MMPM,300\n",
        "CYCLE/DRILL,DEPTH,8,MMPM,300,CLEAR,3,RETURN,20\n", "FEDRAT/300\nCYCLE/DRILL,8,CLEAR,3,RETURN,20\n",
        "CYCLE/DRILL,8,MMPM,300,3,RTRCTO,20\n"}) {
    SCOPED_TRACE(cycle);
    const AptOperation op = only_operation(kStart + cycle + points);
    expect_hops(op, want);
    EXPECT_EQ(feed_of(op.path, 3).mm_per_min(), 300.0);
    EXPECT_EQ(feed_of(op.path, 14).mm_per_min(), 77.0);
  }
}

TEST(AptCycle, GoesBackToWhereItCameFrom) {
  // From 25 down, and never lower than the clearance: without RTRCTO to the clearance itself.
  expect_hops(
      only_operation(kStart + "FEDRAT/9\nCYCLE/DRILL,FEDTO,2,RAPTO,1,RTRCTO,AUTO\nGOTO/4,0,5\nFINI\n"),
      {{0, 0, 25, true}, {4, 0, 25, true}, {4, 0, 6, true}, {4, 0, 3, false}, {4, 0, 25, true}});
  expect_hops(
      only_operation(kStart + "FEDRAT/9\nCYCLE/DRILL,FEDTO,2,RAPTO,1\nGOTO/4,0,5\nGOTO/6,0,5\nFINI\n"),
      {{0, 0, 25, true},
       {4, 0, 25, true},
       {4, 0, 6, true},
       {4, 0, 3, false},
       {4, 0, 6, true},
       {6, 0, 6, true},
       {6, 0, 3, false},
       {6, 0, 6, true}});
}

TEST(AptCycle, PecksAndBreaksChips) {
  expect_hops(
      only_operation(kStart + "CYCLE/DEEP2,FEDTO,7.,1STPECK,5.,SUBPECK,2.,MMPM,90.,RAPTO,3.,RTRCTO,25.\n"
                              "GOTO/1,2,0\nCYCLE/OFF\nFINI\n"),
      {{0, 0, 25, true},
       {1, 2, 25, true},
       {1, 2, 3, true},
       {1, 2, -2, false},
       {1, 2, 3, true},
       {1, 2, -1, true},
       {1, 2, -4, false},
       {1, 2, 3, true},
       {1, 2, -3, true},
       {1, 2, -6, false},
       {1, 2, 3, true},
       {1, 2, -5, true},
       {1, 2, -7, false},
       {1, 2, 25, true}});
  expect_hops(only_operation(kStart + "CYCLE/DRILL,BRKCHP,FEDTO,-4,STEP,3,MMPM,90,RAPTO,1,RTRCTO,5\n"
                                      "GOTO/1,2,0\nCYCLE/OFF\nFINI\n"),
              {{0, 0, 25, true},
               {1, 2, 25, true},
               {1, 2, 1, true},
               {1, 2, -2, false},
               {1, 2, -1.5, true},
               {1, 2, -4, false},
               {1, 2, 5, true}});
}

TEST(AptCycle, TapsAndBores) {
  const AptOperation tap =
      only_operation(kStart + "CYCLE/TAP,FEDTO,6,MMPR,1.25,RAPTO,2,RTRCTO,9\nGOTO/0,0,0\nCYCLE/OFF\nFINI\n");
  expect_hops(tap, {{0, 0, 25, true}, {0, 0, 2, true}, {0, 0, -6, false}, {0, 0, 2, false}, {0, 0, 9, true}});
  EXPECT_EQ(feed_of(tap.path, 2).mm_per_min(), 1250.0);
  EXPECT_EQ(tap.events, (std::vector<PathEvent>{{0, EventKind::kSpindle, 1000, ""},
                                                {3, EventKind::kSpindle, -1000, ""},
                                                {4, EventKind::kSpindle, 1000, ""}}));
  const AptOperation bore = only_operation(
      kStart + "CYCLE/BORE,FEDTO,6,MMPM,50,RAPTO,2,DWELL,REV,5\nGOTO/0,0,0\nCYCLE/OFF\nFINI\n");
  expect_hops(bore, {{0, 0, 25, true}, {0, 0, 2, true}, {0, 0, -6, false}, {0, 0, 2, false}});
  ASSERT_EQ(bore.events.size(), 2u);
  EXPECT_EQ(bore.events[1], (PathEvent{3, EventKind::kDwell, 0.3, ""})) << "five turns at 1000 1/min";
}

TEST(AptCycle, GoesAlongTheToolAxisInInches) {
  // Along (-1, 0, 0), as a side is drilled.
  const AptOperation side = only_operation(
      "UNIT/INCH\nLOADTL/1,LENGTH,4\nRAPID\nGOTO/-2,1,1,-1,0,0\nCYCLE/"
      "DRILL,FEDTO,.5,IPM,10,RAPTO,.1,RTRCTO,1\n"
      "GOTO/0,2,1,-1,0,0\nCYCLE/OFF\nFINI\n");
  const double i = 25.4;
  expect_hops(side, {{-2 * i, i, i, true},
                     {-2 * i, 2 * i, i, true},
                     {-0.1 * i, 2 * i, i, true},
                     {0.5 * i, 2 * i, i, false},
                     {-1 * i, 2 * i, i, true}});
  EXPECT_NEAR(feed_of(side.path, 3).mm_per_min(), 254.0, 1e-9);
}

/// Largest distance of chords from the circle they stand for, and the angle that they turn about `axis`.
struct Turned {
  double off = 0.0, angle = 0.0;
};
Turned turned(const AptOperation& op, std::size_t first, Vec3 centre, Vec3 axis, double radius) {
  Turned out;
  const auto flat = [&](Point<Part> p) {
    const Vec3 d = from_origin(p) - centre;
    return d - axis * dot(d, axis);
  };
  for (std::size_t i = first; i < op.path.moves.size(); ++i) {
    const Point<Part> p = op.path.moves[i - 1].pose.tip, q = op.path.moves[i].pose.tip;
    for (const double f : {0.0, 0.25, 0.5, 0.75, 1.0})
      out.off = std::max(out.off, std::abs(length(flat(lerp(p, q, f))) - radius));
    out.angle += std::atan2(dot(cross(flat(p), flat(q)), axis), dot(flat(p), flat(q)));
  }
  return out;
}

TEST(AptArc, EveryArcIsFollowedWithinTheTolerance) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int round = 0; round < 300; ++round) {
    const Vec3 axis = normalized(Vec3{unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5});
    const Vec3 x = normalized(cross(axis, Vec3{0.3, 0.5, -0.7})), y = cross(axis, x);
    const double radius = 0.5 + 200.0 * unit(random) * unit(random), from = 6.0 * unit(random);
    const bool whole = round % 7 == 0;
    const double sweep = whole ? 2.0 * kPi : 0.01 + (2.0 * kPi - 0.02) * unit(random);
    const double rise = round % 3 == 0 ? 5.0 * unit(random) : 0.0;
    const Vec3 centre{10.0 * unit(random), -3.0, 7.0 * unit(random)};
    const bool nx = round % 2 == 0;
    const auto point = [&](double angle, double height) {
      const Vec3 p = centre + (x * std::cos(angle) + y * std::sin(angle)) * radius + axis * height;
      return decimal(p.x, 9) + "," + decimal(p.y, 9) + "," + decimal(p.z, 9);
    };
    const Vec3 stated = nx ? -axis : axis;
    const auto triple = [](Vec3 v) {
      return decimal(v.x, 9) + "," + decimal(v.y, 9) + "," + decimal(v.z, 9);
    };
    AptOptions options;
    options.chord_error = round % 5 == 0 ? 0.05 : 0.002;
    const AptOperation op =
        only_operation("UNITS/MM\nFEDRAT/100\nGOTO/" + point(from, 0) + "\nCIRCLE/" + triple(centre) + "," +
                           triple(stated) + (nx ? "," + decimal(radius, 9) + ",0.002,0.5,10,0" : "") +
                           "\nGOTO/" + point(whole ? from : from + sweep, rise) + "\nFINI\n",
                       options);
    const Turned way = turned(op, 1, centre, axis, radius);
    EXPECT_LE(way.off, options.chord_error + 1e-7);
    EXPECT_NEAR(way.angle, sweep, 1e-6) << round;
    // No more chords than that takes.
    EXPECT_LE(static_cast<double>(op.path.moves.size()) - 2.0,
              sweep / (2.0 * std::acos(1.0 - std::min(1.0, options.chord_error / radius))) + 1e-6);
  }
}

TEST(AptArc, PointsAlongACircleAreFollowed) {
  // Centre, axis, radius, and three points of it; then away from it.
  const AptOperation op = only_operation(
      "UNITS/MM\nFEDRAT/100\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/7.071068,7.071068,0\nGOTO/0,10,0\n"
      "GOTO/-7.071068,7.071068,0\nGOTO/-30,7.071068,0\nFINI\n");
  AptOperation arc = op;
  ASSERT_FALSE(arc.path.moves.empty());
  arc.path.moves.pop_back();
  const Turned way = turned(arc, 1, {0, 0, 0}, {0, 0, 1}, 10);
  EXPECT_LE(way.off, 0.0025 + 1e-6);
  EXPECT_NEAR(way.angle, 0.75 * kPi, 1e-6);
  EXPECT_EQ(op.path.moves.back().pose.tip, (Point<Part>{-30, 7.071068, 0}));
}

TEST(AptFrame, PointsOfAMachineSystemBecomeThoseOfThePart) {
  // x of the system is the part's y, its y the part's z, so its z the part's x.
  const std::string second = "MSYS/100,0,0,0,1,0,0,0,1\n";
  const AptOperation op = only_operation(
      "UNITS/MM\nMSYS/0,0,0,1,0,0,0,1,0\nGOTO/0,0,10,0,0,1\nFEDRAT/100\nGOTO/1,0,0\n" + second +
      "RAPID\nGOTO/0,0,10\nGOTO/1,2,0\nGODLTA/0,0,5\nCIRCLE/1,4,5,0,0,1\nGOTO/1,6,5\nFINI\n");
  const std::vector<Move>& moves = op.path.moves;
  ASSERT_GT(moves.size(), 6u);
  EXPECT_EQ(moves[1].pose.tip, (Point<Part>{1, 0, 0}));
  EXPECT_EQ(moves[2].pose.tip, (Point<Part>{110, 0, 0}));
  EXPECT_EQ(moves[2].pose.axis, (Vec3{1, 0, 0}));
  EXPECT_EQ(moves[3].pose.tip, (Point<Part>{100, 1, 2}));
  EXPECT_EQ(moves[4].pose.tip, (Point<Part>{105, 1, 2}));
  EXPECT_EQ(moves.back().pose.tip, (Point<Part>{105, 1, 6}));
  EXPECT_NEAR(turned(op, 5, {105, 1, 4}, {1, 0, 0}, 2).angle, kPi, 1e-9);
}

TEST(AptFrame, ASetUpGivesPointsWithoutDirectionItsAxis) {
  const AptOperation op = only_operation(
      "UNIT/MM\nTRNTYP/WORLD,0,0,0\nCSYS/0,0,-1.,0,-1.,0,0,0,0,1.,0,0\nGOTO/-25.,100.,-47.,-1.,0,0\n"
      "TRNTYP/WORLD,0,0,0\nCSYS/1.,0,0,0,0,1.,0,33.,0,0,1.,0\nRAPID/\nGOTO/1.,2.,3.\n"
      "CSYS/0,0,-1.,0,-1.,0,0,0,0,1.,0,0\nRAPID/\nGOTO/4.,5.,6.\nFINI\n");
  ASSERT_EQ(op.path.moves.size(), 3u);
  EXPECT_EQ(op.path.moves[0].pose.axis, (Vec3{-1, 0, 0}));
  EXPECT_EQ(op.path.moves[1].pose, (Pose{{1, 2, 3}, {0, 0, 1}}));
  EXPECT_EQ(op.path.moves[2].pose, (Pose{{4, 5, 6}, {-1, 0, 0}}));
}

TEST(AptUnits, HoldForTheWholeFile) {
  for (const char* word : {"UNIT/INCH", "UNIT/INCHES", "UNITS/INCH", "units / inches"}) {
    const AptOperation op =
        only_operation("PARTNO A\nCUTTER/0.5\nLOADTL/1,LENGTH,4\nFEDRAT/10\nFROM/1,0,0\n" +
                       std::string(word) + "\nGODLTA/1,0,0\nGOTO/0,0,1\n" + word + "\nGOTO/0,0,2\nFINI\n");
    EXPECT_EQ(op.path.tool, (ToolData{12.7, 0, 101.6})) << word;
    ASSERT_EQ(op.path.moves.size(), 3u);
    EXPECT_NEAR(op.path.moves[0].pose.tip.x, 50.8, 1e-12);
    EXPECT_NEAR(feed_of(op.path, 1).mm_per_min(), 254.0, 1e-9);
  }
}

TEST(AptOptions, AFeedForFilesWithoutOneAndWordsToLeaveOut) {
  const std::string text = "UNITS/INCHES\nGOTO/0,0,1\nTRACUT/0,1,0,5,1,0,0,0,0,0,1,0\nGOTO/0,0,0\nFINI\n";
  AptOptions options;
  options.feed = 120.0;
  EXPECT_FALSE(read_text(text, options));
  options.ignored = {"TRACUT"};
  const auto program = read_text(text, options);
  ASSERT_TRUE(program) << program.error().message;
  EXPECT_EQ(feed_of(program->operations[0].path, 1).mm_per_min(), 120.0);
  EXPECT_EQ(program->notes, (std::vector<std::string>{"p.cls:3: TRACUT was left out, as asked"}));
}

}  // namespace
}  // namespace tiltfeed
