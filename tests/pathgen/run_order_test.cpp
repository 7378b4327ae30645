// The order of runs by the time of their links: against all orders by brute force, and as a way in closed
// form.
#include "pathgen/linking/run_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace tiltfeed {
using namespace pathgen;
namespace {

LinkTime::Options rates() {
  LinkTime::Options o;
  o.rapid = {{250.0, 2000.0}, {60.0, 600.0}, {240.0, 1200.0}};
  o.centre = {0, 0, 0}, o.radius = 60.0;
  o.lift = 5.0, o.short_way = 30.0, o.short_turn = Angle::from_radians(1.0);
  o.plunge_seconds = 0.1;
  return o;
}
const Point<Part> kStart{0, 0, 60};
const Vec3 kUp{0, 0, 1};

/// Runs on a ball of 40 mm, the tool square to it.
std::vector<RunEnds> some_runs(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> turn(-kPi, kPi), tilt(0.1, 1.5);
  const auto pose = [](double lean, double round) {
    const Vec3 axis{std::sin(lean) * std::cos(round), std::sin(lean) * std::sin(round), std::cos(lean)};
    return Pose{Point<Part>{0, 0, 0} + axis * 40.0, axis};
  };
  std::vector<RunEnds> runs;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = tilt(random), a = turn(random);
    runs.push_back({pose(t, a), pose(t, a + 0.6)});
  }
  return runs;
}

double ours(const std::vector<RunEnds>& runs, bool reversible, const LinkTime& time) {
  return time_of_order(order_runs(runs, reversible, time, kStart, kUp), runs, time, kStart, kUp);
}

/// The least of all orders and senses.
double best_of_all(const std::vector<RunEnds>& runs, bool reversible, const LinkTime& time) {
  std::vector<std::uint32_t> sequence(runs.size());
  std::iota(sequence.begin(), sequence.end(), 0u);
  double best = std::numeric_limits<double>::infinity();
  do {
    for (std::uint32_t senses = 0; senses < (reversible ? 1u << runs.size() : 1u); ++senses) {
      std::vector<OrderedRun> order;
      for (const std::uint32_t run : sequence) order.push_back({run, (senses >> run & 1u) != 0});
      best = std::min(best, time_of_order(order, runs, time, kStart, kUp));
    }
  } while (std::next_permutation(sequence.begin(), sequence.end()));
  return best;
}

TEST(RunOrder, IsNearTheBestOfAllOrdersOfFewRuns) {
  const LinkTime time(rates());
  double all = 0.0, least = 0.0;
  int best = 0;
  for (unsigned seed = 1; seed <= 12; ++seed)
    for (const bool reversible : {false, true}) {
      const auto runs = some_runs(reversible ? 6 : 7, seed);
      const double found = ours(runs, reversible, time), bound = best_of_all(runs, reversible, time);
      EXPECT_GE(found, bound - 1e-9);
      EXPECT_LE(found, 1.12 * bound) << "seed " << seed << " reversible " << reversible;
      all += found, least += bound;
      best += found < bound + 1e-9 ? 1 : 0;
    }
  EXPECT_LE(all, 1.02 * least);
  EXPECT_GE(best, 12) << "of 24";
}

TEST(RunOrder, HoldsEachRunOnceAndTurnsNoneThatMustNotBe) {
  const LinkTime time(rates());
  for (const bool reversible : {false, true}) {
    const auto runs = some_runs(150, 7);
    const auto order = order_runs(runs, reversible, time, kStart, kUp);
    EXPECT_EQ(order, order_runs(runs, reversible, time, kStart, kUp));
    std::vector<int> seen(runs.size(), 0);
    bool turned = false;
    for (const OrderedRun& r : order) ++seen[r.run], turned |= r.reversed;
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), 150);
    EXPECT_EQ(turned, reversible);
  }
}

