#include "sim/motion/dry_run.h"

#include <algorithm>

namespace tiltfeed::sim {
namespace {

// Blocks of the reference: at ten blocks a millimetre half a metre, many times the way that any axis brakes
// in.
constexpr std::size_t kFarAhead = 5000;

/// To the next event, past an M0; false when there is none.
bool step(Motion& motion) {
  if (motion.standing()) motion.resume();
  const auto event = motion.next_event();
  if (event) motion.advance(*event);
  return event.has_value();
}

MotionOptions far_sighted(MotionOptions options) {
  options.look_ahead = 0;
  return options;
}

}  // namespace

Result<DryRun> dry_run(const std::vector<Block>& program, const std::string& name,
                       const MachineModel& machine, const Setup& setup, const MotionOptions& options) {
  DryRun run;
  run.rows.reserve(program.size());
  const std::size_t slots =
      std::max<std::size_t>(1, options.look_ahead == 0 ? program.size() : options.look_ahead);
  Motion motion(
      machine, setup, slots, [&](const TraceRow& row) { run.rows.push_back(row); }, options);
  for (const Block& block : program) {
    const bool moves = block.op == Op::kRapid || block.op == Op::kFeed;
    if (const auto outside = motion.outside(block.target); moves && outside)
      return fail(Code::kLimit, name + ", line " + std::to_string(block.line) + ": " + *outside);
    while (motion.free_slots() == 0) step(motion);
    motion.push(block);
  }
  while (!motion.idle() && step(motion)) {
  }
  run.totals = motion.totals();
  return run;
}

ReferenceRun::ReferenceRun(const MachineModel& machine, const Setup& setup, MotionOptions options)
    : motion_(
          machine, setup, kFarAhead, [](const TraceRow&) {}, far_sighted(options)) {
  motion_.without_poses();
}

void ReferenceRun::take(const TraceRow& row) {
  while (motion_.free_slots() == 0) step(motion_);
  motion_.push(row.command);
}

double ReferenceRun::seconds() {
  while (!motion_.idle() && step(motion_)) {
  }
  return motion_.totals().busy;
}

}  // namespace tiltfeed::sim
