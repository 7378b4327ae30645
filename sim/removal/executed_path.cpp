#include "sim/removal/executed_path.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "sim/motion/forward.h"
#include "sim/motion/motion.h"
#include "sim/motion/path_block.h"

namespace tiltfeed::sim {
namespace {

// Blocks that the simulated axes hold, if they look no further ahead; a program from a file is never late.
constexpr std::size_t kSlots = 64;

/// Takes rows in order, keeps the moves.
class Collector {
 public:
  Collector(const MotionOptions& options, std::size_t moves) : options_(options) {
    path_.moves.reserve(moves);
  }
  void take(const TraceRow& row) {
    end_ = row.end;
    const Op op = row.command.op;
    if (op != Op::kRapid && op != Op::kFeed) return;
    if (!started_ || !row.command.placed) {
      started_ = row.command.placed, begin_ = row.end;
      path_.start = row.command.target, path_.start_line = row.command.line;
      return;
    }
    const bool away = row.command.off_path;
    // The block that comes down from a later retract is one of the path's own.
    if (!away && std::exchange(on_path_, true) && away_) path_.moves.back().off_path = false;
    away_ = away;
    const Joints& from = path_.moves.empty() ? path_.start : path_.moves.back().to;
    AxisVector way = axes_of(row.command.target);
    for (std::size_t i = 0; const double start : axes_of(from)) way[i++] -= start;
    path_.moves.push_back({row.command.target, row.start, row.end,
                           programmed_seconds(row.command, way, options_), row.block, row.command.line,
                           op == Op::kRapid, away || row.command.goes_on});
  }
  Result<ExecutedPath> finish(const std::string& name) {
    if (path_.moves.empty())
      return fail(Code::kInput, name + ": no motion after its first block; is it the right file?");
    path_.seconds = end_ - begin_;
    return std::move(path_);
  }

 private:
  const MotionOptions options_;
  ExecutedPath path_;
  bool started_ = false, away_ = false, on_path_ = false;
  double begin_ = 0.0, end_ = 0.0;
};

}  // namespace

struct ProgramRun::Parts {
  std::string name, machine;
  Collector collector;
  Motion motion;
  std::optional<Error> error;

  Parts(std::string the_name, const MachineModel& model, const Setup& setup, const MotionOptions& options,
        std::size_t expected)
      : name(std::move(the_name)),
        machine(model.name),
        collector(options, expected),
        motion(
            model, setup, std::max(kSlots, options.look_ahead),
            [this](const TraceRow& row) { collector.take(row); }, options) {
    motion.without_poses();
  }

  void run_until_free(std::size_t slots) {
    while (motion.free_slots() < slots) {
      if (motion.held()) motion.resume();  // M0 waits for the operator, who is not part of the time
      const auto next = motion.next_event();
      if (!next) break;
      motion.advance(*next);
    }
  }
};

ProgramRun::ProgramRun(std::string name, const MachineModel& machine, const Setup& setup,
                       const MotionOptions& options, std::size_t expected)
    : parts_(std::make_unique<Parts>(std::move(name), machine, setup, options, expected)) {}

ProgramRun::~ProgramRun() = default;

void ProgramRun::take(const Block& block) {
  Parts& p = *parts_;
  if (p.error) return;
  if (block.op == Op::kRapid || block.op == Op::kFeed) {
    if (const auto outside = p.motion.outside(block.target)) {
      p.error = Error{Code::kLimit, p.name + ": line " + std::to_string(block.line) + ": " + *outside +
                                        "; was the program posted for machine '" + p.machine + "'?"};
      return;
    }
  }
  p.run_until_free(1);
  p.motion.push(block);
}

Result<ExecutedPath> ProgramRun::finish() {
  if (parts_->error) return tl::unexpected(*parts_->error);
  parts_->run_until_free(parts_->motion.slots());
  return parts_->collector.finish(parts_->name);
}

Result<ExecutedPath> execute_program(const std::vector<Block>& program, const std::string& name,
                                     const MachineModel& machine, const Setup& setup,
                                     const MotionOptions& options) {
  ProgramRun run(name, machine, setup, options, program.size());
  for (const Block& block : program) run.take(block);
  return run.finish();
}

Result<ExecutedPath> executed_path(const std::vector<TraceRow>& trace, const std::string& name,
                                   const MotionOptions& options) {
  Collector collector(options, trace.size());
  for (const TraceRow& row : trace) collector.take(row);
  return collector.finish(name);
}

std::size_t ExecutedPath::blocks() const {
  return static_cast<std::size_t>(
      std::count_if(moves.begin(), moves.end(), [](const ExecutedMove& move) { return !move.off_path; }));
}

Result<std::vector<ExecutedPath>> by_operations(ExecutedPath path, const std::vector<std::uint32_t>& begins,
                                                const std::string& name) {
  std::vector<ExecutedPath> paths;
  auto first = path.moves.begin();
  Joints start = path.start;
  for (std::size_t i = 0; i < begins.size(); ++i) {
    const auto last = i + 1 == begins.size()
                          ? path.moves.end()
                          : std::find_if(first, path.moves.end(), [&](const ExecutedMove& move) {
                              return move.line >= begins[i + 1];
                            });
    if (first == last)
      return fail(Code::kInput, name + ": operation " + std::to_string(i + 1) + " of the job moves nothing");
    ExecutedPath one;
    one.start = start, one.start_line = i == 0 ? path.start_line : begins[i];
    one.moves.assign(first, last);
    const double begin = one.moves.front().start;
    for (ExecutedMove& move : one.moves) move.start -= begin, move.end -= begin;
    one.seconds = one.moves.back().end;
    start = one.moves.back().to;
    first = last;
    paths.push_back(std::move(one));
  }
  return paths;
}

int main_direction(const ExecutedPath& path, const MachineModel& machine, const Setup& setup) {
  constexpr std::size_t kPosesAsked = 2000;
  Vec3 sum;
  const std::size_t step = path.moves.size() / kPosesAsked + 1;
  for (std::size_t m = 0; m < path.moves.size(); m += step) {
    const Vec3 axis = forward_by_frames(machine, setup, path.moves[m].to).axis;
    sum = sum + Vec3{std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)};
  }
  return sum.z >= sum.x && sum.z >= sum.y ? 2 : sum.y >= sum.x ? 1 : 0;
}

}  // namespace tiltfeed::sim
