#pragma once
// What a program's comments and T words say that it was made for, against the job that it is verified with.

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "sim/gcode/gcode_reader.h"
#include "sim/motion/trace.h"

namespace tiltfeed::sim {

/// From comments `(TILTFEED key ...)`; what is not stated stays empty.
struct ProgramHeader {
  std::string part, machine;
  std::optional<double> diameter, length;  ///< of the tool, mm
  std::optional<Vec3> part_zero;           ///< from the rotary axis, mm
  std::optional<std::uint64_t> blocks;     ///< that move an axis
  std::optional<double> seconds;           ///< machining time that the post foresaw
};

/// Looks at the lines before the first block that moves an axis; the stream is left anywhere.
ProgramHeader read_program_header(std::istream& in);

/// Errors: kInput: posted for another machine, part, part zero or tool; `name` and both values.
Result<void> check_header(const ProgramHeader& header, const config::Job& job, const std::string& name);

/// Errors: kInput: the program moves with another tool in the spindle than the job's `program.tool`, by its T
/// and M6 words; `name`, line and both numbers. A program without T words may mean any tool; T0, an empty
/// spindle, may move in rapid.
Result<void> check_tool(const Block& block, const config::Job& job, const std::string& name);
Result<void> check_tool(const std::vector<Block>& program, const config::Job& job, const std::string& name);

/// Errors: kInput: a tip of the trace is not where the job's machine, set-up and tool length put it by the
/// row's words; `name`, the block and both places.
Result<void> check_trace(const std::vector<TraceRow>& trace, const config::Job& job, const std::string& name);

}  // namespace tiltfeed::sim
