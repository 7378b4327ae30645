#pragma once
// What was found at the stops of `tiltfeed machine check`: whether the profile is right, and what would make
// it so.

#include <string>
#include <vector>

#include "config/machine_profile.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// A change after which all stops agree.
struct CheckRemedy {
  std::string change;  ///< "rotary.sign: 1", of several keys with "and"
  double worst = 0.0;  ///< the largest distance that is left, mm
};
struct CheckResult {
  std::size_t stops = 0;
  double worst = 0.0;  ///< largest distance of the tip from where the profile puts it, mm
  std::string where;   ///< "stop 4 (A30 C0)"
  bool passed = false;
  std::vector<std::string> unseen;    ///< signs that these stops do not tell
  std::vector<CheckRemedy> remedies;  ///< each by itself; empty: none explains what was found
};

/// `table`: CSV with stop and either x_mm y_mm z_mm, the words at which the tool is centred on the ball that
/// it was centred on at stop 1, or dx_mm dy_mm dz_mm, by how much the tip is off the ball there, along the
/// machine's axes. `within`: allowed, mm. Errors: kInput as file:line; fewer than three stops; as
/// check_stops().
Result<CheckResult> judge_check(const config::MachineProfile& machine, double tool_length, double height,
                                double aside, const std::string& table, const std::string& path,
                                double within);
std::string text_of(const CheckResult& result, double within);

}  // namespace tiltfeed::daemon
