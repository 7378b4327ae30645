// The links between passes, held against brute force on random parts with holes: nothing touches the part,
// joins stay on the envelope, leads are tangential and over it, and there is less air and fewer retracts.
#include "pathgen/linking/linking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>

#include "tests/shapes/link_shop.h"

namespace tiltfeed {
using namespace pathgen;
namespace {
struct Feature {
  const char* name;
  AxisFrame frame;
  double rho;
  Point<Flat> low, high;
};

std::vector<Feature> features() {
  const Vec3 t = normalized(Vec3{0.2, 0.9, -0.3}), n = normalized(cross(t, Vec3{0.5, -0.2, 0.8}));
  const Point<Part> o{5.0, -8.0, 3.0};
  return {{"fixed", {AxisMode::kFixed, Sense::kOutward, o, t, n, 0.0}, 0.0, {-25, -20, 0}, {25, 20, 0}},
          {"point", {AxisMode::kPoint, Sense::kOutward, o, t, n, 0.0}, 25.0, {-60, -25, 0}, {60, 25, 0}},
          {"line", {AxisMode::kLine, Sense::kOutward, o, t, n, 0.0}, 20.0, {-20, -55, 0}, {20, 55, 0}},
          {"circle", {AxisMode::kCircle, Sense::kOutward, o, t, n, 60.0}, 14.0, {-90, -25, 0}, {90, 25, 0}},
          {"cavity", {AxisMode::kPoint, Sense::kInward, o, t, n, 0.0}, 40.0, {-70, -40, 0}, {70, 40, 0}}};
}

/// Bumps and holes.
CheckedMesh random_part(const Feature& c, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::uniform_int_distribution<int> odd(0, 9);
  const double s = c.frame.sense == Sense::kInward ? -1.0 : 1.0;
  return sheet(
      c.frame, std::max(c.rho, 1.0), c.low, c.high, 18, 12,
      [&](double, double) { return s * c.rho + 0.9 * unit(random); },
      [&](int i, int j) { return odd(random) > 1 && !(i > 6 && i < 11 && j > 3 && j < 9); });
}

class RandomPart : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(RandomPart, JoinsLeadsAndRapidsKeepOffIt) {
  const Feature c = features()[static_cast<std::size_t>(std::get<0>(GetParam()))];
  SCOPED_TRACE(c.name);
  Shop shop(random_part(c, 17u + static_cast<unsigned>(std::get<1>(GetParam()))), c.frame, 2.5,
            c.frame.sense == Sense::kInward ? 20.0 : 30.0);
  shop.links.direction = std::get<1>(GetParam()) % 2 == 0 ? Direction::kZigzag : Direction::kOneWay;
  const bool zigzag = shop.links.direction == Direction::kZigzag;
  const Linked regions = shop.run();
  shop.links.order = PassOrder::kGiven;
  const Linked given = shop.run();
  EXPECT_LE(air_of(regions), air_of(given));
  EXPECT_EQ(given.retracts, shop.passes() - given.skipped_passes);
  EXPECT_EQ(given.joins + given.leads + given.straight_ends, 0u);

  shop.links.order = PassOrder::kRegions;
  shop.links.join_distance = 6.0;
  const Linked joined = shop.run();
  EXPECT_EQ(joined.retracts + joined.joins, shop.passes() - joined.skipped_passes);
  EXPECT_EQ(joined.retracts, descents(joined));
  if (zigzag) {
    EXPECT_LT(joined.retracts, 0.8 * static_cast<double>(given.retracts));
  }

  EXPECT_LE(air_of(joined), air_of(regions) * (1.0 + 1e-12));
  EXPECT_NEAR(joined.air_length, air_of(joined), 1e-9 * air_of(joined));
  expect_proven(shop, joined);

