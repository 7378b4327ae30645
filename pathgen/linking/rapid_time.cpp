#include "pathgen/linking/rapid_time.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {
namespace {

/// Nearer to the table's axis (rad) the table need not turn for the tool.
constexpr double kUpright = 0.02;

}  // namespace

double rest_to_rest(double way, const RapidRates::Axis& axis) {
  if (way * axis.acceleration >= axis.velocity * axis.velocity)
    return way / axis.velocity + axis.velocity / axis.acceleration;
  return 2.0 * std::sqrt(way / axis.acceleration);
}

RotaryTurn rotary_turn(Vec3 from, Vec3 to, Vec3 up) {
  const double tilt_from = angle_between(from, up), tilt_to = angle_between(to, up);
  RotaryTurn turn{std::abs(tilt_to - tilt_from), 0.0};
  if (std::min(tilt_from, tilt_to) > kUpright && std::max(tilt_from, tilt_to) < kPi - kUpright)
    turn.table = angle_between(from - up * dot(from, up), to - up * dot(to, up));
  return turn;
}

double rest_to_rest(const RotaryTurn& turn, const RapidRates& rapid) {
  return std::max(rest_to_rest(Angle::from_radians(turn.tilt).degrees(), rapid.tilt),
                  rest_to_rest(Angle::from_radians(turn.table).degrees(), rapid.table));
}

}  // namespace tiltfeed::pathgen
