// Links of random paths with random choices: the cuts are what they were, and the tool leaves and comes to
// them along its axis.

#include "daemon/plan/link_choice.h"

#include <gtest/gtest.h>

#include <random>

namespace tiltfeed::daemon {
namespace {

struct LinkDice {
  std::mt19937 random;
  double operator()(double low, double high) { return std::uniform_real_distribution(low, high)(random); }
  int below(int count) { return std::uniform_int_distribution(0, count - 1)(random); }
  Vec3 axis() { return normalized(Vec3{(*this)(-1, 1), (*this)(-1, 1), (*this)(0.3, 1)}); }
  Point<Part> tip() { return {(*this)(-40, 40), (*this)(-40, 40), (*this)(-40, 40)}; }
};

Pose over(const Pose& pose, double by) { return {pose.tip + pose.axis * by, pose.axis}; }

/// Passes of some cuts, each with a plunge before it; between them up, across in some moves, and down.
ToolPath random_path(LinkDice& dice) {
  ToolPath path;
  path.cut_feed = Feed::from_mm_per_min(900), path.plunge_feed = Feed::from_mm_per_min(300);
  const auto put = [&](const Pose& pose, MoveKind kind) { path.moves.push_back({pose, kind, kNoFacet}); };
  const int passes = 1 + dice.below(5);
  Vec3 axis = dice.axis();
  for (int pass = 0; pass < passes; ++pass) {
    if (dice.below(3) > 0) axis = dice.axis();
    Pose at{dice.tip(), axis};
    put(over(at, 20), MoveKind::kRapid);
    if (dice.below(2) > 0) put(over(at, 1), MoveKind::kRapid);
    put(at, MoveKind::kPlunge);
    for (int cut = 0; cut <= dice.below(4); ++cut) {
      at = {dice.tip(), axis};
      put(at, MoveKind::kCut);
    }
    if (dice.below(2) > 0)
      path.feeds.push_back(
          {static_cast<std::uint32_t>(path.moves.size() - 1), Feed::from_mm_per_min(dice(200, 2000))});
    put(over(at, 20), MoveKind::kRapid);
    for (int way = dice.below(3); way > 0; --way) put({dice.tip(), dice.axis()}, MoveKind::kRapid);
  }
  return path;
}

std::vector<Move> cuts_of(const ToolPath& path) {
  std::vector<Move> cuts;
  for (const Move& move : path.moves)
    if (move.kind == MoveKind::kCut) cuts.push_back(move);
  return cuts;
}

std::vector<double> feeds_of(const ToolPath& path) {
  std::vector<double> feeds;
  for (std::size_t i = 0; i < path.moves.size(); ++i)
    if (path.moves[i].kind == MoveKind::kCut) feeds.push_back(feed_of(path, i).mm_per_min());
  return feeds;
}

/// Whether q lies from p on along the axis that both have.
bool along_axis(const Pose& p, const Pose& q) {
  const Vec3 way = q.tip - p.tip;
  return length(p.axis - q.axis) < 1e-12 && length(way - p.axis * dot(way, p.axis)) < 1e-9;
}

TEST(LinkChoice, AreTheRapidsBetweenTheCuts) {
  LinkDice dice{std::mt19937(5)};
  for (int run = 0; run < 500; ++run) {
    const ToolPath path = random_path(dice);
    const std::vector<LinkWay> ways = link_ways(path);
    for (std::size_t i = 0; i < path.moves.size(); ++i) {
      const auto in = std::count_if(ways.begin(), ways.end(), [&](const LinkWay& way) { return way.has(i); });
      const auto rapid = std::count_if(ways.begin(), ways.end(),
                                       [&](const LinkWay& way) { return i >= way.first && i < way.last; });
      EXPECT_EQ(in, path.moves[i].kind == MoveKind::kCut ? 0 : 1) << run << " " << i;
      EXPECT_EQ(rapid, path.moves[i].kind == MoveKind::kRapid ? 1 : 0) << run << " " << i;
    }
    EXPECT_EQ(ways.front().first, 0u);
    EXPECT_EQ(ways.back().last, path.moves.size());
    EXPECT_EQ(with_links(path, std::vector<std::size_t>(ways.size(), 0)).moves.size(), path.moves.size());
  }
}

TEST(LinkChoice, OtherChoicesLeaveTheCutsAsTheyAre) {
  LinkDice dice{std::mt19937(7)};
  std::size_t longer = 0;
  for (int run = 0; run < 500; ++run) {
    const ToolPath path = random_path(dice);
    const std::vector<LinkWay> ways = link_ways(path);
    std::vector<std::size_t> choices;
    for (std::size_t i = 0; i < ways.size(); ++i)
      choices.push_back(static_cast<std::size_t>(dice.below(static_cast<int>(kLinkChoices.size()))));
    // A way to the first cut, or from the last one, has its retract already.
    for (std::size_t* const end : {&choices.front(), &choices.back()})
      if (kLinkChoices[*end].at_retract) *end = 0;
    std::vector<std::size_t> begins;
    const ToolPath made = with_links(path, choices, &begins);
    const auto before = cuts_of(path), after = cuts_of(made);
    ASSERT_EQ(before.size(), after.size()) << run;
    for (std::size_t i = 0; i < before.size(); ++i) {
      EXPECT_EQ(before[i].pose, after[i].pose) << run;
      EXPECT_EQ(before[i].kind, after[i].kind) << run;
    }
    EXPECT_EQ(feeds_of(path), feeds_of(made)) << run;
    const std::vector<LinkWay> anew = link_ways(made);
    ASSERT_EQ(anew.size(), ways.size()) << run;
    for (std::size_t i = 0; i < anew.size(); ++i) {
      const LinkChoice& choice = kLinkChoices[choices[i]];
      // The stretch behind a retract begins over the next cut, with a rapid to its axis.
      const auto in =
          std::count_if(begins.begin(), begins.end(), [&](std::size_t move) { return anew[i].has(move); });
      EXPECT_EQ(in, choice.at_retract ? 1 : 0) << run << " " << i;
      for (const std::size_t move : begins)
        if (anew[i].has(move)) {
          EXPECT_EQ(made.moves[move].kind, MoveKind::kRapid) << run << " " << i;
          EXPECT_TRUE(along_axis(made.moves[anew[i].end - 1].pose, made.moves[move].pose)) << run << " " << i;
          EXPECT_TRUE(along_axis(made.moves[anew[i].begin - 1].pose, made.moves[move - 1].pose))
              << run << " " << i;
        }
      if (choice.higher == 0.0) continue;
      // All between the cuts, but for the plunge that was there.
      const bool first = i == 0, last = i + 1 == anew.size();
      const std::size_t begin = anew[i].begin, end = anew[i].end - (last ? 0 : 1);
      ASSERT_GT(end - begin, 1u);
      const Pose down = made.moves[end - 1].pose, ahead = made.moves[end - 2].pose;
      if (!first) {
        const Pose &cut = made.moves[begin - 1].pose, &above = made.moves[begin].pose;
        EXPECT_TRUE(along_axis(cut, above)) << run << " " << i;
        if (!last) {
          EXPECT_GE(dot(above.tip - cut.tip, cut.axis), choice.higher - 1e-9) << run << " " << i;
        }
      }
      if (!last) {
        const Pose& top = first ? made.moves[begin].pose : ahead;
        EXPECT_TRUE(along_axis(ahead, down)) << run << " " << i;
        EXPECT_GE(dot(top.tip - down.tip, down.axis), choice.higher - 1e-9) << run << " " << i;
      }
      if (!first && !last) {
        const MoveKind along = choice.at_feed ? MoveKind::kPlunge : MoveKind::kRapid;
        EXPECT_EQ(made.moves[begin].kind, along);
        EXPECT_EQ(made.moves[end - 1].kind, along);
      }
      if (!first && !last && choice.turn != LinkTurn::kOnTheWay) {
        // Across with one axis, and the turn with the tip held.
        ASSERT_LE(end - begin, 4u);
        for (std::size_t k = begin; k < end; ++k) {
          const Pose &p = made.moves[k - 1].pose, &q = made.moves[k].pose;
          EXPECT_TRUE(length(p.axis - q.axis) < 1e-12 || distance(p.tip, q.tip) < 1e-9) << run << " " << i;
        }
      }
      ++longer;
    }
  }
  EXPECT_GT(longer, 500u);
}

TEST(LinkChoice, ATurnIsAnotherWayOnlyWhereTheAxisTurns) {
  LinkDice dice{std::mt19937(9)};
  for (int run = 0; run < 200; ++run) {
    const ToolPath path = random_path(dice);
    const std::vector<LinkWay> ways = link_ways(path);
    for (std::size_t i = 0; i < ways.size(); ++i)
      for (std::size_t choice = 1; choice < kLinkChoices.size(); ++choice) {
        const bool turns = kLinkChoices[choice].turn != LinkTurn::kOnTheWay;
        const bool ends = i == 0 || i + 1 == ways.size();
        const bool retract = kLinkChoices[choice].at_retract;
        const bool axes =
            !ends && path.moves[ways[i].first - 1].pose.axis != path.moves[ways[i].last].pose.axis;
        EXPECT_EQ(differs(path, i, choice), retract ? !ends : !turns || axes) << run << " " << i;
      }
  }
}

}  // namespace
}  // namespace tiltfeed::daemon
