// The four formula parts, planned and posted in every dialect: the text read back by two readers gives the
// words to the last digit, and the printed program, sampled densely with the simulated machine's own
// kinematics, stays on the planned path. Prints the figures.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "config/job.h"
#include "kinematics/timing/tcp_path.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/plan/plan.h"
#include "sim/motion/forward.h"
#include "sim/parts/parts.h"
#include "tests/judges/dialect_reader.h"
#include "tests/texts/dialect_posting.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

constexpr double kTolerance = 0.0035;   // of the joints, mm
constexpr double kAxisTolerance = 0.1;  // degrees
constexpr int kSamples = 16;            // places in each block
// Printed with three decimals, a tip may be off by 0.0005 mm an axis, and by the rotaries' rounding at the
// lever.
constexpr double kCoarsePrint = 0.006;

/// The job of a part, its rows further apart.
Job coarse_job(const std::string& name) {
  auto job = load_job(SOURCE_DIR "/config/jobs/" + name + ".yaml");
  EXPECT_TRUE(job) << job.error().message;
  job->plan.pattern.side_step *= 8.0;
  job->program.tool = 3;
  return *job;
}

ToolPath planned_path(const std::string& name, const Job& job) {
  Stl stl;
  stl.facets = *sim::part_by_name(name);
  const auto part = check_mesh(stl);
  EXPECT_TRUE(part) << part.error().message;
  const auto planned = plan(*part, job.plan, nullptr);
  EXPECT_TRUE(planned) << planned.error().message;
  return planned->path;
}

struct Deviations {
  double tip = 0.0, axis = 0.0;
};

/// Every block of feed of the printed words against its move of the path.
Deviations sampled(const std::vector<SeenBlock>& blocks, const JointPath& words, const ToolPath& path,
                   const Job& job) {
  Deviations worst;
  const MachineModel& machine = job.machine.model;
  const bool tcp = job.machine.format.tcp;
  for (std::size_t i = 1; i < blocks.size(); ++i) {
    if (blocks[i].rapid) continue;
    const Joints &p = blocks[i - 1].words, &q = blocks[i].words;
    const std::uint32_t move = words.moves[i].move;
    const Pose &from = path.moves[move - 1].pose, &to = path.moves[move].pose;
    const double whole = angle_between(from.axis, to.axis);
    for (int s = 1; s <= kSamples; ++s) {
      const double f = static_cast<double>(s) / kSamples;
      const Joints at{p.x + f * (q.x - p.x), p.y + f * (q.y - p.y), p.z + f * (q.z - p.z),
                      p.a + f * (q.a - p.a), p.c + f * (q.c - p.c)};
      Pose pose = sim::forward_by_frames(machine, job.setup, at);
      if (tcp) {
        const Vec3 tip = transposed(job.setup.fixture) * Vec3{at.x, at.y, at.z};
        pose.tip = {tip.x, tip.y, tip.z};
      }
      worst.tip = std::max(worst.tip, distance_to_segment(pose.tip, from.tip, to.tip));
      // The nearest place of the great circle.
      const double turned = std::clamp(angle_between(from.axis, pose.axis), 0.0, whole);
      const Vec3 nearest = whole > 0.0 ? slerp(from.axis, to.axis, turned / whole) : to.axis;
      worst.axis = std::max(worst.axis, angle_between(nearest, pose.axis));
    }
  }
  worst.axis = Angle::from_radians(worst.axis).degrees();
  return worst;
}

class DialectParts : public testing::TestWithParam<const char*> {};

TEST_P(DialectParts, ReadBackToTheLastDigitAndOnThePath) {
  const std::string name = GetParam();
  Job job = coarse_job(name);
  const ToolPath path = planned_path(name, job);
  for (const auto& [dialect, tcp] : dialect_cases()) {
    const std::string trace = name_of(dialect).name + std::string(tcp ? " TCP" : "");
    SCOPED_TRACE(trace);
    job.machine.format = usual_format(dialect);
    job.machine.format.tcp = tcp;
    const ProgramFormat& format = job.machine.format;
    JointPathOptions options;
    options.tolerance = kTolerance;
    options.axis_tolerance = tcp ? kAxisTolerance / 2.0 : kAxisTolerance;
    options.linear_decimals = tcp ? kTcpDecimals : format.linear_decimals;
    options.rotary_decimals = format.rotary_decimals;
    auto words = to_joints(path, job.machine.model, job.setup, options);
    ASSERT_TRUE(words) << words.error().message;
    if (tcp)
      *words = words_under_tcp(*words, job.machine.model, job.setup,
                               {format.linear_decimals, kAxisTolerance / 2.0});
    Posting posting{job.plan.name, job.machine, job.program, {}};
    posting.operations.push_back(
        {&*words, job.setup, path.tool, 3, path.cut_feed, path.plunge_feed, path.feeds, {}});
    std::ostringstream out;
    const auto written = write_program(posting, out);
    ASSERT_TRUE(written) << written.error().message;
    SeenProgram seen = seen_program(out.str(), dialect == Dialect::kHeidenhain, job.machine.model.tilt.letter,
                                    job.machine.model.rotary.letter);
    EXPECT_EQ(seen.trouble, "");
    std::istringstream in(out.str());
    const auto read = read_nc_program(in, "x.nc", language_of(job.machine));
    ASSERT_TRUE(read) << read.error().message;
    std::vector<TextBlock> blocks = read->operations[0].blocks;
    ASSERT_EQ(seen.blocks.size(), blocks.size());
    const auto start =
        static_cast<std::ptrdiff_t>(blocks_before({dialect, tcp}, read->operations[0], words->moves.size()));
    seen.blocks.erase(seen.blocks.begin(), seen.blocks.begin() + start);
    blocks.erase(blocks.begin(), blocks.begin() + start);
    ASSERT_EQ(blocks.size(), words->moves.size());
    for (std::size_t i = 0; i < words->moves.size(); ++i) {
      ASSERT_EQ(seen.blocks[i].words, words->moves[i].joints) << "block " << i;
      ASSERT_EQ(seen.blocks[i].rapid, words->moves[i].kind == MoveKind::kRapid) << "block " << i;
      ASSERT_EQ(blocks[i].words, words->moves[i].joints) << "block " << i;
    }
    const Deviations worst = sampled(seen.blocks, *words, path, job);
    std::printf("%s %s: %zu blocks, tip %.4f mm, axis %.4f degrees\n", name.c_str(), trace.c_str(),
                words->moves.size(), worst.tip, worst.axis);
    EXPECT_LE(worst.tip, format.linear_decimals < 4 ? kCoarsePrint : kTolerance);
    EXPECT_LE(worst.axis, kAxisTolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(Parts, DialectParts, testing::Values("tyre", "pin", "sphere", "handle"));

}  // namespace
}  // namespace tiltfeed
