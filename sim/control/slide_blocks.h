#pragma once
// Blocks under TCP as the machine's axes run them: cut up until axes that travel linearly keep the tip on its
// way.

#include <functional>
#include <utility>

#include "sim/control/control_reader.h"

namespace tiltfeed::sim {

class SlideBlocks {
 public:
  /// `reach`: how far the tool reaches up from its tip; none of it strays further than `tolerance`, mm.
  SlideBlocks(const MachineModel& machine, const Setup& setup, double reach, double tolerance)
      : frames_(machine, setup), reach_(reach), tolerance_(tolerance) {}

  /// Another tool is in the spindle from here on. Requires: TCP is off.
  void use(const MachineModel& machine, const Setup& setup, double reach, double tolerance) {
    frames_ = MoveFrames(machine, setup), reach_ = reach, tolerance_ = tolerance;
  }
  /// Calls take(block) with the block, or its pieces, X Y Z those of the slides. All pieces but the last go
  /// on.
  void take(const ControlBlock& one, const std::function<void(const Block&)>& take);

 private:
  void cut(const ControlBlock& one, const Joints& from, const std::function<void(const Block&)>& take) const;

  MoveFrames frames_;
  double reach_, tolerance_;
  Joints at_;  ///< the words of where the block before ended
  bool tcp_ = false;
};

}  // namespace tiltfeed::sim
