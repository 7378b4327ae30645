// Machines of every structure: inverse undone by forward, forward by the simulated machine's own chain of
// frames, the shipped profiles by the formulas that their controls publish, rotary words of every counting.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "config/machine_profile.h"
#include "kinematics/machine/machine.h"
#include "sim/gcode/gcode_reader.h"
#include "sim/motion/forward.h"
#include "tests/judges/joint_path_check.h"

namespace tiltfeed {
using namespace config;
namespace {

constexpr double kTip = 1e-9;    // mm
constexpr double kAxis = 2e-12;  // unit vectors; within 1e-12 of the pole both branches count as on it

/// Everything non-zero and random.
class Workshop {
 public:
  explicit Workshop(unsigned seed) : random_(seed) {}
  double spread(double scale) { return scale * normal_(random_); }
  int sign() { return normal_(random_) < 0.0 ? -1 : 1; }
  Vec3 vector(double scale) { return {spread(scale), spread(scale), spread(scale)}; }
  Vec3 unit() { return normalized(vector(1.0)); }
  /// Nominal axes that are off by `misaligned` rad or so; any directions at all where that is large.
  MachineModel machine(Structure structure, Vec3 tilt, Vec3 rotary, Vec3 spindle, double misaligned) {
    MachineModel m;
    m.name = "random";
    m.structure = structure;
    m.tilt.direction = normalized(tilt + vector(misaligned));
    m.rotary.direction = normalized(rotary + vector(misaligned));
    m.spindle = normalized(spindle + vector(misaligned));
    m.tilt.sign = sign();
    m.rotary.sign = sign();
    m.tilt.zero = spread(20);
    m.rotary.zero = spread(60);
    m.rotary.letter = 'C';
    m.pivot_to_gauge = vector(20) + Vec3{0, 0, -150};
    m.rotary_to_tilt = vector(30);
    m.table_centre = {spread(100), spread(100), spread(100)};
    return m;
  }
  Setup setup() { return {vector(80), rotation_about(unit(), spread(1.0)), 100.0 + spread(20)}; }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

constexpr Structure kStructures[] = {Structure::kTableHead, Structure::kTableTable, Structure::kHeadHead};
const struct Nominal {
  const char* name;
  Vec3 tilt, rotary, spindle;
} kNominals[] = {{"A over C", {1, 0, 0}, {0, 0, 1}, {0, 0, 1}},
                 {"B over C, C downwards", {0, 1, 0}, {0, 0, -1}, {0, 0, 1}},
                 {"nutating 45", {0, 1, 1}, {0, 0, 1}, {0, 0, 1}},
                 {"nutating 30", {0, 0.5, 0.8660254037844386}, {0, 0, 1}, {0, 0, 1}},
                 {"B over A", {0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
                 {"horizontal spindle, A over B", {1, 0, 0}, {0, 1, 0}, {0, -1, 0}},
                 {"nothing square", {1, 0.4, 0.3}, {0.2, -0.5, 1}, {-0.3, 0.1, 1}}};

/// Poses that the machine makes, from random joints; every tenth with the tool near the rotary axis.
Joints random_joints(Workshop& shop, const MachineModel& machine, int i) {
  Joints q{shop.spread(100), shop.spread(100), shop.spread(100), shop.spread(60), shop.spread(200)};
  if (i % 10 == 0) q.a = machine.tilt.zero + std::pow(10.0, -(i / 10) % 12);
  return q;
}

void expect_same(const Pose& a, const Pose& b, const std::string& what) {
  ASSERT_LT(distance(a.tip, b.tip), kTip) << what;
  ASSERT_LT(length(a.axis - b.axis), kAxis) << what;
}

// (machine.h, property 1)
TEST(MachineTypes, InverseOfForwardOnBothBranchesAndTheSimulatorsForward) {
  unsigned seed = 1;
  for (const Structure structure : kStructures) {
    for (const Nominal& nominal : kNominals) {
      for (const double misaligned : {0.0, 1e-4, 0.1}) {
        Workshop shop(seed++);
        for (int i = 0; i < 300; ++i) {
          const std::string what = std::string(nominal.name) + ", structure " +
                                   std::to_string(static_cast<int>(structure)) + ", misaligned by " +
                                   std::to_string(misaligned) + ", case " + std::to_string(i);
          const MachineModel machine =
              shop.machine(structure, nominal.tilt, nominal.rotary, nominal.spindle, misaligned);
          const tiltfeed::Setup setup = shop.setup();
          const Joints q = random_joints(shop, machine, i);
          const Pose pose = forward(machine, setup, q);
          expect_same(pose, sim::forward_by_frames(machine, setup, q), what + " by frames");
          const auto both = inverse(machine, setup, {pose.tip, normalized(pose.axis)}, q.c);
          ASSERT_TRUE(both) << what << ": " << both.error().message;
          for (const Joints& joints : *both) {
            expect_same(forward(machine, setup, joints), pose, what);
            expect_same(sim::forward_by_frames(machine, setup, joints), pose, what + " by frames");
          }
        }
      }
    }
  }
}

// (machine.h, property 2)
TEST(MachineTypes, BothBranchesAreTheTwoThatThereAre) {
  // Away from the pole a pose has two solutions and one of them is the joints that it came from.
  Workshop shop(99);
  for (const Structure structure : kStructures) {
    for (const Nominal& nominal : kNominals) {
      for (int i = 1; i < 200; ++i) {
        const MachineModel machine =
            shop.machine(structure, nominal.tilt, nominal.rotary, nominal.spindle, 1e-3);
        const tiltfeed::Setup setup = shop.setup();
        Joints q = random_joints(shop, machine, 1);
        const Pose pose = forward(machine, setup, q);
        const auto both = inverse(machine, setup, {pose.tip, normalized(pose.axis)}, 0.0);
        ASSERT_TRUE(both);
        double nearest = 1e9;
        for (const Joints& joints : *both)
          nearest = std::min(nearest, std::hypot(std::remainder(joints.a - q.a, 360.0),
                                                 std::remainder(joints.c - q.c, 360.0)));
        // The two merge at the pole and at the rim of the reach, where 1e-16 of the axis is 1e-8 of the
        // angle.
        EXPECT_LT(nearest, 1e-4) << nominal.name << " case " << i;
      }
    }
  }
}

// (machine.h, property 4)
TEST(MachineTypes, ProgramCoordinatesArePartCoordinatesAtHome) {
  Workshop shop(5);
  for (const Structure structure : kStructures) {
    const MachineModel m = shop.machine(structure, {0, 1, 1}, {0, 0, 1}, {0, 0, 1}, 0.05);
    const tiltfeed::Setup setup = shop.setup();
    const Point<Part> tip{4, 5, 6};
    const Joints joints = solve_linear(m, setup, tip, m.tilt.zero, m.rotary.zero);
    EXPECT_LT(length(Vec3{joints.x, joints.y, joints.z} - setup.fixture * from_origin(tip)), 1e-12);
  }
}

/// Random joint paths on random machines of every structure, a third of the poses near the rotary axis.
TEST(MachineTypes, RandomPathsStayOnTheirWay) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Workshop shop(seed);
    const Nominal& nominal = kNominals[seed % 4];
    // So little out of true that the pole is missed by less than the axis may stray.
    MachineModel m = shop.machine(kStructures[seed % 3], nominal.tilt, nominal.rotary, nominal.spindle,
                                  seed % 2 == 0 ? 0.0 : 5e-5);
    const MachineModel fast = joint_check::trunnion();
    m.x = m.y = m.z = {-1e5, 1e5, 12000, 2000};
    m.tilt.min = m.tilt.zero - 181;
    m.tilt.max = m.tilt.zero + 181;
    m.rotary.min = -36000;
    m.rotary.max = 36000;
    m.tilt.velocity = fast.tilt.velocity;
    m.rotary.velocity = fast.rotary.velocity;
    const tiltfeed::Setup setup = shop.setup();
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1), degrees(-180, 180);
    const Vec3 up = rotary_up(m, setup);
    const Vec3 across = normalized(cross(up, std::abs(up.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    std::vector<Pose> poses;
    for (int i = 0; i < 12; ++i) {
      const double tilt = unit(random) < 0.33 ? std::pow(10.0, -6 + 7 * unit(random)) : 55 * unit(random);
      const Vec3 leaning = rotation_about(across, tilt * kPi / 180) * up;
      poses.push_back({{shop.spread(40), shop.spread(40), shop.spread(40)},
                       normalized(rotation_about(up, degrees(random)) * leaning)});
    }
    const ToolPath path = joint_check::path_of(poses, seed % 3 == 0 ? MoveKind::kRapid : MoveKind::kCut);
    JointPathOptions options;
    options.axis_tolerance = 0.2;
    const auto joints = to_joints(path, m, setup, options);
    ASSERT_TRUE(joints) << joints.error().message;
    joint_check::check_densely(path, m, setup, options, *joints);
    ASSERT_FALSE(HasFailure());
  }
}

TEST(MachineTypes, AMisalignedAxisLeavesAConeThatCannotBeReached) {
  MachineModel m;
  m.name = "skew";
  m.tilt.direction = {1, 0, 0};
  m.rotary.letter = 'C';
  m.rotary.direction =
      normalized(Vec3{1e-3, 0, 1});  // tilts the tool about X never leave the plane square to X
  const auto pole = inverse(m, {}, {{0, 0, 0}, m.rotary.direction}, 0.0);
  ASSERT_FALSE(pole);
  EXPECT_EQ(pole.error().code, Code::kUnreachable);
  EXPECT_NE(pole.error().message.find("reaches 0.0573 to 179.9427 degrees"), std::string::npos)
      << pole.error().message;
  EXPECT_NE(pole.error().message.find("axis tolerance"), std::string::npos) << pole.error().message;
  EXPECT_TRUE(inverse(m, {}, {{0, 0, 0}, {0, 0, 1}}, 0.0));
}

MachineModel shipped(const std::string& name) {
  const auto profile = load_machine(SOURCE_DIR "/config/machines/" + name + ".yaml");
  EXPECT_TRUE(profile) << profile.error().message;
  return profile ? profile->model : MachineModel{};
}

struct Case {
  Joints q;
  double b, c;  ///< rad
};
Case random_case(Workshop& shop) {
  const Joints q{shop.spread(50), shop.spread(50), shop.spread(50), shop.spread(40), shop.spread(200)};
  return {q, Angle::from_degrees(q.a).radians(), Angle::from_degrees(q.c).radians()};
}

// maxkins with its default, unconventional B: the tool hangs off the B axis by L, the part turns with C.
TEST(MachineTypes, TheTabletopMillIsThatOfMaxkins) {
  const MachineModel m = shipped("linuxcnc-max5");
  tiltfeed::Setup setup;
  setup.tool_length = 35;
  Workshop shop(3);
  for (int i = 0; i < 100; ++i) {
    const auto [q, b, c] = random_case(shop);
    const double L = setup.tool_length, x = q.x + L * std::sin(b);
    const Pose expected{
        {std::cos(c) * x - std::sin(c) * q.y, std::sin(c) * x + std::cos(c) * q.y, q.z - L * std::cos(b) + L},
        {-std::sin(b) * std::cos(c), -std::sin(b) * std::sin(c), std::cos(b)}};
    expect_same(forward(m, setup, q), expected, "case " + std::to_string(i));
  }
}

// xyzac-trt with y-offset 20, z-offset 10 and the rotation point at the program's zero.
TEST(MachineTypes, TheTrunnionIsThatOfXyzacTrt) {
  const MachineModel m = shipped("linuxcnc-trunnion-ac");
  Workshop shop(4);
  const double dy = 20, dz = 10;
  for (int i = 0; i < 100; ++i) {
    const auto [q, a, c] = random_case(shop);
    const double y = std::cos(a) * (q.y - dy) + std::sin(a) * (q.z - dz) + dy;
    const double z = -std::sin(a) * (q.y - dy) + std::cos(a) * (q.z - dz) + dz;
    const Pose expected{{std::cos(c) * q.x + std::sin(c) * y, -std::sin(c) * q.x + std::cos(c) * y, z},
                        {std::sin(c) * std::sin(a), std::cos(c) * std::sin(a), std::cos(a)}};
    expect_same(forward(m, {}, q), expected, "case " + std::to_string(i));
  }
}

// 5axiskins: the tip hangs on a sphere of the pivot length (and tool) below the joint.
TEST(MachineTypes, TheBridgeMillIsThatOfFiveAxisKins) {
  const MachineModel m = shipped("linuxcnc-bridge-bc");
  tiltfeed::Setup setup;
  setup.part_zero = {10, 20, 30};  // where the part lies does not matter to a head
  setup.tool_length = 60;
  const double r = 250 + setup.tool_length;
  Workshop shop(6);
  for (int i = 0; i < 100; ++i) {
    const auto [q, b, c] = random_case(shop);
    const double polar = kPi - b;
    const Pose expected{{q.x + r * std::sin(polar) * std::cos(c), q.y + r * std::sin(polar) * std::sin(c),
                         q.z + r * std::cos(polar) + r},
                        {-std::sin(b) * std::cos(c), -std::sin(b) * std::sin(c), std::cos(b)}};
    expect_same(forward(m, setup, q), expected, "case " + std::to_string(i));
  }
}

// The worked vector of the 45 degree nutating head, kinematics/machine/README.md.
TEST(MachineTypes, TheNutatingHeadReproducesItsWorkedVector) {
  tiltfeed::Setup setup;
  setup.tool_length = 100;
  const Pose pose =
      forward(shipped("dmu-nutating-bc"), setup, {163.241799, 66.159770, -23.493649, 42.941403, -15.542268});
  EXPECT_LT(distance(pose.tip, {50, 20, 10}), 5e-6);
  EXPECT_LT(length(pose.axis - Vec3{0.5, 0, 0.866025404}), 5e-8);
}

TEST(RotaryWords, SayTheTurnThatIsMeant) {
  const struct {
    RotaryWord counting;
    double from, to, word;
  } table[] = {{RotaryWord::kAccumulate, 350, 370.5, 370.5}, {RotaryWord::kAccumulate, 10, -350, -350},
               {RotaryWord::kShortest, 350, 370.5, 10.5},    {RotaryWord::kShortest, 10, -9.5, 350.5},
               {RotaryWord::kShortest, 710, 720, 0},         {RotaryWord::kSigned, 350, 370.5, 10.5},
               {RotaryWord::kSigned, 370.5, 350, -350},      {RotaryWord::kSigned, 10, -9.5, -350.5},
               {RotaryWord::kSigned, -9.5, 10, 10}};
  for (const auto& row : table) {
    SCOPED_TRACE(std::to_string(row.from) + " to " + std::to_string(row.to));
    EXPECT_EQ(control_word(row.counting, row.to, row.from, 4), row.word);
    EXPECT_EQ(counted_turn(row.counting, row.word, row.from), row.to);
    EXPECT_EQ(sim::turned_to(row.counting, row.word, row.from), row.to);
  }
}

TEST(RotaryWords, OfAPathTurnTheSimulatorAlongWithIt) {
  // To and fro over whole turns, where a signed word has no sign.
  const auto poses = joint_check::sampled(600, [](double f) {
    return Pose{{20, 0, 0}, joint_check::axis_at(30, 90 + 800 * std::sin(6 * f))};
  });
  for (const RotaryWord counting : {RotaryWord::kShortest, RotaryWord::kSigned}) {
    MachineModel m = joint_check::trunnion();
    m.rotary.word = counting;
    m.rotary.min = -std::numeric_limits<double>::infinity();
    m.rotary.max = std::numeric_limits<double>::infinity();
    const auto joints = to_joints(joint_check::path_of(poses), m, joint_check::standing(), {});
    ASSERT_TRUE(joints) << joints.error().message;
    double counted = 0.0, at = 0.0, offset = 0.0;
    for (std::size_t i = 0; i < joints->moves.size(); ++i) {
      const double to = joints->moves[i].joints.c;
      if (i > 0 && to == at) continue;
      const double word = control_word(counting, to, at, 4);
      EXPECT_FALSE(word == 0.0 && counting == RotaryWord::kSigned);
      counted = sim::turned_to(counting, word, counted);
      if (i == 0) offset = to - counted;  // the first word may be reached on another turn
      ASSERT_NEAR(counted + offset, to, 1e-9) << "block " << i;
      at = to;
    }
    EXPECT_NEAR(std::remainder(offset, 360.0), 0.0, 1e-9);
  }
}

// (machine.h, property 5)
TEST(RotaryWords, AreReadBackByTheSimulatorFromAnyTurn) {
  std::mt19937 random(8);
  std::uniform_int_distribution<int> place(-20'000'000, 20'000'000), step(-1'799'999, 1'799'999);
  for (const RotaryWord counting : {RotaryWord::kShortest, RotaryWord::kSigned}) {
    for (int i = 0; i < 20000; ++i) {
      const int from = place(random), to = from + step(random);
      if (counting == RotaryWord::kSigned && to % 3'600'000 == 0) continue;
      const double word = control_word(counting, to / 1e4, from / 1e4, 4);
      ASSERT_LT(std::abs(word), 360.0);
      ASSERT_NEAR(sim::turned_to(counting, word, from / 1e4), to / 1e4, 1e-9) << from << " " << to;
      ASSERT_NEAR(counted_turn(counting, word, from / 1e4), to / 1e4, 1e-9) << from << " " << to;
    }
  }
}

}  // namespace
}  // namespace tiltfeed
