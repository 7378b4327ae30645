// Speeds that follow loads: against the limits asked span by span, and moves at these speeds against their
// ways and times summed up.

#include "daemon/plan/feed_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "daemon/plan/moves_at_speeds.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/timing/timing.h"

namespace tiltfeed::daemon {
namespace {

std::vector<LoadSpan> random_spans(std::mt19937& random, std::size_t count) {
  std::uniform_real_distribution<double> any(0.0, 1.0);
  std::vector<LoadSpan> spans;
  double at = 0.5, level = 0.5;
  for (std::size_t i = 0; i < count; ++i) {
    if (any(random) < 0.05) at += any(random);   // a rapid
    if (any(random) < 0.1) level = any(random);  // another engagement
    const double seconds = 0.005 + 0.05 * any(random);
    LoadSpan span{at, at + seconds, 0.2 + 0.1 * any(random)};
    if (level > 0.2) {
      span.chip = 1000.0 * level * (0.9 + 0.2 * any(random));
      span.edge_load = 50.0 * level * any(random), span.turn_load = 20.0 * level * level;
    }
    span.cut = any(random) > 0.05;
    span.pace = 0.7 + 0.3 * any(random);
    spans.push_back(span);
    at += seconds;
  }
  return spans;
}

double speed_at(const std::vector<SpeedStep>& steps, double time) {
  for (const SpeedStep& step : steps)
    if (time < step.end) return step.speed;
  return 1.0;
}

// (feed_profile.h, properties 1 to 4)
TEST(FeedProfile, NoLoadOverItsLimit) {
  std::mt19937 random(23);
  for (int round = 0; round < 60; ++round) {
    const std::vector<LoadSpan> spans = random_spans(random, 400);
    const Loads limits = largest_loads(spans).times(round % 3 == 0 ? 0.8 : 1.0);
    const FeedRule rule{1.0 + 0.1 * (round % 20), 0.2, round % 4 == 0 ? 0.1 : 0.0, 0.1 * (round % 7)};
    const auto steps = feed_profile(spans, limits, rule);
    double end = 0.0;
    for (const SpeedStep& step : steps) {
      EXPECT_GT(step.end, end);
      end = step.end;
      EXPECT_NEAR(std::remainder(step.speed, kSpeedStep), 0.0, 1e-9);
      EXPECT_LE(step.speed, rule.highest + 1e-9);
      EXPECT_GE(step.speed, rule.lowest - 1e-9);
    }
    for (std::size_t i = 0; i < spans.size(); ++i) {
      const double speed = speed_at(steps, 0.5 * (spans[i].begin + spans[i].end));
      if (!spans[i].cut) {
        EXPECT_EQ(speed, 1.0);
        continue;
      }
      // Its own load, and those that begin within the way ahead.
      double way = 0.0;
      for (std::size_t k = i; k < spans.size() && way <= rule.ahead; ++k) {
        if (k > i && (!spans[k].cut || spans[k].begin > spans[k - 1].end + 1e-5)) break;
        if (speed <= rule.lowest + kSpeedStep) break;
        EXPECT_LE(spans[k].chip * speed, limits.chip * (1 + 1e-9)) << round << " " << i << " " << k;
        EXPECT_LE(spans[k].edge_load * std::pow(speed, 0.75), limits.edge_load * (1 + 1e-9));
        EXPECT_LE(spans[k].turn_load * std::pow(speed, 0.75), limits.turn_load * (1 + 1e-9));
        if (k > i) way += spans[k].way;
      }
      if (rule.change > 0.0 && i > 0 && spans[i - 1].cut && spans[i].begin <= spans[i - 1].end + 1e-5) {
        // Merged speeds differ by 6 % and a step more than the slope.
        const double before = speed_at(steps, 0.5 * (spans[i - 1].begin + spans[i - 1].end));
        EXPECT_LE(std::abs(speed - before), 0.5 * rule.change * (spans[i].way + spans[i - 1].way) +
                                                0.07 * std::max(speed, before) + 2 * kSpeedStep);
      }
    }
    for (double time = 0.0; time < 0.49; time += 0.1) EXPECT_EQ(speed_at(steps, time), 1.0);
  }
}

TEST(FeedProfile, AirIsCutAtTheHighest) {
  std::vector<LoadSpan> spans;
  for (int i = 0; i < 100; ++i) spans.push_back({0.1 * i, 0.1 * (i + 1), 1.0});
  for (int i = 40; i < 60; ++i) spans[i].edge_load = 10.0, spans[i].chip = 100.0;
  const auto steps = feed_profile(spans, largest_loads(spans), {2.5, 0.2, 0.0, 0.3});
  ASSERT_EQ(steps.size(), 3u);
  EXPECT_NEAR(steps[0].speed, 2.5, 1e-9);
  // The last span before the load is slow already, and so is the first behind it.
  EXPECT_NEAR(steps[0].end, 3.9, 1e-9);
  EXPECT_NEAR(steps[1].speed, 1.0, 1e-9);
  EXPECT_NEAR(steps[1].end, 6.1, 1e-9);
}

MachineModel square_machine() {
  MachineModel m;
  for (LinearAxis* axis : {&m.x, &m.y, &m.z}) *axis = {-500, 500, 6000, 1000};
  m.tilt = {'A', {1, 0, 0}, +1, 0, -110, 110, 3600, 1000};
  m.rotary = {'C', {0, 0, 1}, -1, 0, -36000, 36000, 3600, 1000};
  return m;
}

// (moves_at_speeds.h, properties 1 to 4)
TEST(FeedProfile, MovesKeepTheirPlaces) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const MachineModel machine = square_machine();
  for (int round = 0; round < 40; ++round) {
    std::vector<JointMove> moves{{}};
    double total = 0.0;
    for (int i = 1; i < 60; ++i) {
      JointMove move = moves.back();
      move.joints.x = round_decimal(move.joints.x + 5 * any(random), 4);
      move.joints.z = round_decimal(move.joints.z + any(random), 4);
      move.joints.c = round_decimal(move.joints.c + 3 * any(random), 4);
      move.kind = i % 11 == 0 ? MoveKind::kRapid : i % 11 == 1 ? MoveKind::kPlunge : MoveKind::kCut;
      move.move = static_cast<std::uint32_t>(i);
      move.seconds =
          std::max(rapid_seconds(machine, moves.back().joints, move.joints), 0.1 + 0.1 * any(random));
      total += move.seconds;
      moves.push_back(move);
    }
    std::vector<SpeedStep> steps;
    for (double at = 0.1; at < total; at += 0.05 + 0.5 * std::abs(any(random)))
      steps.push_back({at, 1.0 + kSpeedStep * std::floor(40 * any(random))});
    const auto same = at_speeds(moves, {}, {machine});
    ASSERT_EQ(same.size(), moves.size());
    for (std::size_t i = 0; i < moves.size(); ++i)
      EXPECT_TRUE(same[i].joints == moves[i].joints && same[i].seconds == moves[i].seconds);
    const auto cut = at_speeds(moves, steps, {machine});
    EXPECT_GT(cut.size(), moves.size());
    std::size_t at = 0;
    double begun = 0.0;
    for (std::size_t i = 1; i < moves.size(); ++i) {
      // The least time by the steps, numerically; no piece leaves the straight way by more than a rounding.
      double asked = 0.0, took = 0.0;
      constexpr int kParts = 2000;
      for (int k = 0; k < kParts; ++k)
        asked += moves[i].seconds / kParts / speed_at(steps, begun + moves[i].seconds * (k + 0.5) / kParts);
      if (moves[i].kind != MoveKind::kCut) asked = moves[i].seconds;
      begun += moves[i].seconds;
      const Joints from = moves[i - 1].joints, to = moves[i].joints;
      for (++at; at < cut.size(); ++at) {
        const double f = (cut[at].joints.x - from.x) / (to.x - from.x);
        EXPECT_NEAR(cut[at].joints.c, from.c + f * (to.c - from.c),
                    1e-4 + 6e-5 / std::abs(to.x - from.x) * std::abs(to.c - from.c));
        EXPECT_EQ(cut[at].move, moves[i].move);
        EXPECT_GE(cut[at].seconds, rapid_seconds(machine, cut[at - 1].joints, cut[at].joints) - 3e-6);
        took += cut[at].seconds;
        if (cut[at].joints == to) break;
      }
      ASSERT_LT(at, cut.size()) << "a place is not passed";
      EXPECT_GE(took, std::min(asked, moves[i].seconds) * 0.98 - 1e-9);
      EXPECT_GE(took, asked * 0.98) << i;
    }
    EXPECT_EQ(at + 1, cut.size());
  }
}

}  // namespace
}  // namespace tiltfeed::daemon
