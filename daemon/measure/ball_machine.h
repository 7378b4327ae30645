#pragma once
// Where the axes stand when the tool's ball meets a ball on the table, and what of a machine that shows.
// Equations (ME1)..(ME4): daemon/measure/README.md.

#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

/// A machine and the ball that was measured on it. Readings are those of X Y Z with the gauge line at home,
/// machine coordinates; `machine.table_centre` is in the same.
struct BallMachine {
  MachineModel machine;
  Vec3 ball;            ///< from the table's point to the ball's centre at home; head-head: its place, mm
  double radius = 0.0;  ///< of touches: ball and stylus together, less the pretravel, mm
};

/// Both words and the length at which one ball was found.
struct BallPlace {
  double tilt = 0.0, rotary = 0.0;  ///< words, degrees
  double tool_length = 0.0;         ///< gauge line to the stylus ball's centre, mm
};

/// (ME1)..(ME3): X Y Z at which the tool's ball is centred on the ball.
Vec3 reading_at(const BallMachine& machine, const BallPlace& place);

/// One number that a fit may change.
enum class Sought : std::uint8_t {
  kCentre,
  kRotary,
  kBall,
  kTilt,
  kGauge,
  kOffset,
  kSpindle,
  kRadius,
  kTiltZero
};
struct Unknown {
  Sought what = Sought::kCentre;
  int part = 0;  ///< component, or tangent of a direction
};

/// An angle counts as the way of a point so far away, mm: about the size of what is cut. It makes lengths and
/// angles comparable in ranks and conditions.
inline constexpr double kLever = 300.0;

/// What there is to be found on a machine; not the tilt's zero, which is in the others. `spindle`: the tool's
/// direction, too; `touches`: the radius.
std::vector<Unknown> unknowns_of(const MachineModel& machine, bool spindle, bool touches);
/// Directions in which a fit may run without any reading changing: along each rotary axis.
int gauges_of(const MachineModel& machine);
/// One number changed by `step`, mm; directions by step / kLever, rad.
BallMachine moved(BallMachine machine, Unknown unknown, double step);

/// The one description of `found` that differs least from `before`: directions and signs as there, homes so
/// that the carried axis stands as there, points along an axis as there. A spindle that was not measured
/// leans as the axes do, so that the tool still reaches the rotary's direction; the tip of a tool of
/// `tool_length` stays. (ME4)
MachineModel settled(const BallMachine& found, const MachineModel& before, bool spindle, double tool_length);

/// A value of the profile as measured.
struct MeasuredValue {
  std::string key;            ///< of the profile; "square": the angle between the axes
  const char* unit = "mm";    ///< "mm" or "deg"
  std::vector<double> parts;  ///< of a direction: its two angles from `before`
};
/// Those that readings can tell, of a settled machine.
std::vector<MeasuredValue> measured_values(const MachineModel& settled, const MachineModel& before,
                                           bool spindle);

}  // namespace tiltfeed::daemon
