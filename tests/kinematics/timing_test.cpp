// Times of programs: closed forms of trapezoids and corners, limits held by a simulated drive, starved links.

#include "kinematics/timing/timing.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tests/judges/joint_path_check.h"

namespace tiltfeed {
namespace {

constexpr double kTolerance = 0.01, kAxisTolerance = 0.1;

MachineModel drive() {
  MachineModel m;
  m.x = m.y = m.z = {-1e6, 1e6, 60000, 1000};
  m.tilt = {'A', {1, 0, 0}, +1, 0.0, -1e6, 1e6, 6000, 200};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -1e6, 1e6, 6000, 400};
  return m;
}

std::vector<JointMove> program(const std::vector<std::pair<Joints, double>>& blocks,
                               MoveKind kind = MoveKind::kCut) {
  std::vector<JointMove> moves;
  for (const auto& [joints, seconds] : blocks)
    moves.push_back({joints, seconds, moves.empty() ? MoveKind::kRapid : kind, 0});
  return moves;
}

TEST(Timing, OneLongBlockIsATrapezoid) {
  // 100 mm in 1 s: 100 mm/s, reached in 0.1 s over 5 mm, left again likewise.
  const Timing t = time_blocks(program({{{}, 0}, {{100, 0, 0, 0, 0}, 1.0}}, MoveKind::kRapid), drive(),
                               kTolerance, kAxisTolerance);
  EXPECT_NEAR(t.seconds, 0.9 + 0.2, 1e-12);
  EXPECT_NEAR(t.peak_velocity.x, 6000, 1e-9);
  EXPECT_NEAR(t.peak_acceleration.x, 1000, 1e-9);
  EXPECT_EQ(t.slowed, 1u);
  EXPECT_EQ(t.peak_velocity.c, 0.0);
}

TEST(Timing, OneShortBlockIsATriangle) {
  // 1 degree of A at 200 deg/s^2: up and down in 2 sqrt(s / a), whatever was programmed.
  const Timing t = time_blocks(program({{{}, 0}, {{0, 0, 0, 1, 0}, 0.01}}, MoveKind::kRapid), drive(),
                               kTolerance, kAxisTolerance);
  EXPECT_NEAR(t.seconds, 2 * std::sqrt(1.0 / 200), 1e-12);
  EXPECT_NEAR(t.peak_velocity.a, 60 * std::sqrt(200.0), 1e-9);
}

TEST(Timing, WhereAnOperationBeginsTheMachineStandsAndTakesNoTime) {
  // Two operations of one block each, wherever the second begins; and two that only begin.
  for (const Joints begin : {Joints{}, Joints{100, 0, 0, 0, 0}, Joints{7, 8, 9, 10, 11}}) {
    Joints end = begin;
    end.y += 100;
    const auto moves = program({{{}, 0}, {{100, 0, 0, 0, 0}, 1.0}, {begin, 0}, {end, 1.0}}, MoveKind::kRapid);
    EXPECT_NEAR(time_blocks(moves, drive(), kTolerance, kAxisTolerance).seconds, 2 * 1.1, 1e-12);
    MachineModel stops = drive();
    stops.blends_rotary = false;
    const Timing t = time_blocks(moves, stops, kTolerance, kAxisTolerance);
    EXPECT_NEAR(t.seconds, 2 * 1.1, 1e-12);
    EXPECT_TRUE(std::isfinite(t.peak_velocity.x) && std::isfinite(t.peak_acceleration.c));
    const auto points = program({{{}, 0}, {begin, 0}});
    EXPECT_EQ(time_blocks(points, drive(), kTolerance, kAxisTolerance).seconds, 0.0);
    EXPECT_EQ(time_blocks(points, stops, kTolerance, kAxisTolerance).seconds, 0.0);
  }
}

TEST(Timing, AStraightLineOfManyBlocksIsThatOfOne) {
  std::vector<std::pair<Joints, double>> blocks{{{}, 0}};
  for (int i = 1; i <= 1000; ++i) blocks.push_back({{0.1 * i, 0, 0, 0, 0}, 0.001});
  const Timing t = time_blocks(program(blocks, MoveKind::kRapid), drive(), kTolerance, kAxisTolerance);
  EXPECT_NEAR(t.seconds, 1.1, 1e-9);
}

TEST(Timing, ACornerIsRoundedOffWithinTheTolerance) {
  // 90 degrees at 50 mm/s: each axis changes by 50 mm/s over 8 tol / dv = 1.6 ms, or slower.
  const auto corner = program({{{}, 0}, {{50, 0, 0, 0, 0}, 1.0}, {{50, 50, 0, 0, 0}, 1.0}}, MoveKind::kRapid);
  const Timing t = time_blocks(corner, drive(), kTolerance, kAxisTolerance);
  // a = dv^2 / (8 tol): sqrt(8 * 0.01 * 1000) = 8.94 mm/s through the corner.
  const double v = std::sqrt(8 * kTolerance * 1000);
  const double lost = 50.0 / 1000 - 50.0 / 2000 + (50 - v) / 1000 - (50 * 50 - v * v) / 2000 / 50;
  EXPECT_NEAR(t.seconds, 2.0 + 2 * lost, 1e-9);
  const Timing coarse = time_blocks(corner, drive(), 1e9, 1e9);
  EXPECT_NEAR(coarse.seconds, 2.05, 1e-9) << "no stop at a corner that may be rounded off at will";
}

TEST(Timing, RapidAndFeedMeetAtAStandstill) {
  auto moves = program({{{}, 0}, {{100, 0, 0, 0, 0}, 1.0}, {{200, 0, 0, 0, 0}, 1.0}}, MoveKind::kRapid);
  const double through = time_blocks(moves, drive(), kTolerance, kAxisTolerance).seconds;
  moves[2].kind = MoveKind::kCut;
  const double stopped = time_blocks(moves, drive(), kTolerance, kAxisTolerance).seconds;
  EXPECT_NEAR(through, 2.1, 1e-9);
  EXPECT_NEAR(stopped, 2.2, 1e-9);
}

/// Random programs of all axes; the velocities that the durations imply change no faster than the drives can.
TEST(Timing, RandomProgramsKeepEveryLimit) {
  const MachineModel m = drive();
  const double limits[5] = {1000, 1000, 1000, 200, 400};
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> step;
    std::uniform_real_distribution<double> time(0.001, 0.1);
    Joints q, v{};
    std::vector<std::pair<Joints, double>> blocks{{q, 0}};
    for (int i = 0; i < 300; ++i) {
      v = {v.x * 0.9 + step(random), v.y * 0.9 + step(random), v.z * 0.9 + step(random),
           v.a * 0.9 + step(random), v.c * 0.9 + step(random)};
      const double t = time(random);
      q = {q.x + v.x * t, q.y + v.y * t, q.z + v.z * t, q.a + v.a * t, q.c + v.c * t};
      blocks.push_back({q, t});
    }
    const auto moves = program(blocks);
    const Timing timing = time_blocks(moves, m, kTolerance, kAxisTolerance);
    double sum = 0;
    std::array<double, 5> before{};
    double last = 0;
    for (std::size_t i = 1; i < moves.size(); ++i) {
      const double t = timing.durations[i];
      ASSERT_GE(t, moves[i].seconds * (1 - 1e-6));
      sum += t;
      const Joints &p = moves[i - 1].joints, &r = moves[i].joints;
      const std::array<double, 5> d{r.x - p.x, r.y - p.y, r.z - p.z, r.a - p.a, r.c - p.c};
      for (std::size_t k = 0; k < 5; ++k) {
        const double mean = d[k] / t;
        // Mean speeds of two blocks lie (t + last) / 2 apart; corner and ramp may share that time.
        ASSERT_LE(std::abs(mean - before[k]), 2.02 * limits[k] * (t + last) / 2 + 1e-9) << "block " << i;
        before[k] = mean;
      }
      last = t;
    }
    EXPECT_NEAR(sum, timing.seconds, 1e-4);
    const Joints& a = timing.peak_acceleration;
    EXPECT_LE(std::max({a.x, a.y, a.z}), 1000 * (1 + 1e-9));
    EXPECT_LE(a.a, 200 * (1 + 1e-9));
    EXPECT_LE(a.c, 400 * (1 + 1e-9));
  }
}

