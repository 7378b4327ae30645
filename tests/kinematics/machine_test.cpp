// Forward and inverse kinematics: worked vectors, inverse of forward on random poses, the pole, what cannot
// be reached, limits.

#include "kinematics/machine/machine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

namespace tiltfeed {
namespace {

constexpr double kTravel = 1e6;

MachineModel machine_with_head(Vec3 direction, char letter = 'A') {
  MachineModel m;
  m.name = "test";
  m.x = m.y = m.z = {-kTravel, kTravel, 10000.0, 1000.0};
  m.tilt = {letter, direction, +1, 0.0, -360.0, 360.0, 3600.0, 100.0};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -3600.0, 3600.0, 7200.0, 100.0};
  m.pivot_to_gauge = {0, 0, -150};
  return m;
}

const Vec3 kHeadA{1, 0, 0}, kHeadB{0, 1, 0};
const Vec3 kNutating45{0, std::sqrt(0.5), std::sqrt(0.5)};

struct Vector {
  const char* name;
  Vec3 head;
  Point<Part> tip;
  Vec3 axis;
  Joints joints;
  std::size_t branch;
};

TEST(Machine, WorkedVectors) {
  const Vec3 tilted{0.5, 0, 0.866025404};
  const std::vector<Vector> table{
      {"A", kHeadA, {50, 20, 10}, tilted, {20, -175, -23.493649, 30, 90}, 0},
      {"A, other branch", kHeadA, {50, 20, 10}, tilted, {-20, 175, -23.493649, -30, -90}, 1},
      {"A, oblique", kHeadA, {-30, 40, 15}, {0.3, -0.4, 0.866025404}, {0, -75, -18.493649, 30, 36.869898}, 0},
      {"B", kHeadB, {50, 20, 10}, tilted, {175, 20, -23.493649, 30, 0}, 0},
      {"nutating",
       kNutating45,
       {50, 20, 10},
       tilted,
       {163.241799, 66.159770, -23.493649, 42.941403, -15.542268},
       0}};
  tiltfeed::Setup setup;
  setup.tool_length = 100;
  for (const Vector& v : table) {
    SCOPED_TRACE(v.name);
    const auto both = inverse(machine_with_head(v.head), setup, {v.tip, v.axis}, 0.0);
    ASSERT_TRUE(both);
    const Joints& q = (*both)[v.branch];
    EXPECT_NEAR(q.x, v.joints.x, 1e-6);
    EXPECT_NEAR(q.y, v.joints.y, 1e-6);
    EXPECT_NEAR(q.z, v.joints.z, 1e-6);
    EXPECT_NEAR(q.a, v.joints.a, 1e-6);
    EXPECT_NEAR(q.c, v.joints.c, 1e-6);
  }
}

TEST(Machine, WorkedVectorWithOffsets) {
  MachineModel m = machine_with_head(kHeadA);
  m.pivot_to_gauge = {1.5, -22, -165.4};
  tiltfeed::Setup setup;
  setup.part_zero = {30, -12.5, 80};
  setup.tool_length = 100;
  const Pose pose{{40, 25, -10}, {0.250627354, -0.350878295, 0.902258473}};
  const auto both = inverse(m, setup, pose, 0.0);
  ASSERT_TRUE(both);
  const Joints expected[2]{{34.226820, -134.604632, -26.454298, 25.543460, 35.537678},
                           {-94.226820, 155.304005, -45.426905, -25.543460, -144.462322}};
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR((*both)[i].x, expected[i].x, 1e-6);
    EXPECT_NEAR((*both)[i].y, expected[i].y, 1e-6);
    EXPECT_NEAR((*both)[i].z, expected[i].z, 1e-6);
    EXPECT_NEAR((*both)[i].a, expected[i].a, 1e-6);
    EXPECT_NEAR((*both)[i].c, expected[i].c, 1e-6);
  }
}

