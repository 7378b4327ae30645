// The order of passes: closed forms, brute force, and a hundred thousand of them.
#include "pathgen/linking/link_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <utility>

#include "pathgen/linking/nearest_ends.h"

namespace tiltfeed {
using namespace pathgen;
namespace {
const AxisFrame kFlatFrame{AxisMode::kFixed, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.0};

Pass row(double from, double to, double y) {
  Pass pass;
  for (const double x : {from, to}) {
    EnvelopePoint p;
    p.flat = {x, y, 0.0}, p.centre = {x, y, 0.0}, p.axis = {0, 0, 1};
    pass.push_back(p);
  }
  return pass;
}

TEST(Order, ACombIsCutFingerByFinger) {
  std::vector<std::vector<Pass>> slices;
  for (int k = 0; k < 10; ++k) slices.push_back({row(0, 10, k), row(20, 30, k)});
  for (int k = 10; k < 12; ++k) slices.push_back({row(0, 30, k)});
  const Deformation map(kFlatFrame, 1.0);
  Linking links;
  links.clearance_z = 5.0;
  const Order zigzag = region_order(slices, map, links);
  Order expected;
  for (std::uint32_t k = 0; k < 10; ++k) expected.push_back({k, 0, k % 2 == 1});
  for (std::uint32_t k = 10; k < 12; ++k) expected.push_back({k, 0, k % 2 == 1});
  for (std::uint32_t k = 0; k < 10; ++k) expected.push_back({9 - k, 1, true});
  for (std::size_t i = 0; i < 10; ++i) expected[12 + i].reversed = zigzag[12].reversed != (i % 2 == 1);
  EXPECT_EQ(zigzag, expected);
  links.direction = Direction::kOneWay;
  const Order one_way = region_order(slices, map, links);
  ASSERT_EQ(one_way.size(), zigzag.size());
  for (std::size_t i = 1; i < one_way.size(); ++i) {
    EXPECT_FALSE(one_way[i].reversed);
    EXPECT_TRUE(one_way[i].slice == one_way[i - 1].slice + 1 || one_way[i].slice == 0 ||
                one_way[i].slice == 10);
  }
  EXPECT_EQ(plain_order(slices, Direction::kZigzag)[1], (Travelled{0, 1, false}));
  EXPECT_EQ(plain_order(slices, Direction::kZigzag)[2], (Travelled{1, 1, true}));
}

TEST(Order, HoldsAHundredThousandPassesOnceEachAndFinishesRegions) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> gap(0.3, 6.0);
  std::vector<std::vector<Pass>> slices;
  std::size_t count = 0;
  for (int k = 0; k < 1000; ++k) {
    slices.emplace_back();
    for (double x = gap(random); slices.back().size() < 100;) {
      const double to = x + gap(random);
      slices.back().push_back(row(x, to, k));
      x = to + gap(random), ++count;
    }
  }
  ASSERT_EQ(count, 100000u);
  const Deformation map(kFlatFrame, 1.0);
  Linking links;
  links.clearance_z = 5.0;
  const Order order = region_order(slices, map, links);
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  for (const Travelled& t : order) seen.insert({t.slice, t.pass});
  EXPECT_EQ(order.size(), count);
  EXPECT_EQ(seen.size(), count);
  // By brute force: a pass with one neighbour in the next slice that has but this one in turn is travelled
  // next to it, and the other way.
  const auto touching = [&](const Pass& pass, std::uint32_t slice) {
    std::vector<std::uint32_t> found;
    for (std::uint32_t p = 0; p < slices[slice].size(); ++p) {
      const Pass& other = slices[slice][p];
      if (other.front().flat.x <= pass.back().flat.x && pass.front().flat.x <= other.back().flat.x)
        found.push_back(p);
    }
    return found;
  };
  std::vector<std::vector<std::size_t>> place(slices.size(), std::vector<std::size_t>(100));
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i].slice][order[i].pass] = i;
  std::size_t pairs = 0;
  for (std::uint32_t s = 0; s + 1 < slices.size(); s += 9)
    for (std::uint32_t p = 0; p < slices[s].size(); ++p) {
      const auto next = touching(slices[s][p], s + 1);
      if (next.size() != 1 || touching(slices[s + 1][next[0]], s).size() != 1) continue;
      ++pairs;
      const std::size_t a = place[s][p], b = place[s + 1][next[0]];
      EXPECT_EQ(std::max(a, b) - std::min(a, b), 1u);
      EXPECT_NE(order[a].reversed, order[b].reversed);
    }
  EXPECT_GT(pairs, 500u);
}

