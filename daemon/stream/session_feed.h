#pragma once
// The program's lines as the sessions take them, each on record before it may leave.

#include <cstdint>
#include <utility>
#include <vector>

#include "config/link_profile.h"
#include "daemon/program/line_reader.h"
#include "daemon/program/numeric_block.h"
#include "daemon/program/tool_change.h"
#include "daemon/stream/stream_hooks.h"

namespace tiltfeed::daemon {

/// Asks for the record of each block before a session has it.
class Reserve {
 public:
  explicit Reserve(const StreamHooks& hooks) : hooks_(hooks) {}
  Result<void> before(std::uint64_t block, std::uint64_t line) {
    if (!hooks_.reserve || block <= reserved_) return {};
    const Result<std::uint64_t> reserved = hooks_.reserve(block, line);
    if (!reserved) return tl::unexpected<Error>(reserved.error());
    reserved_ = *reserved;
    return {};
  }

 private:
  const StreamHooks& hooks_;
  std::uint64_t reserved_ = 0;
};

/// LineReader lines of a span of the program, for a session that sends text.
class LineFeed {
 public:
  LineFeed(LineReader& program, const ProgramSpan& span) : program_(program), span_(span) {}

  template <class Session>
  Result<void> fill(Session& session, Reserve& reserve) {
    if (session.wants_rewind()) {
      if (const Result<void> back = program_.rewind(); !back) return back;
      blocks_ = 0;
    }
    while (session.wants_work()) {
      Line line;
      const Result<bool> more = program_.next(line);
      if (!more) return tl::unexpected<Error>(more.error());
      if (!*more || ++blocks_ > span_.last) {
        session.end_of_program();
        return {};
      }
      if (blocks_ <= span_.after) continue;
      if (session.phase() == Phase::kRun)
        if (const Result<void> noted = reserve.before(blocks_, line.number); !noted) return noted;
      session.push(std::move(line));
    }
    return {};
  }

 private:
  LineReader& program_;
  ProgramSpan span_;
  std::uint64_t blocks_ = 0;
};

/// LineReader lines as numeric blocks for a session over Modbus, or just counted.
class BlockFeed {
 public:
  BlockFeed(LineReader& program, const NumericAxes& axes, const ProgramSpan& span)
      : program_(program), span_(span), reader_(axes) {}

  /// False at the program's end.
  Result<bool> next(NumericBlock& block);

  template <class Session>
  Result<void> fill(Session& session, Reserve& reserve) {
    while (session.wants_work()) {
      NumericBlock block;
      const Result<bool> more = next(block);
      if (!more) return tl::unexpected<Error>(more.error());
      if (!*more || ++count_ > span_.last) {
        session.end_of_program();
        return {};
      }
      if (count_ <= span_.after) continue;
      // Completed before this process came.
      if (count_ <= span_.after + *session.first_block()) {
        session.pass(block);
        continue;
      }
      if (const Result<void> noted = reserve.before(count_, block.line); !noted) return noted;
      session.push(std::move(block));
    }
    return {};
  }

 private:
  LineReader& program_;
  ProgramSpan span_;
  BlockReader reader_;
  Line line_;
  std::vector<NumericBlock> blocks_;
  std::size_t used_ = 0;
  std::uint64_t count_ = 0;
};

/// Converts the whole program before anything is sent. Returns the number of blocks.
Result<std::uint64_t> survey_blocks(LineReader& program, const NumericAxes& axes);
/// The same for what a drive can do of it. Errors: as DriveEncoder, with path:line.
Result<void> survey_drive(LineReader& program, const NumericAxes& axes, const config::DriveMap& map);

}  // namespace tiltfeed::daemon