/// (K3) written out for an A head with phi = -C, w and v as in the maths.
TEST(Machine, ClosedFormOfAnAHead) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> mm(-200, 200), degrees(-170, 170);
  for (int i = 0; i < 10000; ++i) {
    MachineModel m = machine_with_head(kHeadA);
    m.pivot_to_gauge = {mm(random), mm(random), -250};
    tiltfeed::Setup setup;
    setup.part_zero = {mm(random), mm(random), mm(random)};
    setup.tool_length = 80;
    const double a = degrees(random), c = degrees(random);
    const Point<Part> q{mm(random), mm(random), mm(random)};
    const Joints joints = solve_linear(m, setup, q, a, c);
    const double A = Angle::from_degrees(a).radians(), C = Angle::from_degrees(c).radians();
    const Vec3 w = setup.part_zero;
    const double vy = m.pivot_to_gauge.y, L = 330;
    ASSERT_NEAR(joints.x, std::cos(C) * (q.x + w.x) + std::sin(C) * (q.y + w.y) - w.x, 1e-9);
    ASSERT_NEAR(joints.y,
                -std::sin(C) * (q.x + w.x) + std::cos(C) * (q.y + w.y) - w.y + vy * (1 - std::cos(A)) -
                    L * std::sin(A),
                1e-9);
    ASSERT_NEAR(joints.z, q.z - vy * std::sin(A) + L * (std::cos(A) - 1), 1e-9);
    const Pose pose = forward(m, setup, joints);
    const Vec3 u{std::sin(C) * std::sin(A), -std::cos(C) * std::sin(A), std::cos(A)};
    ASSERT_NEAR(length(pose.axis - u), 0.0, 1e-12);
  }
}

// (machine.h, property 4)
TEST(Machine, ProgramCoordinatesArePartCoordinatesAtZero) {
  MachineModel m = machine_with_head(kNutating45, 'B');
  m.pivot_to_gauge = {3, -7, -180};
  m.tilt.zero = 12;
  m.rotary.zero = -33;
  tiltfeed::Setup setup;
  setup.part_zero = {10, 20, 30};
  setup.fixture = rotation_about(normalized(Vec3{1, 2, 3}), 0.7);
  setup.tool_length = 55;
  const Point<Part> tip{4, 5, 6};
  const Joints joints = solve_linear(m, setup, tip, m.tilt.zero, m.rotary.zero);
  const Vec3 turned = setup.fixture * from_origin(tip);
  EXPECT_NEAR(joints.x, turned.x, 1e-12);
  EXPECT_NEAR(joints.y, turned.y, 1e-12);
  EXPECT_NEAR(joints.z, turned.z, 1e-12);
}

/// A machine and set-up with everything non-zero, random.
struct RandomMachine {
  std::mt19937 random;
  std::normal_distribution<double> normal;
  explicit RandomMachine(unsigned seed) : random(seed) {}
  double mm(double scale) { return scale * normal(random); }
  Vec3 unit() { return normalized(Vec3{normal(random), normal(random), normal(random)}); }
  MachineModel machine(Vec3 head) {
    MachineModel m = machine_with_head(head);
    m.tilt.sign = normal(random) < 0 ? -1 : 1;
    m.rotary.sign = normal(random) < 0 ? -1 : 1;
    if (normal(random) < 0) m.rotary.direction = {0, 0, -1};
    m.tilt.zero = mm(20);
    m.rotary.zero = mm(60);
    m.pivot_to_gauge = {mm(10), mm(10), -150 + mm(20)};
    return m;
  }
  Setup setup() {
    Setup s;
    s.part_zero = {mm(80), mm(80), mm(80)};
    s.fixture = rotation_about(unit(), normal(random));
    s.tool_length = 100 + mm(20);
    return s;
  }
};

