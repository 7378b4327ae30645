// How often planning says how far it is, and that it stops where it is told to; counted, not timed.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>
#include <set>

#include "kinematics/basics/units.h"

#include "pathgen/progress/watch.h"
#include "tests/samples.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

CheckedMesh wavy() {
  return sheet(kUpright, {-12, 12, -12, 12, 24, 24},
               [](double u, double v) { return 2.0 * std::sin(u / 3.0) * std::cos(v / 4.0); });
}

struct Case {
  const char* name;
  PlanOptions options;
  std::vector<std::string> stages;  ///< whose share must be seen to grow
};

std::vector<Case> cases() {
  PlanOptions plain = options_with(kUpright);
  plain.find_rest_material = true;
  std::vector<Case> all{{"rows", plain, {"CL surface", "passes", "link", "uncut"}}};
  const auto add = [&](const char* name, const std::vector<std::string>& stages) -> PlanOptions& {
    all.push_back({name, plain, stages});
    return all.back().options;
  };
  add("scallop", {"passes"}).pattern.measure = StepMeasure::kScallop;
  all.back().options.pattern.scallop = 0.02;
  add("ridge", {"passes"}).pattern.measure = StepMeasure::kRidge;
  for (const PatternKind kind : {PatternKind::kZLevel, PatternKind::kSplit, PatternKind::kRough}) {
    add("levels", {"passes"}).pattern.kind = kind;
    all.back().options.pattern.step_down = 0.5;
  }
  for (const Reaction reaction : {Reaction::kRetract, Reaction::kTrim, Reaction::kReport}) {
    PlanOptions& held = add("holder", {});
    held.cutter.length = 40.0, held.cutter.shank_length = 1.0;
    held.cutter.holder = {{30.0, 30.0, 30.0}};
    held.holder = {0.2, reaction};
    if (reaction == Reaction::kReport)
      all.back().stages = {"touches"};
    else
      all.back().stages = {"guards", "shank and holder"};
  }
  PlanOptions& indexed = add("indexed", {"directions"});
  indexed.axis.mode = AxisMode::kIndexed;
  indexed.find_rest_material = false;
  PlanOptions& free = add("free", {"CL surface", "orientation", "link"});
  free.axis.mode = AxisMode::kFree;
  free.free.plane_normals = {{0, 1, 0}};
  free.find_rest_material = false;
  return all;
}

using Shares = std::map<std::string, std::vector<double>>;

TEST(Progress, EveryStageMovesItsShareAndNeverBack) {
  const CheckedMesh part = wavy();
  // One thread, so that the one that is told sees all the work.
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    Shares seen;
    std::string last;
    const auto planned = plan(part, c.options, [&](const char* stage, double share) {
      EXPECT_GE(share, 0.0);
      EXPECT_LE(share, 1.0);
      std::vector<double>& shares = seen[stage];
      if (!shares.empty() && c.options.axis.mode != AxisMode::kIndexed) {
        EXPECT_GE(share, shares.back()) << stage;
      }
      shares.push_back(share);
      return true;
    });
    ASSERT_TRUE(planned) << planned.error().message;
    for (const std::string& stage : c.stages) {
      const std::set<double> steps(seen[stage].begin(), seen[stage].end());
      EXPECT_GE(steps.size(), 8u) << stage;
    }
  }
}

TEST(Progress, StopsAtEachWordAndAsksNoMore) {
  const CheckedMesh part = wavy();
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    int all = 0;
    ASSERT_TRUE(plan(part, c.options, [&](const char*, double) { return ++all, true; }));
    for (int stop = 1; stop <= all; stop += std::max(1, all / samples(12))) {
      int calls = 0;
      std::string where;
      const auto planned = plan(part, c.options, [&](const char* stage, double) {
        where = stage;
        return ++calls < stop;
      });
      if (calls < stop) continue;  // fewer looks this time: they follow the clock, too
      ASSERT_FALSE(planned) << where << ", word " << stop;
      EXPECT_EQ(planned.error().code, Code::kCancelled) << where << ": " << planned.error().message;
      EXPECT_EQ(calls, stop) << where;
    }
  }
}

TEST(Watch, ReportsEachHundredthAndEndsLoopsAtOnce) {
  int reports = 0;
  const ReportShare count = [&](double) { return ++reports, true; };
  Watch watch(count, 10'000);
  for (int i = 0; i < 10'000; ++i) ASSERT_TRUE(watch.next());
  EXPECT_GE(reports, 100);
  const ReportShare stop = [](double share) { return share < 0.5; };
  Watch stopping(stop, 1'000);
  int done = 0;
  while (done < 1'000 && stopping.next()) ++done;
  EXPECT_GE(done, 500);
  EXPECT_LE(done, 510);
  EXPECT_FALSE(stopping.next());
}

}  // namespace
}  // namespace tiltfeed
