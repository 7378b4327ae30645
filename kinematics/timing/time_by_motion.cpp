#include "kinematics/timing/time_by_motion.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {
namespace {

/// Does one of the rotaries take longer from p to q than the slides?
bool is_swing(const MachineModel& m, const Joints& p, const Joints& q) {
  const auto time = [](double way, double speed) { return speed > 0.0 ? std::abs(way) / speed : 0.0; };
  const double slides =
      std::max({time(q.x - p.x, m.x.velocity), time(q.y - p.y, m.y.velocity), time(q.z - p.z, m.z.velocity)});
  const double tilt = m.tilt.present ? time(q.a - p.a, m.tilt.velocity) : 0.0,
               rotary = m.rotary.present ? time(q.c - p.c, m.rotary.velocity) : 0.0;
  return std::max(tilt, rotary) > slides;
}

}  // namespace

void TimeByMotion::add(const TimeByMotion& more) {
  for (const auto part : {&TimeByMotion::cuts_at_feed, &TimeByMotion::slow_axes, &TimeByMotion::accelerations,
                          &TimeByMotion::plunges, &TimeByMotion::rapids, &TimeByMotion::swings})
    this->*part += more.*part;
}

TimeByMotion time_by_motion(const ToolPath& path, const std::vector<JointMove>& moves,
                            const std::vector<double>& durations, const MachineModel& machine) {
  TimeByMotion times;
  for (std::size_t i = 1; i < path.moves.size(); ++i)
    if (path.moves[i].kind == MoveKind::kCut)
      times.cuts_at_feed +=
          distance(path.moves[i - 1].pose.tip, path.moves[i].pose.tip) / feed_of(path, i).mm_per_s();
  double programmed = 0.0, cuts = 0.0;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const double seconds = durations[i];
    switch (moves[i].kind) {
      case MoveKind::kCut:
        programmed += moves[i].seconds, cuts += seconds;
        break;
      case MoveKind::kPlunge:
        times.plunges += seconds;
        break;
      case MoveKind::kRapid:
        (is_swing(machine, moves[i - 1].joints, moves[i].joints) ? times.swings : times.rapids) += seconds;
    }
  }
  // Blocks may run at other feeds than the path's, and a block left out is not waited for.
  programmed = std::min(programmed, cuts);
  times.cuts_at_feed = std::min(times.cuts_at_feed, programmed);
  times.slow_axes = programmed - times.cuts_at_feed, times.accelerations = cuts - programmed;
  return times;
}

}  // namespace tiltfeed
