// The choice of few directions and their order, against exhaustive search.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>

#include "pathgen/indexed/index_order.h"
#include "pathgen/indexed/set_cover.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

using Sets = std::vector<std::vector<std::uint8_t>>;

std::uint32_t held_by(const Sets& sets, const std::vector<std::uint32_t>& some) {
  std::uint32_t sum = 0;
  for (std::size_t e = 0; e < sets[0].size(); ++e)
    sum += std::any_of(some.begin(), some.end(), [&](std::uint32_t s) { return sets[s][e] != 0; }) ? 1 : 0;
  return sum;
}

std::vector<std::uint32_t> members(std::uint32_t bits) {
  std::vector<std::uint32_t> all;
  for (std::uint32_t s = 0; bits >> s != 0; ++s)
    if ((bits >> s & 1u) != 0) all.push_back(s);
  return all;
}

struct Random {
  std::mt19937_64 engine;
  explicit Random(std::uint64_t seed) : engine(seed) {}
  double unit() { return static_cast<double>(engine() >> 11) * 0x1p-53; }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(engine() % n); }
  Vec3 direction() {
    const double z = 2.0 * unit() - 1.0, turn = 2.0 * kPi * unit(), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
  }
};

struct Case {
  Sets sets;
  double share = 1.0;
};

Case random_case(Random& random) {
  Case c;
  const std::uint32_t count = 4 + random.below(8), elements = 6 + random.below(30);
  const double fill = 0.1 + 0.4 * random.unit();
  for (std::uint32_t s = 0; s < count; ++s) {
    c.sets.emplace_back();
    for (std::uint32_t e = 0; e < elements; ++e) c.sets.back().push_back(random.unit() < fill ? 1 : 0);
  }
  c.share = random.below(2) == 0 ? 1.0 : 0.9;
  return c;
}

/// The fewest sets that hold `wanted`.
std::uint32_t fewest(const Case& c, std::uint32_t wanted) {
  auto least = static_cast<std::uint32_t>(c.sets.size());
  for (std::uint32_t bits = 0; bits < 1u << c.sets.size(); ++bits)
    if (const auto size = static_cast<std::uint32_t>(std::popcount(bits));
        size < least && held_by(c.sets, members(bits)) >= wanted)
      least = size;
  return least;
}

TEST(SetCover, IsWithinOneOfTheFewestAndMostlyThat) {
  Random random(1);
  int optimal = 0;
  constexpr int kCases = 300;
  for (int i = 0; i < kCases; ++i) {
    const Case c = random_case(random);
    std::vector<std::uint32_t> all(c.sets.size());
    std::iota(all.begin(), all.end(), 0u);
    const auto wanted = static_cast<std::uint32_t>(std::ceil(c.share * held_by(c.sets, all) - 1e-9));
    const SetCover found = cover_by_few(c.sets, c.share, 99);
    ASSERT_EQ(found.held, held_by(c.sets, found.chosen)) << i;
    ASSERT_GE(found.held, wanted) << i;
    const std::uint32_t least = fewest(c, wanted);
    ASSERT_LE(found.chosen.size(), least + 1) << i;
    optimal += found.chosen.size() == least ? 1 : 0;
    for (const std::uint32_t s : found.chosen) {
      std::vector<std::uint32_t> rest = found.chosen;
      std::erase(rest, s);
      ASSERT_LT(held_by(c.sets, rest), wanted) << "set " << s << " is not needed in case " << i;
    }
  }
  EXPECT_GE(optimal, kCases * 95 / 100);
}

TEST(SetCover, HoldsNearlyAsMuchAsAnyWhereTooFewAreAllowed) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Case c = random_case(random);
    const std::uint32_t most = 1 + random.below(3);
    const SetCover found = cover_by_few(c.sets, 1.0, most);
    ASSERT_LE(found.chosen.size(), most);
    std::uint32_t best = 0;
    for (std::uint32_t bits = 0; bits < 1u << c.sets.size(); ++bits)
      if (std::popcount(bits) <= static_cast<int>(most))
        best = std::max(best, held_by(c.sets, members(bits)));
    ASSERT_GE(found.held, 0.85 * best) << i;
    ASSERT_LE(found.held, best) << i;
  }
}

