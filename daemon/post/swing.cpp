#include "daemon/post/swing.h"

#include <algorithm>

#include "kinematics/timing/timing.h"

namespace tiltfeed::daemon {

std::vector<Joints> swing_places(const MachineModel& machine, const Joints& from, const Joints& to,
                                 SwingWay way) {
  std::vector<Joints> places;
  Joints at = from;
  const auto stop = [&] {
    if (at != (places.empty() ? from : places.back())) places.push_back(at);
  };
  const auto across = [&](bool now) {
    if (now) at.x = to.x, at.y = to.y, stop();
  };
  const auto tilt = [&](double word) { at.a = word, stop(); };
  const auto rotary = [&] { at.c = to.c, stop(); };
  if (way.order == SwingOrder::kOverHome && machine.tilt.present) tilt(machine.tilt.zero);
  across(way.across_first);
  switch (way.order) {
    case SwingOrder::kTogether:
      at.a = to.a, rotary();
      break;
    case SwingOrder::kTiltFirst:
      tilt(to.a), rotary();
      break;
    case SwingOrder::kRotaryFirst:
    case SwingOrder::kOverHome:
      rotary(), tilt(to.a);
      break;
  }
  across(!way.across_first);
  return places;
}

std::vector<JointMove> moves_between(const MachineModel& machine, const Joints& from, const Joints& to,
                                     SwingWay way) {
  std::vector<JointMove> moves;
  Joints at = from;
  const auto go = [&](const Joints& next) {
    moves.push_back({next, rapid_seconds(machine, at, next), MoveKind::kRapid, 0});
    at = next;
  };
  Joints up = from;
  up.z = std::max({machine.z.max, from.z, to.z});
  if (up != from) go(up);
  for (const Joints& place : swing_places(machine, up, to, way)) go(place);
  return moves;
}

}  // namespace tiltfeed::daemon
