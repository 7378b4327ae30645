#pragma once
// What happens along a tool path besides motion: spindle, coolant, dwell, stops, remarks,
// the control's cutter compensation.

#include <cstddef>
#include <string>

namespace tiltfeed {

enum class EventKind {
  kRemark,        ///< `text`
  kSpindle,       ///< `value` in 1/min, negative: counter-clockwise, 0: off
  kCoolant,       ///< `value` 0 off, 1 flood, 2 mist, 3 through the spindle
  kDwell,         ///< `value` in s
  kStop,          ///< until the operator goes on
  kOptionalStop,  ///< likewise where the operator wants it
  kCutterLeft,    ///< the control shifts the tool to the left of its way by register `value` (0: the tool's)
  kCutterRight,   ///< likewise to the right
  kCutterOff,     ///< it no longer does
  kPlane,         ///< that shift is in the plane G`value`: 17, 18 or 19. Of programs, not of CL text
};

struct PathEvent {
  std::size_t move = 0;  ///< before this move; the number of moves: behind the last
  EventKind kind = EventKind::kRemark;
  double value = 0.0;
  std::string text;
  bool operator==(const PathEvent&) const = default;
};

}  // namespace tiltfeed
