#include "sim/motion/motion_options.h"

namespace tiltfeed::sim {

MotionOptions motion_options(const config::MachineProfile& profile) {
  const config::ProgramFormat& format = profile.format;
  MotionOptions options{static_cast<std::size_t>(profile.control.look_ahead), profile.control.corner_time,
                        profile.model.blends_rotary, format.dialect == config::Dialect::kGrbl};
  if (format.feed_measure != config::FeedMeasure::kXyz) options.feed_over_all_axes = true;
  if (format.feed_measure == config::FeedMeasure::kRadius)
    options.mm_per_degree = Angle::from_degrees(1.0).radians() * format.feed_radius;
  return options;
}

}  // namespace tiltfeed::sim
