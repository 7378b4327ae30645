#pragma once
// The executed motion as dense poses: joints linear within each block, own forward kinematics.

#include <array>
#include <cstdint>
#include <vector>

#include "kinematics/machine/machine.h"
#include "sim/motion/trace.h"

namespace tiltfeed::sim {

/// Indices of two rows of the trace: the tool moves from the end of `from` to the end of `to`.
struct ExecutedBlock {
  std::size_t from = 0, to = 0;
};

/// The blocks that move an axis, in order; the first motion block of the trace is the start of the first.
std::vector<ExecutedBlock> executed_blocks(const std::vector<TraceRow>& trace);

/// Largest values over a trace, X Y Z tilt rotary.
struct AxisPeaks {
  std::array<double, 5> speed{};         ///< mm/min, degrees/min
  std::array<double, 5> acceleration{};  ///< within blocks, mm/s^2, degrees/s^2
};

/// From the peaks of each block. Requires: the rows are whole and in order.
AxisPeaks axis_peaks(const std::vector<TraceRow>& trace);

struct Sampling {
  int per_block = 5;      ///< at least
  double max_step = 0.0;  ///< of the tip and of the shank's end between two samples, mm
  double shank_length = 0.0;
};

/// Appends evenly spaced poses of the block, its end included, its start not; returns how many.
std::uint32_t sample_block(const MachineModel& machine, const Setup& setup, const Joints& from,
                           const Joints& to, const Sampling& sampling, std::vector<Pose>& poses);

}  // namespace tiltfeed::sim
