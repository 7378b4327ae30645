#include "desk/service/tool_place.h"

namespace tiltfeed::desk {

std::optional<Pose> tool_place(const AxisPlaces& axes, const MachineModel& machine, const Setup& setup) {
  bool known = true;
  const auto at = [&](const std::string& letter) {
    const auto found = axes.find(letter);
    if (found != axes.end()) return found->second;
    known = false;
    return 0.0;
  };
  Joints joints{at("X"), at("Y"), at("Z"), 0.0, 0.0};
  if (machine.tilt.present) joints.a = at(std::string(1, machine.tilt.letter));
  if (machine.rotary.present) joints.c = at(std::string(1, machine.rotary.letter));
  if (!known) return std::nullopt;
  return forward(machine, setup, joints);
}

}  // namespace tiltfeed::desk
