// How high the tip is over the part where the table turns under TCP, and what is said of it.

#include "daemon/plan/start_turn.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "daemon/post/tcp_start.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

Job job_on(const std::string& name) {
  Job job;
  auto profile = load_machine(SOURCE_DIR "/config/machines/" + name + ".yaml", Dialect::kFanuc);
  EXPECT_TRUE(profile) << profile.error().message;
  job.machine = *profile;
  job.machine.format.tcp = true;
  job.setup.part_zero = {120, -30, 20};
  job.setup.tool_length = 100.0;
  job.plan.links.clearance = 5.0;
  return job;
}

Mesh slab() {
  Mesh mesh;
  for (const double x : {-40.0, 40.0})
    for (const double y : {-30.0, 30.0})
      for (const double z : {0.0, 25.0}) mesh.vertices.push_back({x, y, z});
  return mesh;
}

/// Where a point of the part is on a machine whose table turns about z, and on it all tilts.
Vec3 on_machine(const MachineModel& m, const Setup& setup, Vec3 p, double a, double c) {
  const auto turned = [](const RotaryAxis& axis, double word, Vec3 v) {
    return rotation_about(axis.direction, Angle::from_degrees(axis.sign * (word - axis.zero)).radians()) * v;
  };
  const Vec3 on_table = turned(m.rotary, c, p + setup.part_zero);
  if (m.structure != Structure::kTableTable) return on_table;
  return turned(m.tilt, a, on_table - m.rotary_to_tilt) + m.rotary_to_tilt;
}

TEST(StartTurn, TheHeightIsThatOfTheTipOverTheHighestPoint) {
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "dmu-nutating-bc"})
    for (const double below : {50.0, 300.0}) {
      Job job = job_on(name);
      job.machine.format.tcp_start_below = below;
      const MachineModel& m = job.machine.model;
      const Joints first{20, 30, m.z.min, m.structure == Structure::kTableTable ? -35.0 : 20.0, 140};
      const auto turn = start_turn(slab(), job, first);
      ASSERT_TRUE(turn);
      const std::vector<Joints> start = tcp_start(job.machine, job.setup, first);
      EXPECT_EQ(turn->blocks, start.size());
      double least = 1e9;
      for (std::size_t i = 1; i < start.size(); ++i)
        for (double f = 0.0; f <= 1.0; f += 0.01) {
          const Joints &p = start[i - 1], &q = start[i];
          const double a = p.a + f * (q.a - p.a), c = p.c + f * (q.c - p.c);
          const auto height = [&](Vec3 at) { return on_machine(m, job.setup, at, a, c).z; };
          double top = -1e9;
          for (const Point<Part>& v : slab().vertices) top = std::max(top, height({v.x, v.y, v.z}));
          const double tip = height({p.x + f * (q.x - p.x), p.y + f * (q.y - p.y), p.z + f * (q.z - p.z)});
          least = std::min(least, tip - top);
        }
      // Between four places of a block the way bends by a sixteenth of what it does in the whole block.
      EXPECT_NEAR(turn->height, least, m.structure == Structure::kTableTable ? 0.8 : 1e-6)
          << name << " " << below;
    }
}

TEST(StartTurn, ATableThatDoesNotTurnIsNotSpokenOf) {
  Job job = job_on("generic-ac");
  EXPECT_FALSE(start_turn(slab(), job, {20, 30, 0, 20, 360}));
  EXPECT_TRUE(start_turn(slab(), job, {20, 30, 0, 20, 90}));
  job.machine.format.dialect = Dialect::kSiemens;
  EXPECT_FALSE(start_turn(slab(), job, {20, 30, 0, 20, 90}));
}

TEST(StartTurn, ALowTipIsAWarning) {
  const Job job = job_on("generic-ac");
  const std::string high = start_turn_text({412.34, 4}, job), low = start_turn_text({4.9, 4}, job),
                    under = start_turn_text({-12.0, 4}, job);
  EXPECT_EQ(
      high,
      "where TCP begins the table turns from home to its place, the tip 412.3 mm over the top of the part\n");
  for (const std::string& text : {low, under}) {
    EXPECT_TRUE(text.starts_with("warning: ")) << text;
    EXPECT_NE(text.find("program.tcp_start_below_mm"), std::string::npos) << text;
  }
  EXPECT_NE(under.find("12.0 mm under the top"), std::string::npos) << under;
  EXPECT_EQ(start_turn_comment({412.34, 4}, job), "table turns, tip 412.3 mm over part");
}

/// Of the lines in which the table turns, each; of those before and behind, none.
TEST(StartTurn, AHitThereNamesTheKey) {
  Job job = job_on("generic-ac");
  const std::string head =
      "O0001 (part)\nG0 A0. C0.\nG0 X1. Y2.\nG0 G43.4 H1 X1. Y2. Z9. A0. C0.\nG0 X2. Y2. Z9. A0. C30.\n"
      "G0 X2. Y1. Z9. A0. C60.\nG0 X2. Y1. Z3. A0. C60.\n";
  for (int line = 1; line <= 7; ++line) {
    const std::string message = "not proven, nothing was written: /a/u.nc:" + std::to_string(line) +
                                ": gouge: cutter 5 mm deep, block 2";
    const std::string advice = start_turn_advice({-12.0, 3}, job, head, message, "/a/u.nc");
    EXPECT_EQ(advice.find("a smaller program.tcp_start_below_mm than 50 in ") != advice.npos,
              line >= 4 && line <= 6)
        << line << advice;
    EXPECT_EQ(advice.empty(), line < 4 || line > 6);
  }
  job.machine.format.tcp_start_below = 0.0;
  const std::string advice = start_turn_advice({-12.0, 3}, job, head, "/a/u.nc:5: gouge", "/a/u.nc");
  EXPECT_NE(advice.find("program.tcp_start_below_mm has it at the end of Z's travel"), advice.npos) << advice;
  EXPECT_NE(advice.find("put the part lower"), advice.npos);
}

}  // namespace
}  // namespace tiltfeed