/// `count` equal blocks one after the other from 0.
std::vector<JointMove> equal_blocks(int count, const Joints& step, double seconds) {
  std::vector<std::pair<Joints, double>> blocks{{{}, 0}};
  for (int i = 1; i <= count; ++i)
    blocks.push_back({{step.x * i, step.y * i, step.z * i, step.a * i, step.c * i}, seconds});
  return program(blocks);
}

/// From rest to rest in whole servo periods: T + v / a, or 2 sqrt(d / a) where v is not reached.
double rest_to_rest(double way, double seconds, double acceleration) {
  const double v = way / seconds;
  const double exact =
      v * v / acceleration <= way ? seconds + v / acceleration : 2 * std::sqrt(way / acceleration);
  return std::ceil(exact / kServoPeriod - 1e-6) * kServoPeriod;
}

TEST(Timing, ExactStopIsFromRestToRest) {
  MachineModel stops = drive();
  stops.blends_rotary = false;
  for (const double seconds : {0.3, 0.1, 0.01}) {
    const double block = rest_to_rest(1.0, seconds, 400);
    const auto moves = equal_blocks(40, {0.5, 0, 0, 0, 1}, seconds);
    for (const Timing& t : {time_blocks(moves, stops, kTolerance, kAxisTolerance),
                            time_blocks(moves, stops, 1e9, 1e9, Corners::kExact),
                            time_blocks(moves, drive(), kTolerance, kAxisTolerance, Corners::kExact)}) {
      EXPECT_NEAR(t.seconds, 40 * block, 1e-9);
      EXPECT_NEAR(t.peak_acceleration.c, 400, 1e-9);
      EXPECT_NEAR(t.peak_acceleration.x, 200, 1e-9);
      EXPECT_NEAR(t.peak_velocity.c, 60 * std::min(1 / seconds, std::sqrt(400.0)), 1e-6);
      EXPECT_EQ(t.slowed, 40u);
    }
    EXPECT_LT(time_blocks(moves, drive(), kTolerance, kAxisTolerance).seconds, 40 * block - 0.1);
  }
}

