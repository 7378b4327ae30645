#pragma once
// What was read at the machine: a CSV file, one line a reading.

#include <string>
#include <vector>

#include "daemon/measure/ball_machine.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// X Y Z as the axes were read at one place of the rotaries: centred on the ball, or where the stylus touched
/// it.
struct BallReading {
  BallPlace at;
  Vec3 axes;      ///< machine coordinates, mm
  int place = 0;  ///< from 0
  int line = 0;   ///< of the file; 0: none
};

struct BallReadings {
  std::vector<BallReading> all;     ///< those of a place side by side
  std::vector<std::string> places;  ///< what the file calls them
  bool touches = false;             ///< readings are touches, several a place; else centred on the ball
};

/// The lines of a place have the same words and length.
inline constexpr int kFewestTouches = 4;
inline constexpr std::size_t kMostReadings = 2000;

/// The values of a line of CSV, without blanks at their ends.
std::vector<std::string> cells_of(const std::string& line, char between);

/// Columns by name, in any order: tilt_deg, rotary_deg (those of the machine's axes), x_mm, y_mm, z_mm,
/// tool_length_mm (or `tool_length`, where it is at least 0), place (makes touches of readings). Commas or
/// semicolons; lines that begin with # are remarks. Errors: kInput as file:line, what was expected.
Result<BallReadings> read_ball_readings(const std::string& text, const std::string& path,
                                        const MachineModel& machine, double tool_length);

}  // namespace tiltfeed::daemon
