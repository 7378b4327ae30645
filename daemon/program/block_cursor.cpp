#include "daemon/program/block_cursor.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::daemon {

namespace {

constexpr double kSecondsPerMinute = 60.0;

/// Not on the way from or to an unknown place.
bool states_place(const NumericBlock& b) { return b.kept == 0 && !b.machine; }

}  // namespace

Result<BlockCursor> BlockCursor::open(const std::string& path, LinkKind kind, const MachineModel& machine) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  return BlockCursor(std::move(*program), kind, machine);
}

double BlockCursor::seconds_of(const NumericBlock& b) const {
  if (b.op == BlockOp::kDwell) return b.seconds;
  if (b.op == BlockOp::kMCode) return 0.0;
  if (b.op == BlockOp::kFeed && b.inverse_time) return b.feed > 0.0 ? kSecondsPerMinute / b.feed : 0.0;
  if (!placed_ || !states_place(b)) return 0.0;
  const NumericBlock& from = at_.state;
  const double dx = std::abs(b.x - from.x), dy = std::abs(b.y - from.y), dz = std::abs(b.z - from.z);
  const double da = std::abs(b.tilt - from.tilt), dc = std::abs(b.rotary - from.rotary);
  if (b.op == BlockOp::kFeed) {
    const double length = b.way > 0.0 ? b.way : std::hypot(dx, dy, dz);
    return b.feed > 0.0 ? kSecondsPerMinute * (length > 0.0 ? length : std::max(da, dc)) / b.feed : 0.0;
  }
  return kSecondsPerMinute *
         std::max({dx / machine_.x.velocity, dy / machine_.y.velocity, dz / machine_.z.velocity,
                   machine_.tilt.present ? da / machine_.tilt.velocity : 0.0,
                   machine_.rotary.present ? dc / machine_.rotary.velocity : 0.0});
}

void BlockCursor::pass(const NumericBlock& block) {
  at_.seconds += seconds_of(block);
  at_.is_move = block.op == BlockOp::kRapid || block.op == BlockOp::kFeed;
  if (at_.is_move) {
    placed_ = states_place(block);
    if (placed_) ++at_.moves;
  }
  at_.state = block;
}

Result<bool> BlockCursor::next(WalkedBlock& block) {
  while (by_line_ || used_ == blocks_.size()) {
    blocks_.clear();
    used_ = 0;
    const Result<bool> more = program_.next(line_);
    if (!more || !*more) return more;
    if (const Result<void> read = reader_.read(line_, blocks_); !read)
      return fail(read.error().code, program_.path() + ":" + std::to_string(line_.number) + ": '" +
                                         line_.text + "': " + read.error().message);
    if (!by_line_) continue;
    at_.is_move = false;
    bool moved = false;
    for (const NumericBlock& part : blocks_) pass(part), moved = moved || at_.is_move;
    at_.is_move = moved;
    break;
  }
  if (!by_line_) pass(blocks_[used_++]);
  ++at_.block;
  at_.line = line_.number;
  at_.text = line_.text;
  block = at_;
  return true;
}

Result<WalkedBlock> find_block(const std::string& path, LinkKind kind, const MachineModel& machine,
                               std::uint64_t number) {
  Result<BlockCursor> walk = BlockCursor::open(path, kind, machine);
  if (!walk) return tl::unexpected<Error>(walk.error());
  WalkedBlock block;
  while (block.block < number) {
    const Result<bool> more = walk->next(block);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more)
      return fail(Code::kUsage,
                  "block " + std::to_string(number) + ": the program has " + std::to_string(block.block));
  }
  return block;
}

Result<ProgramTime> ProgramTime::read(const std::string& path, LinkKind kind, const MachineModel& machine) {
  Result<BlockCursor> walk = BlockCursor::open(path, kind, machine);
  if (!walk) return tl::unexpected<Error>(walk.error());
  ProgramTime time;
  WalkedBlock block;
  for (;;) {
    const Result<bool> more = walk->next(block);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    if (block.block % kStride == 0) time.marks_.push_back(block.seconds);
  }
  time.blocks_ = block.block;
  time.total_ = block.seconds;
  return time;
}

double ProgramTime::at(std::uint64_t blocks) const {
  if (blocks >= blocks_) return total_;
  const std::uint64_t mark = blocks / kStride, first = mark * kStride;
  const std::uint64_t last = std::min(first + kStride, blocks_);
  const double begin = marks_[mark], end = mark + 1 < marks_.size() ? marks_[mark + 1] : total_;
  return begin + (end - begin) * static_cast<double>(blocks - first) / static_cast<double>(last - first);
}

}  // namespace tiltfeed::daemon
