// The part's size in words, and the warning where its unit can hardly be meant.
#include "daemon/plan/part_size.h"

#include <gtest/gtest.h>

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

Job job_with(double diameter, double unit_mm) {
  Job job;
  job.plan.cutter.diameter = diameter;
  job.stl_unit_mm = unit_mm;
  MachineModel& m = job.machine.model;
  m.x.min = -300, m.x.max = 300, m.y.min = -200, m.y.max = 200, m.z.min = -400, m.z.max = 0;
  return job;
}

Box box(double x, double y, double z) { return {{1, 2, 3}, {1 + x, 2 + y, 3 + z}}; }

TEST(PartSize, IsInMillimetres) { EXPECT_EQ(size_text(box(100, 80.5, 40)), "part 100 x 80.5 x 40 mm"); }

TEST(PartSize, WarnsOfAUnitThatCanHardlyBeMeant) {
  struct Case {
    double longest, diameter, unit_mm;
    const char* asks;  ///< empty: no warning
  };
  for (const Case& c : {Case{100, 6, 1, ""}, Case{20, 6, 1, ""}, Case{12, 1, 1, ""}, Case{600, 6, 1, ""},
                        Case{3.94, 6, 1, "part.unit to inch"}, Case{0.1, 6, 1, "part.unit to m"},
                        Case{2540, 6, 25.4, "part.unit to mm"}, Case{25400, 6, 1000, "part.unit to mm"},
                        Case{1e5, 6, 1, "check part.unit"}, Case{15, 6, 1, "part.unit to inch"}}) {
    const auto warning =
        unit_warning(box(c.longest, c.longest / 2, c.longest / 4), job_with(c.diameter, c.unit_mm));
    EXPECT_EQ(warning.has_value(), *c.asks != '\0') << c.longest;
    if (warning) {
      EXPECT_NE(warning->find(c.asks), std::string::npos) << *warning;
    }
  }
}

}  // namespace
}  // namespace tiltfeed
