#pragma once
// How fast each place of a program may be run, so that no place loads the cutter more than a limit: (FE1) to
// (FE4) in daemon/plan/README.md.

#include <vector>

namespace tiltfeed::daemon {

/// A short stretch of a program at feed, and what the cutter has to do there at the feed that is asked for.
struct LoadSpan {
  double begin = 0.0, end = 0.0;  ///< s of the program as it was planned
  double way = 0.0;               ///< of the tip, mm
  double chip = 0.0, edge_load = 0.0,
         turn_load = 0.0;  ///< as the table of `tiltfeed-sim engagement` has them
  double pace = 1.0;       ///< of the speed asked for, the share at which the machine runs
  bool cut = true;         ///< false: a plunge, whose feed stays
};

struct Loads {
  double chip = 0.0, edge_load = 0.0, turn_load = 0.0;
  Loads times(double share) const { return {chip * share, edge_load * share, turn_load * share}; }
};

/// Exponent with which a load grows as the feed does: that of the simulated machine.
inline constexpr double kLoadExponent = 0.75;
/// Speeds are whole multiples of this share of the job's feed.
inline constexpr double kSpeedStep = 0.02;

/// The largest of all cuts as the machine runs them.
Loads largest_loads(const std::vector<LoadSpan>& spans);

struct FeedRule {
  double highest = 1.0, lowest = 0.2;  ///< shares of the job's feed; lowest <= 1 <= highest
  double change = 0.0;                 ///< by which the share changes within a mm, at most; 0: no limit
  double ahead = 0.0;                  ///< so far before a load the feed has fallen, mm
};

/// Until `end` (s of the program as it was planned) at this share of its feed.
struct SpeedStep {
  double end = 0.0, speed = 1.0;
};

/// Properties: 1 At its step's speed no load of a span is over `limits`, nor that of a span which begins
/// within `ahead` after it; but for spans that would have to be slower than `lowest`. 2 Speeds are within the
/// rule, and multiples of kSpeedStep. 3 Plunges, and what is in no span, stay as they are. 4 The steps' ends
/// rise. Requires: spans in order.
std::vector<SpeedStep> feed_profile(const std::vector<LoadSpan>& spans, const Loads& limits,
                                    const FeedRule& rule);

}  // namespace tiltfeed::daemon
