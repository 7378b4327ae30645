// Rows that go all the way round, joined without turning back: nothing touches the part, every place is still
// passed as near by as rows do, the table turns back once, and no further than it is allowed.

#include "pathgen/linking/closed_row.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/shapes/link_shop.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kRho = 12.0, kStep = 1.5;
const AxisFrame kPoint{AxisMode::kPoint, Sense::kOutward, {5, -8, 3}, {1, 0, 0}, {0, 0, 1}, 0.0};

struct Wound {
  int turned_back = 0;                      ///< so often the table goes the other way than before
  double low = 0.0, high = 0.0, end = 0.0;  ///< turns since the first cut
  double cut = 0.0;                         ///< mm
  std::vector<Point<Part>> places;          ///< of the reference along the cuts, 0.1 mm apart
};

Wound wound(const Linked& linked, const Deformation& map) {
  Wound w;
  int sense = 0;
  for (std::size_t i = 1; i < linked.moves.size(); ++i) {
    if (linked.moves[i].kind != MoveKind::kCut) continue;
    const Pose &a = linked.moves[i - 1].pose, &b = linked.moves[i].pose;
    const Point<Part> from = a.tip + a.axis * kRadius, to = b.tip + b.axis * kRadius;
    const double turn = std::remainder((map.flatten(to).x - map.flatten(from).x) / map.period_x(), 1.0);
    w.end += turn, w.cut += distance(a.tip, b.tip);
    w.low = std::min(w.low, w.end), w.high = std::max(w.high, w.end);
    if (const int now = turn > 1e-6 ? 1 : turn < -1e-6 ? -1 : 0; now != 0) {
      w.turned_back += sense != 0 && now != sense ? 1 : 0;
      sense = now;
    }
    const int steps = 1 + static_cast<int>(distance(from, to) / 0.1);
    for (int k = 1; k <= steps; ++k) w.places.push_back(from + (to - from) * (1.0 * k / steps));
  }
  return w;
}

/// How far places from the first row to the last are from the nearest cut at most, mm.
double furthest_between(const Wound& w, const Shop& shop) {
  const Deformation& map = shop.field->deformation;
  const double first = shop.slices.front()[0][0].flat.y, last = shop.slices.back()[0][0].flat.y;
  double furthest = 0.0;
  for (double y = first; y <= last; y += 0.25 * kStep)
    for (double x = -0.48; x < 0.5; x += 0.07) {
      const Point<Part> at = map.unflatten({x * map.period_x(), y, kRho + kRadius});
      double nearest = 1e9;
      for (const Point<Part> p : w.places) nearest = std::min(nearest, squared_length(p - at));
      furthest = std::max(furthest, std::sqrt(nearest));
    }
  return furthest;
}

TEST(ClosedRows, GoOnTheSameWayRoundAndBackInTheMiddle) {
  Shop shop(whole(kPoint, kRho), kPoint, kStep);
  const auto rows = static_cast<int>(shop.passes());
  for (const auto& slice : shop.slices)
    for (const Pass& pass : slice) ASSERT_TRUE(goes_round(pass));
  shop.links.join_distance = 2.0 * kStep;
  const Linked apart = shop.run();
  const Deformation& map = shop.field->deformation;
  const Wound before = wound(apart, map);
  EXPECT_EQ(before.turned_back, rows - 1) << "to and fro";
  EXPECT_EQ(apart.closed_rows, static_cast<std::uint64_t>(rows));

  shop.links.rounds = 1000;
  const Linked joined = shop.run();
  expect_proven(shop, joined);
  const Wound now = wound(joined, map);
  EXPECT_EQ(now.turned_back, 1);
  EXPECT_LE(std::abs(now.end), 2.5) << "as many back as forth";
  EXPECT_EQ(joined.retracts, 1u);
  // The turn in the middle takes a ring more, the last one, too.
  EXPECT_LE(now.cut, before.cut + 2.0 * 2.0 * kPi * (kRho + kRadius));
  EXPECT_LE(furthest_between(now, shop), furthest_between(before, shop) + 0.02);

  shop.links.rounds = 4;
  const Linked held = shop.run();
  expect_proven(shop, held);
  const Wound few = wound(held, map);
  EXPECT_GT(few.turned_back, 1);
  EXPECT_LE(std::max(-few.low, few.high), 4.1);
  EXPECT_LE(furthest_between(few, shop), furthest_between(before, shop) + 0.02);

  shop.links.direction = Direction::kOneWay;
  const Linked one_way = shop.run();
  expect_proven(shop, one_way);
  const Wound on = wound(one_way, map);
  EXPECT_EQ(on.turned_back, 0);
  EXPECT_NEAR(on.end, rows + 1.0, 1.1);
}

TEST(ClosedRows, BeginAnywhereWithEveryPoint) {
  const Shop shop(whole(kPoint, kRho), kPoint, kStep);
  const Pass& row = shop.slices[7][0];
  const double period = shop.field->deformation.period_x();
  for (const bool reversed : {false, true})
    for (const std::size_t at : {std::size_t{0}, row.size() / 3, row.size() - 2}) {
      const Pass turned = begun_near(row, reversed, row[at].centre);
      ASSERT_EQ(turned.size(), row.size());
      EXPECT_LE(distance(turned.front().centre, turned.back().centre), 1e-6);
      EXPECT_LE(distance(turned.front().centre, row[at].centre), 0.6);
      EXPECT_NEAR(turned.back().flat.x - turned.front().flat.x, reversed ? -period : period, 1e-6);
      for (std::size_t i = 1; i < turned.size(); ++i) {
        const double step = turned[i].flat.x - turned[i - 1].flat.x;
        EXPECT_GT(reversed ? -step : step, 0.0);
        EXPECT_EQ(std::count_if(
                      row.begin() + 1, row.end(),
                      [&](const EnvelopePoint& p) { return distance(p.centre, turned[i].centre) < 1e-6; }),
                  1);
      }
    }
  Pass open(row.begin(), row.end() - 1);
  EXPECT_FALSE(goes_round(open));
}

}  // namespace
}  // namespace tiltfeed
