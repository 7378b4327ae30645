#include "daemon/stream/stream.h"

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "daemon/machine/stop_machine.h"
#include "daemon/program/block_cursor.h"
#include "daemon/protocol/drip_session.h"
#include "daemon/protocol/drive_session.h"
#include "daemon/protocol/grbl_session.h"
#include "daemon/protocol/modbus_session.h"
#include "daemon/protocol/reprap_session.h"
#include "daemon/stream/session_feed.h"
#include "daemon/wire/open_link.h"
#include "daemon/wire/steady_clock.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;

constexpr Time kProgressInterval = milliseconds(100);
/// After a fault one last byte (feed hold) may be due; it gets this long to leave.
constexpr Time kLastWordWait = milliseconds(100);
/// An operator's command waits no longer than this: well within a status interval.
constexpr Time kLongestWait = milliseconds(50);

/// The wire, and whoever looks on.
class WatchedLink {
 public:
  WatchedLink(Link& link, Clock& clock, const StreamHooks& hooks)
      : link_(link), clock_(clock), hooks_(hooks) {}
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) {
    in.clear();
    Result<std::size_t> taken = link_.exchange(out, wait, in);
    if (!hooks_.traffic) return taken;
    const Time now = clock_.now();
    if (taken && *taken > 0) hooks_.traffic(Way::kOut, out.substr(0, *taken), now);
    if (!in.empty()) hooks_.traffic(Way::kIn, in, now);
    return taken;
  }

 private:
  Link& link_;
  Clock& clock_;
  const StreamHooks& hooks_;
};

template <class Session>
void say_last_word(Session& session, WatchedLink& link, Time now) {
  std::string in;
  const std::string_view out = session.output(now);
  if (!out.empty())
    static_cast<void>(link.exchange(out, kLastWordWait, in));  // best effort: it has failed anyway
}

template <class Session>
void obey(Session& session, CommandQueue* commands, Time now) {
  if (commands == nullptr) return;
  while (const std::optional<OperatorCommand> command = commands->take()) session.command(*command, now);
}

/// The loop: program -> session -> wire -> session, until a final phase.
template <class Session, class Feed>
Result<SendReport> run(Session& session, Feed& feed, std::uint64_t last, Link& wire, Clock& clock,
                       const StreamHooks& hooks) {
  WatchedLink link(wire, clock, hooks);
  Reserve reserve(hooks);
  SendReport report;
  const Time began = clock.now();
  Time next_progress = began;
  Phase shown = session.phase();
  bool proved = false;
  std::optional<Error> program_error;
  std::string in;
  while (!is_final(session.phase())) {
    obey(session, hooks.commands, clock.now());
    if (const Result<void> fed = program_error ? Result<void>() : feed.fill(session, reserve); !fed) {
      program_error = fed.error();
      session.command({Order::kStop}, clock.now());
    }
    Time now = clock.now();
    const std::string_view out = session.output(now);
    if (is_final(session.phase())) break;
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
    const bool finished = !proved && session.phase() == Phase::kDrain && session.state().executed == last;
    proved = proved || finished;
    if (hooks.progress && (now >= next_progress || session.phase() != shown || finished)) {
      next_progress = now + kProgressInterval;
      shown = session.phase();
      if (!is_final(shown) && !hooks.progress(session.state())) session.command({Order::kStop}, now);
    }
  }
  const SendState state = session.state();
  if (session.phase() != Phase::kDone) say_last_word(session, link, clock.now());
  if (hooks.progress) hooks.progress(state);
  if (program_error) return fail(program_error->code, program_error->message + "; " + describe(state));
  if (session.phase() != Phase::kDone) return tl::unexpected<Error>(session.error());
  report.lines = state.sent;
  report.acknowledged = state.acknowledged;
  report.executed = state.executed;
  report.resends = state.resends;
  report.seconds = std::chrono::duration<double>(clock.now() - began).count();
  return report;
}

/// The wire of a run that has failed, while whoever watches it is told that it still lives.
class AliveLink : public Link {
 public:
  AliveLink(Link& wire, Clock& clock, const StreamHooks& hooks, const SendState& state)
      : link_(wire, clock, hooks), hooks_(hooks), state_(state) {}
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (hooks_.progress) hooks_.progress(state_);
    std::string came;
    Result<std::size_t> taken = link_.exchange(out, std::min(wait, kProgressInterval), came);
    in += came;
    gone = gone || !taken;
    return taken;
  }
  bool gone = false;

 private:
  WatchedLink link_;
  const StreamHooks& hooks_;
  const SendState& state_;
};

