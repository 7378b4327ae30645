#pragma once
// What becomes of a facet in one set-up: one word for pictures, tables and reports.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pathgen/options/rest_reason.h"

namespace tiltfeed::pathgen {

/// If several apply, the first one listed but kCut.
enum class Reach : std::uint8_t {
  kCut,      ///< the tool touches it
  kAway,     ///< it faces away from the tool
  kNarrow,   ///< the cutter does not fit there, whatever its axis
  kBlocked,  ///< the part is in the way of the tool's cutter, shank or holder
  kTilt,     ///< the tool axis would lean further than the job or the machine's rotaries allow
  kTravel,   ///< the machine's linear axes do not go there
  kOutside,  ///< outside of the job's containment
  kWall,     ///< parallel to the axis, and the passes end above
};
inline constexpr std::size_t kReaches = 8;

/// One word: "cut", "away", "narrow", "blocked", "tilt", "travel", "outside", "wall".
const char* word_of(Reach reach);
/// For a machinist: "the cutter does not fit".
const char* meaning(Reach reach);

/// What the plan's own reason is called here; `fits`: the cutter does at that facet.
Reach reach_of(RestReason why, bool fits);

/// Of each place, and in sum.
struct ReachMap {
  std::vector<Reach> places;
  std::array<double, kReaches> area{};  ///< mm^2, by Reach

  double whole() const;
  double share(Reach reach) const;
};

}  // namespace tiltfeed::pathgen
