#pragma once
// How long axes take from rest to rest. (L8) in pathgen/linking/README.md.

#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

/// Over a way (mm or degrees, at least 0), s.
double rest_to_rest(double way, const RapidRates::Axis& axis);

/// How far tilt and table turn, rad.
struct RotaryTurn {
  double tilt = 0.0, table = 0.0;
};
/// From one tool axis to another, `up` the table's axis; all unit.
RotaryTurn rotary_turn(Vec3 from, Vec3 to, Vec3 up);
/// The longer of what both take, s.
double rest_to_rest(const RotaryTurn& turn, const RapidRates& rapid);

}  // namespace tiltfeed::pathgen
