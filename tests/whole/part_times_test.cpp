// The four formula parts, planned, posted and executed by the simulated axes: the time that planning foresees
// is within 2 % of theirs, with limits of acceleration alone and with those of jerk. Prints the figures.

#include <gtest/gtest.h>

#include <cstdio>
#include <sstream>

#include "config/job.h"
#include "daemon/post/block.h"
#include "daemon/post/post.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/plan/plan.h"
#include "sim/parts/parts.h"
#include "sim/removal/executed_path.h"

namespace tiltfeed {
namespace {

struct TimedPart {
  const char *part, *job;
};

class PartTimes : public testing::TestWithParam<TimedPart> {};

TEST_P(PartTimes, AsTheSimulatedMachine) {
  const TimedPart which = GetParam();
  auto job = config::load_job(std::string(SOURCE_DIR "/config/jobs/") + which.job + ".yaml");
  ASSERT_TRUE(job) << job.error().message;
  job->plan.pattern.side_step *= 8.0;
  pathgen::Stl stl;
  stl.facets = *sim::part_by_name(which.part);
  const auto part = pathgen::check_mesh(stl);
  ASSERT_TRUE(part) << part.error().message;
  const auto planned = pathgen::plan(*part, job->plan, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  JointPathOptions options;
  options.tolerance = 0.0035;
  for (const bool jerk : {false, true}) {
    MachineModel& m = job->machine.model;
    if (jerk) {
      m.x.jerk = m.y.jerk = m.z.jerk = 50000.0;
      m.tilt.jerk = 15000.0, m.rotary.jerk = 30000.0;
    }
    const auto joints = to_joints(planned->path, m, job->setup, options);
    ASSERT_TRUE(joints) << joints.error().message;
    std::stringstream text;
    const auto written = daemon::write_program(*joints, *job, text);
    ASSERT_TRUE(written) << written.error().message;
    sim::ProgramRun run("p.nc", m, job->setup, sim::motion_options(job->machine), joints->moves.size());
    const auto read = sim::read_program(text, "p.nc", sim::GcodeReader(m),
                                        [&](const sim::Block& block) { run.take(block); });
    ASSERT_TRUE(read) << read.error().message;
    const auto path = run.finish();
    ASSERT_TRUE(path) << path.error().message;
    double executed = 0.0;
    for (const sim::ExecutedMove& move : path->moves)
      if (!move.off_path) executed += move.end - move.start;
    const Timing timing = daemon::time_moves(joints->moves, job->machine, options.tolerance, 0.05);
    // (K10), which knows no jerk and rounds corners off.
    const double rounded = time_blocks(joints->moves, m, options.tolerance, 0.05).seconds;
    std::printf("%-15s%-5s %7zu blocks: simulated %8.1f s, foreseen %+.2f %%, by (K10) %+.2f %%\n", which.job,
                jerk ? " jerk" : "", joints->moves.size(), executed,
                100.0 * (timing.seconds / executed - 1.0), 100.0 * (rounded / executed - 1.0));
    EXPECT_NEAR(timing.seconds / executed, 1.0, 0.02);
  }
}

INSTANTIATE_TEST_SUITE_P(Parts, PartTimes,
                         testing::Values(TimedPart{"tyre", "tyre"}, TimedPart{"pin", "pin"},
                                         TimedPart{"sphere", "sphere"}, TimedPart{"handle", "handle"},
                                         TimedPart{"handle", "handle_free"},
                                         TimedPart{"handle", "handle_indexed"},
                                         TimedPart{"sphere", "sphere_free"}),
                         [](const auto& of) { return std::string(of.param.job); });

}  // namespace
}  // namespace tiltfeed
