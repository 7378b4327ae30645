#include "sim/motion_options.h"

namespace tiltfeed::sim {

MotionOptions motion_options(const MachineProfile& profile) {
  return {static_cast<std::size_t>(profile.control.look_ahead), profile.control.corner_time,
          profile.model.blends_rotary, profile.format.dialect == Dialect::kGrbl};
}

}  // namespace tiltfeed::sim