/// Does each of the sets alone hold at least so many elements?
bool worth_it(const Sets& sets, const std::vector<std::uint32_t>& some, double least) {
  return std::all_of(some.begin(), some.end(), [&](std::uint32_t s) {
    std::vector<std::uint32_t> rest = some;
    std::erase(rest, s);
    return held_by(sets, some) - held_by(sets, rest) >= least - 1e-9;
  });
}

/// Against the most that any such family holds; without the stop nothing changes.
TEST(SetCover, LeavesOutSetsThatAddTooLittle) {
  Random random(3);
  constexpr int kCases = 150;
  double shares = 0.0;
  int fewer = 0;
  for (int i = 0; i < kCases; ++i) {
    const Case c = random_case(random);
    std::vector<std::uint32_t> every(c.sets.size());
    std::iota(every.begin(), every.end(), 0u);
    const std::uint32_t all = held_by(c.sets, every);
    const double gain = 0.03 * random.below(6);
    const SetCover found = cover_by_few(c.sets, c.share, 99, gain), plain = cover_by_few(c.sets, c.share, 99);
    ASSERT_EQ(found.held, held_by(c.sets, found.chosen)) << i;
    ASSERT_TRUE(worth_it(c.sets, found.chosen, gain * all)) << i;
    if (gain == 0.0) {
      ASSERT_EQ(found.chosen, plain.chosen) << i;
    }
    std::uint32_t best = 0;
    for (std::uint32_t bits = 0; bits < 1u << c.sets.size(); ++bits)
      if (const auto some = members(bits); worth_it(c.sets, some, gain * all))
        best = std::max(best, held_by(c.sets, some));
    const double share = found.held / std::min<double>(best, std::ceil(c.share * all - 1e-9));
    ASSERT_GE(share, 0.6) << i;
    shares += std::min(share, 1.0);
    fewer += found.chosen.size() < plain.chosen.size() ? 1 : 0;
  }
  EXPECT_GT(fewer, 15);
  EXPECT_GT(shares, 0.97 * kCases);
}

