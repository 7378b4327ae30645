// The printed programs of the four demonstration parts, read back by the simulated control and moved by the
// simulated machine's own kinematics: between blocks, at many places of every block, tip, ball centre,
// shank's end and axis stay on the planned path (K6), (K7).

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "config/job.h"
#include "daemon/post/block.h"
#include "kinematics/basics/tolerance_budget.h"
#include "kinematics/joints/joint_path.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/plan/plan.h"
#include "sim/gcode/gcode_reader.h"
#include "sim/motion/forward.h"
#include "sim/parts/parts.h"
#include "tests/judges/joint_path_check.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

// Places on each block. The post samples eight; these are no multiple of them, so they fall between.
constexpr int kPlaces = 27;
// Passes this much further apart than the job's: fewer of the same.
constexpr double kSparser = 5.0;
// The shank's end is looked at in each block of so many, at every so many places.
constexpr std::size_t kSomeBlocks = 20;
constexpr int kSomePlaces = 4;

struct Worst {
  double tip = 0, centre = 0, axis = 0, rapid = 0, end = 0;
  std::size_t tip_block = 0, axis_block = 0;
};

/// How far tip and shank's end, `reach` up the axis, are from where they should be, at the place of the move
/// where the further of them is the nearest.
double off_move(const Pose& pose, const Pose& from, const Pose& to, double reach) {
  const auto off = [&](double share) {
    const Vec3 tip = pose.tip - lerp(from.tip, to.tip, share);
    return std::max(length(tip), length(tip + (pose.axis - slerp(from.axis, to.axis, share)) * reach));
  };
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
    (off(a) < off(b) ? high : low) = off(a) < off(b) ? b : a;
  }
  return std::min({off(0.5 * (low + high)), off(0.0), off(1.0)});
}

/// The executed blocks against the moves that they belong to.
Worst sampled(const ToolPath& path, const JointPath& joints, const std::vector<sim::Block>& blocks,
              const MachineModel& machine, const tiltfeed::Setup& setup, double reach) {
  Worst worst;
  const double radius = path.tool.corner_radius;
  for (std::size_t i = 1; i < blocks.size(); ++i) {
    const std::size_t move = joints.moves[i].move;
    const Pose &from = path.moves[move - 1].pose, &to = path.moves[move].pose;
    const Joints &p = blocks[i - 1].target, &q = blocks[i].target;
    for (int k = 1; k <= kPlaces; ++k) {
      const double f = static_cast<double>(k) / kPlaces, g = 1 - f;
      const Pose pose = sim::forward_by_frames(
          machine, setup,
          {g * p.x + f * q.x, g * p.y + f * q.y, g * p.z + f * q.z, g * p.a + f * q.a, g * p.c + f * q.c});
      const double tip = joint_check::off_segment(pose.tip, from.tip, to.tip);
      const double axis = joint_check::off_arc(pose.axis, from.axis, to.axis);
      const double centre = joint_check::off_segment(
          pose.tip + pose.axis * radius, from.tip + from.axis * radius, to.tip + to.axis * radius);
      if (path.moves[move].kind == MoveKind::kRapid) {
        worst.rapid = std::max(worst.rapid, tip);
        continue;
      }
      if (i % kSomeBlocks == 0 && k % kSomePlaces == 2)
        worst.end = std::max(worst.end, off_move(pose, from, to, reach));
      if (tip > worst.tip) worst.tip = tip, worst.tip_block = i;
      if (axis > worst.axis) worst.axis = axis, worst.axis_block = i;
      // The centre of a turning tool runs on a bow; only moves that hardly turn have a straight one.
      if (angle_between(from.axis, to.axis) < 1e-4) worst.centre = std::max(worst.centre, centre);
    }
  }
  return worst;
}

