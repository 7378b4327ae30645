#include "pathgen/reach/reach.h"

#include <numeric>

namespace tiltfeed::pathgen {

const char* word_of(Reach reach) {
  constexpr std::array<const char*, kReaches> kWords{"cut",  "away",   "narrow",  "blocked",
                                                     "tilt", "travel", "outside", "wall"};
  return kWords[static_cast<std::size_t>(reach)];
}

const char* meaning(Reach reach) {
  constexpr std::array<const char*, kReaches> kMeanings{"is cut",
                                                        "faces away from the tool",
                                                        "is too narrow for the cutter",
                                                        "is blocked by the part",
                                                        "is beyond the tilt",
                                                        "is beyond the travels",
                                                        "is outside of the containment",
                                                        "is a wall along the tool axis, below the passes"};
  return kMeanings[static_cast<std::size_t>(reach)];
}

Reach reach_of(RestReason why, bool fits) {
  switch (why) {
    case RestReason::kCutter:
      return fits ? Reach::kBlocked : Reach::kNarrow;
    case RestReason::kShank:
    case RestReason::kHolder:
    case RestReason::kFixture:
      return Reach::kBlocked;
    case RestReason::kTilt:
      return Reach::kTilt;
    case RestReason::kContainment:
      return Reach::kOutside;
    case RestReason::kWall:
      break;
  }
  return Reach::kWall;
}

double ReachMap::whole() const { return std::accumulate(area.begin(), area.end(), 0.0); }

double ReachMap::share(Reach reach) const {
  const double all = whole();
  return all > 0.0 ? area[static_cast<std::size_t>(reach)] / all : 0.0;
}

}  // namespace tiltfeed::pathgen
