#pragma once
// Arcs (G2, G3) for runs of straight blocks that lie on one circle in a plane of the words' axes. Fitted to
// the words as they are printed, and judged as they are printed.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "config/program_format.h"
#include "daemon/post/posting.h"
#include "daemon/post/printed_arc.h"
#include "kinematics/basics/path_event.h"
#include "kinematics/basics/tool_path.h"
#include "kinematics/joints/joint_moves.h"

namespace tiltfeed::daemon {

/// An arc stands for so many blocks at least: less saves nothing where its centre or plane needs a line, too.
inline constexpr std::size_t kLeastArcBlocks = 3;
/// An arc goes round by this at most, degrees; a circle has three.
inline constexpr double kMostArcTurn = 150.0;
/// The printed radius at the end differs by no more than this from that at the start, mm. Grbl takes 0.005,
/// a Sinumerik as it is delivered 0.01 (MD21000), LinuxCNC 0.028; a Fanuc what No.3410 says, a Heidenhain
/// its MP7431.
inline constexpr double kMostArcRadiusError = 0.004;
/// Smaller and larger circles stay straight, mm.
inline constexpr double kLeastArcRadius = 0.05;
inline constexpr double kMostArcRadius = 5000.0;

/// What must not be in one arc.
struct ArcBreaks {
  const std::vector<FeedChange>& feeds;  ///< as in ToolPath: before these moves
  const std::vector<PathEvent>& events;  ///< likewise
};

struct ArcFit {
  JointPath words;  ///< an arc is one move of it, to its end
  std::vector<PrintedArc> arcs;
};

/// Properties, of the printed words: 1 Each way is within `tolerance` (mm) of the other, place by place.
/// 2 The radius at the end is within kMostArcRadiusError of that at the start. 3 An arc goes round by at most
/// kMostArcTurn, in a plane that the control has arcs in (DialectTable::planes), the rotaries standing. 4 It
/// has one kind of move, one feed, and no event within. 5 What a straight line within the tolerance does
/// stays straight. 6 The last place is that of `words`, or the third axis is within the tolerance of it.
/// Requires: words as printed_path() has them.
ArcFit fit_arcs(const JointPath& words, const ArcBreaks& breaks, const config::ProgramFormat& format,
                double tolerance);

/// The operation with its words so; they are kept in `words`. Not under TCP, not where the control shifts the
/// tool to a side, and with a tolerance of 0 nothing.
void put_arcs(Operation& op, const config::ProgramFormat& format, double tolerance,
              std::vector<std::unique_ptr<JointPath>>& words);

}  // namespace tiltfeed::daemon