/// After a fault in mid-run the machine must not run on with what it has, nor stand with its spindle turning:
/// held, and reset at a stand; a firmware without hold ends what it has, then spindle and coolant go off.
/// What a restart or an alarm has emptied, and a wire that has gone, are left.
Error make_safe(const Error& error, const SendState& state, const LinkSpec& spec, Link& link, Clock& clock,
                const StreamHooks& hooks) {
  const bool emptied = state.loss == Loss::kRestarted || state.loss == Loss::kForgotten;
  if (state.phase != Phase::kFault || state.sent == 0 || emptied) return error;
  AliveLink wire(link, clock, hooks, state);
  const Result<std::string> stopped = stop_machine(spec, wire, clock);
  if (wire.gone) return error;
  return {error.code, error.message + "; " + (stopped ? "then " + *stopped : stopped.error().message)};
}

/// A fresh name for the run, so that an old session's blocks can never be taken for ours.
std::uint16_t new_session_id() {
  std::random_device random;
  return static_cast<std::uint16_t>(1 + random() % 0xFFFF);
}

struct Opened {
  LineReader program;
  ProgramFacts facts;
  std::uint64_t blocks = 0;
  ProgramSpan span = {};
};

Result<Opened> open_program(const std::string& path, LinkKind kind, const NumericAxes& axes) {
  Result<LineReader> program = LineReader::open(path);
  if (!program) return tl::unexpected<Error>(program.error());
  Result<ProgramFacts> facts = program->survey();
  if (!facts) return tl::unexpected<Error>(facts.error());
  std::uint64_t blocks = facts->lines;
  if (counts_numeric_blocks(kind)) {
    const Result<std::uint64_t> counted = survey_blocks(*program, axes);
    if (!counted) return tl::unexpected<Error>(counted.error());
    blocks = *counted;
  }
  return Opened{std::move(*program), std::move(*facts), blocks};
}

Result<Opened> open_span(const std::string& path, const LinkSpec& spec, const SendOptions& options) {
  Result<Opened> opened = open_program(path, spec.kind, spec.axes);
  if (!opened) return opened;
  opened->span = {0, opened->blocks, {}};
  if (options.span) {
    opened->span = *options.span;
  } else if (opened->facts.waits > 0) {
    const auto changes = kept_changes(path, spec);
    if (!changes) return tl::unexpected<Error>(changes.error());
    opened->span = span_at(*changes, opened->blocks, 0);
  }
  return opened;
}

ModbusOptions modbus_options(const LinkSpec& spec, const SendOptions& options, const Opened& opened) {
  ModbusOptions modbus;
  modbus.total = opened.blocks;
  modbus.before = opened.span.after;
  modbus.map = spec.profile.ring;
  modbus.tolerance = spec.positions.tolerance;
  modbus.session_id = options.session_id != 0 ? options.session_id : new_session_id();
  if (options.attach) {
    modbus.attach = true;
    modbus.session_id = options.attach->session;
    modbus.boot = options.attach->boot;
    modbus.accepted = options.attach->accepted - std::min(modbus.before, options.attach->accepted);
    modbus.reserved = options.attach->reserved - std::min(modbus.before, options.attach->reserved);
    modbus.executed = options.attach->executed - std::min(modbus.before, options.attach->executed);
  }
  return modbus;
}

GrblOptions grbl_options(const LinkSpec& spec, const SendOptions& options, const Opened& opened) {
  const ProgramFacts& facts = opened.facts;
  GrblOptions grbl;
  grbl.before = opened.span.after;
  grbl.total = facts.lines;
  grbl.longest = facts.longest;
  grbl.longest_line = facts.longest_line;
  grbl.receive_buffer = spec.receive_buffer;
  grbl.max_line = spec.max_line;
  grbl.check = options.check || spec.profile.check;
  grbl.number_lines = spec.profile.line_numbers;
  grbl.positions = spec.positions;
  return grbl;
}

