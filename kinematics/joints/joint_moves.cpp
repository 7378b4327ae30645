#include "kinematics/joints/joint_moves.h"

#include <algorithm>

namespace tiltfeed {

Joints least(const Joints& p, const Joints& q) {
  return {std::min(p.x, q.x), std::min(p.y, q.y), std::min(p.z, q.z), std::min(p.a, q.a), std::min(p.c, q.c)};
}

Joints greatest(const Joints& p, const Joints& q) {
  return {std::max(p.x, q.x), std::max(p.y, q.y), std::max(p.z, q.z), std::max(p.a, q.a), std::max(p.c, q.c)};
}

void JointPathReport::add(const JointPathReport& more) {
  seconds += more.seconds;
  max_tip_deviation = std::max(max_tip_deviation, more.max_tip_deviation);
  max_end_deviation = std::max(max_end_deviation, more.max_end_deviation);
  max_axis_deviation = std::max(max_axis_deviation, more.max_axis_deviation);
  max_rapid_deviation = std::max(max_rapid_deviation, more.max_rapid_deviation);
  subdivided_moves += more.subdivided_moves;
  pole_swings += more.pole_swings;
  reconfigurations += more.reconfigurations;
  min = least(min, more.min);
  max = greatest(max, more.max);
}

}  // namespace tiltfeed
