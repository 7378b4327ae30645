// The simulated machine's frame chain against the closed forms (K2), (K3) and the worked examples of
// kinematics/machine/README.md; nothing here calls kinematics/machine/machine.cpp.

#include "sim/motion/forward.h"

#include <gtest/gtest.h>

#include <random>

namespace tiltfeed::sim {
namespace {

constexpr double kPrinted = 2e-6;  // the examples have six decimals, at a lever of 250 mm two digits are lost

MachineModel machine_with_head(Vec3 tilt_direction) {
  MachineModel machine;
  machine.tilt.direction = tilt_direction;
  machine.tilt.sign = +1;
  machine.rotary.letter = 'C';
  machine.rotary.direction = {0, 0, 1};
  machine.rotary.sign = -1;  // ISO 841: the word turns the tool against the work
  return machine;
}

void expect_pose(const Pose& pose, Vec3 tip, Vec3 axis, double tolerance, const std::string& what) {
  EXPECT_NEAR(pose.tip.x, tip.x, tolerance) << what;
  EXPECT_NEAR(pose.tip.y, tip.y, tolerance) << what;
  EXPECT_NEAR(pose.tip.z, tip.z, tolerance) << what;
  EXPECT_NEAR(pose.axis.x, axis.x, tolerance / 100) << what;
  EXPECT_NEAR(pose.axis.y, axis.y, tolerance / 100) << what;
  EXPECT_NEAR(pose.axis.z, axis.z, tolerance / 100) << what;
}

TEST(SimForward, WorkedExamples) {
  const double h = std::sqrt(0.5);
  const struct {
    const char* name;
    Vec3 head;
    Joints joints;
    Vec3 tip, axis;
  } cases[] = {
      {"A head", {1, 0, 0}, {20, -175, -23.493649, 30, 90}, {50, 20, 10}, {.5, 0, .866025404}},
      {"A head, other branch",
       {1, 0, 0},
       {-20, 175, -23.493649, -30, -90},
       {50, 20, 10},
       {.5, 0, .866025404}},
      {"A head, 3-4-5", {1, 0, 0}, {0, -75, -18.493649, 30, 36.869898}, {-30, 40, 15}, {.3, -.4, .866025404}},
      {"B head", {0, 1, 0}, {175, 20, -23.493649, 30, 0}, {50, 20, 10}, {.5, 0, .866025404}},
      {"nutating head",
       {0, h, h},
       {163.241799, 66.159770, -23.493649, 42.941403, -15.542268},
       {50, 20, 10},
       {.5, 0, .866025404}},
  };
  for (const auto& c : cases) {
    MachineModel machine = machine_with_head(c.head);
    machine.pivot_to_gauge = {0, 0, -150};
    tiltfeed::Setup setup;
    setup.tool_length = 100;
    expect_pose(forward_by_frames(machine, setup, c.joints), c.tip, c.axis, kPrinted, c.name);
  }
}

TEST(SimForward, WorkedExampleWithOffsetsOnBothBranches) {
  MachineModel machine = machine_with_head({1, 0, 0});
  machine.pivot_to_gauge = {1.5, -22, -165.4};
  machine.table_centre = {311, -207, 55};  // cancels: program coordinates are relative to the part
  tiltfeed::Setup setup;
  setup.part_zero = {30, -12.5, 80};
  setup.tool_length = 100;
  const Vec3 tip{40, 25, -10}, axis{0.250627354, -0.350878295, 0.902258473};
  expect_pose(forward_by_frames(machine, setup, {34.226820, -134.604632, -26.454298, 25.543460, 35.537678}),
              tip, axis, kPrinted, "first branch");
  expect_pose(
      forward_by_frames(machine, setup, {-94.226820, 155.304005, -45.426905, -25.543460, -144.462322}), tip,
      axis, kPrinted, "second branch");
}

// (K3) solved by hand here, with signs and zeros of the words on top, must come back as the pose.
TEST(SimForward, UndoesTheClosedFormOfTheAHead) {
  std::mt19937 random(20240611);
  std::uniform_real_distribution<double> mm(-300, 300), unit(-1, 1), degrees(-90, 90);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 q{mm(random), mm(random), mm(random)}, w{mm(random), mm(random), mm(random)};
    const Vec3 u = normalized({unit(random), unit(random), unit(random) + 1.5});
    const double length = 200 + mm(random) / 3, vx = unit(random) * 20, vy = unit(random) * 20;
    const double branch = i % 2 == 0 ? 1 : -1;
    const double a = branch * std::atan2(std::hypot(u.x, u.y), u.z);
    const double c = std::atan2(branch * u.x, -branch * u.y);
    const double x = std::cos(c) * (q.x + w.x) + std::sin(c) * (q.y + w.y) - w.x;
    const double y = -std::sin(c) * (q.x + w.x) + std::cos(c) * (q.y + w.y) - w.y + vy * (1 - std::cos(a)) -
                     length * std::sin(a);
    const double z = q.z - vy * std::sin(a) + length * (std::cos(a) - 1);

    MachineModel machine = machine_with_head({1, 0, 0});
    machine.tilt.sign = i % 3 == 0 ? -1 : 1;
    machine.rotary.sign = i % 5 == 0 ? 1 : -1;
    machine.tilt.zero = degrees(random);
    machine.rotary.zero = degrees(random);
    machine.pivot_to_gauge = {vx, vy, -length / 2};
    tiltfeed::Setup setup;
    setup.part_zero = w;
    setup.tool_length = length / 2;
    const Joints joints{x, y, z, machine.tilt.zero + machine.tilt.sign * a * 180 / kPi,
                        machine.rotary.zero - machine.rotary.sign * c * 180 / kPi};
    expect_pose(forward_by_frames(machine, setup, joints), q, u, 1e-9, "case " + std::to_string(i));
  }
}

// (K2) with a fixture: P = R(phi)(RW Q + w) - w + v - R(alpha) v, for any head direction.
TEST(SimForward, UndoesProgramCoordinatesWithFixtureAndAnyHead) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> mm(-300, 300), unit(-1, 1), angle(-3, 3);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 q{mm(random), mm(random), mm(random)};
    const Vec3 head = normalized({unit(random) + 2, unit(random), unit(random)});
    const Vec3 turn_about = normalized({unit(random), unit(random), unit(random) + 2});
    const double phi = angle(random), alpha = angle(random) / 2;
    MachineModel machine = machine_with_head(head);
    machine.table_centre = {mm(random), mm(random), mm(random)};
    machine.pivot_to_gauge = {mm(random) / 10, mm(random) / 10, -200};
    tiltfeed::Setup setup;
    setup.fixture = rotation_about(turn_about, angle(random));
    setup.part_zero = {mm(random), mm(random), mm(random)};
    setup.tool_length = 80 + mm(random) / 10;
    const Vec3 w = setup.part_zero;
    const Vec3 v = machine.pivot_to_gauge + Vec3{0, 0, -setup.tool_length};
    const Rotation table = rotation_about({0, 0, 1}, phi), tilt = rotation_about(head, alpha);
    const Vec3 p = table * (setup.fixture * q + w) - w + v - tilt * v;
    const Vec3 u = transposed(setup.fixture) * (transposed(table) * (tilt * Vec3{0, 0, 1}));
    const Joints joints{p.x, p.y, p.z, alpha * 180 / kPi, -phi * 180 / kPi};
    expect_pose(forward_by_frames(machine, setup, joints), q, u, 1e-9, "case " + std::to_string(i));
  }
}

TEST(SimForward, AtHomeProgramCoordinatesArePartCoordinatesTurnedByTheFixture) {
  MachineModel machine = machine_with_head({1, 0, 0});
  machine.table_centre = {5, 6, 7};
  machine.pivot_to_gauge = {1, 2, -100};
  tiltfeed::Setup setup;
  setup.part_zero = {10, 20, 30};
  setup.tool_length = 50;
  setup.fixture = {{Vec3{0, -1, 0}, Vec3{1, 0, 0}, Vec3{0, 0, 1}}};  // part x lies along table y
  expect_pose(forward_by_frames(machine, setup, {3, 4, 5, 0, 0}), {4, -3, 5}, {0, 0, 1}, 1e-12, "home");
}

}  // namespace
}  // namespace tiltfeed::sim
