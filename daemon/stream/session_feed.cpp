#include "daemon/stream/session_feed.h"

#include <string>

#include "daemon/protocol/drive_block.h"
#include "daemon/wire/modbus_map.h"

namespace tiltfeed::daemon {

namespace {

tl::unexpected<Error> at_line(const LineReader& program, const Line& line, const Error& error) {
  return fail(error.code,
              program.path() + ":" + std::to_string(line.number) + ": '" + line.text + "': " + error.message);
}

}  // namespace

Result<bool> BlockFeed::next(NumericBlock& block) {
  while (used_ == blocks_.size()) {
    blocks_.clear();
    used_ = 0;
    const Result<bool> more = program_.next(line_);
    if (!more || !*more) return more;
    if (const Result<void> read = reader_.read(line_, blocks_); !read)
      return at_line(program_, line_, read.error());
  }
  block = std::move(blocks_[used_++]);
  return true;
}

Result<std::uint64_t> survey_blocks(LineReader& program, const NumericAxes& axes) {
  BlockFeed feed(program, axes, {});
  const RingIdentity usual_scale;
  NumericBlock block;
  std::uint64_t blocks = 0;
  for (;; ++blocks) {
    const Result<bool> more = feed.next(block);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    if (const auto words = encode_block(block, 0, usual_scale, false); !words)
      return at_line(program, {block.line, block.text}, words.error());
  }
  if (blocks == 0) return fail(Code::kInput, program.path() + ": has no block to send");
  if (const Result<void> back = program.rewind(); !back) return tl::unexpected<Error>(back.error());
  return blocks;
}

Result<void> survey_drive(LineReader& program, const NumericAxes& axes, const config::DriveMap& map) {
  BlockFeed feed(program, axes, {});
  DriveEncoder encoder(map);
  NumericBlock block;
  for (;;) {
    const Result<bool> more = feed.next(block);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) return program.rewind();
    if (const auto words = encoder.encode(block); !words)
      return at_line(program, {block.line, block.text}, words.error());
  }
}

}  // namespace tiltfeed::daemon
