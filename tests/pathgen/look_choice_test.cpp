// Which of two ways of looking at places is kept, by what they cost.
#include "pathgen/envelope/look_choice.h"

#include <gtest/gtest.h>

#include <functional>

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr int kPlaces = 50'000;

struct Looked {
  double by_tree = 0.0;   ///< share of the places
  double cost = 0.0;      ///< mean at a place
  std::size_t spent = 0;  ///< told to has_tree
  std::size_t asked = 0;  ///< has_tree, how often
};

using Cost = std::function<std::size_t(int place)>;

/// `made_after`: so much spent makes the tree.
Looked look(const Cost& list, const Cost& tree, std::size_t made_after = 0) {
  LookChoice choice;
  Looked looked;
  for (int i = 0; i < kPlaces; ++i) {
    const bool by_tree = choice.by_tree();
    const std::size_t cost = (by_tree ? tree : list)(i);
    looked.by_tree += by_tree ? 1.0 / kPlaces : 0.0;
    looked.cost += static_cast<double>(cost) / kPlaces;
    choice.count(cost, [&](std::size_t spent) {
      looked.spent += spent, ++looked.asked;
      return looked.spent >= made_after;
    });
  }
  return looked;
}

Cost always(std::size_t cost) {
  return [cost](int) { return cost; };
}

/// Few places cost nearly all: one in 16.
Cost mostly_cheap(std::size_t mean) {
  return [mean](int place) { return place % 16 == 5 ? 15 * mean : mean / 15; };
}

TEST(LookChoice, KeepsToAShortList) {
  const Looked looked = look(always(20), always(2));
  EXPECT_EQ(looked.by_tree, 0.0);
  EXPECT_EQ(looked.asked, 0u);
}

TEST(LookChoice, TakesTheCheaperWay) {
  EXPECT_GT(look(always(500), always(60)).by_tree, 0.95);
  EXPECT_LT(look(always(100), always(400)).by_tree, 0.05);
  EXPECT_GT(look(mostly_cheap(500), mostly_cheap(100)).by_tree, 0.9);
  EXPECT_LT(look(mostly_cheap(500), mostly_cheap(2500)).by_tree, 0.1);
}

/// The list is dear at a few places only: the tree is better there and in the mean, though at most single
/// places the list is cheaper.
TEST(LookChoice, GoesByTheMean) {
  const Looked looked = look(mostly_cheap(450), always(100));
  EXPECT_GT(looked.by_tree, 0.9);
  EXPECT_LT(looked.cost, 120.0);
}

/// What is hundreds of times as dear is tried seldom: trials would cost the most.
TEST(LookChoice, SeldomTriesWhatIsFarDearer) {
  const Looked looked = look(always(50'000), always(100));
  EXPECT_GT(looked.by_tree, 0.99);
  EXPECT_LT(looked.cost, 150.0);
}

/// Slowly, by few trials.
TEST(LookChoice, ChangesWithThePart) {
  const Cost list = [](int place) { return place < kPlaces / 2 ? 1000u : 60u; };
  const Looked looked = look(list, always(200));
  EXPECT_GT(looked.by_tree, 0.45);
  EXPECT_LT(looked.by_tree, 0.9);
}

/// What the list cost is told but for the places before the mean was known to be much.
TEST(LookChoice, TellsWhatTheListCostUntilThereIsATree) {
  const Looked looked = look(always(200), always(10), 1'000'000);
  EXPECT_EQ(looked.spent, 1'000'000u);
  EXPECT_GT(looked.by_tree, 0.85);
}

}  // namespace
}  // namespace tiltfeed
