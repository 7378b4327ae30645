#pragma once
// The machine that explains readings best, how well each number is known, and which ones are not.

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/measure/ball_machine.h"
#include "daemon/measure/ball_readings.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// What is known of the numbers sought, as the sum of the squared slopes of readings over their noise.
struct Knowledge {
  std::vector<Unknown> unknowns;
  std::vector<double> information;  ///< n by n, per mm^2
};

/// How far the reading of a place lies from the fit; of touches: of the centre that they give.
struct PlaceRest {
  BallPlace at;
  Vec3 rest;           ///< mm
  double times = 0.0;  ///< its size, in standard deviations of what is left there
};

struct PivotFit {
  BallMachine found;         ///< explains the readings; not settled
  bool spindle = false;      ///< two tool lengths: the spindle's direction was found, too
  double tool_length = 0.0;  ///< mean of the readings'
  Knowledge known;
  double noise = 0.0;  ///< standard deviation of a reading: of a touch, or of X, Y or Z of a centre, mm
  int freedom = 0;     ///< readings beyond what is sought
  int rank = 0, full_rank = 0;
  double condition = 0.0;           ///< largest over least singular value; angles as kLever says
  std::vector<std::string> untold;  ///< keys of values that the readings do not tell
  std::vector<PlaceRest> places;    ///< in the order of BallReadings::places
};

/// Step of a slope, mm: reading_at bends so little that the slope is right to ten digits.
inline constexpr double kSlopeStep = 1e-3;
/// Tool lengths of readings that differ by less do not tell the spindle's direction, mm.
inline constexpr double kTwoLengths = 20.0;
/// Above it numbers are known too badly to be used: good places give 6 to 11.
inline constexpr double kMostCondition = 30.0;

/// (ME5), (ME6). Errors: kInput: too few readings, touches of a place in one plane, readings of no such
/// machine (then with the place that does not fit, if it is one).
Result<PivotFit> fit_pivots(const MachineModel& before, const BallReadings& readings);

/// The machine that explains readings best when these numbers alone may change, from `start`; of several, the
/// nearest.
struct Explanation {
  BallMachine machine;
  std::vector<double> rests;  ///< of each place, mm
};
/// Requires: no touches.
Explanation explained(const BallMachine& start, const BallReadings& readings,
                      const std::vector<Unknown>& free);

/// Standard deviations of values, and whether readings tell them.
struct ValueSpread {
  MeasuredValue value;
  std::vector<double> spread;  ///< of each part, in the value's unit
  bool told = true;
};
std::vector<ValueSpread> spreads(const PivotFit& fit, const MachineModel& before);

}  // namespace tiltfeed::daemon
