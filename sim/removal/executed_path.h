#pragma once
// What the verification looks at, whatever it came from: the moves that a machine made, with their times.
// A program and an executed trace become the same thing here.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/machine/machine.h"
#include "sim/gcode/gcode_reader.h"
#include "sim/motion/motion_options.h"
#include "sim/motion/trace.h"

namespace tiltfeed::sim {

/// One block that moves the tool: every axis word runs linearly from where the move before ended to `to`.
struct ExecutedMove {
  Joints to;
  double start = 0.0, end = 0.0;  ///< machine time, s
  double asked = 0.0;             ///< what its F asks for, s; 0: a rapid
  std::uint64_t block = 0;        ///< count from 1 of the program's blocks, or TraceRow::block
  std::uint32_t line = 0;         ///< of the program: its N word, or the count of lines
  bool rapid = false;
  bool off_path = false;  ///< to or from the retract, or a piece of a block but its last
};

/// Properties: times ascend; the first motion block only states `start`, the pose the tool stands at, and is
/// not among the moves.
struct ExecutedPath {
  Joints start;
  std::uint32_t start_line = 0;
  std::vector<ExecutedMove> moves;
  double seconds = 0.0;  ///< from the first move's start to the last row's end, dwells included

  /// Blocks of the path: what the program's header counts, but for the first.
  std::size_t blocks() const;
  const Joints& from(std::size_t move) const { return move == 0 ? start : moves[move - 1].to; }
};

/// The words at a share f of the way.
inline Joints between(const Joints& from, const Joints& to, double f) {
  const auto mix = [f](double a, double b) { return a + (b - a) * f; };
  return {mix(from.x, to.x), mix(from.y, to.y), mix(from.z, to.z), mix(from.a, to.a), mix(from.c, to.c)};
}

/// A program as the simulated axes (sim/motion/motion.h) execute it when it is fed without delay, block by
/// block; `options`: how its control plans speeds. `expected`: about how many blocks there will be; only
/// saves time.
class ProgramRun {
 public:
  ProgramRun(std::string name, const MachineModel& machine, const Setup& setup, const MotionOptions& options,
             std::size_t expected);
  ~ProgramRun();
  /// After a block that leaves the machine's travel nothing more is executed.
  void take(const Block& block);
  /// Errors: kInput when it moved no axis; kLimit when a block left the travel: `name`, line, axis.
  Result<ExecutedPath> finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// All of a program. Errors: as ProgramRun.
Result<ExecutedPath> execute_program(const std::vector<Block>& program, const std::string& name,
                                     const MachineModel& machine, const Setup& setup,
                                     const MotionOptions& options = {});

/// A program's path by its operations: `begins` has the line of the text at which each begins, by rising
/// number. Times begin at 0 in each. Errors: kInput: an operation moves nothing: `name`.
Result<std::vector<ExecutedPath>> by_operations(ExecutedPath path, const std::vector<std::uint32_t>& begins,
                                                const std::string& name);

/// The moves of an executed trace; `options`: how its control reads F. Errors: kInput when there is none.
Result<ExecutedPath> executed_path(const std::vector<TraceRow>& trace, const std::string& name,
                                   const MotionOptions& options = {});

/// The coordinate (0 x, 1 y, 2 z) that the tool's axis is nearest to over the feed moves, on the whole.
int main_direction(const ExecutedPath& path, const MachineModel& machine, const Setup& setup);

}  // namespace tiltfeed::sim