// Measured: LinuxCNC 2.9, 1 ms, axes of 300 per s^2; tests/linuxcnc/README.md.
TEST(Timing, ExactStopAgreesWithLinuxCnc) {
  MachineModel m = drive();
  m.blends_rotary = false;
  m.x.acceleration = m.y.acceleration = m.z.acceleration = 300;
  m.tilt.acceleration = m.rotary.acceleration = 300;
  std::vector<std::pair<Joints, double>> square{{{}, 0}};
  for (int i = 1; i <= 20; ++i)
    square.push_back({{i % 4 == 1 || i % 4 == 2 ? 1.0 : 0.0, i % 4 >= 2 ? 1.0 : 0.0, 0, 0, 0}, 0.1});
  const std::vector<std::pair<std::vector<JointMove>, double>> measured{
      {equal_blocks(40, {0, 0, 0, 0, 1}, 0.1), 5.362},
      {equal_blocks(40, {0, 0, 0, 0, 1}, 0.3), 12.481},
      {equal_blocks(40, {1, 0, 0, 0, 1}, 0.1), 5.362},
      {equal_blocks(200, {0, 0, 0, 0, 0.1}, 0.01), 7.402},
      {equal_blocks(200, {0, 0, 0, 0, 0.1}, 0.1), 20.802},
      {equal_blocks(40, {1, 0, 0, 0, 0}, 0.1), 4.036},
      {equal_blocks(200, {0.05, 0, 0, 0, 0}, 0.01), 2.020},
      {program(square), 2.760},
      {equal_blocks(200, {0.02, 0, 0, 0, 0.02}, 0.005), 3.402}};
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const double seconds =
        time_blocks(measured[i].first, m, kTolerance, kAxisTolerance, Corners::kExact).seconds;
    EXPECT_NEAR(seconds / measured[i].second, 1.0, 0.005) << "program " << i;
  }
}