  shop.links.lead_radius = 1.5;
  const Linked led = shop.run();
  EXPECT_EQ(led.leads + led.straight_ends, 2 * led.retracts);
  expect_proven(shop, led);
  std::printf(
      "%-7s %-7s passes %zu: air given %.0f regions %.0f joined %.0f mm; retracts %zu -> %zu; leads %zu of "
      "%zu\n",
      c.name, zigzag ? "zigzag" : "one way", shop.passes(), given.air_length, regions.air_length,
      joined.air_length, static_cast<std::size_t>(given.retracts), static_cast<std::size_t>(joined.retracts),
      static_cast<std::size_t>(led.leads), static_cast<std::size_t>(led.leads + led.straight_ends));
}

TEST_P(RandomPart, WithoutJoinsAndLeadsEachPassStandsBetweenTwoLegsOfItsAxes) {
  const Feature c = features()[static_cast<std::size_t>(std::get<0>(GetParam()))];
  SCOPED_TRACE(c.name);
  Shop shop(random_part(c, 3), c.frame, 2.5, 20.0);
  const bool zigzag = std::get<1>(GetParam()) == 0;
  shop.links.direction = zigzag ? Direction::kZigzag : Direction::kOneWay;
  shop.links.order = PassOrder::kGiven;
  const std::vector<Move> moves = shop.run().moves;
  const sim::PartDistance parted(shop.part.mesh);
  std::size_t at = 0, rapid_ends = 0;
  // The tip, `up` over the pass's end along its axis, or on the clearance surface.
  const auto over = [&](const EnvelopePoint& p, double up) {
    return p.centre + p.axis * (std::min(up, shop.links.clearance_z - p.flat.z) - kRadius);
  };
  const auto take = [&](Point<Part> tip, Vec3 axis, MoveKind kind) {
    ASSERT_LT(at, moves.size());
    EXPECT_EQ(moves[at].kind, kind) << at;
    EXPECT_LT(distance(moves[at].pose.tip, tip), 1e-9) << at;
    EXPECT_LT(length(moves[at++].pose.axis - axis), 1e-12);
  };
  bool reversed = false;
  for (std::vector<Pass> slice : shop.slices) {
    if (slice.empty()) continue;
    if (reversed) std::reverse(slice.begin(), slice.end());
    for (Pass& pass : slice) {
      if (reversed) std::reverse(pass.begin(), pass.end());
      const EnvelopePoint &first = pass.front(), &last = pass.back();
      while (at < moves.size() && distance(moves[at].pose.tip, over(first, 1e9)) > 1e-9) {
        const double z =
            shop.field->deformation.flatten(moves[at].pose.tip + moves[at].pose.axis * kRadius).z;
        ASSERT_NEAR(z, shop.links.clearance_z, 1e-9);
        ASSERT_EQ(moves[at++].kind, MoveKind::kRapid);
      }
      take(over(first, 1e9), first.axis, MoveKind::kRapid);
      // The rapid ends where stock as thick as the approach could touch the ball.
      ASSERT_LT(at, moves.size());
      if (moves[at].kind == MoveKind::kRapid) {
        const Point<Part> centre = moves[at].pose.tip + moves[at].pose.axis * kRadius;
        const double up = dot(centre - first.centre, first.axis);
        EXPECT_GE(up, shop.links.approach - 1e-9);
        EXPECT_GE(parted.nearest(centre, 50.0).value, kRadius + shop.links.approach - 1e-6);
        take(over(first, up), first.axis, MoveKind::kRapid);
        ++rapid_ends;
      }
      take(over(first, 0.0), first.axis, MoveKind::kPlunge);
      for (std::size_t i = 1; i < pass.size(); ++i) take(over(pass[i], 0.0), pass[i].axis, MoveKind::kCut);
      take(over(last, 1e9), last.axis, MoveKind::kRapid);
    }
    if (zigzag) reversed = !reversed;
  }
  EXPECT_EQ(at, moves.size());
  EXPECT_GT(rapid_ends, shop.passes() / 2);
}

/// Only what lies this far (mm) inside the sheet's border is cut, so that passes end on the surface.
constexpr double kFrame = 5.0;

TEST_P(RandomPart, InsideAFrameLeadsAreTangentialAndStayAbove) {
  const Feature c = features()[static_cast<std::size_t>(std::get<0>(GetParam()))];
  SCOPED_TRACE(c.name);
  const auto outside = [&](const EnvelopePoint& p) {
    const Point<Flat> f = p.flat;
    return f.x < c.low.x + kFrame || f.x > c.high.x - kFrame || f.y < c.low.y + kFrame ||
           f.y > c.high.y - kFrame;
  };
  Shop shop(random_part(c, 40u + static_cast<unsigned>(std::get<1>(GetParam()))), c.frame, 2.5, 25.0,
            outside);
  shop.links.direction = std::get<1>(GetParam()) % 2 == 0 ? Direction::kZigzag : Direction::kOneWay;
  shop.links.lead_radius = 1.5;
  shop.links.join_distance = 4.0;
  int asked = 0;
  shop.links.allowed = [&](const EnvelopePoint& p) { return ++asked, !outside(p); };
  const Linked linked = shop.run();
  EXPECT_GE(asked, linked.joins > 0 ? 1 : 0);
  EXPECT_GE(linked.leads, 2u);
  expect_proven(shop, linked);
  const Deformation& map = shop.field->deformation;
  const auto reference = [](const Pose& p) { return p.tip + p.axis * kRadius; };
  std::size_t arcs = 0;
  for (std::size_t i = 8; i + 8 < linked.moves.size(); ++i) {
    const auto kind = [&](std::size_t k) { return linked.moves[k].kind; };
    const auto step = [&](std::size_t k) {
      return reference(linked.moves[k].pose) - reference(linked.moves[k - 1].pose);
    };
    if (kind(i) == MoveKind::kCut) {
      EnvelopePoint p;
      p.flat = map.flatten(reference(linked.moves[i].pose));
      EXPECT_FALSE(outside(p));
    }
    const bool in =
        kind(i - 1) == MoveKind::kPlunge && kind(i - 2) == MoveKind::kPlunge && kind(i) == MoveKind::kCut;
    const bool out = kind(i) == MoveKind::kPlunge && kind(i - 1) == MoveKind::kCut;
    if (!in && !out) continue;
    ++arcs;
    // The two chords at the touching point turn by half a step of the arc: a quarter circle and the slope's
    // 45 degrees in 8 moves at the most.
    EXPECT_LT(angle_between(step(i - 1), step(i)), 0.75 * kPi / 8.0 / 2.0 + 1e-6);
    // The arc's other end points along the axis, but for half a step and the axis's own turn.
    std::size_t end = i;
    if (in)
      for (end = i - 1; kind(end - 1) == MoveKind::kPlunge;) --end;
    else
      while (kind(end + 1) == MoveKind::kPlunge) ++end;
    const Vec3 last = in ? -step(end + 1) : step(end), axis = linked.moves[i - 1].pose.axis;
    EXPECT_LT(angle_between(last, axis), 0.75 * kPi / 8.0 / 2.0 + 1e-6);
    EXPECT_EQ(kind(in ? end - 1 : end + 1), MoveKind::kRapid);
  }
  EXPECT_GT(arcs, linked.leads / 2);
  std::printf("%-7s leads %zu of %zu, joins %zu\n", c.name, static_cast<std::size_t>(linked.leads),
              static_cast<std::size_t>(linked.leads + linked.straight_ends),
              static_cast<std::size_t>(linked.joins));
}

INSTANTIATE_TEST_SUITE_P(Modes, RandomPart, testing::Combine(testing::Range(0, 5), testing::Range(0, 2)));

}  // namespace
}  // namespace tiltfeed
