// Ways over the clearance surface, joins and leads one by one: closed forms, the tilt limit, and every
// fallback.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

#include "pathgen/linking/joins.h"
#include "pathgen/linking/leads.h"
#include "pathgen/linking/travel.h"
#include "pathgen/plan/plan.h"
#include "tests/shapes/link_shop.h"

namespace tiltfeed {
using namespace pathgen;
namespace {
struct TiltCase {
  const char* name;
  AxisMode mode;
  Vec3 up;  ///< in the frame's t, n, b
  double tilt_max;
  Along along;
};

TEST(Tilt, HoldsOnEveryWayOverTheClearanceSurface) {
  const Vec3 t = normalized(Vec3{0.2, 0.9, -0.3}), n = normalized(cross(t, Vec3{0.5, -0.2, 0.8}));
  for (const TiltCase& c : {TiltCase{"line", AxisMode::kLine, {0, 1, 0}, 130.0, Along::kY},
                            {"point, pole up", AxisMode::kPoint, {0, 0, 1}, 115.0, Along::kY},
                            {"point, leaning", AxisMode::kPoint, {0.4, 0.5, 0.6}, 100.0, Along::kX},
                            {"circle, ring level", AxisMode::kCircle, {0, 0, 1}, 110.0, Along::kX},
                            {"circle, ring leaning", AxisMode::kCircle, {0.1, 0.5, 0.8}, 95.0, Along::kX}}) {
    SCOPED_TRACE(c.name);
    const AxisFrame frame{
        c.mode, Sense::kOutward, {5, -8, 3}, t, n, c.mode == AxisMode::kCircle ? 60.0 : 0.0};
    const Vec3 up = normalized(t * c.up.x + n * c.up.y + cross(n, t) * c.up.z);
    Shop shop(whole(frame, 20.0), frame, 4.0, 20.0, {}, up, c.tilt_max, c.along);
    // One way round the line: from the end of a pass to the start of the next it is short under the table.
    if (c.mode == AxisMode::kLine) shop.links.direction = Direction::kOneWay;
    shop.links.order = PassOrder::kGiven;
    const Linked linked = shop.run();
    ASSERT_GT(linked.retracts, 5u);
    EXPECT_EQ(linked.tilted_passes + linked.skipped_passes, 0u);
    EXPECT_LE(widest_tilt(linked, up), Angle::from_degrees(c.tilt_max).radians() + 2e-6);
    EXPECT_LE(proof(shop, linked).rapid_overlap, kTolerance / 2.0);
    shop.links.tilt_max = Angle::from_degrees(180.0);
    EXPECT_GT(widest_tilt(shop.run(), up), Angle::from_degrees(c.tilt_max).radians() + 1e-4);
  }
}

TEST(Tilt, TheLongWayRoundWhereTheShortOneGoesUnderTheTable) {
  const AxisFrame frame{AxisMode::kLine, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.0};
  Shop shop(whole(frame, 20.0), frame, 8.0, 20.0);
  shop.links.up = {0, 0, 1};
  const double deg = shop.field->deformation.scale_y() * kPi / 180.0;
  for (const auto& [tilt, turn] : {std::pair{180.0, 160.0}, {120.0, 200.0}}) {
    shop.links.tilt_max = Angle::from_degrees(tilt);
    std::vector<Pose> poses;
    ASSERT_EQ(shop.travel().find({0, 100 * deg, 0}, {5, -100 * deg, 0}, poses), Travel::Way::kFound);
    double way = 0.0;
    Vec3 axis = shop.travel().pose({0, 100 * deg, 0}).axis;
    for (const Pose& pose : poses) way += angle_between(axis, pose.axis), axis = pose.axis;
    EXPECT_NEAR(Angle::from_radians(way).degrees(), turn, 1e-6);
    EXPECT_LT(distance(poses.back().tip, shop.travel().pose({5, -100 * deg, shop.links.clearance_z}).tip),
              1e-9);
  }
}

TEST(Tilt, WhatNoWayReachesIsLeftOutAndCounted) {
  // The axis leans less than 60 degrees from n on the outside of the ring's one half and on the inside of
  // the other; between them it lies along the ring's plane, square to n, or leans further.
  const AxisFrame frame{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 60.0};
  Shop shop(whole(frame, 20.0), frame, 8.0, 20.0, {}, {0, 1, 0}, 60.0);
  const Linked linked = shop.run();
  EXPECT_GT(linked.tilted_passes, 0u);
  EXPECT_EQ(linked.skipped_passes, 0u);
  EXPECT_EQ(linked.retracts + linked.tilted_passes, shop.passes());
  EXPECT_LE(widest_tilt(linked, {0, 1, 0}), Angle::from_degrees(60.0).radians() + 2e-6);
}

TEST(Tilt, AWayRoundStaysInItsColumns) {
  // The clearance surface of the ring's inside lies beyond the ring's axis, in another column.
  const AxisFrame frame{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 13.5};
  Shop shop(whole(frame, 6.0), frame, 3.0, 6.0);
  const Deformation& map = shop.field->deformation;
  const double deg = map.scale_y() * kPi / 180.0;
  shop.links.up = {0, -1, 0}, shop.links.tilt_max = Angle::from_degrees(120.0);
  const double z = shop.links.clearance_z;
  ASSERT_FALSE(map.in_column({0, 180 * deg, z}, 0.0));
  std::vector<Pose> poses;
  ASSERT_EQ(shop.travel().find({0, 80 * deg, 0}, {0, -80 * deg, 0}, poses), Travel::Way::kFound);
  for (const Pose& pose : poses) {
    const Point<Flat> f = map.flatten(pose.tip + pose.axis * kRadius);
    EXPECT_LT(length(map.axis_line(f.x, f.y).axis - pose.axis), 1e-9);
    EXPECT_NEAR(f.z, z, 1e-9);
  }
}

TEST(Travel, GoesRoundWhatTheFarSideBlocks) {
  const AxisFrame frame{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 20.0};
  for (const auto& [shank, turn] : {std::pair{12.0, 160.0}, {60.0, 200.0}}) {
    Shop shop(whole(frame, 6.0), frame, 3.0, shank);
    const double deg = shop.field->deformation.scale_y() * kPi / 180.0;
    const Travel travel = shop.travel();
    std::vector<Pose> poses;
    ASSERT_EQ(shop.travel().find({0, 100 * deg, 0}, {0, -100 * deg, 0}, poses), Travel::Way::kFound);
    double way = 0.0;
    Vec3 axis = travel.pose({0, 100 * deg, 0}).axis;
    for (const Pose& pose : poses) way += angle_between(axis, pose.axis), axis = pose.axis;
    EXPECT_NEAR(Angle::from_radians(way).degrees(), turn, 1e-6);
  }
}

TEST(Travel, MindsThePartBeyondTheRingsAxis) {
  // Higher than the ring is wide, the clearance surface of one side's inside runs through the other side.
  const AxisFrame frame{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 13.5};
  Shop shop(whole(frame, 6.0), frame, 3.0, 6.0);
  const Deformation& map = shop.field->deformation;
  shop.links.clearance_z = 20.0;
  shop.opposite_wall =
      std::make_unique<OppositeWall>(shop.part.mesh, map, shop.options, shop.links.clearance_z);
  const double deg = map.scale_y() * kPi / 180.0;
  const Point<Flat> from{0, 120 * deg, 20.0};
  Linked linked;
  linked.moves.push_back({shop.travel().pose(from), MoveKind::kRapid});
  std::vector<Pose> poses;
  ASSERT_EQ(shop.travel().find(from, {0, -120 * deg, 0}, poses), Travel::Way::kFound);
  for (const Pose& pose : poses) linked.moves.push_back({pose, MoveKind::kRapid});
  const Measured m = proof(shop, linked);
  EXPECT_LE(m.rapid_overlap, kTolerance) << pasteable(m.rapid_at);
}

TEST(Travel, StraysIntoNothingOnTheFarSide) {
  const AxisFrame frame{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 20.0};
  // From where the shank hardly fits across the hole to where it does not.
  int slow = 0;
  for (double shank = 24.3; shank < 25.0; shank += 0.02) {
    Shop shop(whole(frame, 6.0), frame, 3.0, shank);
    const double deg = shop.field->deformation.scale_y() * kPi / 180.0;
    for (const double y : {100.0, -100.0})
      shop.slices.push_back({{*shop.envelope->at(0.0, y * deg), *shop.envelope->at(0.1, y * deg)}});
    const std::vector<Move> moves = shop.run().moves;
    const sim::PartDistance part(shop.part.mesh);
    const sim::ToolSolid strayed(shop.options.cutter, {stray_of_rapids(kTolerance)}, 0.0);
    for (std::size_t i = 1; i < moves.size(); ++i) {
      const Pose &from = moves[i - 1].pose, &to = moves[i].pose;
      if (from.axis == to.axis) continue;
      if (moves[i].kind == MoveKind::kPlunge) ++slow;
      if (moves[i].kind != MoveKind::kRapid) continue;
      for (const sim::ToolPart tool : sim::kToolParts)
        EXPECT_GT(strayed.clearance(part, between(from, to, 0.5), tool).value, -kTolerance) << shank;
    }
    if (slow > 0) break;
  }
  EXPECT_GT(slow, 0);
}

TEST(Tilt, LeastCosineIsThatOfTheGreatCircle) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto any = [&] { return normalized(Vec3{normal(random), normal(random), normal(random)}); };
  for (int i = 0; i < 200; ++i) {
    const Vec3 a = any(), b = any(), up = any();
    double least = 1.0;
    for (int k = 0; k <= 2000; ++k) least = std::min(least, dot(slerp(a, b, k / 2000.0), up));
    EXPECT_NEAR(least_cosine(a, b, up), least, 1e-5);
    EXPECT_NEAR(least_cosine(a, a, up), dot(a, up), 1e-15);
  }
}

/// A level sheet, 60 by 60, of another height where x is near 0.
template <class Height>
Shop valley(Height height, bool hole = false) {
  return Shop(
      sheet(
          kFixedFrame, 1.0, {-30, -30, 0}, {30, 30, 0}, 60, 60, [&](double x, double) { return height(x); },
          [&](int i, int) { return !(hole && i >= 25 && i < 35); }),
      kFixedFrame, 10.0);
}
const auto level = [](double, double = 0.0) { return 0.0; };

Joins::End end_at(Shop& shop, double x, double y) {
  const auto p = shop.envelope->at(x, y), in = shop.envelope->at(x + (x < 0.0 ? -0.5 : 0.5), y);
  return {*p, *in};
}

TEST(Join, OnlyWhereTheEnvelopeLeadsThere) {
  const auto joined = [](Shop& shop, double x) {
    shop.links.join_distance = 25.0, shop.links.plunge_ratio = 100.0;
    const Travel travel = shop.travel();
    Joins joins(*shop.field, shop.links, *shop.opposite_wall, *shop.envelope, travel);
    return joins.between(end_at(shop, -x, 3.0), end_at(shop, x, 3.0));
  };
  Shop plain = valley(level), holed = valley(level, true);
  ASSERT_TRUE(joined(plain, 8.0));
  EXPECT_TRUE(joined(plain, 8.0)->empty());  // a straight move is all
  EXPECT_FALSE(joined(holed, 8.0));          // a gap
  EXPECT_FALSE(joined(plain, 12.6));         // too far
  plain.links.allowed = [](const EnvelopePoint& p) { return std::abs(p.flat.x) > 1.0; };
  EXPECT_FALSE(joined(plain, 8.0)) << "over points that may not be cut";
  plain.links.allowed = [](const EnvelopePoint&) { return true; };
  EXPECT_TRUE(joined(plain, 8.0));
}

TEST(Join, NotWhereUpAndOverIsQuicker) {
  Shop shop = valley([](double x) { return std::min(0.0, 3.0 * std::abs(x) - 20.0); });
  shop.links.join_distance = 25.0;
  const Travel travel = shop.travel();
  Joins joins(*shop.field, shop.links, *shop.opposite_wall, *shop.envelope, travel);
  const auto a = end_at(shop, -9.0, 3.0), b = end_at(shop, 9.0, 3.0);
  shop.links.plunge_ratio = 1.0;
  EXPECT_FALSE(joins.between(a, b));  // the gap alone is too wide
  shop.links.plunge_ratio = 20.0;
  EXPECT_FALSE(joins.between(a, b));  // the gap is not, the way down and up is too long
  shop.links.plunge_ratio = 100.0;
  const auto down_and_up = joins.between(a, b);
  ASSERT_TRUE(down_and_up);
  double lowest = 0.0, way = 0.0;
  Point<Part> at = a.point.centre;
  for (const EnvelopePoint& p : *down_and_up)
    lowest = std::min(lowest, p.centre.z), way += distance(at, p.centre), at = p.centre;
  EXPECT_NEAR(lowest, -20.0 + kRadius * std::sqrt(10.0), 0.1);  // the ball rests on both flanks
  shop.links.plunge_ratio = 0.0;                                // now up and over costs its rapids alone
  const double rapids = 2.0 * (shop.links.clearance_z - a.point.flat.z) + 18.0 - shop.links.approach;
  EXPECT_GT(way, rapids / 5.0);
  EXPECT_FALSE(joins.between(a, b));
}

/// Up, over and down from rest to rest by the machine's rates, against 16 mm at the feed: the speed at which
/// both take the same.
TEST(Join, WhereItIsQuickerByTheMachinesRates) {
  Shop shop = valley(level);
  shop.links.join_distance = 25.0;
  shop.links.rapid.linear = {250.0, 2000.0};
  const auto rapid = [](double way) {
    const double ramps = 250.0 * 250.0 / 2000.0;
    return way < ramps ? 2.0 * std::sqrt(way / 2000.0) : way / 250.0 + 250.0 / 2000.0;
  };
  const auto a = end_at(shop, -8.0, 3.0), b = end_at(shop, 8.0, 3.0);
  const double up = shop.links.clearance_z - a.point.flat.z, plunge = shop.links.approach;
  const double seconds = rapid(up) + rapid(16.0) + rapid(up - plunge);
  const double same = (16.0 - plunge * shop.links.plunge_ratio) / seconds;
  for (const double share : {0.98, 1.02}) {
    shop.links.cut_speed = share * same;
    const Travel travel = shop.travel();
    Joins joins(*shop.field, shop.links, *shop.opposite_wall, *shop.envelope, travel);
    EXPECT_EQ(joins.between(a, b).has_value(), share > 1.0) << shop.links.cut_speed;
  }
}

TEST(Join, GoesBackIntoThePassesWhereTheOutlineIsHollow) {
  // A round hole: the straight line between two ends beside it crosses the hole.
  const auto in_hole = [](double x, double y) { return std::hypot(x, y) < 15.0; };
  Shop shop(sheet(kFixedFrame, 1.0, {-30, -30, 0}, {30, 30, 0}, 240, 240, level,
                  [&](int i, int j) { return !in_hole(-29.875 + 0.25 * i, -29.875 + 0.25 * j); }),
            kFixedFrame, 2.0);
  shop.links.join_distance = 5.0;
  const Linked linked = shop.run();
  EXPECT_LE(linked.retracts, 5u);
  EXPECT_GT(shop.passes(), 40u);
  expect_proven(shop, linked);
}

TEST(Join, NotAcrossWhatTheFarSideBlocks) {
  const AxisFrame frame{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 20.0};
  for (const double shank : {16.0, 60.0}) {
    Shop shop(whole(frame, 6.0), frame, 3.0, shank);
    shop.links.join_distance = 50.0, shop.links.plunge_ratio = 1000.0;
    const Travel travel = shop.travel();
    Joins joins(*shop.field, shop.links, *shop.opposite_wall, *shop.envelope, travel);
    const double deg = shop.field->deformation.scale_y() * kPi / 180.0;
    const auto a = shop.envelope->at(3.0, 110.0 * deg), b = shop.envelope->at(3.0, -110.0 * deg);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(joins.between({*a, *a}, {*b, *b}).has_value(), shank < 20.0);
  }
}

// Rows end at a round hole that the ball falls through, beside a wall that raises the holder: across the
// hole's rim the holder would rest on the wall, too.
TEST(Join, NotWhereTheHolderAloneHoldsTheTool) {
  constexpr double kHole = 15.0;
  const CheckedMesh part = sheet(
      kFixedFrame, 1.0, {-20, -20, 0}, {20, 20, 0}, 160, 160,
      [](double u, double) { return u < 17.1 ? 0.0 : 20.0; },
      [](int i, int j) { return std::hypot(-19.875 + 0.25 * i, -19.875 + 0.25 * j) > kHole; });
  PlanOptions options;
  options.axis = kFixedFrame, options.tolerance = kTolerance;
  options.cutter = {2.0 * kRadius, 100.0, 12.0};
  options.cutter.holder = {{16.0, 20.0, 30.0}};
  options.holder = {0.5, Reaction::kRetract};
  options.pattern.side_step = 7.0;
  options.links = {.clearance = kClearance, .approach = 1.0, .join_distance = 20.0};
  const auto planned = plan(part, options, {});
  ASSERT_TRUE(planned) << planned.error().message;
  std::size_t raised = 0;
  for (std::size_t i = 1; i < planned->path.moves.size(); ++i) {
    if (planned->path.moves[i].kind != MoveKind::kCut) continue;
    for (const double share : {0.5, 1.0}) {
      const Pose pose = between(planned->path.moves[i - 1].pose, planned->path.moves[i].pose, share);
      if (pose.tip.x < 8.5) continue;
      EXPECT_GE(std::hypot(pose.tip.x, pose.tip.y), kHole - 0.25 - kRadius) << pasteable(pose);
      raised += pose.tip.z > 8.0;
    }
  }
  EXPECT_GT(raised, 10u) << "the holder has to matter";
}

// Inside work in a trough with a fin between two passes, nearer to the line than the clearance surface. Where
// the trough has a gap, on the side away from the seam, the way leads round.
TEST(Travel, InAHollowMindsWhatIsOverTheClearanceSurface) {
  const AxisFrame line{AxisMode::kLine, Sense::kInward, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 0.0};
  const double half = 50.0 * kPi / 180.0 * 30.0;
  for (const bool has_gap : {false, true}) {
    Shop shop(
        sheet(
            line, 30.0, {-20, -half, 0}, {20, half, 0}, 80, 40,
            [&](double u, double) { return std::abs(u) < 1.0 ? -6.0 : -30.0; },
            [&](int i, int) { return !has_gap || std::abs(i - 39.5) > 4.0; }),
        line, 4.0, 10.0, [](const EnvelopePoint& p) { return p.flat.z > -25.0; }, {0, 0, 1}, 180.0,
        Along::kY);
    shop.links.clearance_z = -28.0 + kRadius + kClearance;
    shop.opposite_wall = std::make_unique<OppositeWall>(shop.part.mesh, shop.field->deformation, shop.options,
                                                        shop.links.clearance_z);
    const Linked linked = shop.run();
    EXPECT_LE(proof(shop, linked).rapid_overlap, kTolerance / 2.0);
    EXPECT_GT(linked.moves.size(), 20u);
    EXPECT_EQ(linked.skipped_passes == 0, has_gap);
  }
}

TEST(Lead, IsAQuarterCircleOnALevelSheet) {
  Shop shop = valley(level);
  shop.links.lead_radius = 3.0;
  const Travel travel = shop.travel();
  Leads leads(*shop.field, shop.links, *shop.opposite_wall, *shop.envelope, travel);
  const auto end = shop.envelope->at(0.0, 1.0), next = shop.envelope->at(1.0, 1.0);
  const auto arc = leads.arc(*end, *next);
  ASSERT_GE(arc.size(), 8u);
  for (const Point<Flat>& p : arc) EXPECT_NEAR(std::hypot(p.x, p.z - end->flat.z - 3.0), 3.0, 1e-9);
  EXPECT_NEAR(arc.back().x, -3.0, 1e-9);
  EXPECT_NEAR(arc.back().z, end->flat.z + 3.0, 1e-9);
  shop.links.lead_radius = kClearance + 0.1;  // its end would be over the clearance surface
  EXPECT_TRUE(leads.arc(*end, *next).empty());
  shop.links.lead_radius = kClearance - 0.1;
  EXPECT_FALSE(leads.arc(*end, *next).empty());
}

TEST(Lead, NotIntoAWallNorFromFarBelow) {
  // Level, a wall behind it, and a flank of 60 degrees further on.
  Shop shop = valley([](double x) {
    return x < -10.0 ? 8.0 : x < -9.0 ? 8.0 * (-9.0 - x) : x > 5.0 ? std::sqrt(3.0) * (x - 5.0) : 0.0;
  });
  shop.links.lead_radius = 3.0;
  const Travel travel = shop.travel();
  Leads leads(*shop.field, shop.links, *shop.opposite_wall, *shop.envelope, travel);
  const auto arc = [&](double x, double towards) {
    const auto end = shop.envelope->at(x, 1.0), next = shop.envelope->at(x + towards, 1.0);
    return leads.arc(*end, *next);
  };
  EXPECT_FALSE(arc(-3.0, 0.5).empty());
  EXPECT_TRUE(arc(-5.0, 0.5).empty());    // the ball would cut the wall
  EXPECT_FALSE(arc(-5.0, -0.5).empty());  // the other way there is room
  EXPECT_TRUE(arc(15.0, 0.5).empty());    // up the flank
  EXPECT_FALSE(arc(15.0, -0.5).empty());  // down the flank: the arc is short and over it
  // No arc: straight down, and the pass is cut all the same.
  shop.slices = {{{*shop.envelope->at(-5.0, 1.0), *shop.envelope->at(-4.0, 1.0)}}};
  const Linked linked = shop.run();
  EXPECT_EQ(linked.leads, 1u);
  EXPECT_EQ(linked.straight_ends, 1u);
  ASSERT_GE(linked.moves.size(), 4u);
  EXPECT_EQ(linked.moves[2].kind, MoveKind::kPlunge);
  EXPECT_LT(distance(linked.moves[2].pose.tip, linked.moves[1].pose.tip), shop.links.approach + 1e-9);
}

TEST(Lead, KeepsTheTiltLimitAndMindsTheFarSide) {
  const AxisFrame point{AxisMode::kPoint, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.0};
  Shop shell(whole(point, 25.0), point, 4.0, 20.0, {}, {0, 1, 0}, 50.0);
  const AxisFrame ring{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 20.0};
  Shop hole(whole(ring, 6.0), ring, 3.0, 60.0);
  const auto arc = [](Shop& shop, double x, double y, double next_x, double next_y) {
    shop.links.lead_radius = 2.0;
    const Travel travel = shop.travel();
    Leads leads(*shop.field, shop.links, *shop.opposite_wall, *shop.envelope, travel);
    const auto end = shop.envelope->at(x, y), next = shop.envelope->at(next_x, next_y);
    return leads.arc(*end, *next);
  };
  const double deg = shell.field->deformation.scale_x() * kPi / 180.0;
  EXPECT_TRUE(arc(shell, 49.0 * deg, 0.0, 48.0 * deg, 0.0).empty());   // outwards over 50 degrees
  EXPECT_FALSE(arc(shell, 49.0 * deg, 0.0, 50.0 * deg, 0.0).empty());  // inwards
  const double turn = hole.field->deformation.scale_y() * kPi / 180.0;
  double last = 0.0;  // the last place that the opposite wall leaves free
  for (double y = 60.0; y < 180.0; y += 1.0) {
    std::vector<std::vector<Pass>> lines{{{*hole.envelope->at(0.0, y * turn)}}};
    if (hole.opposite_wall->trim(lines) > 0) break;
    last = y;
  }
  ASSERT_GT(last, 60.0);
  ASSERT_LT(last, 179.0);
  EXPECT_TRUE(arc(hole, 0.0, last * turn, 0.0, (last - 1.0) * turn).empty());
  EXPECT_FALSE(arc(hole, 0.0, last * turn, 0.0, (last + 1.0) * turn).empty());
  // A tool that fits across the hole where it cuts and where the arc ends, but not where it would retract to.
  Shop tight(whole(ring, 6.0), ring, 3.0, 23.0), loose(whole(ring, 6.0), ring, 3.0, 16.0);
  EXPECT_TRUE(arc(tight, 0.0, 178.0 * turn, 0.0, 177.0 * turn).empty());
  EXPECT_FALSE(arc(loose, 0.0, 178.0 * turn, 0.0, 177.0 * turn).empty());
}

}  // namespace
}  // namespace tiltfeed
