#include "daemon/stream.h"

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "daemon/grbl_session.h"
#include "daemon/modbus_session.h"
#include "daemon/words.h"

namespace tiltfeed {

namespace {

using std::chrono::milliseconds;

constexpr Time kProgressInterval = milliseconds(100);
/// After a fault one last byte (feed hold) may be due; it gets this long to leave.
constexpr Time kLastWordWait = milliseconds(100);
/// A session always wants to be called again soon; this bounds a mistake there.
constexpr Time kLongestWait = milliseconds(500);

class SteadyClock : public Clock {
 public:
  Time now() override { return std::chrono::steady_clock::now().time_since_epoch(); }
};

tl::unexpected<Error> at_line(const Program& program, const Line& line, const Error& error) {
  return fail(error.code,
              program.path() + ":" + std::to_string(line.number) + ": '" + line.text + "': " + error.message);
}

/// Program lines for a GrblSession.
class LineFeed {
 public:
  explicit LineFeed(Program& program) : program_(program) {}

  Result<void> fill(GrblSession& session) {
    while (session.wants_work()) {
      Line line;
      const Result<bool> more = program_.next(line);
      if (!more) return tl::unexpected<Error>(more.error());
      if (!*more) {
        session.end_of_program();
        return {};
      }
      session.push(std::move(line));
    }
    return {};
  }

 private:
  Program& program_;
};

/// Program lines as numeric blocks for a ModbusSession, or just counted.
class BlockFeed {
 public:
  explicit BlockFeed(Program& program) : program_(program) {}

  /// False at the program's end.
  Result<bool> next(NumericBlock& block) {
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

  Result<void> fill(ModbusSession& session) {
    while (session.wants_work()) {
      NumericBlock block;
      const Result<bool> more = next(block);
      if (!more) return tl::unexpected<Error>(more.error());
      if (!*more) {
        session.end_of_program();
        return {};
      }
      session.push(std::move(block));
    }
    return {};
  }

 private:
  Program& program_;
  BlockReader reader_;
  Line line_;
  std::vector<NumericBlock> blocks_;
  std::size_t used_ = 0;
};

/// Converts the whole program before anything is sent. Returns the number of blocks.
Result<std::uint64_t> survey_blocks(Program& program) {
  BlockFeed feed(program);
  const RingIdentity usual_scale;
  NumericBlock block;
  std::uint64_t blocks = 0;
  for (;; ++blocks) {
    const Result<bool> more = feed.next(block);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) break;
    if (const auto words = encode_block(block, 0, usual_scale); !words)
      return at_line(program, {block.line, block.text, false, 0.0}, words.error());
  }
  if (blocks == 0) return fail(Code::kInput, program.path() + ": has no block to send");
  if (const Result<void> back = program.rewind(); !back) return tl::unexpected<Error>(back.error());
  return blocks;
}

bool finished(Phase phase) { return phase == Phase::kDone || phase == Phase::kFault; }

template <class Session>
tl::unexpected<Error> say_last_word(Session& session, Link& link, Clock& clock) {
  std::string in;
  const std::string_view out = session.output(clock.now());
  if (!out.empty())
    static_cast<void>(link.exchange(out, kLastWordWait, in));  // best effort: it has failed anyway
  return tl::unexpected<Error>(session.error());
}

/// The loop: program -> session -> wire -> session, until done or fault.
template <class Session, class Feed>
Result<SendReport> run(Session& session, Feed& feed, Link& link, Clock& clock, const SendProgress& progress) {
  SendReport report;
  const Time began = clock.now();
  Time next_progress = began;
  std::string in;
  while (!finished(session.phase())) {
    if (const Result<void> fed = feed.fill(session); !fed) {
      session.stop();
      if (finished(session.phase())) static_cast<void>(say_last_word(session, link, clock));
      return tl::unexpected<Error>(fed.error());
    }
    Time now = clock.now();
    const std::string_view out = session.output(now);
    if (finished(session.phase())) break;
    in.clear();
    const Result<std::size_t> taken =
        link.exchange(out, std::clamp(session.deadline() - now, Time::zero(), kLongestWait), in);
    if (!taken) {
      session.link_lost(taken.error());
      break;
    }
    session.sent(*taken);
    report.bytes += *taken;
    now = clock.now();
    session.receive(in, now);
    if (now >= next_progress) {
      next_progress = now + kProgressInterval;
      if (progress && !progress(session.state())) session.stop();
    }
  }
  const SendState state = session.state();
  if (progress) progress(state);
  if (session.phase() == Phase::kFault) return say_last_word(session, link, clock);
  report.lines = state.sent;
  report.acknowledged = state.acknowledged;
  report.executed = state.executed;
  report.resends = state.resends;
  report.seconds = std::chrono::duration<double>(clock.now() - began).count();
  return report;
}

/// A fresh name for the run, so that an old session's blocks can never be taken for ours.
std::uint16_t new_session_id() {
  std::random_device random;
  return static_cast<std::uint16_t>(1 + random() % 0xFFFF);
}

struct Opened {
  Program program;
  ProgramFacts facts;
  std::uint64_t blocks = 0;
};

Result<Opened> open_program(const std::string& path, LinkKind kind) {
  Result<Program> program = Program::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  Result<ProgramFacts> facts = program->survey();
  if (!facts) return tl::unexpected<Error>(facts.error());
  std::uint64_t blocks = facts->lines;
  if (kind != LinkKind::kGrbl) {
    const Result<std::uint64_t> counted = survey_blocks(*program);
    if (!counted) return tl::unexpected<Error>(counted.error());
    blocks = *counted;
  }
  return Opened{std::move(*program), std::move(*facts), blocks};
}

Result<SendReport> send_opened(Opened& opened, const LinkSpec& spec, Link& link, Clock& clock,
                               std::uint16_t session_id, const SendProgress& progress) {
  Result<SendReport> report;
  if (spec.kind == LinkKind::kGrbl) {
    GrblSession session({opened.facts.lines, opened.facts.longest, opened.facts.longest_line,
                         spec.receive_buffer, spec.max_line},
                        clock.now());
    LineFeed feed(opened.program);
    report = run(session, feed, link, clock, progress);
  } else {
    ModbusSession session({opened.blocks, session_id}, clock.now());
    BlockFeed feed(opened.program);
    report = run(session, feed, link, clock, progress);
  }
  if (!report) return fail(report.error().code, describe(spec) + ": " + report.error().message);
  if (const Result<void> same = opened.program.rewind(); !same) return tl::unexpected<Error>(same.error());
  report->link = spec.kind;
  report->header = opened.facts.header;
  return report;
}

}  // namespace

Result<SendReport> send_over(const std::string& program_path, const LinkSpec& spec, Link& link, Clock& clock,
                             std::uint16_t session_id, const SendProgress& progress) {
  Result<Opened> opened = open_program(program_path, spec.kind);
  if (!opened) return tl::unexpected<Error>(opened.error());
  return send_opened(*opened, spec, link, clock, session_id, progress);
}

Result<SendReport> send_program(const std::string& program_path, const LinkSpec& spec,
                                const SendProgress& progress) {
  Result<Opened> opened = open_program(program_path, spec.kind);
  if (!opened) return tl::unexpected<Error>(opened.error());
  Result<std::unique_ptr<Link>> link = open_link(spec);
  if (!link) return tl::unexpected<Error>(link.error());
  SteadyClock clock;
  return send_opened(*opened, spec, **link, clock, new_session_id(), progress);
}

}  // namespace tiltfeed
