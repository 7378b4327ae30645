#include "daemon/command/send_command.h"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "config/machine_profile.h"
#include "daemon/command/command.h"
#include "daemon/command/patient_writer.h"
#include "daemon/command/send_tool.h"
#include "daemon/service/state_lock.h"
#include "daemon/stream/stream.h"
#include "daemon/wire/open_link.h"
#include "daemon/wire/steady_clock.h"

namespace tiltfeed::daemon {

namespace {

std::atomic<bool> end_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");
extern "C" void end_send(int) { end_asked = true; }

/// A signal that would end the process ends the run in order instead; one that the caller has switched off
/// (nohup) stays so. Ctrl-Z must not leave a machine without its sender.
void watch_signals() {
  struct sigaction action {};
  action.sa_handler = end_send;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    struct sigaction before {};
    if (::sigaction(signal, nullptr, &before) == 0 && signal == SIGHUP && before.sa_handler == SIG_IGN)
      continue;
    ::sigaction(signal, &action, nullptr);
  }
  for (const int signal : {SIGTSTP, SIGTTIN, SIGTTOU}) std::signal(signal, SIG_IGN);
}

/// The operator's keys, where standard input is a terminal that this process has.
class Keys {
 public:
  Keys() {
    if (isatty(STDIN_FILENO) != 1 || isatty(STDERR_FILENO) != 1 || !in_front()) return;
    if (::tcgetattr(STDIN_FILENO, &before_) != 0) return;
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    active_ = ::tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
  }
  ~Keys() {
    if (active_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  bool active() const { return active_; }
  /// What was typed since, as orders. False when the terminal has gone.
  bool take(CommandQueue& orders, const SendState& state) {
    while (active_ && in_front()) {
      pollfd typed{STDIN_FILENO, POLLIN, 0};
      if (::poll(&typed, 1, 0) <= 0) return true;
      char key = 0;
      if ((typed.revents & POLLIN) == 0 || ::read(STDIN_FILENO, &key, 1) != 1) return false;
      press(key, orders, state);
    }
    return true;
  }

 private:
  static bool in_front() { return ::tcgetpgrp(STDIN_FILENO) == ::getpgrp(); }

  void press(char key, CommandQueue& orders, const SendState& state) {
    const auto change = [&](Order order, int& percent, int by) {
      percent = std::clamp(by == 0 ? 100 : percent + by, 10, 200);
      orders.push({order, percent});
    };
    if (feed_ == 0) feed_ = state.feed_override > 0 ? state.feed_override : 100;
    if (spindle_ == 0) spindle_ = state.spindle_override > 0 ? state.spindle_override : 100;
    switch (key) {
      case 'h':
      case '!':
        return orders.push({Order::kHold});
      case 'r':
      case '~':
        return orders.push({Order::kResume});
      case 'q':
        return orders.push({Order::kStop});
      case '+':
      case '-':
        return change(Order::kFeedOverride, feed_, key == '+' ? 10 : -10);
      case '0':
        return change(Order::kFeedOverride, feed_, 0);
      case '>':
      case '<':
        return change(Order::kSpindleOverride, spindle_, key == '>' ? 10 : -10);
      case '1':
      case '2':
      case '3':
        return orders.push({Order::kRapidOverride, key == '1' ? 25 : key == '2' ? 50 : 100});
      default:
        return;
    }
  }

  termios before_{};
  bool active_ = false;
  int feed_ = 0, spindle_ = 0;  // percent, as asked for last; 0: not yet
};

/// On a terminal one line, rewritten; elsewhere a line a phase, and one every few seconds.
class StatusLine {
 public:
  /// Waits for nobody. False when it cannot be written any more.
  bool show(const SendState& state) {
    if (out_.failed()) return false;
    const auto now = std::chrono::steady_clock::now();
    const bool fresh = shown_ != phase_name(state.phase);
    if (!open_ || (!fresh && now - at_ < (terminal_ ? kRedraw : kHeartbeat))) return true;
    shown_ = phase_name(state.phase);
    at_ = now;
    const double share =
        state.total > 0 ? static_cast<double>(state.acknowledged) / static_cast<double>(state.total) : 0.0;
    if (!terminal_) {
      out_.write("send: " + shown_ + " " + std::to_string(std::lround(share * 100.0)) + " %\n", false);
      return true;
    }
    std::string text = "send: " + shown_ + ", " + std::to_string(state.acknowledged) + " of " +
                       std::to_string(state.total) + " blocks taken, " + std::to_string(state.executed) +
                       " executed";
    if (!state.machine.empty()) text += ", machine " + state.machine;
    if (state.feed_override > 0) text += ", feed " + std::to_string(state.feed_override) + " %";
    if (!state.held.empty()) text += ", " + state.held;
    if (!state.refused.empty()) text += " (" + state.refused + ")";
    out_.write("\r\033[K" + text, true);
    return true;
  }
  void say(const std::string& text) {
    if (terminal_) out_.write(text + "\n", false);
  }
  ~StatusLine() {
    if (terminal_ && !shown_.empty()) out_.write("\r\033[K", false);
  }

 private:
  static constexpr std::chrono::milliseconds kRedraw{100}, kHeartbeat{2000};
  const bool open_ = ::fcntl(STDERR_FILENO, F_GETFD) >= 0;  // it may have been closed from the start
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  PatientWriter out_{STDERR_FILENO};
  std::string shown_;
  std::chrono::steady_clock::time_point at_;
};

/// One run, watched: `send` sends.
template <class Send>
auto watched(Send send) {
  CommandQueue orders;
  Keys keys;
  StatusLine line;
  if (keys.active())
    line.say("keys: h hold, r resume, q stop; feed + - 0; spindle > <; rapids 1 2 3 (25, 50, 100 %)");
  StreamHooks hooks;
  hooks.commands = &orders;
  hooks.progress = [&](const SendState& state) {
    const bool typed = keys.take(orders, state), told = line.show(state);
    return typed && told && !end_asked;
  };
  return send(hooks);
}

/// What stands between two runs of one program must not have been changed.
Result<void> same_program(const std::string& program, const LinkSpec& link, const SendReport& before) {
  const Result<ProgramSum> now = sum_program(program, link.kind, link.axes);
  if (!now) return tl::unexpected<Error>(now.error());
  if (now->hash != before.program) return fail(Code::kIo, program + ": was changed while it ran");
  return {};
}

struct Sent {
  SendReport report;
  std::uint64_t by_hand = 0;  ///< tool changes among its blocks, which no controller was given
};

/// From one tool change to the next.
Result<Sent> send_all(const std::string& program, const LinkSpec& link,
                      const config::MachineProfile& machine) {
  SendOptions options;
  Result<SendReport> report =
      watched([&](const StreamHooks& hooks) { return send_program(program, link, options, hooks); });
  if (!report) return tl::unexpected<Error>(report.error());
  if (!report->change) return Sent{std::move(*report)};
  std::uint64_t by_hand = 0;
  const Result<std::vector<ToolChange>> changes = kept_changes(program, link);
  if (!changes) return tl::unexpected<Error>(changes.error());
  const Result<std::unique_ptr<Link>> wire = open_link(link);
  if (!wire) return tl::unexpected<Error>(wire.error());
  SteadyClock clock;
  while (report->change) {
    const ToolChange change = *report->change;
    if (const auto same = same_program(program, link, *report); !same) return tl::unexpected(same.error());
    // The keys are the run's, the lines the operator's.
    if (const auto made = change_in_program(
            program, change, machine, link, **wire, clock, [] { return end_asked.load(); }, std::cin,
            std::cerr);
        !made)
      return tl::unexpected<Error>(made.error());
    const SendReport before = *report;
    options.program = before.program;
    options.span = span_at(*changes, before.blocks, change.block);
    report = watched(
        [&](const StreamHooks& hooks) { return send_over(program, link, **wire, clock, options, hooks); });
    if (!report) return tl::unexpected<Error>(report.error());
    ++by_hand;
    report->seconds += before.seconds;
    report->bytes += before.bytes;
    report->resends += before.resends;
  }
  return Sent{std::move(*report), by_hand};
}

/// The same with the machine claimed, which is free again when this returns: last words may be waited for.
Result<Sent> send_claimed(const std::string& program, const LinkSpec& link,
                          const config::MachineProfile& machine) {
  MachineClaim claim;  // a serial port is locked by opening it; an address is not
  if (link.over_network())
    if (const Result<void> mine = claim.follow(link); !mine) return tl::unexpected<Error>(mine.error());
  return send_all(program, link, machine);
}

}  // namespace

int send_command(const std::string& program, std::string link_text, const std::string& machine,
                 bool as_json) {
  watch_signals();
  config::MachineProfile profile;
  if (!machine.empty()) {
    auto loaded = config::load_machine(machine);
    if (!loaded) return complain(loaded.error());
    profile = std::move(*loaded);
  }
  if (link_text.empty()) link_text = profile.link;
  if (link_text.empty())
    return complain(
        {Code::kUsage, "no link: give --link, or --machine with a profile that has link.default"});
  const auto link = parse_link(link_text, profile.wire, machine.empty() ? nullptr : &profile.model);
  if (!link) return complain(link.error());
  const auto sent = send_claimed(program, *link, profile);
  if (!sent) return complain(sent.error());
  const SendReport& report = sent->report;
  const std::uint64_t blocks = report.lines - sent->by_hand;
  if (as_json) {
    nlohmann::ordered_json json = {{"blocks", blocks},
                                   {"executed", nullptr},  // where the link proves none
                                   {"seconds", report.seconds},
                                   {"bytes", report.bytes},
                                   {"resends", report.resends}};
    if (report.executed) json["executed"] = *report.executed - sent->by_hand;
    if (sent->by_hand > 0) json["tool_changes"] = sent->by_hand;
    return show_json(json.dump());
  }
  std::printf("%llu blocks %s", static_cast<unsigned long long>(blocks),
              report.executed ? "sent and executed" : "sent");
  if (sent->by_hand > 0)
    std::printf(", %llu tool change%s made by hand", static_cast<unsigned long long>(sent->by_hand),
                sent->by_hand == 1 ? "" : "s");
  std::printf(" in %.2f s, %llu bytes, %llu resends\n", report.seconds,
              static_cast<unsigned long long>(report.bytes), static_cast<unsigned long long>(report.resends));
  return kExitDone;
}

}  // namespace tiltfeed::daemon
