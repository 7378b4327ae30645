// The brute-force judges of reach, cover and interference, each against closed forms and seeded faults,
// before any planner is held against them.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/judges/reach.h"
#include "tests/judges/surface_sample.h"
#include "tests/shapes/turned_parts.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kTolerance = 0.01;

Cutter ball(double diameter, double shank_length) { return {diameter, 2 * shank_length, shank_length}; }

Angle degrees(double value) { return Angle::from_degrees(value); }

TEST(Reach, DirectionsAreEven) {
  const auto all = even_directions(1000);
  for (const Vec3 pole : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, normalized({1, -2, 3})})
    for (const double angle : {0.3, 1.0, 2.0}) {
      int in = 0;
      for (const Vec3 d : all) in += angle_between(d, pole) <= angle ? 1 : 0;
      EXPECT_NEAR(in / 1000.0, (1.0 - std::cos(angle)) / 2.0, 0.012) << angle;
    }
}

/// A shank as wide as its ball clears a convex part as soon as it does not lean past the tangent plane.
TEST(Reach, ConvexBallUnderATiltLimit) {
  const CheckedMesh part = solid_ball(10.0, 60);
  const sim::PartDistance distances(part.mesh);
  for (const double limit : {10.0, 60.0, 120.0}) {
    ReachOptions options{.cutter = ball(4, 60), .up = {0, 0, 1}, .tilt_max = degrees(limit)};
    const Reach reach(distances, part.bounds, options);
    SurfaceSample surface(part.mesh);
    int reached = 0;
    constexpr int kPoints = 400;
    for (int i = 0; i < kPoints; ++i) {
      const auto [p, n] = surface.next();
      const auto seat = reach.seat(p, n);
      ASSERT_TRUE(seat);
      EXPECT_NEAR(distance(p, *seat), 2.0, kTolerance);
      const bool is = reach.direction_at(*seat, n).has_value();
      reached += is ? 1 : 0;
      const double polar = std::acos(n.z) * 180.0 / kPi;
      // Between the sampled directions, which are 8 degrees apart, nothing is said.
      if (std::abs(polar - (limit + 90.0)) > 6.0) {
        EXPECT_EQ(is, polar < limit + 90.0) << polar << " " << limit;
      }
    }
    const double share = (1.0 - std::cos(std::min(kPi, (limit + 90.0) * kPi / 180.0))) / 2.0;
    EXPECT_NEAR(reached / double{kPoints}, share, 0.05) << limit;
  }
}

/// A holder that does not enter the slot stands on its top: the ball's centre comes shank_length - R deep.
TEST(Reach, SlotIsAsDeepAsTheHolderLets) {
  Cutter cutter = ball(6, 20);
  cutter.holder = {{30, 30, 40}};
  for (const double clearance : {0.0, 1.5}) {
    const CheckedMesh part = slotted_bar(8.0, 30.0, 60.0, 200.0);
    const sim::PartDistance distances(part.mesh);
    const Reach reach(distances, part.bounds, {.cutter = cutter, .clearance = {0, 0, clearance}});
    SurfaceSample surface(part.mesh);
    int in_reach = 0, out_of_reach = 0, no_seat = 0;
    for (int i = 0; i < 1500; ++i) {
      const auto [p, n] = surface.next();
      if (std::abs(p.x) > 4.001 || std::abs(p.y) > 60.0 || p.z < -30.5) continue;
      const auto seat = reach.seat(p, n);
      const bool fits = n.z > 0.5 ? std::abs(p.x) <= 1.0 : p.z >= -27.0;
      EXPECT_EQ(seat.has_value(), fits) << p.x << ", " << p.z;
      no_seat += fits ? 0 : 1;
      if (!seat) continue;
      const bool within = -seat->z <= 17.0 - clearance;
      EXPECT_EQ(reach.direction_at(*seat, n).has_value(), within) << p.x << ", " << p.z;
      ++(within ? in_reach : out_of_reach);
    }
    EXPECT_GT(in_reach, 20);
    EXPECT_GT(out_of_reach, 20);
    EXPECT_GT(no_seat, 10);
  }
}

/// A shank wider than the hole stands on its rim: the centre comes cutting_length - R deep.
TEST(Reach, BlindHoleIsAsDeepAsTheShankLets) {
  Cutter cutter = ball(6, 60);
  cutter.cutting_length = 12, cutter.shank_diameter = 20;
  const CheckedMesh part = blind_hole(40.0, 5.0, 30.0, 180);
  const sim::PartDistance distances(part.mesh);
  const Reach reach(distances, part.bounds, {.cutter = cutter, .directions = 300});
  SurfaceSample surface(part.mesh);
  int in_reach = 0, out_of_reach = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto [p, n] = surface.next();
    if (std::hypot(p.x, p.y) > 5.001 || p.z > -0.01 || p.z < -30.5) continue;
    const auto seat = reach.seat(p, n);
    if (!seat) continue;
    const bool within = -seat->z <= 9.0;
    EXPECT_EQ(reach.direction_at(*seat, n).has_value(), within) << p.x << ", " << p.y << ", " << p.z;
    ++(within ? in_reach : out_of_reach);
  }
  EXPECT_GT(in_reach, 10);
  EXPECT_GT(out_of_reach, 20);
}

