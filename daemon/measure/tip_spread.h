#pragma once
// How far the tool's tip may be off with numbers known so well, and where a ball is to be measured next.

#include <vector>

#include "daemon/measure/pivot_fit.h"

namespace tiltfeed::daemon {

/// The tip's root mean square error at the worst pose: within kWorkSide and kWorkHeight of the table's point
/// (half of the travels, where they are less), over the limits of both rotaries (up to kWorkTilt), mm. (ME7)
double tip_spread(const PivotFit& fit, const MachineModel& before, const Knowledge& known);
inline constexpr double kWorkSide = 200.0, kWorkHeight = 300.0, kWorkTilt = 100.0;

/// A place to measure at, and the tip's spread after it.
struct NextPlace {
  BallPlace at;
  double tip = 0.0;  ///< mm
};
/// Places one by one, each the one of a grid over both rotaries that lowers the tip's spread most, until it
/// is at most `wanted` or there are `most`. `noise`: of X, Y, Z of one centre, mm. (ME8)
std::vector<NextPlace> next_places(const PivotFit& fit, const MachineModel& before, double noise,
                                   double wanted, int most);

/// As if nothing were measured yet, the machine as in its profile and the ball beside the rotary's axis: to
/// choose the first places.
PivotFit nothing_measured(const MachineModel& before, double tool_length, bool spindle);

}  // namespace tiltfeed::daemon
