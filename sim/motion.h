#pragma once
// The simulated axes: a queue of blocks with a fixed number of slots, executed one after the other in
// simulated time. Within a block every axis word moves linearly. Knows nothing of wires.

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "kinematics/machine.h"
#include "sim/program.h"
#include "sim/trace.h"

namespace tiltfeed::sim {

/// What the machine did since it was built.
struct MotionTotals {
  std::uint64_t blocks = 0;    ///< executed to their end
  std::uint64_t programs = 0;  ///< ended by M2 or M30
  double busy = 0.0;           ///< sum of the blocks' times, holds excluded, s
  double starved = 0.0;        ///< time inside a program with nothing to execute, holds excluded, s
};

/// Properties: blocks end in the order in which they came; a block takes at least the time that its slowest
/// axis needs at its axis velocity; the time of G93 is 60 / F; the same calls give the same rows.
/// Seconds everywhere. Acceleration is not modelled.
class Motion {
 public:
  using Sink = std::function<void(const TraceRow&)>;

  /// Axes start at zero, or at the limit nearest to it. Requires: slots >= 1.
  Motion(MachineModel machine, Setup setup, std::size_t slots, Sink sink);

  std::size_t slots() const { return slots_; }
  /// A slot is taken from push() to the block's end.
  std::size_t free_slots() const { return slots_ - queue_.size(); }
  bool idle() const { return queue_.empty(); }
  /// Requires: free_slots() > 0.
  void push(const Block& block);

  /// Runs to `now`. Requires: now >= this->now().
  void advance(double now);
  /// When the running block will end; nothing while idle or held.
  std::optional<double> next_event() const;
  double now() const { return now_; }

  void hold();
  void resume();
  bool held() const { return held_; }
  /// Axes stop where they are and everything queued is forgotten; no row for the cut-off block.
  void stop();

  void set_feed_override(int percent);
  void set_rapid_override(int percent);
  int feed_override() const { return feed_override_; }
  int rapid_override() const { return rapid_override_; }

  Joints position() const;  ///< now
  /// The block in execution (perhaps held), or nothing.
  const Block* running() const { return running_ ? &queue_.front() : nullptr; }
  double speed() const;  ///< of X Y Z together, mm/min; 0 when nothing moves
  double spindle() const { return spindle_; }
  const MotionTotals& totals() const { return totals_; }

  /// The first axis of a block that would leave its travel, as text, or nothing.
  std::optional<std::string> outside(const Joints& target) const;
  const MachineModel& machine() const { return machine_; }

 private:
  void start_next();
  void finish();
  void account();
  void set_override(int& which, int percent);
  double duration(const Block& block) const;
  double fraction() const;
  double end() const { return since_ + (1.0 - fraction_) * duration_; }

  MachineModel machine_;
  Setup setup_;
  std::size_t slots_;
  Sink sink_;
  std::deque<Block> queue_;
  Joints at_;  ///< where the running block started
  double now_ = 0.0;
  double start_ = 0.0;       ///< of the running block
  double since_ = 0.0;       ///< when fraction_ was true
  double fraction_ = 0.0;    ///< of the running block, done at since_
  double duration_ = 0.0;    ///< of the whole running block at the present override
  double idle_since_ = 0.0;  ///< while in a program with an empty queue
  double spindle_ = 0.0;
  int feed_override_ = 100, rapid_override_ = 100;
  bool running_ = false, held_ = false, in_program_ = false;
  MotionTotals totals_;
};

}  // namespace tiltfeed::sim
