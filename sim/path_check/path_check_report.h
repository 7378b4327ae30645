#pragma once
// What a check of a trace against its path finds.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh.h"
#include "sim/motion/trace.h"
#include "sim/path_check/block_comparison.h"
#include "sim/path_check/executed.h"
#include "sim/solid/tool_solid.h"

namespace tiltfeed::sim {

/// Where in the execution something is worst.
struct TracePlace {
  std::uint64_t block = 0;         ///< TraceRow::block, 0: nowhere
  std::uint32_t line = 0;          ///< of the program
  std::uint32_t move = 0;          ///< of the planned path
  std::uint32_t facet = kNoFacet;  ///< of the STL file
  Point<Part> tip;
  ToolPart tool = ToolPart::kCutter;  ///< what of the tool overlaps
};

/// The largest of its kind and where it is.
struct Extreme {
  double value = 0.0;
  TracePlace place;
};

struct PathCheckReport {
  double tolerance = 0.0, axis_tolerance = 0.0;
  BlockComparison program;
  // Feed moves against the planned path.
  Extreme tip_deviation;    ///< executed tip from planned path, mm
  Extreme axis_deviation;   ///< degrees
  Extreme missed_point;     ///< planned point from executed tip, mm
  Extreme rapid_deviation;  ///< rapids: measured, not judged; what matters is that they touch nothing
  // Cutter, shank and holder, grown by allowance and stock, against the part.
  Extreme gouge;                    ///< feed moves: deepest overlap, mm
  std::array<Extreme, 3> gouge_by;  ///< the same by kToolParts
  Extreme rapid_overlap;            ///< rapids: deepest overlap, mm
  // Cutting moves: how far the cutter is from the part.
  Extreme gap;   ///< least distance of the cutter's end from the part, mm
  Extreme drop;  ///< along the axis until it touches, mm; steep walls make it larger than the gap
  std::uint64_t air_samples = 0;  ///< cutting samples whose gap is over the tolerance; a few are the descents
                                  ///< past overhangs, more than one in a hundred fails
  double drop_999 = 0.0;          ///< 99.9 percent of the cutting samples drop less than this, mm
  std::uint64_t samples = 0, cut_samples = 0;
  double seconds = 0.0;  ///< machine time from the first move's end to the last row's end
  AxisPeaks peaks;
  double cut_length = 0.0, plunge_length = 0.0, rapid_length = 0.0;  ///< of the tip, mm
  std::vector<std::string> failures;                                 ///< one line each: value, limit, place
  bool passed() const { return failures.empty(); }
};

}  // namespace tiltfeed::sim
