#pragma once
// `tiltfeed plan`: the way from STL to a proven program, in order.

#include <string>

namespace tiltfeed {

struct PlanFiles {
  std::string job, program, cl, report, map, stl, machine;
  std::string gouge_picture;  ///< PNG, where the program is not proven
  bool prove = true;
  std::string progress;  ///< file that holds stage and percentage while it plans
};

/// The exit status: 0 done, 1 failed, 2 wrong use. Files appear when all of them are written, or not at all.
int plan_command(const PlanFiles& files);

}  // namespace tiltfeed