void expect_inverse_of_forward(Vec3 head, unsigned seed, double largest_tilt) {
  RandomMachine source(seed);
  for (int i = 0; i < 40000; ++i) {
    const MachineModel m = source.machine(head);
    const tiltfeed::Setup setup = source.setup();
    // An axis on the table within reach; every hundredth very near the pole.
    const double tilt = i % 100 == 0 ? std::pow(10.0, -1.0 - (i / 100) % 11)
                                     : std::fmod(std::abs(source.mm(1.0)), 1.0) * largest_tilt;
    const Vec3 sideways = source.unit();
    const double azimuth = std::atan2(sideways.y, sideways.x);
    const Vec3 on_table{std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                        std::cos(tilt)};
    const Pose pose{{source.mm(100), source.mm(100), source.mm(100)},
                    normalized(transposed(setup.fixture) * on_table)};
    const auto both = inverse(m, setup, pose, 12.5);
    ASSERT_TRUE(both) << both.error().message << " tilt " << tilt;
    for (const Joints& q : *both) {
      ASSERT_GT(q.c, -180.0);
      ASSERT_LE(q.c, 180.0);
      const Pose back = forward(m, setup, q);
      ASSERT_LT(distance(back.tip, pose.tip), 1e-9) << "case " << i;
      ASSERT_LT(length(back.axis - pose.axis), 1e-12) << "case " << i << " tilt " << tilt;
    }
    ASSERT_NEAR((*both)[0].a - m.tilt.zero, m.tilt.zero - (*both)[1].a, 1e-9);
  }
}

// (machine.h, property 1, for five heads)
TEST(Machine, InverseOfForwardAHead) { expect_inverse_of_forward(kHeadA, 1, 3.1); }
TEST(Machine, InverseOfForwardBHead) { expect_inverse_of_forward(kHeadB, 2, 3.1); }
TEST(Machine, InverseOfForwardObliqueHead) {
  expect_inverse_of_forward(normalized(Vec3{1, -0.6, 0}), 3, 3.1);
}
TEST(Machine, InverseOfForwardNutatingHead) { expect_inverse_of_forward(kNutating45, 4, 1.57); }
TEST(Machine, InverseOfForwardSteepNutatingHead) {
  expect_inverse_of_forward(normalized(Vec3{0.3, std::cos(1.0), std::sin(1.0)}), 5, 1.1);
}

// (machine.h, property 3)
TEST(Machine, HoldsTheTableAtThePole) {
  for (const Vec3 head : {kHeadA, kHeadB, kNutating45}) {
    const auto both = inverse(machine_with_head(head), {}, {{10, 20, 30}, {0, 0, 1}}, 77.25);
    ASSERT_TRUE(both);
    EXPECT_EQ((*both)[0].c, 77.25);
    EXPECT_EQ((*both)[0], (*both)[1]);
    EXPECT_EQ((*both)[0].a, 0.0);
  }
}

TEST(Machine, ConfessesWhatANutatingHeadCannotReach) {
  const MachineModel m = machine_with_head(kNutating45);
  const double beyond = Angle::from_degrees(90.01).radians(), within = Angle::from_degrees(89.99).radians();
  EXPECT_TRUE(inverse(m, {}, {{0, 0, 0}, {std::sin(within), 0, std::cos(within)}}, 0.0));
  const auto none = inverse(m, {}, {{0, 0, 0}, {std::sin(beyond), 0, std::cos(beyond)}}, 0.0);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Code::kUnreachable);
  EXPECT_NE(none.error().message.find("90.01 degrees"), std::string::npos) << none.error().message;
  EXPECT_NE(none.error().message.find("0 to 90 degrees"), std::string::npos) << none.error().message;
}

TEST(Machine, NamesTheFirstBrokenLimit) {
  MachineModel m = machine_with_head(kHeadA);
  m.z.min = -500;
  m.tilt.max = 120;
  EXPECT_EQ(broken_limit(m, {1, 2, 3, 4, 5}), std::nullopt);
  EXPECT_EQ(broken_limit(m, {0, 0, -512.3, 0, 0}), "Z -512.3 mm is below its travel of -500 mm");
  EXPECT_EQ(broken_limit(m, {0, 0, -512.3, 120.5, 0}), "A 120.5 degrees is above its limit of 120 degrees");
  EXPECT_EQ(broken_limit(m, {0, 0, 0, 120.00001, 0}), "A goes above its limit of 120 degrees");
  EXPECT_TRUE(broken_limit(m, {0, 0, std::nan(""), 0, 0}));
  EXPECT_FALSE(within_limits(m, {0, 0, std::nan(""), 0, 0}));
  EXPECT_TRUE(within_limits(m, {0, 0, -500, 120, 0}));
}

}  // namespace
}  // namespace tiltfeed
