// `machine check` for every shipped profile: its program is read by the simulated control, whose own
// kinematics finds the tip where the comments say, in one place all the time.

#include "daemon/post/machine_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "sim/gcode/gcode_reader.h"
#include "sim/motion/forward.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

MachineProfile shipped(const std::string& name) {
  const auto profile = load_machine(SOURCE_DIR "/config/machines/" + name + ".yaml");
  EXPECT_TRUE(profile) << profile.error().message;
  return profile.value_or(MachineProfile{});
}

struct Said {
  Vec3 tip, axis;
};

/// "(3: TIP 0 0 100 AXIS 0 -0.5 0.866)" of a program's comments.
std::vector<Said> said(const std::string& program) {
  std::vector<Said> all;
  std::istringstream in(program);
  for (std::string line; std::getline(in, line);) {
    const std::size_t at = line.find(": TIP ");
    if (at == std::string::npos) continue;
    Said s;
    std::string word;
    std::istringstream words(line.substr(at + 6));
    words >> s.tip.x >> s.tip.y >> s.tip.z >> word >> s.axis.x >> s.axis.y >> s.axis.z;
    EXPECT_EQ(word, "AXIS");
    all.push_back(s);
  }
  return all;
}

TEST(MachineCheck, HoldsTheTipStillOnEveryShippedMachine) {
  for (const auto& entry : std::filesystem::directory_iterator(SOURCE_DIR "/config/machines")) {
    const MachineProfile machine = shipped(entry.path().stem().string());
    SCOPED_TRACE(machine.model.name);
    const double height = machine.model.z.max < 50.0 ? -50.0 : 50.0;
    const auto program = check_program(machine, 80.0, height);
    ASSERT_TRUE(program) << program.error().message;
    std::istringstream in(*program);
    const auto blocks = sim::read_program(in, "check.nc", sim::GcodeReader(machine.model));
    ASSERT_TRUE(blocks) << blocks.error().message;
    const std::vector<Said> expected = said(*program);
    tiltfeed::Setup setup;
    setup.tool_length = 80.0;
    std::size_t stop = 0;
    bool tilted = false, turned = false;
    for (const sim::Block& block : *blocks) {
      if (block.op != sim::Op::kFeed) continue;
      ASSERT_LT(stop, expected.size());
      const Pose pose = sim::forward_by_frames(machine.model, setup, block.target);
      EXPECT_LT(distance(pose.tip, {0, 0, height}), 5e-4) << "stop " << stop + 1;
      EXPECT_LT(length(from_origin(pose.tip) - expected[stop].tip), 1.1e-3);
      EXPECT_LT(length(pose.axis - expected[stop].axis), 1.1e-4);
      EXPECT_TRUE(within_limits(machine.model, block.target));
      tilted = tilted || std::abs(block.target.a - machine.model.tilt.zero) > 5;
      turned = turned || std::abs(block.target.c - machine.model.rotary.zero) > 5;
      ++stop;
    }
    EXPECT_EQ(stop, expected.size());
    const MachineModel& model = machine.model;
    EXPECT_GE(stop, model.tilt.present && model.rotary.present ? 5u : 1u);
    EXPECT_EQ(tilted, model.tilt.present);
    EXPECT_EQ(turned, model.rotary.present);
    for (std::string line; std::getline(in, line);) EXPECT_LE(line.size(), 79u) << line;
  }
}

TEST(MachineCheck, SaysWhichWayTheToolLeans) {
  // A10: the tip of an A head swings so that the shank leans to -Y; its table sees it unturned.
  const auto program = check_program(shipped("generic-ac"), 100.0, 100.0);
  ASSERT_TRUE(program);
  EXPECT_NE(program->find("stands upright"), std::string::npos);
  const std::size_t tilted = program->find("(2: TIP 0 0 100 AXIS 0 -0.1736 0.9848)");
  ASSERT_NE(tilted, std::string::npos) << *program;
  EXPECT_NE(program->find("leans to -Y", tilted), std::string::npos);
  EXPECT_NE(program->find(" A10 C0 ", tilted), std::string::npos);
}

/// A Fanuc takes B10 for 0.01 degrees. Who cannot read the program at all is told.
TEST(MachineCheck, NumbersAreThoseOfTheControl) {
  for (const auto& [dialect, words, by_hand] :
       {std::tuple{config::Dialect::kRs274, "X0 Y0 Z100 A0 C0 F300\n", false},
        {config::Dialect::kFanuc, "X0. Y0. Z100. A0. C0. F300.\n", false},
        {config::Dialect::kHaas, "X0. Y0. Z100. A0. C0. F300.\n", false},
        {config::Dialect::kSiemens, "X0 Y0 Z100 A0 C0 F300\n", true},
        {config::Dialect::kHeidenhain, "X0 Y0 Z100 A0 C0 F300\n", true}}) {
    const auto machine = load_machine(SOURCE_DIR "/config/machines/generic-ac.yaml", dialect);
    ASSERT_TRUE(machine) << machine.error().message;
    const auto program = check_program(*machine, 100.0, 100.0);
    ASSERT_TRUE(program) << program.error().message;
    EXPECT_NE(program->find(words), std::string::npos) << *program;
    EXPECT_EQ(program->find("ENTER EACH PLACE BY HAND") != std::string::npos, by_hand) << *program;
  }
}

TEST(MachineCheck, ConfessesThatNoPlaceIsWithinTheLimits) {
  const auto program = check_program(shipped("generic-ac"), 100.0, 5000.0);
  ASSERT_FALSE(program);
  EXPECT_EQ(program.error().code, Code::kLimit);
  EXPECT_NE(program.error().message.find("Z 5000 mm is above its travel"), std::string::npos)
      << program.error().message;
}

}  // namespace
}  // namespace tiltfeed
