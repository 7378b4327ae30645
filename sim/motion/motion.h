#pragma once
// The simulated axes: a queue of blocks with a fixed number of slots, executed one after the other in
// simulated time. Within a block every axis word moves linearly; how fast, and over which corners without a
// stop, is planned ahead over what is queued. Knows nothing of wires.

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "kinematics/machine/machine.h"
#include "sim/gcode/gcode_reader.h"
#include "sim/motion/forward.h"
#include "sim/motion/path_block.h"
#include "sim/motion/trace.h"

namespace tiltfeed::sim {

/// What the machine did since it was built.
struct MotionTotals {
  std::uint64_t blocks = 0;    ///< executed to their end
  std::uint64_t programs = 0;  ///< ended by M2 or M30
  double busy = 0.0;           ///< sum of the blocks' times, standstill in a hold excluded, s
  double starved = 0.0;        ///< time inside a program with nothing to execute, holds excluded, s
};

/// What turns or flows beside the axes, as M3 to M9 left it.
struct Accessories {
  double spindle = 0.0;  ///< 1/min; 0: it stands
  bool reverse = false;  ///< M4
  bool mist = false, flood = false;
};

/// Properties: blocks end in the order in which they came, each exactly at its target; no axis exceeds its
/// velocity, acceleration and jerk within a block, nor at a corner the change of velocity that MotionOptions
/// allows; a block takes at least its programmed time; more slots or more look-ahead never make a program
/// slower; the same calls give the same rows. Seconds everywhere. A limit of zero in the machine model states
/// none.
class Motion {
 public:
  using Sink = std::function<void(const TraceRow&)>;

  /// Axes start at zero, or at the limit nearest to it. Requires: slots >= 1.
  Motion(MachineModel machine, Setup setup, std::size_t slots, Sink sink, MotionOptions options = {});

  /// The rows' poses stay at the origin, for sinks that do not ask for them.
  Motion& without_poses() {
    poses_ = false;
    return *this;
  }

  std::size_t slots() const { return slots_; }
  /// A slot is taken from push() to the block's end.
  std::size_t free_slots() const { return slots_ - (queue_.size() - slotless_); }
  bool idle() const { return queue_.empty(); }
  /// Requires: free_slots() > 0.
  void push(const Block& block);

  /// Runs to `now`. Requires: now >= this->now().
  void advance(double now);
  /// When the running block will end or the axes come to rest in a hold; nothing while they stand.
  std::optional<double> next_event() const;
  double now() const { return now_; }

  /// The axes brake at once, over as many blocks as it takes.
  void hold();
  void resume();
  bool held() const { return held_; }
  /// In a hold: have the axes come to rest?
  bool standing() const { return standing_; }
  /// Axes stop dead where they are and everything queued is forgotten; no row for the cut-off block. Spindle
  /// and coolant go off.
  void stop();
  /// The same, with spindle and coolant as they are.
  void quick_stop();

  void set_feed_override(int percent);
  void set_rapid_override(int percent);
  int feed_override() const { return feed_override_; }
  int rapid_override() const { return rapid_override_; }

  Joints position() const;  ///< now
  /// The block in execution (perhaps held), or nothing.
  const Block* running() const { return running_ ? &queue_.front().command : nullptr; }
  double speed() const;  ///< of X Y Z together, mm/min; 0 when nothing moves
  const Accessories& accessories() const { return accessories_; }
  const MotionTotals& totals() const { return totals_; }

  /// The first axis of a block that would leave its travel, as text, or nothing.
  std::optional<std::string> outside(const Joints& target) const;
  const MachineModel& machine() const { return machine_; }

 private:
  bool takes_slot(const PathBlock& block) const {
    return options_.still_takes_slot || block.stands || block.length > 0.0;
  }
  void look_ahead();
  void limit_entries(std::size_t last_known);
  void start_next();
  void plan_running(const PathState& from, double exit_before);
  void replan_running();
  void finish();
  void switch_accessories(const Block& command);
  void stand();
  void account();
  void set_override(int& which, int percent);
  std::size_t window() const;
  double exit_allowed() const;
  double end() const { return since_ + profile_.seconds(); }
  double fraction() const;

  MachineModel machine_;
  AxisLimits limits_;
  FrameChain chain_;
  std::size_t slots_;
  Sink sink_;
  MotionOptions options_;
  std::deque<PathBlock> queue_;
  std::size_t planned_ = 0;   ///< blocks of the queue that the look-ahead has seen
  std::size_t slotless_ = 0;  ///< blocks of the queue that take no slot
  Joints at_;                 ///< where the front block starts
  Joints last_;               ///< where the last queued block ends
  SpeedProfile profile_;      ///< of the running block from since_ on
  double now_ = 0.0;
  double start_ = 0.0;       ///< of the running block
  double since_ = 0.0;       ///< when profile_ began
  double accounted_ = 0.0;   ///< busy time is counted up to here
  double speed_ = 0.0;       ///< at the end of the block before, in its measure
  PathPeaks peaks_;          ///< of the running block's profiles that were cut off
  double idle_since_ = 0.0;  ///< while in a program with an empty queue
  Accessories accessories_;
  int feed_override_ = 100, rapid_override_ = 100;
  bool running_ = false, held_ = false, standing_ = false, in_program_ = false;
  bool poses_ = true;
  bool halts_ = false;  ///< profile_ ends at rest inside the block
  MotionTotals totals_;
};

}  // namespace tiltfeed::sim
