#pragma once
// How long the blocks really take: the programmed times, slowed down where an axis would have to accelerate
// harder than it can, by a forward and a backward pass over the program. (K10).

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kinematics/joints/joint_path.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// What the whole program asks of the machine.
struct Timing {
  double seconds = 0.0;           ///< machining time, accelerations and stops included
  std::uint64_t slowed = 0;       ///< blocks that take longer than programmed, by more than kSlowed
  Joints peak_velocity;           ///< mm/min and degrees/min
  Joints peak_acceleration;       ///< mm/s^2 and degrees/s^2
  std::vector<double> durations;  ///< of each block, s
};

/// A block that takes longer by this share of its time counts as slowed.
inline constexpr double kSlowed = 0.01;

/// What the control does where two blocks meet.
enum class Corners {
  kBlended,  ///< look-ahead over any number of blocks
  kExact,    ///< exact stop (G61): every block ends at rest, but for those that go straight on in X Y Z
  kFixed,    ///< blended where both blocks are blends_corners(), else exact stop
};

/// Of each block whether a control that bounds X Y Z alone may round its ends off (LinuxCNC's G64 P): neither
/// it nor a block beside it turns a rotary, and there are some of them in a row.
std::vector<bool> blends_corners(const std::vector<JointMove>& moves);

/// Servo period of LinuxCNC's configurations, s: a stop falls on a whole period.
inline constexpr double kServoPeriod = 0.001;

/// Axes move at constant acceleration along a block and round its corners off by at most `tolerance` (mm) and
/// `axis_tolerance` (degrees), over at most half of each block beside it; they stand still before and after
/// the program and where rapid and feed meet. With kExact, with kFixed where it does not blend, and at both
/// ends of a block that turns a rotary on a control that does not blend these, the axes stop by LinuxCNC's
/// rule (K10). Properties: 1 no axis speeds up or slows down harder than its limit. 2 No block is faster than
/// programmed.
Timing time_blocks(const std::vector<JointMove>& moves, const MachineModel& machine, double tolerance,
                   double axis_tolerance, Corners corners = Corners::kBlended);

/// Programs that run one after the other, with a stop between them. Requires: at least one.
Timing one_after_the_other(const std::vector<const Timing*>& programs);

/// A rapid at axis speed, the slowest axis's time, s.
double rapid_seconds(const MachineModel& machine, const Joints& from, const Joints& to);

/// A link and a control that take blocks so fast.
struct LinkRate {
  double bytes_per_s = 0.0;
  double bytes_per_block = 0.0;  ///< on average, line end included
  double buffer_bytes = 0.0;     ///< that wait in the control
};

/// Where blocks run out faster than they can be sent.
struct Starvation {
  double waits = 0.0;  ///< longest time that the machine stands for want of blocks in one window, s
  std::size_t first = 0, count = 0;  ///< of the window, blocks from 0
  double seconds = 0.0;              ///< what the window takes at the programmed feed
  double bytes_per_s = 0.0;          ///< that would just do for it
};

/// The window with the longest wait; `count` is 0 where the machine never waits. Requires: rates above 0.
Starvation starvation(const std::vector<double>& durations, const LinkRate& link);

}  // namespace tiltfeed