/// Greedy takes the large set in the middle first and ends with three; two suffice.
TEST(SetCover, ExchangesWhatGreedyTakesFirst) {
  const Sets sets{{1, 1, 1, 1, 0, 0, 0, 0}, {0, 0, 0, 0, 1, 1, 1, 1}, {0, 1, 1, 1, 1, 1, 1, 0}};
  const SetCover found = cover_by_few(sets, 1.0, 9);
  EXPECT_EQ(found.chosen, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(found.held, 8u);
}

/// Pairs of a cube's sides that are not opposite: two opposite pairs taken first leave two sides that no pair
/// holds; three pairs suffice.
TEST(SetCover, ThreeDirectionsHoldTheSixSidesOfACube) {
  Sets sets;
  for (const auto& [a, b] : {std::array{0, 2},
                             {1, 3},
                             {0, 3},
                             {0, 4},
                             {0, 5},
                             {1, 2},
                             {1, 4},
                             {1, 5},
                             {2, 4},
                             {2, 5},
                             {3, 4},
                             {3, 5}}) {
    sets.emplace_back(6, 0);
    sets.back()[a] = sets.back()[b] = 1;
  }
  EXPECT_EQ(cover_by_few(sets, 1.0, 9).chosen.size(), 3u);
}

TEST(SetCover, NothingToCoverNeedsNothing) {
  EXPECT_TRUE(cover_by_few({}, 1.0, 5).chosen.empty());
  EXPECT_TRUE(cover_by_few({{0, 0}, {0, 0}}, 1.0, 5).chosen.empty());
}

TEST(IndexOrder, IsTheBestOfAllOrders) {
  Random random(3);
  for (int i = 0; i < 60; ++i) {
    const Vec3 up = random.direction();
    std::vector<Vec3> directions;
    const std::uint32_t count = 1 + random.below(6);
    for (std::uint32_t k = 0; k < count; ++k) directions.push_back(random.direction());
    if (i % 3 == 0) directions[0] = up;
    const auto travel = [&](const std::vector<std::uint32_t>& order) {
      Vec3 at = up;
      double sum = 0.0;
      for (const std::uint32_t k : order)
        sum += rotary_travel(at, directions[k], up).radians(), at = directions[k];
      return sum;
    };
    std::vector<std::uint32_t> any(count);
    std::iota(any.begin(), any.end(), 0u);
    const auto found = order_by_travel(directions, up);
    ASSERT_TRUE(std::is_permutation(found.begin(), found.end(), any.begin(), any.end()));
    double best = travel(any);
    while (std::next_permutation(any.begin(), any.end())) best = std::min(best, travel(any));
    EXPECT_NEAR(travel(found), best, 1e-12) << i;
  }
}

TEST(IndexOrder, TravelIsTheGreaterOfTiltAndTurn) {
  const Vec3 up{0, 0, 1};
  const auto at = [](double tilt, double turn) {
    const double t = tilt * kPi / 180, u = turn * kPi / 180;
    return Vec3{std::sin(t) * std::cos(u), std::sin(t) * std::sin(u), std::cos(t)};
  };
  EXPECT_NEAR(rotary_travel(up, at(40, 200), up).degrees(), 40, 1e-9) << "the table need not turn";
  EXPECT_NEAR(rotary_travel(at(30, 10), at(50, 15), up).degrees(), 20, 1e-9);
  EXPECT_NEAR(rotary_travel(at(30, 10), at(50, 100), up).degrees(), 90, 1e-9);
  EXPECT_NEAR(rotary_travel(at(90, -170), at(90, 170), up).degrees(), 20, 1e-9) << "the short way";
}

TEST(IndexOrder, TurnsNeverTiltFurtherThanTheirEnds) {
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    const Vec3 up = random.direction(), from = i % 5 == 0 ? up : random.direction(), to = random.direction();
    const auto turns = turns_between(from, to, up, Angle::from_degrees(5.0));
    EXPECT_EQ(turns.front(), from);
    EXPECT_EQ(turns.back(), to);
    const double most = std::max(angle_between(from, up), angle_between(to, up));
    for (std::size_t k = 0; k < turns.size(); ++k) {
      EXPECT_LE(angle_between(turns[k], up), most + 1e-9) << i;
      EXPECT_NEAR(length(turns[k]), 1.0, 1e-12);
      if (k == 0) continue;
      EXPECT_LE(angle_between(turns[k - 1], turns[k]), 5.0 * kPi / 180 + 1e-9) << i;
    }
  }
}

/// Directions on a spiral from `up` down are best gone along it; however they are listed, the order found for
/// more of them than are ordered exactly is no more than a little longer.
TEST(IndexOrder, OfManyDirectionsIsNearlyTheShortest) {
  const Vec3 up{0, 0, 1};
  std::vector<Vec3> spiral;
  for (int i = 0; i < 28; ++i) {
    const double tilt = 0.3 + 0.04 * i, turn = 0.2 * i;
    spiral.push_back({std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)});
  }
  const auto travel = [&](const std::vector<Vec3>& all) {
    double sum = 0.0;
    Vec3 at = up;
    for (const Vec3 d : all) sum += rotary_travel(at, d, up).radians(), at = d;
    return sum;
  };
  std::mt19937 random(5);
  for (int round = 0; round < 10; ++round) {
    std::vector<Vec3> listed = spiral, ordered;
    std::shuffle(listed.begin(), listed.end(), random);
    const auto order = order_by_travel(listed, up);
    ASSERT_EQ(order.size(), listed.size());
    for (const std::uint32_t i : order) ordered.push_back(listed[i]);
    EXPECT_LE(travel(ordered), 1.1 * travel(spiral)) << round;
    EXPECT_GE(travel(listed), 2.0 * travel(ordered));
    auto each = order;
    std::sort(each.begin(), each.end());
    for (std::uint32_t i = 0; i < each.size(); ++i) EXPECT_EQ(each[i], i);
  }
}

}  // namespace
}  // namespace tiltfeed