/// Plans and posts a job, reads the program back and measures it; then holds it to what was asked.
Worst expect_on_path(Job& job, const std::string& part_name) {
  Stl stl;
  stl.facets = *sim::part_by_name(part_name);
  const auto part = check_mesh(stl, {ToleranceBudget(job.plan.tolerance).repair()});
  const auto planned = part ? plan(*part, job.plan, nullptr) : tl::unexpected(part.error());
  EXPECT_TRUE(planned) << planned.error().message;
  if (!planned) return {};
  JointPathOptions options;
  options.tolerance = ToleranceBudget(job.plan.tolerance).joints();
  options.reach = job.plan.cutter.shank_length;
  options.axis_tolerance =
      std::min(options.axis_tolerance,
               Angle::from_radians(options.tolerance / job.plan.cutter.shank_length).degrees());
  const auto joints = to_joints(planned->path, job.machine.model, job.setup, options);
  EXPECT_TRUE(joints) << joints.error().message;
  if (!joints) return {};
  std::stringstream text;
  const auto before = std::chrono::steady_clock::now();
  EXPECT_TRUE(write_program(*joints, job, text));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;

  const auto read = sim::read_program(text, part_name, sim::GcodeReader(job.machine.model));
  EXPECT_TRUE(read) << read.error().message;
  if (!read) return {};
  std::vector<sim::Block> blocks;
  for (const sim::Block& block : *read)
    if (block.op == sim::Op::kRapid || block.op == sim::Op::kFeed) blocks.push_back(block);
  // Before the first block of the path: the retract, rotaries, X Y; behind its last the retract.
  const auto down =
      std::find_if(blocks.begin(), blocks.end(), [](const sim::Block& block) { return !block.off_path; });
  blocks.erase(blocks.begin(), down == blocks.begin() ? down : std::prev(down));
  if (blocks.back().off_path) blocks.pop_back();
  EXPECT_EQ(blocks.size(), joints->moves.size());
  const Worst worst = sampled(planned->path, *joints, blocks, job.machine.model, job.setup, options.reach);
  std::printf(
      "%s on %s: %zu blocks, %.0f blocks/s posted; tip %.5f mm (block %zu), centre %.5f mm, end %.5f mm, "
      "axis "
      "%.5f degrees (block %zu), rapids %.4f mm; allowed %.5f mm, %.5f degrees\n",
      part_name.c_str(), job.machine.model.name.c_str(), blocks.size(),
      static_cast<double>(blocks.size()) / took.count(), worst.tip, worst.tip_block, worst.centre, worst.end,
      worst.axis, worst.axis_block, worst.rapid, options.tolerance, options.axis_tolerance);
  EXPECT_LE(worst.tip, options.tolerance);
  EXPECT_LE(worst.centre, options.tolerance);
  EXPECT_LE(worst.end, options.tolerance);
  EXPECT_LE(worst.axis, options.axis_tolerance);
  EXPECT_LE(worst.rapid, options.tolerance * kRapidToleranceFactor);
  // The bounds are used, not undercut by needless blocks; where passes do not turn the tool, by rapids.
  EXPECT_GT(std::max(worst.tip, worst.rapid / kRapidToleranceFactor), 0.5 * options.tolerance);
  return worst;
}

class Posted : public testing::TestWithParam<const char*> {};

TEST_P(Posted, ProgramStaysOnThePathBetweenItsBlocks) {
  const std::string name = GetParam();
  auto job = load_job(SOURCE_DIR "/config/jobs/" + name + ".yaml");
  ASSERT_TRUE(job) << job.error().message;
  job->plan.pattern.side_step *= kSparser;
  expect_on_path(*job, name);
}

/// Every structure, counting of words and sign that is shipped, with travels that hold the sphere.
TEST(PostedMachines, EveryShippedMachineCutsTheSphere) {
  for (const auto& entry : std::filesystem::directory_iterator(SOURCE_DIR "/config/machines")) {
    SCOPED_TRACE(entry.path().string());
    auto job = load_job(SOURCE_DIR "/config/jobs/sphere.yaml");
    ASSERT_TRUE(job) << job.error().message;
    const auto machine = load_machine(entry.path().string());
    ASSERT_TRUE(machine) << machine.error().message;
    job->machine = *machine;
    job->machine.format = usual_format(Dialect::kRs274);  // what the simulated machine reads
    MachineModel& model = job->machine.model;
    if (!model.tilt.present || !model.rotary.present) continue;  // fewer_axes_test has these
    for (LinearAxis* axis : {&model.x, &model.y, &model.z}) axis->min = -2000, axis->max = 2000;
    job->plan.tilt_max = Angle::from_degrees(45);
    job->plan.pattern.side_step *= 2 * kSparser;
    expect_on_path(*job, "sphere");
  }
}

INSTANTIATE_TEST_SUITE_P(Parts, Posted, testing::Values("tyre", "pin", "sphere", "handle"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace
}  // namespace tiltfeed
