#pragma once
// The whole operation looked at before it is walked: with which joints to start, and where the tool has to be
// taken off the part so that the rotaries can be turned back or brought to their other side. (K11).

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "kinematics/joints/joint_chooser.h"
#include "kinematics/joints/joint_moves.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// At the end of a move: these joints there are given up for those.
struct Reconfiguration {
  std::size_t after = 0;  ///< index into ToolPath::moves
  JointSolution from, to;
  bool outward = false;  ///< off sideways, beyond the clear radius; the tilt stays
  /// `to` belongs to the end of the move after it, a rapid, which is done at the clear height: the rotaries
  /// may turn the other way round than along its great circle.
  bool instead = false;
};

struct OperationPlan {
  JointSolution start;
  std::vector<Reconfiguration> changes;  ///< in the path's order
};

/// Dynamic programming over both solutions and the turns of the rotary: the fewest reconfigurations with the
/// tool in cut, then the fewest of all, then the preferred side of the tilt, then the least rotary time, sum
/// of max_i |dq_i| / V_i at the moves' ends. The tool is taken off upwards where its axis rises (kLeastRise);
/// a tool that lies is taken off sideways where a rotary under the work needs its turns back only. A rapid
/// between tools that rise may be replaced by one at the clear height. The travels must reach there. Nothing
/// where no way leads through. `replaced`: by move, a rapid that must be. Requires: a path that check_path
/// accepts.
std::optional<OperationPlan> plan_operation(const ToolPath& path, const MachineModel& machine,
                                            const Setup& setup, const JointChooser& chooser,
                                            const ClearSpace& clear, const std::vector<bool>& replaced);

/// A tool that lies flatter than this (cosine to the rotary axis) is not taken off upwards: the way would be
/// ten times the height, and the holder would pass low over the part.
inline constexpr double kLeastRise = 0.1;

/// How far along its axis the tool is clear above. Requires: an axis that rises.
double rise_to(double clear_height, const Pose& pose, Vec3 up);
/// How far along its axis the tip is `clear_radius` from the rotary's axis, going away from it; nothing for a
/// tool that rises, a shank that points to the axis, or a rotary in the head.
std::optional<double> way_out(double clear_radius, const Pose& pose, const MachineModel& machine,
                              const Setup& setup);

/// The path with the moves of each reconfiguration put in. Upwards: off along the tool axis to the clear
/// height, the rotaries turned there with the tip held, on to above the end of the rapid that is replaced.
/// Outwards: off along the tool axis to the clear
/// radius, the work turned with the tool standing. Then back, the last of it as a plunge where the tool was
/// in cut: at plunge feed, or at the feed in force where that is slower. `planned`: by move, the move of
/// `path` that it is, or after which it is put in.
ToolPath with_reconfigurations(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                               const OperationPlan& plan, const ClearSpace& clear,
                               std::vector<std::uint32_t>& planned);

}  // namespace tiltfeed