/// To the nearest in time, each time.
double nearest_neighbours(const std::vector<RunEnds>& runs, bool reversible, const LinkTime& time) {
  std::vector<bool> gone(runs.size(), false);
  std::vector<OrderedRun> order;
  while (order.size() < runs.size()) {
    double least = std::numeric_limits<double>::infinity();
    OrderedRun best;
    for (std::uint32_t i = 0; i < runs.size(); ++i)
      for (const bool reversed : {false, true}) {
        if (gone[i] || (reversed && !reversible)) continue;
        std::vector<OrderedRun> longer = order;
        longer.push_back({i, reversed});
        const double all = time_of_order(longer, runs, time, kStart, kUp);
        if (all < least) least = all, best = {i, reversed};
      }
    order.push_back(best), gone[best.run] = true;
  }
  return time_of_order(order, runs, time, kStart, kUp);
}

TEST(RunOrder, ExchangesSaveTimeOfTheNearestNeighbours) {
  const LinkTime time(rates());
  for (const bool reversible : {false, true})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const auto runs = some_runs(80, seed);
      EXPECT_LE(ours(runs, reversible, time), 0.97 * nearest_neighbours(runs, reversible, time)) << seed;
    }
}

/// From rest to rest.
double in_time(double way, double v, double a) {
  const double ramp = v / a;
  return way > v * ramp ? 2.0 * ramp + (way - v * ramp) / v : 2.0 * std::sqrt(way / a);
}

TEST(RunOrder, WaysTakeWhatTheirAxesTake) {
  const LinkTime time(rates());
  const Pose top{{0, 0, 40}, {0, 0, 1}}, side{{40, 0, 0}, {1, 0, 0}}, aside{{0, 40, 0}, {0, 1, 0}};
  const Pose beside{{10, 0, 40}, {0, 0, 1}};
  const double up = in_time(20.0, 250.0, 2000.0), over = in_time(30.0 * kPi, 250.0, 2000.0);
  // The tilt's 90 degrees take longer than the way.
  EXPECT_NEAR(time.between(top, side), 2.0 * up + in_time(90.0, 60.0, 600.0) + 0.1, 1e-9);
  EXPECT_GT(in_time(90.0, 60.0, 600.0), over);
  // The table's take less than the tip over the sphere.
  EXPECT_NEAR(time.between(side, aside), 2.0 * up + std::max(over, in_time(90.0, 240.0, 1200.0)) + 0.1, 1e-9);
  EXPECT_NEAR(time.between(top, beside),
              2.0 * in_time(5.0, 250.0, 2000.0) + in_time(10.0, 250.0, 2000.0) + 0.1, 1e-9);
  EXPECT_NEAR(time.between(beside, top), time.between(top, beside), 1e-12);
  EXPECT_NEAR(time.from_above(kStart, kUp, side), in_time(90.0, 60.0, 600.0) + up + 0.1, 1e-9);
}

TEST(RunOrder, APathTakesTheTimeOfItsRapidsAndPlunges) {
  const LinkTime time(rates());
  const Vec3 axis{0, 0, 1};
  const auto at = [&](double x, double z) { return Pose{{x, 0, z}, axis}; };
  const std::vector<Move> moves{
      {at(0, 60), MoveKind::kRapid, kNoFacet}, {at(0, 10), MoveKind::kRapid, kNoFacet},
      {at(0, 0), MoveKind::kPlunge, kNoFacet}, {at(7, 0), MoveKind::kCut, kNoFacet},
      {at(7, 60), MoveKind::kRapid, kNoFacet}, {at(20, 60), MoveKind::kRapid, kNoFacet},
      {at(40, 60), MoveKind::kRapid, kNoFacet}};
  EXPECT_NEAR(time.of(moves), in_time(50.0, 250.0, 2000.0) + 0.1 + in_time(93.0, 250.0, 2000.0), 1e-9);
}

}  // namespace
}  // namespace tiltfeed
