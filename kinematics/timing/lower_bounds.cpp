#include "kinematics/timing/lower_bounds.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {
namespace {

constexpr double kSecondsPerMinute = 60.0;

/// An axis at its speed; one that the machine lacks stands.
double seconds_of(double way, double speed_per_min) {
  return way > 0.0 && speed_per_min > 0.0 ? way / speed_per_min * kSecondsPerMinute : 0.0;
}

}  // namespace

void LowerBounds::add(const LowerBounds& more) {
  path += more.path, blocks += more.blocks;
  for (const auto axis : {&Joints::x, &Joints::y, &Joints::z, &Joints::a, &Joints::c})
    axes.*axis += more.axes.*axis;
}

double LowerBounds::most() const { return std::max({path, axes.x, axes.y, axes.z, axes.a, axes.c, blocks}); }

LowerBounds lower_bounds(const ToolPath& path, const std::vector<JointMove>& moves,
                         const MachineModel& machine) {
  LowerBounds bounds;
  for (std::size_t i = 1; i < path.moves.size(); ++i)
    if (path.moves[i].kind != MoveKind::kRapid)
      bounds.path += distance(path.moves[i - 1].pose.tip, path.moves[i].pose.tip) /
                     feed_of(path, i).mm_per_min() * kSecondsPerMinute;
  Joints way;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const Joints &from = moves[i - 1].joints, &to = moves[i].joints;
    for (const auto axis : {&Joints::x, &Joints::y, &Joints::z, &Joints::a, &Joints::c})
      way.*axis += std::abs(to.*axis - from.*axis);
    bounds.blocks += moves[i].seconds;
  }
  bounds.axes = {seconds_of(way.x, machine.x.velocity), seconds_of(way.y, machine.y.velocity),
                 seconds_of(way.z, machine.z.velocity),
                 machine.tilt.present ? seconds_of(way.a, machine.tilt.velocity) : 0.0,
                 machine.rotary.present ? seconds_of(way.c, machine.rotary.velocity) : 0.0};
  return bounds;
}

}  // namespace tiltfeed