/// Corners of 90 degrees, 1 mm and 0.1 s apart, and before each block of `turns` the rotary turns by a
/// degree.
std::vector<JointMove> stairs(int count, const std::vector<int>& turns) {
  std::vector<std::pair<Joints, double>> blocks{{{}, 0}};
  for (int i = 0; i < count; ++i) {
    Joints at = blocks.back().first;
    (i % 2 == 0 ? at.x : at.y) += 1.0;
    if (std::find(turns.begin(), turns.end(), i) != turns.end()) at.c += 1.0;
    blocks.push_back({at, 0.1});
  }
  return program(blocks);
}

TEST(Timing, FixedBlendsOnlyWhereNoRotaryIsNear) {
  // 20 blocks without a rotary, then one with, then 9, of which the last has nothing behind it.
  const std::vector<JointMove> moves = stairs(30, {20});
  const std::vector<bool> blends = blends_corners(moves);
  ASSERT_EQ(blends.size(), moves.size());
  for (std::size_t i = 0; i < moves.size(); ++i)
    EXPECT_EQ(blends[i], (i >= 2 && i <= 19))
        << i << ": the first block, block 21 and those beside it are exact";
  const auto any = [](const std::vector<bool>& all) {
    return std::find(all.begin(), all.end(), true) != all.end();
  };
  EXPECT_FALSE(any(blends_corners(stairs(8, {})))) << "too short a run";
  EXPECT_FALSE(any(blends_corners(stairs(30, {4, 9, 14, 19, 24, 29}))));
  EXPECT_FALSE(any(blends_corners({})));

  MachineModel stops = drive();
  stops.blends_rotary = false;
  const auto seconds = [&](const std::vector<JointMove>& path, Corners corners) {
    return time_blocks(path, stops, kTolerance, kAxisTolerance, corners).seconds;
  };
  const std::vector<JointMove> turning = stairs(30, {4, 9, 14, 19, 24, 29});
  EXPECT_EQ(seconds(turning, Corners::kFixed), seconds(turning, Corners::kExact));
  // 18 blocks of a run have 17 corners that are no stops.
  const double exact = seconds(moves, Corners::kExact), fixed = seconds(moves, Corners::kFixed);
  EXPECT_LT(fixed, exact);
  EXPECT_GT(fixed, exact - 17 * (rest_to_rest(1.0, 0.1, 900) - 0.1) - 1e-9);
}

TEST(Timing, ExactStopGoesOnOnlyWhereXyzGoStraight) {
  const auto time = [](double aside, double turn) {
    const auto moves = program({{{}, 0}, {{100, 0, 0, 0, 0}, 1.0}, {{200, aside, 0, turn, 0}, 1.0}});
    return time_blocks(moves, drive(), 1e9, 1e9, Corners::kExact).seconds;
  };
  EXPECT_NEAR(time(0, 0), 2.1, 1e-9);
  EXPECT_NEAR(time(0, 0.001), 2.2, 1e-9) << "a rotary turns";
  // 100 mm/s aside by 0.0005 rad within 1 ms: 50 mm/s^2, of 1000; 950 are left.
  EXPECT_NEAR(time(0.05, 0), 2 + 0.1 / 0.95, 0.001);
  // By 0.01 rad: 1000 mm/s^2. It stops, with 0.9 of the acceleration.
  EXPECT_NEAR(time(1, 0), 2 * (1 + 0.1 / 0.9), 0.002);
}

