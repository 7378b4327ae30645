#include "daemon/post/printed_path.h"

#include <utility>

namespace tiltfeed::daemon {

JointPath printed_path(JointPath path, const config::ProgramFormat& format) {
  std::vector<JointMove> kept;
  kept.reserve(path.moves.size());
  double seconds = 0.0;
  for (JointMove move : path.moves) {
    for (double Joints::*place : {&Joints::x, &Joints::y, &Joints::z})
      move.joints.*place = config::printed_place(format, move.joints.*place);
    seconds += move.seconds;
    if (!kept.empty() && move.joints == kept.back().joints) continue;
    move.seconds = std::exchange(seconds, 0.0);
    kept.push_back(move);
  }
  path.moves = std::move(kept);
  return path;
}

}  // namespace tiltfeed::daemon
