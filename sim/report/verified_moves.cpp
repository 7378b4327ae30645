#include "sim/report/verified_moves.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <optional>

#include "sim/control/program_frame.h"
#include "sim/control/slide_blocks.h"
#include "sim/gcode/canon.h"
#include "sim/gcode/gcode_reader.h"
#include "sim/gcode/lines.h"

namespace tiltfeed::sim {
namespace {

// A line of a program is hardly shorter: a header that states more blocks is wrong.
constexpr std::uint64_t kBytesPerBlock = 8;
// Axes that travel linearly instead of a tip that does may leave its way by this share of the tolerance.
constexpr double kTipShare = 0.1;

using TakeBlock = std::function<void(const Block&)>;

double top_of(const config::Job& job) { return ToolSolid(job.plan.cutter).top(); }

/// The blocks of an operation's program in the dialect of the job's machine, X Y Z those of the slides.
Result<void> read_in_dialect(std::istream& in, const std::string& name, const config::Job& job,
                             const TakeBlock& take) {
  const config::Dialect dialect = job.machine.format.dialect;
  // With a tool number the text has the words of a tool change, which the simulated controller has not.
  if ((dialect == config::Dialect::kRs274 || dialect == config::Dialect::kGrbl) && job.program.tool == 0)
    return read_program(in, name, GcodeReader(job.machine.model), take);
  ControlReader reader(job.machine, job.setup);
  SlideBlocks slides(job.machine.model, job.setup, top_of(job), kTipShare * job.plan.tolerance);
  return read_control_program(in, name, reader, [&](const ControlBlock& one) { slides.take(one, take); });
}

/// The same of a program of several operations. `begins`: gets the line at which each begins.
Result<void> read_operations(std::istream& in, const std::string& name,
                             const std::vector<config::Job>& operations, std::vector<std::uint32_t>& begins,
                             const std::function<void(const Block&, const config::Job&)>& take) {
  const config::Job* job = &operations.front();
  const MachineModel& model = job->machine.model;
  Lines lines(in);
  FrameCheck frame(name, operations);
  ControlReader reader(job->machine, job->setup);
  SlideBlocks slides(model, job->setup, top_of(*job), kTipShare * job->plan.tolerance);
  std::vector<ControlBlock> blocks;
  begins = {1};
  while (!reader.ended()) {
    const auto line = lines.next();
    if (!line) break;
    if (auto sound = frame.take(*line); !sound) return sound;
    if (frame.operation() >= begins.size()) {
      job = &operations[frame.operation()];
      reader.use(job->setup);
      slides.use(model, job->setup, top_of(*job), kTipShare * job->plan.tolerance);
      begins.push_back(reader.lines() + 1);
    }
    blocks.clear();
    if (auto read = reader.read_line(*line, blocks); !read)
      return fail(read.error().code,
                  name + ":" + std::to_string(reader.lines()) + ": " + read.error().message);
    for (const ControlBlock& one : blocks) slides.take(one, [&](const Block& block) { take(block, *job); });
  }
  if (in.bad()) return fail(Code::kIo, name + ": cannot be read to its end");
  return {};
}

Result<VerifiedMoves> execute(std::ifstream& in, const std::string& name,
                              const std::vector<config::Job>& operations) {
  const config::Job& job = operations.front();
  VerifiedMoves moves;
  moves.header = read_program_header(in);
  if (auto fits = check_header(moves.header, job, name); !fits) return tl::unexpected(fits.error());
  in.clear();
  in.seekg(0);
  if (auto sound = check_frame(in, name, operations); !sound) return tl::unexpected(sound.error());
  in.clear();
  const auto size =
      static_cast<std::uint64_t>(std::max<std::streamoff>(0, in.seekg(0, std::ios::end).tellg()));
  in.seekg(0);
  const std::uint64_t expected = std::min(moves.header.blocks.value_or(0), size / kBytesPerBlock);
  ProgramRun run(name, job.machine.model, job.setup, motion_options(job.machine), expected);
  Result<void> fits;
  const auto take = [&](const Block& block, const config::Job& of) {
    if (fits) fits = check_tool(block, of, name);
    if (fits) run.take(block);
  };
  std::vector<std::uint32_t> begins;
  const auto read = operations.size() > 1
                        ? read_operations(in, name, operations, begins, take)
                        : read_in_dialect(in, name, job, [&](const Block& block) { take(block, job); });
  // What cannot be read comes before what does not fit, wherever it is.
  if (!read) return tl::unexpected(read.error());
  if (!fits) return tl::unexpected(fits.error());
  auto path = run.finish();
  if (!path) return tl::unexpected(path.error());
  if (operations.size() == 1) {
    moves.paths.push_back(std::move(*path));
    return moves;
  }
  auto paths = by_operations(std::move(*path), begins, name);
  if (!paths) return tl::unexpected(paths.error());
  moves.paths = std::move(*paths);
  return moves;
}

}  // namespace

Result<VerifiedMoves> read_moves(const MovesFile& file, const std::vector<config::Job>& operations) {
  const auto& [kind, name] = file;
  const config::Job& job = operations.front();
  std::ifstream in(name, std::ios::binary);
  if (!in) return fail(Code::kIo, name + ": cannot be opened");
  if (kind == Source::kProgram) return execute(in, name, operations);
  if (operations.size() > 1)
    return fail(Code::kUsage, name +
                                  ": only a program says where the operations of a job begin: verify that, "
                                  "or name the operation whose moves these are (--operation)");
  VerifiedMoves moves;
  const auto keep = [&](Result<ExecutedPath> path) -> Result<VerifiedMoves> {
    if (!path) return tl::unexpected(path.error());
    moves.paths.push_back(std::move(*path));
    return std::move(moves);
  };
  if (kind == Source::kCanon) {
    const auto program = read_canon(in, name, job.machine.model);
    if (!program) return tl::unexpected(program.error());
    if (auto fits = check_tool(*program, job, name); !fits) return tl::unexpected(fits.error());
    return keep(execute_program(*program, name, job.machine.model, job.setup, motion_options(job.machine)));
  }
  const auto trace = read_trace(in, name);
  if (!trace) return tl::unexpected(trace.error());
  if (auto fits = check_trace(*trace, job, name); !fits) return tl::unexpected(fits.error());
  return keep(executed_path(*trace, name, motion_options(job.machine)));
}

}  // namespace tiltfeed::sim
