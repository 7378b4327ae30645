#pragma once
// Where the tool is in a move of a program, as the control makes it. Shares nothing with
// kinematics/machine/machine.cpp.

#include <cstdint>

#include "kinematics/machine/machine.h"
#include "sim/motion/forward.h"

namespace tiltfeed::sim {

/// One move from words to words. All axes travel linearly; under TCP X Y Z are the tip's in the part's frame
/// as it stands with the rotaries at home.
struct ProgramMove {
  Joints from, to;
  bool rapid = false, tcp = false;
  std::uint32_t line = 0;   ///< of the text, from 1
  std::uint64_t block = 0;  ///< of those that move an axis, from 1
  bool goes_on = false;     ///< a piece of the block's arc, more of which follows
};

class MoveFrames {
 public:
  MoveFrames(const MachineModel& machine, const Setup& setup);

  Pose pose(const Joints& words, bool tcp) const;
  Pose pose(const ProgramMove& move, double share) const;
  /// The words under TCP of where the axes stand, and back.
  Joints tip_words(const Joints& slides) const;
  Joints slide_words(const Joints& tip) const;
  /// The tool axis and the directions of X Y Z (columns) in the part's frame with the table at home.
  Vec3 tool(const Joints& words) const { return fixture_ * chain_(words).axis; }
  Rotation slides(const Joints& words) const;
  /// A rotary turns.
  static bool turns(const ProgramMove& move) { return move.from.a != move.to.a || move.from.c != move.to.c; }
  /// (P3) The largest distance of any point within `reach` of the tip from the straight way between where
  /// it is at the begin and at the end of the move, at the same share of it, mm. Over a share s of the move
  /// it is no more than s^2 times that. `from`, `to`: where the move begins and ends.
  double stray(const ProgramMove& move, const Pose& from, const Pose& to, double reach) const {
    return turns(move) ? stray(move, from, pose(move, 0.5), to, reach) : 0.0;
  }
  /// `middle`: where it is half way; asked for where a rotary turns.
  double stray(const ProgramMove& move, const Pose& from, const Pose& middle, const Pose& to,
               double reach) const;

 private:
  /// Bounds of the second and third derivative of the way by the share, mm.
  struct Bounds {
    double second = 0.0, third = 0.0;
  };
  Bounds bounds(const ProgramMove& move, const Pose& from, const Pose& to, double reach) const;
  FrameChain chain_;
  Structure structure_;
  Rotation fixture_;
  Vec3 part_zero_, rotary_;
  double pivot_to_tip_, between_;  ///< lengths of arms, mm
};

}  // namespace tiltfeed::sim
