#pragma once
// Why places of the part stay uncut: one list of reasons for all axis modes, and the words for them.

#include <cstddef>

#include "pathgen/options/cutter.h"

namespace tiltfeed {

/// If several reasons apply, the first one listed is reported.
enum class Uncut {
  kCutter,  ///< the cutting part does not fit, or something else of the part is in the way along the axis
  kShank,   ///< the shank would come too near
  kHolder,  ///< the holder would
  kTilt,    ///< beyond the tilt limit
  kContainment,  ///< outside of the containment
  kWall,         ///< parallel to the axis, and the passes end above
};
inline constexpr std::size_t kUncutReasons = 6;

/// Where this part of the tool is in the way.
constexpr Uncut uncut_by(ToolPart part) {
  if (part == ToolPart::kCutter) return Uncut::kCutter;
  return part == ToolPart::kShank ? Uncut::kShank : Uncut::kHolder;
}

/// One word, as it stands in reports.
const char* word_of(Uncut why);
/// What helps: "use a smaller cutter".
const char* remedy(Uncut why);

}  // namespace tiltfeed
