#pragma once
// A loop of crossings to a pass at constant z': the contour between the crossings. (Z3) in
// pathgen/pattern/README.md.

#include "pathgen/pattern/level_set.h"

namespace tiltfeed::pathgen {

struct TraceOptions {
  double level = 0.0;      ///< z' of the tool, mm
  double tolerance = 0.0;  ///< mm, part space
  double max_axis_step = 0.0;
  bool climb = true;  ///< what is higher lies on the right of the feed
  /// Followed there alone, mm of the flat plane within half a turn of 0: elsewhere the pass is the crossings
  /// as they were found, which are for whoever leaves them out. Nothing: everywhere.
  std::optional<FlatBox> wanted = {};
};

/// Of the tolerance: how far over the level the surface may be where the contour's border is taken; the rest
/// is for what rises between two points.
inline constexpr double kRiseShare = 0.5;

struct Trace {
  std::vector<Pass> passes;    ///< one closed pass, or what is left of it
  std::uint64_t left_out = 0;  ///< moves left out because the surface rises over them or falls away
};

/// Properties, where it is wanted: on every move the envelope is at most level + tolerance. At every point,
/// and in the middle of every move, it is higher than the level at most two tolerances aside. (But not where
/// a border is so narrow that it cannot be followed.) A closed pass ends with its first point. Requires: the
/// loop's level is level + kRiseShare * tolerance.
Trace trace_contour(const Loop& loop, const TraceOptions& options, Heights& heights);

}  // namespace tiltfeed::pathgen
