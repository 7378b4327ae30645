#pragma once
// What the numbers of Grbl 1.1, grblHAL and FluidNC, and the messages of Marlin, mean, and what to do.

#include <string>
#include <string_view>

namespace tiltfeed::daemon {

/// "error:22: no feed has been set; give an F word". Of a number that is not in the table: "error:300".
std::string grbl_error_text(int code);
/// "ALARM:5: the probe did not touch ...; ...". 0: "ALARM".
std::string grbl_alarm_text(int code);
/// The same to a reply as it came: ": no feed has been set; give an F word". Empty: not in the tables.
std::string reply_meaning(std::string_view line);
/// "Idle: ready". `alarm`: the newest alarm number that was heard; 0: none.
std::string grbl_state_text(std::string_view state, int alarm);

/// A setting of `$$`; an empty name: not in the table.
struct GrblSettingName {
  std::string name, unit;
};
/// `letters`: the controller's axes, for the settings that each axis has.
GrblSettingName grbl_setting_name(int number, std::string_view letters);

/// To an "Error:..." line of Marlin, likewise with what to do.
std::string marlin_meaning(std::string_view line);

}  // namespace tiltfeed::daemon
