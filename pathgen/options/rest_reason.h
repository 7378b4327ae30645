#pragma once
// Why places of the part stay uncut: one list of reasons for all axis modes, and the words for them.

#include <cstddef>

#include "pathgen/options/cutter.h"

namespace tiltfeed::pathgen {

/// If several reasons apply, the first one listed is reported.
enum class RestReason {
  kCutter,  ///< the cutting part does not fit, or something else of the part is in the way along the axis
  kShank,   ///< the shank would come too near
  kHolder,  ///< the holder would
  kTilt,    ///< beyond the tilt limit
  kContainment,  ///< outside of the containment
  kWall,         ///< parallel to the axis, and the passes end above
  kFixture,      ///< cutter, shank or holder would come nearer to a fixture than their clearance
};
inline constexpr std::size_t kRestReasons = 7;

/// Where this part of the tool is in the way.
constexpr RestReason rest_reason_of(ToolPart part) {
  if (part == ToolPart::kCutter) return RestReason::kCutter;
  return part == ToolPart::kShank ? RestReason::kShank : RestReason::kHolder;
}

/// One word, as it stands in reports.
const char* word_of(RestReason why);
/// What helps: "use a smaller cutter".
const char* remedy(RestReason why);

}  // namespace tiltfeed::pathgen
