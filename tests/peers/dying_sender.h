#pragma once
// A sender that dies at a step of its own: at any operation of the journal's disk or of the link, torn writes
// included. Seeded bugs stand where a broken sender would have them, so that the campaign can show that it
// would find them.

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <functional>
#include <memory>
#include <string>

#include "daemon/journal/program_run.h"
#include "daemon/wire/modbus_map.h"
#include "sim/controller/modbus_controller.h"
#include "tests/peers/simulated_disk.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

/// What a broken sender would do; each must be found by the campaign.
enum class Bug {
  kNone,
  kNoJournal,         // nothing is on record
  kStartsAnew,        // does not look at what is
  kFromExecuted,      // a new session after the executed blocks of the journal: asks nobody
  kFromAcknowledged,  // the same after the acknowledged ones
  kFromOffered,       // the same after those that may have left
  kBuffered,          // a record is written when the next one comes
  kOldProgram,        // goes on although the file is another one
  kNeverDurable,      // no sync (power loss)
  kOfferedForSure,    // after a power loss believes what was not durable
};

/// Counts the steps of a sender; at one of them it dies.
struct Steps {
  std::uint64_t count = 0, at = ~0ull, torn = 0;
  bool power = false;  // no process to kill: everything fails from here on
  bool dead = false;
  /// True when this is the step.
  bool now() { return ++count == at; }
  void die() {
    dead = true;
    if (!power) ::kill(::getpid(), SIGKILL);
  }
  bool step() {
    if (!dead && now()) die();
    return dead;
  }
};

inline JournalDisk dying_disk(JournalDisk inner, Steps& steps, Bug bug) {
  JournalDisk disk = inner;
  const auto waiting = std::make_shared<std::pair<std::uint64_t, std::string>>();
  disk.write = [inner, &steps, bug, waiting](std::uint64_t at, std::string_view bytes) -> std::ptrdiff_t {
    if (steps.dead) return -EIO;
    if (steps.now()) {  // a torn write
      inner.write(at, bytes.substr(0, steps.torn % (bytes.size() + 1)));
      steps.die();
      return -EIO;
    }
    if (bug != Bug::kBuffered) return inner.write(at, bytes);
    if (!waiting->second.empty()) inner.write(waiting->first, waiting->second);
    *waiting = {at, std::string(bytes)};
    return static_cast<std::ptrdiff_t>(bytes.size());
  };
  disk.replace = [inner, &steps](std::string_view content) {
    if (steps.step()) return -EIO;
    const int result = inner.replace(content);
    return steps.step() ? -EIO : result;
  };
  disk.sync = [inner, &steps, bug] {
    if (steps.step()) return -EIO;
    if (bug == Bug::kNeverDurable) return 0;
    const int result = inner.sync();
    return steps.step() ? -EIO : result;
  };
  return disk;
}

/// Time passes only where somebody waits.
struct ScriptClock : Clock {
  Time time{0};
  Time now() override { return time; }
};

/// Requests go to `send`, which gives the reply; waiting tells `wait` how long.
struct DyingLink : Link {
  std::function<std::string(const std::string&)> ask;
  std::function<void(Time)> wait_for;
  ScriptClock& clock;
  Steps& steps;
  DyingLink(ScriptClock& c, Steps& s) : clock(c), steps(s) {}
  Result<std::size_t> exchange(std::string_view out, Time wait, std::string& in) override {
    if (steps.step()) return fail(Code::kLink, "dead");
    if (out.empty()) {
      clock.time += wait;
      wait_for(wait);
      return std::size_t{0};
    }
    clock.time += std::chrono::microseconds(500);
    std::string reply = ask(std::string(out));
    if (steps.step()) return fail(Code::kLink, "dead");
    in = std::move(reply);
    return out.size();
  }
};