TEST(Order, TheNearestEndIsTheNearest) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> grid(0, 9);  // many equals
  std::vector<Point<Part>> points;
  for (int i = 0; i < 700; ++i)
    points.push_back({1.0 * grid(random), 1.0 * grid(random), 1.0 * (grid(random) / 5)});
  NearestEnds ends(points);
  std::set<std::uint32_t> left;
  for (std::uint32_t i = 0; i < points.size(); ++i) left.insert(i);
  while (!left.empty()) {
    const Point<Part> from{0.9 * grid(random), 1.1 * grid(random), 0.5};
    std::uint32_t best = *left.begin();
    for (const std::uint32_t i : left)
      if (squared_length(points[i] - from) < squared_length(points[best] - from)) best = i;
    ASSERT_EQ(ends.nearest(from), best);
    ends.remove(best), left.erase(best);
  }
  EXPECT_FALSE(ends.nearest({0, 0, 0}));
}

/// Rows anywhere: the ways between them, of which the slowest of both axes counts from rest to rest,
/// against all orders and directions.
TEST(Order, OfTheLeastTimeIsNearTheBestOfAll) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(0.0, 100.0), size(10.0, 80.0);
  const Deformation map(kFlatFrame, 1.0);
  Linking links;
  links.clearance_z = 5.0, links.join_distance = 0.5;
  links.rapid.linear = {200.0, 1500.0};
  const auto seconds = [](const EnvelopePoint& a, const EnvelopePoint& b) {
    const double way = std::hypot(b.flat.x - a.flat.x, b.flat.y - a.flat.y), ramp = 200.0 * 200.0 / 1500.0;
    return way < ramp ? 2.0 * std::sqrt(way / 1500.0) : 200.0 / 1500.0 + way / 200.0;
  };
  double sum = 0.0, best_sum = 0.0;
  for (const Direction direction : {Direction::kZigzag, Direction::kOneWay})
    for (int round = 0; round < 40; ++round) {
      links.direction = direction;
      std::vector<std::vector<Pass>> slices;
      for (int k = 0; k < 5; ++k) {
        const double x = place(random);
        slices.push_back({row(x, x + size(random), place(random))});
      }
      const Order order = timed_order(slices, map, links);
      ASSERT_EQ(order.size(), slices.size());
      std::set<std::uint32_t> seen;
      const auto end = [&](const Travelled& t, bool first) -> const EnvelopePoint& {
        const Pass& pass = slices[t.slice][t.pass];
        return t.reversed == first ? pass.back() : pass.front();
      };
      const auto cost = [&](const Order& o) {
        double total = 0.0;
        for (std::size_t i = 1; i < o.size(); ++i) total += seconds(end(o[i - 1], false), end(o[i], true));
        return total;
      };
      for (const Travelled& t : order) {
        seen.insert(t.slice);
        EXPECT_FALSE(t.reversed && direction == Direction::kOneWay);
      }
      EXPECT_EQ(seen.size(), slices.size());
      EXPECT_EQ(order, timed_order(slices, map, links));
      // The first one is where the tool starts: all orders from there.
      std::vector<std::uint32_t> all{0, 1, 2, 3, 4};
      double best = 1e9;
      do {
        if (all.front() != order.front().slice) continue;
        for (unsigned turns = 0; turns < (direction == Direction::kZigzag ? 32u : 1u); ++turns) {
          Order o;
          for (std::uint32_t i = 0; i < 5; ++i) o.push_back({all[i], 0, (turns >> i & 1u) != 0});
          best = std::min(best, cost(o));
        }
      } while (std::next_permutation(all.begin(), all.end()));
      EXPECT_GE(cost(order), best - 1e-9);
      EXPECT_LT(cost(order), 1.5 * best);
      sum += cost(order), best_sum += best;
    }
  EXPECT_LT(sum, 1.08 * best_sum);
}

}  // namespace
}  // namespace tiltfeed
