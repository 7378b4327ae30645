#include "daemon/plan/path_drawing.h"

#include <array>
#include <ostream>

namespace tiltfeed::daemon {

double write_path_drawing(const JointPath& joints, const std::vector<double>& durations,
                          const MachineModel& machine, const Setup& setup, double begin, std::ostream& out) {
  double seconds = begin;
  for (std::size_t i = 0; i < joints.moves.size(); ++i) {
    const Joints& q = joints.moves[i].joints;
    const Pose pose = forward(machine, setup, q);
    seconds += durations[i];
    const std::array<double, kDrawnNumbers> numbers{
        pose.tip.x,   pose.tip.y,  pose.tip.z, pose.axis.x,
        pose.axis.y,  pose.axis.z, seconds,    static_cast<double>(joints.moves[i].kind),
        durations[i], q.x,         q.y,        q.z,
        q.a,          q.c};
    std::array<float, kDrawnNumbers> record{};
    for (std::size_t k = 0; k < kDrawnNumbers; ++k) record[k] = static_cast<float>(numbers[k]);
    out.write(reinterpret_cast<const char*>(record.data()), sizeof record);
  }
  return seconds;
}

}  // namespace tiltfeed::daemon
