#pragma once
// A joint path as data: its moves, what was asked of it, and the report on it.

#include <cstdint>
#include <optional>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "kinematics/machine/machine_model.h"

namespace tiltfeed {

/// One block: all axes move linearly from the joints before to these, in `seconds`.
struct JointMove {
  Joints joints;         ///< already rounded to the decimals that will be printed
  double seconds = 0.0;  ///< at feed; for a rapid at axis speed
  MoveKind kind = MoveKind::kRapid;
  std::uint32_t move = 0;  ///< index into ToolPath::moves of the move that this block belongs to
  double speed = 1.0;      ///< share of the path's feed; `seconds` counts with it
};

/// What is known of the space about the work: nothing (part, stock, clamp) is higher than `height` above part
/// zero along `rotary_up`, nor further than `radius` from the rotary's axis; mm.
struct ClearSpace {
  std::optional<double> height;  ///< a tool whose axis rises may be taken off upwards
  std::optional<double> radius;  ///< a tool that lies may be taken off sideways
};

struct JointPathOptions {
  /// Largest distance from the path's of the moving tip, of the moving ball centre (`tool.corner_radius` up
  /// the axis), and of all of the tool up to `reach`; mm.
  double tolerance = 0.004;
  double reach = 0.0;           ///< from the tip up the axis to the shank's end, mm; 0: the ball's centre
  double axis_tolerance = 0.1;  ///< largest angle between the moving axis and the path's axis, degrees
  int linear_decimals = 4;      ///< printed decimals of X Y Z, mm
  int rotary_decimals = 4;      ///< printed decimals of A C, degrees
  /// With it the tool may be taken off the part where limits force it (K11); without it such a path is an
  /// error.
  ClearSpace clear;
};

/// Rapids, in clear air, may stray this much further than feed moves: fewer stops.
inline constexpr double kRapidToleranceFactor = 10.0;

/// What the post did; every figure is over the whole path. Deviations are sampled on the rounded joints.
struct JointPathReport {
  double seconds = 0.0;                ///< machining time, rapids included
  double max_tip_deviation = 0.0;      ///< of feed moves, mm
  double max_end_deviation = 0.0;      ///< of the shank's end on feed moves (JointPathOptions::reach), mm
  double max_axis_deviation = 0.0;     ///< of feed moves, degrees
  double max_rapid_deviation = 0.0;    ///< of tip and shank's end on rapids, mm
  std::uint64_t subdivided_moves = 0;  ///< moves that became more than one block
  std::uint64_t pole_swings = 0;       ///< turns of the table at the pole with the tip held
  std::uint64_t reconfigurations = 0;  ///< times that the tool is taken off to turn a rotary back or over
  Joints min, max;                     ///< travel used
  /// What comes after this.
  void add(const JointPathReport& more);
};

struct JointPath {
  std::vector<JointMove> moves;  ///< moves[0] states the start joints; its seconds are 0
  JointPathReport report;
  std::optional<ToolPath>
      reconfigured;  ///< the path with its reconfigurations, whose moves `move` then counts
  /// With `reconfigured`, by its moves: the move of the planned path that it is, or after which it is put in.
  std::vector<std::uint32_t> planned;
  /// Of words under TCP, by block: the move of the joint path that it ends with.
  std::vector<std::uint32_t> ends{};
};

/// Axis by axis.
Joints least(const Joints& p, const Joints& q);
Joints greatest(const Joints& p, const Joints& q);

}  // namespace tiltfeed