// LinuxCNC: a line with rotary words keeps its time only if T >= 2 v / a on every axis, v = |dq| / T.
TEST(Timing, WithoutLookAheadEveryBlockCanKeepItsTime) {
  MachineModel m = joint_check::trunnion();
  const ToolPath path = joint_check::path_of(joint_check::sampled(2000, [](double f) {
    return Pose{{60 * f, 20 * std::sin(20 * f), 0}, joint_check::axis_at(30 + 10 * std::sin(40 * f), 90 * f)};
  }));
  std::size_t hurried = 0;
  for (const bool look_ahead : {true, false}) {
    m.blends_rotary = look_ahead;
    const auto joints = to_joints(path, m, joint_check::standing(), {});
    ASSERT_TRUE(joints) << joints.error().message;
    for (std::size_t i = 1; i < joints->moves.size(); ++i) {
      const Joints &p = joints->moves[i - 1].joints, &q = joints->moves[i].joints;
      const double t = joints->moves[i].seconds;
      const std::array<std::pair<double, double>, 5> ways{{{q.x - p.x, m.x.acceleration},
                                                           {q.y - p.y, m.y.acceleration},
                                                           {q.z - p.z, m.z.acceleration},
                                                           {q.a - p.a, m.tilt.acceleration},
                                                           {q.c - p.c, m.rotary.acceleration}}};
      for (const auto& [way, a] : ways) {
        const bool keeps = t * (1 + 1e-9) >= 2 * std::abs(way) / t / a;
        if (look_ahead)
          hurried += keeps ? 0 : 1;
        else
          EXPECT_TRUE(keeps) << "block " << i;
      }
    }
  }
  EXPECT_GT(hurried, 0u) << "the path is too slow to show anything";
}

/// The link block by block: when a block has arrived, when it can start.
double longest_wait(const std::vector<double>& durations, const LinkRate& link) {
  const double send = link.bytes_per_block / link.bytes_per_s;
  const auto room = static_cast<std::size_t>(link.buffer_bytes / link.bytes_per_block);
  double waited = 0, worst = 0;
  // Sent as room is made: block k needs the start of block k - room.
  std::vector<double> start(durations.size());
  double sent = 0, free_at = 0;
  for (std::size_t k = 0; k < durations.size(); ++k) {
    const double begin = k < room ? 0.0 : std::max(sent, start[k - room]);
    sent = k < room ? 0.0 : begin + send;  // the first fill is there before the cycle starts
    start[k] = std::max(free_at, sent);
    if (start[k] > free_at) waited += start[k] - free_at;
    worst = std::max(worst, waited);
    free_at = start[k] + durations[k];
  }
  return worst;
}

TEST(Starvation, FindsTheWindowThatALinkCannotFeed) {
  // 20 ms blocks at 10 ms a block, but for 100 of 4 ms.
  std::vector<double> durations(1000, 0.020);
  for (std::size_t i = 400; i < 500; ++i) durations[i] = 0.004;
  const LinkRate link{5000, 50, 500};
  const Starvation s = starvation(durations, link);
  EXPECT_EQ(s.first, 400u);
  EXPECT_EQ(s.count, 100u);
  EXPECT_NEAR(s.seconds, 0.4, 1e-6);
  EXPECT_NEAR(s.waits, 100 * 0.006 - 10 * 0.010, 1e-5);
  EXPECT_NEAR(s.waits, longest_wait(durations, link), 0.02);
  EXPECT_NEAR(s.bytes_per_s, (100 * 50 - 500) / 0.4, 1e-2);
  EXPECT_EQ(starvation(durations, {s.bytes_per_s * 1.001, 50, 500}).count, 0u) << "the remedy is one";
  EXPECT_EQ(starvation(durations, {5000, 50, 5000}).count, 0u) << "a buffer that holds the window";
}

TEST(Starvation, ASteadyLinkNeverStarves) {
  EXPECT_EQ(starvation(std::vector<double>(1000, 0.0101), {5000, 50, 128}).count, 0u);
  EXPECT_EQ(starvation({}, {5000, 50, 128}).count, 0u);
}

}  // namespace
}  // namespace tiltfeed
