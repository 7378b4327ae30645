#pragma once
// A profile's text with what was measured: values in their place, what they were as remarks.

#include <string>
#include <vector>

#include "config/machine_profile.h"
#include "daemon/measure/pivot_fit.h"

namespace tiltfeed::daemon {

/// A key before and after; both as in the file.
struct ProfileChange {
  std::string key, before, after;  ///< `before`: empty where the file does not state it
  double spread = 0.0;             ///< largest standard deviation of its parts
  const char* unit = "mm";
};
/// Those that the readings tell, in the order of the profile.
std::vector<ProfileChange> profile_changes(const std::string& text, const PivotFit& fit,
                                           const std::vector<ValueSpread>& spreads,
                                           const MachineModel& before);

struct MeasuredProfile {
  std::string text;
  bool check_dropped = false;  ///< places under `check` that do not agree any more are remarks now
};
/// `remarks`: lines behind the profile, each begins with "# ". Properties: the result loads, and its model is
/// the settled one to the digits written. Errors: kInput, where the text is written so that only a person can
/// change it.
Result<MeasuredProfile> measured_profile(const std::string& text, const config::MachineProfile& before,
                                         const MachineModel& settled,
                                         const std::vector<ProfileChange>& changes,
                                         const std::vector<std::string>& remarks);

}  // namespace tiltfeed::daemon
