#pragma once
// A path in short spans, for each of which one engagement is measured.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "sim/motion/forward.h"
#include "sim/removal/executed_path.h"

namespace tiltfeed::sim {

/// From a share of one move to a share of the same or a later one: all feed, or all rapid.
struct EngagedSpan {
  std::uint32_t first_move = 0, last_move = 0;
  double begin = 0.0, end = 1.0;  ///< shares of the first and of the last move
  Pose from, to;
  double way = 0.0;    ///< of the tip, mm
  double asked = 0.0;  ///< what F asks for, s
  double took = 0.0;   ///< machine time, s
  bool rapid = false;
};

struct SpanOptions {
  double step = 0.0;   ///< a span's way at the tip and `top` over it, mm, or a little less
  double stray = 0.0;  ///< what lies between a span's ends is no further off the straight way, mm
  double top = 0.0;    ///< height over the tip of the cutting part's end, mm
};

/// The moves [begin, end) in their order. Properties: 1 Every share of every move is in one span.
/// 2 `way`, `asked` and `took` of all spans are those of the moves. 3 A rapid is one span or several of its
/// own.
std::vector<EngagedSpan> engaged_spans(const ExecutedPath& path, const FrameChain& chain,
                                       const SpanOptions& options, std::size_t begin, std::size_t end);

}  // namespace tiltfeed::sim
