#pragma once
// The executed trace: what the simulated machine did, one row a block, written as it happens.
// CSV with the header line below; times in s, axis words in mm and degrees, tip and axis in part coordinates.

#include <iosfwd>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/machine/machine.h"
#include "sim/gcode/gcode_reader.h"

namespace tiltfeed::sim {

/// Columns as TraceRow. `op` is rapid, feed (f in mm/min), inverse (a feed move, f in 1/min), dwell (f in s)
/// or M<number> (f is the spindle speed in force).
inline constexpr const char* kTraceHeader =
    "block,line,op,start_s,end_s,x,y,z,a,c,f,tip_x,tip_y,tip_z,axis_i,axis_j,axis_k,peak_rate,peak_"
    "acceleration";

struct TraceRow {
  std::uint64_t block = 0;        ///< 1-based count of executed blocks
  Block command;                  ///< what was executed (op, target, feed, line)
  double start = 0.0, end = 0.0;  ///< machine time, s
  Pose pose;                      ///< at the block's end
  /// Largest rate at which the block's fraction grew, 1/s, and the largest change of that rate, 1/s^2: times
  /// the way of an axis in the block they are that axis's peak speed and acceleration. 0 where nothing moved.
  double peak_rate = 0.0, peak_acceleration = 0.0;
};

void write_trace_header(std::ostream& out);
void write_trace_row(const TraceRow& row, std::ostream& out);
/// Reads what was written; Block::spindle of moves and dwells is not in the trace. A last line without its
/// line end is one that is still being written: it is left out.
/// Errors: kInput with `name`:line.
Result<std::vector<TraceRow>> read_trace(std::istream& in, const std::string& name);

}  // namespace tiltfeed::sim