Result<SendReport> send_opened(Opened& opened, const LinkSpec& spec, Link& link, Clock& clock,
                               const SendOptions& options, const StreamHooks& hooks) {
  if (options.program && *options.program != opened.facts.hash)
    return fail(Code::kIo, opened.program.path() + ": was changed since it was checked; nothing was sent");
  if (options.attach && !is_ring(spec.kind))
    return fail(Code::kUsage,
                describe(spec) + ": this link cannot prove what was executed; resume from a line");
  const ProgramSpan& span = opened.span;
  Result<SendReport> report;
  if (is_ring(spec.kind)) {
    ModbusSession session(modbus_options(spec, options, opened), clock.now());
    BlockFeed feed(opened.program, spec.axes, span);
    report = run(session, feed, span.last, link, clock, hooks);
  } else if (is_drive(spec.kind)) {
    if (const Result<void> fits = survey_drive(opened.program, spec.axes, spec.profile.drive); !fits)
      return tl::unexpected<Error>(fits.error());
    DriveSession session({opened.blocks, spec.profile.drive}, clock.now());
    BlockFeed feed(opened.program, spec.axes, span);
    report = run(session, feed, span.last, link, clock, hooks);
    if (report) report->executed.reset();  // the drive's word, with nothing to tell one move from another
  } else if (spec.kind == LinkKind::kGrbl) {
    GrblSession session(grbl_options(spec, options, opened), clock.now());
    LineFeed feed(opened.program, span);
    report = run(session, feed, span.last, link, clock, hooks);
    if (!report)
      report = tl::unexpected(make_safe(report.error(), session.state(), spec, link, clock, hooks));
  } else if (spec.kind == LinkKind::kRepRap) {
    RepRapSession session({opened.facts.lines, spec.profile.reprap_window, spec.positions, span.after},
                          clock.now());
    LineFeed feed(opened.program, span);
    report = run(session, feed, span.last, link, clock, hooks);
    if (!report)
      report = tl::unexpected(make_safe(report.error(), session.state(), spec, link, clock, hooks));
  } else {
    DripSession session({opened.facts.lines, spec.baud, spec.profile.drip}, clock.now());
    LineFeed feed(opened.program, span);
    report = run(session, feed, span.last, link, clock, hooks);
    if (report) report->executed.reset();  // sent is all that can be said
  }
  if (!report && report.error().message.starts_with(describe(spec) + ": ")) return report;
  if (!report) return fail(report.error().code, describe(spec) + ": " + report.error().message);
  report->link = spec.kind;
  report->change = span.next;
  report->program = opened.facts.hash;
  report->blocks = opened.blocks;
  report->header = opened.facts.header;
  return report;
}

}  // namespace

void CommandQueue::push(const OperatorCommand& command) {
  const std::lock_guard lock(mutex_);
  waiting_.push_back(command);
}

std::optional<OperatorCommand> CommandQueue::take() {
  const std::lock_guard lock(mutex_);
  if (waiting_.empty()) return std::nullopt;
  const OperatorCommand first = waiting_.front();
  waiting_.erase(waiting_.begin());
  return first;
}

Error without_range(Error error, const SendState& end) {
  const std::string range = "; " + describe(end);
  if (const std::size_t at = error.message.find(range); at != error.message.npos)
    error.message.erase(at, range.size());
  return error;
}

Result<std::vector<ToolChange>> kept_changes(const std::string& program_path, const LinkSpec& link) {
  // Without a machine profile nobody knows how it is parked.
  if (link.profile.tool_changes == config::ToolChanges::kControl || !link.axes.known)
    return std::vector<ToolChange>();
  return read_tool_changes(program_path, link.kind, link.axes);
}

Result<ProgramSum> sum_program(const std::string& program_path, LinkKind kind, const NumericAxes& axes) {
  const Result<Opened> opened = open_program(program_path, kind, axes);
  if (!opened) return tl::unexpected<Error>(opened.error());
  return ProgramSum{opened->blocks, opened->facts.hash, opened->facts.waits};
}

Result<std::uint64_t> count_blocks(const std::string& program_path, LinkKind kind) {
  const Result<ProgramSum> sum = sum_program(program_path, kind);
  if (!sum) return tl::unexpected<Error>(sum.error());
  return sum->blocks;
}

Result<SendReport> send_over(const std::string& program_path, const LinkSpec& spec, Link& link, Clock& clock,
                             const SendOptions& options, const StreamHooks& hooks) {
  Result<Opened> opened = open_span(program_path, spec, options);
  if (!opened) return tl::unexpected<Error>(opened.error());
  return send_opened(*opened, spec, link, clock, options, hooks);
}

Result<SendReport> send_program(const std::string& program_path, const LinkSpec& spec,
                                const SendOptions& options, const StreamHooks& hooks) {
  Result<Opened> opened = open_span(program_path, spec, options);
  if (!opened) return tl::unexpected<Error>(opened.error());
  Result<std::unique_ptr<Link>> link = open_link(spec);
  if (!link) return tl::unexpected<Error>(link.error());
  SteadyClock clock;
  return send_opened(*opened, spec, **link, clock, options, hooks);
}

}  // namespace tiltfeed::daemon