struct Cave {
  double inner = 40.0, outer = 44.0, hole = 14.0, radius = 5.0;
  /// In the plane of the axis and the hole's axis, leaning by `lean` towards +x through (x, z): how far the
  /// tool's axis is from the nearer rim of the hole, less the radius. Rims lie at both ends of the hole.
  double room(double x, double z, double lean) const {
    double least = sim::kInfinity;
    for (const double shell : {inner, outer}) {
      const double height = std::sqrt(shell * shell - hole * hole);
      const double at = x + (height - z) * std::tan(lean);
      least = std::min(least, (hole - std::abs(at)) * std::cos(lean) - radius);
    }
    return least;
  }
};

TEST(Reach, ConeThroughTheHoleOfAHollowBall) {
  const Cave cave;
  const CheckedMesh part = hollow_ball(cave.inner, cave.outer, cave.hole, 90);
  const sim::PartDistance distances(part.mesh);
  const Reach reach(distances, part.bounds, {.cutter = ball(2 * cave.radius, 120), .directions = 4000});
  // Opposite the hole, on its axis: from the rim (a, h) above the centre, cos(lean + atan(h/a)) = R / |(a,
  // h)|.
  const Point<Part> bottom{0, 0, -(cave.inner - cave.radius) + 0.02};
  const double height = std::sqrt(cave.outer * cave.outer - cave.hole * cave.hole) - bottom.z;
  const double widest =
      std::acos(cave.radius / std::hypot(cave.hole, height)) - std::atan2(height, cave.hole);
  int admitted = 0;
  for (const Vec3 d : reach.directions()) {
    const double lean = angle_between(d, {0, 0, 1});
    const bool is = reach.admits(bottom, d);
    admitted += is ? 1 : 0;
    if (std::abs(lean - widest) > 0.002) {
      EXPECT_EQ(is, lean < widest) << lean << " against " << widest;
    }
  }
  EXPECT_GT(admitted, 5);
}

TEST(Reach, BehindTheRimOfAHollowBallEndsWhereTheHoleSays) {
  const Cave cave;
  const CheckedMesh part = hollow_ball(cave.inner, cave.outer, cave.hole, 90);
  const sim::PartDistance distances(part.mesh);
  const Reach reach(distances, part.bounds, {.cutter = ball(2 * cave.radius, 120)});
  double first_closed = -1.0, first_brute = -1.0;
  for (double polar = 30.0; polar <= 180.0; polar += 0.5) {
    const double s = std::sin(polar * kPi / 180.0), c = std::cos(polar * kPi / 180.0);
    const double r = cave.inner - cave.radius - 0.02;
    bool closed = false, brute = false;
    for (double lean = -80.0; lean <= 80.0; lean += 0.25) {
      const double b = lean * kPi / 180.0;
      const double room = cave.room(r * s, r * c, b);
      const bool is = reach.admits({r * s, 0, r * c}, {std::sin(b), 0, std::cos(b)});
      if (std::abs(room) > 0.02) {
        EXPECT_EQ(is, room > 0.0) << polar << " " << lean << " room " << room;
      }
      closed |= room > 0.0, brute |= is;
    }
    if (closed && first_closed < 0.0) first_closed = polar;
    if (brute && first_brute < 0.0) first_brute = polar;
  }
  EXPECT_GT(first_closed, 30.0);
  EXPECT_NEAR(first_brute, first_closed, 0.51);
}

TEST(Reach, NothingInAClosedVoidThoughTheToolFitsIn) {
  const CheckedMesh part = hollow_ball(40.0, 44.0, 0.0, 40);
  const sim::PartDistance distances(part.mesh);
  const Reach reach(distances, part.bounds, {.cutter = ball(4, 20), .directions = 200});
  SurfaceSample surface(part.mesh);
  for (int i = 0; i < 100; ++i) {
    const auto [p, n] = surface.next();
    const bool inside = distance(p, {}) < 42.0;
    const auto seat = reach.seat(p, n);
    ASSERT_TRUE(seat);
    EXPECT_EQ(reach.direction_at(*seat, n).has_value(), !inside);
  }
}

}  // namespace
}  // namespace tiltfeed