/// The naive way to go on: the controller forgets the old session, a new one begins after `count` blocks.
inline Result<SendReport> send_rest(const ProgramRun& run, std::uint64_t count, Link& link, Clock& clock,
                                    const StreamHooks& hooks) {
  const auto ask = [&](const ModbusRequest& request) {
    std::string in;
    static_cast<void>(link.exchange(pack_request(request), Time{0}, in));
    return unpack_reply(in);
  };
  for (const MailboxCode code : {MailboxCode::kStop, MailboxCode::kClose}) {
    const ModbusReply status = ask({0, sim::kStatusAt, kStatusWords, {}});
    if (status.words.size() != kStatusWords) return fail(Code::kLink, "no status");
    const RingStatus ring = parse_ring_status(status.words, false);
    const auto seq = static_cast<std::uint16_t>(ring.command_ack + 1);
    ask({sim::kMailboxAt, 0, 0, encode_mailbox(ring.session, seq, code, 0, false)});
  }
  std::ifstream in(run.program);
  std::ofstream out(run.program + ".rest");
  std::uint64_t block = 0;
  for (std::string line; std::getline(in, line);)
    if (line[0] == 'G' && line.size() > 3 && line[1] != '2') {
      if (++block > count) out << line << "\n";
    } else if (block <= count || line == "M2") {
      out << line << "\n";
    }
  out.close();
  return send_over(run.program + ".rest", run.link, link, clock, {}, hooks);
}

enum class End : char { kDone = 'D', kKilled = 'K', kUncertain = 'U', kWrong = 'W' };

/// How one life of the sender ended, and what it told the operator.
struct Outcome {
  End end = End::kKilled;
  std::uint64_t executed = 0, may_have = 0;
  std::string text;
};

/// What the spool keeps beside the journal: the run was begun. Durable as soon as it is set.
struct BegunMark {
  bool begun = false;
  std::function<void()> set;
};

inline Outcome sender_life(ProgramRun run, JournalDisk disk, const BegunMark& mark, Link& link, Clock& clock,
                           Steps& steps, Bug bug) {
  if (bug == Bug::kNoJournal) disk = journal_disk(std::make_shared<SimulatedDisk>());
  auto journal = Journal::open(dying_disk(std::move(disk), steps, bug));
  if (!journal) return {steps.dead ? End::kKilled : End::kWrong, 0, 0, journal.error().message};
  const std::optional<RunRecord>& last = journal->content().last;
  if (last && bug == Bug::kOfferedForSure) run.subject.host = last->host;
  if (last && bug == Bug::kOldProgram) run.subject.program = last->program;
  ResumeDecision decision = decide_resume(journal->content(), run.subject);
  if (!mark.begun) {
    if (const auto begun = RunRecorder::begin(*journal, run.subject); !begun)
      return {steps.dead ? End::kKilled : End::kWrong, 0, 0, begun.error().message};
    mark.set();
    decision.way = ResumeWay::kFresh;
  }
  if (bug == Bug::kStartsAnew) decision.way = ResumeWay::kFresh;
  Outcome outcome{End::kDone, decision.executed, decision.may_have, decision.text};
  if (decision.way == ResumeWay::kFinished) return outcome;
  if (decision.way == ResumeWay::kUncertain) return outcome.end = End::kUncertain, outcome;
  Result<SendReport> report;
  SendState newest;
  StreamHooks hooks;
  hooks.progress = [&](const SendState& state) { return newest = state, true; };
  if (decision.way == ResumeWay::kContinue && bug == Bug::kFromExecuted)
    report = send_rest(run, last->executed, link, clock, hooks);
  else if (decision.way == ResumeWay::kContinue && bug == Bug::kFromAcknowledged)
    report = send_rest(run, last->acknowledged, link, clock, hooks);
  else if (decision.way == ResumeWay::kContinue && bug == Bug::kFromOffered)
    report = send_rest(run, last->offered, link, clock, hooks);
  else
    report = run_job(run, decision, *journal, link, clock, hooks);
  if (report) return outcome;
  outcome.text = report.error().message;
  outcome.end = steps.dead ? End::kKilled : End::kWrong;
  // The controller cannot tell any more: judged as left to the operator, with the journal's range.
  if (newest.loss == Loss::kRestarted || newest.loss == Loss::kForgotten || newest.phase == Phase::kAlarm)
    outcome.end = End::kUncertain;
  return outcome;
}

}  // namespace tiltfeed
