#pragma once
// What a measurement says of a machine, for a machinist and for programs.

#include <string>
#include <vector>

#include "daemon/measure/measured_profile.h"
#include "daemon/measure/pivot_fit.h"
#include "daemon/measure/tip_spread.h"

namespace tiltfeed::daemon {

struct Measured {
  config::MachineProfile before;
  BallReadings readings;
  PivotFit fit;
  std::vector<ValueSpread> values;
  std::vector<ProfileChange> changes;
  MachineModel machine;         ///< settled
  double tip = 0.0;             ///< root mean square error at the worst pose, mm
  double tip_before = 0.0;      ///< how far the old profile puts the tip from where the new one does, mm
  std::vector<NextPlace> next;  ///< that would bring the tip within what was wanted
  double wanted = 0.0;          ///< of the tip, mm
  bool good() const { return fit.untold.empty() && fit.condition <= kMostCondition; }
};
/// `text`: the profile's. `wanted`: for the tip, two standard deviations, mm. Errors: as fit_pivots().
Result<Measured> measure(const std::string& text, const config::MachineProfile& before,
                         const BallReadings& readings, double wanted, int most_next);

/// "A0 C120, A-60 C0".
std::string places_text(const MachineModel& machine, const std::vector<NextPlace>& next);
/// Why its values are not to be used, and which places would help; empty: they are.
std::string doubts(const Measured& measured);
std::string report_text(const Measured& measured);
/// One JSON object.
std::string report_json(const Measured& measured);
/// Lines for the profile: date, spread, what the values were.
std::vector<std::string> remarks(const Measured& measured, const std::string& date);

/// Places to begin with, one JSON object.
std::string places_json(const std::string& profile, const std::vector<NextPlace>& places);
/// The same as a table to fill in at the machine, CSV.
std::string empty_table(const MachineModel& machine, const std::vector<NextPlace>& places);

}  // namespace tiltfeed::daemon
