#include "daemon/machine/grbl_talk.h"

#include <algorithm>
#include <charconv>

#include "daemon/machine/talk_parts.h"
#include "daemon/protocol/session.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Time kAskAgain = milliseconds(50), kLook = milliseconds(500);
/// Boards reset when the port opens, and some start a network first.
constexpr Time kReportTime = seconds(10);
/// Offsets come with every tenth report of a machine that stands, with every thirtieth of one that moves.
constexpr int kOffsetReports = 40;

int code_of(std::string_view line) {
  const std::size_t colon = line.find(':');
  int code = 0;
  if (colon != line.npos) std::from_chars(line.data() + colon + 1, line.data() + line.size(), code);
  return code;
}

/// X Y Z and the rotaries: those that the machine has, or all that the profile's type can have.
std::string machine_letters(const MachineModel& machine, bool present) {
  std::string letters = "XYZ";
  for (const char letter : kAxisLetters.substr(3))
    for (const RotaryAxis* one : {&machine.tilt, &machine.rotary})
      if (letter == one->letter && (one->present || !present)) letters += letter;
  return letters;
}

}  // namespace

AxisValues report_axes(const std::vector<double>& values, const std::string& letters,
                       const MachineModel& machine) {
  std::string names = letters.size() == values.size() ? letters : machine_letters(machine, true);
  if (names.size() != values.size()) names = machine_letters(machine, false);
  if (names.size() != values.size() && values.size() == 3) names = "XYZ";
  AxisValues axes = no_axes();
  if (names.size() != values.size()) return axes;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (const std::size_t at = kAxisLetters.find(names[i]); at != kAxisLetters.npos) axes[at] = values[i];
  return axes;
}

GrblTalk::GrblTalk(Link& wire, Clock& clock, std::function<bool()> stopped)
    : wire_(wire), clock_(clock), stopped_(std::move(stopped)) {}

/// One exchange; whole lines go to lines_, printable.
Result<void> GrblTalk::turn(Time wait) {
  std::string in;
  const Result<std::size_t> taken = wire_.exchange(out_, std::max(wait, Time::zero()), in);
  if (!taken) return tl::unexpected<Error>(taken.error());
  out_.erase(0, *taken);
  for (const char c : in) {
    if (c == '\n') {
      if (lines_.size() < kMostReplies) lines_.push_back(std::move(line_));
      line_.clear();
    } else if (c != '\r' && line_.size() < kMaxReplyLine) {
      line_ += c >= ' ' && c <= '~' ? c : '?';
    }
  }
  return {};
}

void GrblTalk::take_note(const GrblStatus& status) {
  if (!status.offset.empty()) offset_ = status.offset;
  if (status.state.starts_with("Alarm:")) alarm_ = code_of(status.state);
}

/// The oldest report that has come, and what else came before it is noted or dropped.
Result<std::optional<GrblStatus>> GrblTalk::take_status() {
  while (!lines_.empty()) {
    const std::string line = std::move(lines_.front());
    lines_.pop_front();
    const GrblReplyKind kind = classify_reply(line);
    if (kind == GrblReplyKind::kAlarm) alarm_ = code_of(line);
    if (kind == GrblReplyKind::kBanner) settled_ = false;
    if (kind != GrblReplyKind::kStatus) continue;
    std::optional<GrblStatus> said = parse_status(line);
    if (!said) continue;
    take_note(*said);
    return said;
  }
  return std::nullopt;
}

Result<GrblStatus> GrblTalk::report() {
  return report_until([](const GrblStatus&) { return true; },
                      std::chrono::duration<double>(kReportTime).count());
}

Result<GrblStatus> GrblTalk::report_until(const std::function<bool(const GrblStatus&)>& wanted,
                                          double patience) {
  lines_.clear();  // reports from before
  std::string last;
  const Time limit = clock_.now() + time_of(patience);
  for (Time ask = clock_.now(); clock_.now() < limit;) {
    if (stopped()) return cancelled();
    if (clock_.now() >= ask) {
      if (out_.empty()) out_ = "?";
      ask = clock_.now() + kAskAgain;
    }
    if (const Result<void> turned = turn(ask - clock_.now()); !turned)
      return tl::unexpected<Error>(turned.error());
    for (auto said = take_status(); *said; said = take_status()) {
      if (wanted(**said)) return **said;
      last = (*said)->state;
    }
  }
  if (last.empty())
    return fail(Code::kLink,
                "no status report from the controller; check the power, the cable and the baud rate");
  return fail(Code::kLink, "the machine is still in state " + last + ": look at it");
}

Result<GrblStatus> GrblTalk::report_with_offset() {
  Result<GrblStatus> said = report();
  for (int i = 0; said && !said->in_work && offset_.empty() && i < kOffsetReports; ++i) said = report();
  return said;
}

Result<void> GrblTalk::urge(std::string_view bytes) {
  out_.insert(0, bytes);
  while (!out_.empty())
    if (const Result<void> turned = turn(kAskAgain); !turned) return turned;
  return {};
}

Result<void> GrblTalk::pause(double length) {
  const Time end = clock_.now() + time_of(length);
  while (clock_.now() < end)
    if (const Result<void> turned = turn(end - clock_.now()); !turned) return turned;
  return {};
}

/// Answers to what others asked come before the [VER:] of this `$I`. A line that somebody left half is spoilt
/// by it, and moves nothing: so it is asked twice.
Result<void> GrblTalk::settle() {
  if (settled_) return {};
  for (int tries = 0; tries < 2; ++tries) {
    const Result<GrblAnswer> who = answer("$I", 5.0, true);
    if (!who) return tl::unexpected<Error>(who.error());
    for (const std::string& line : who->said)
      if (std::string letters = parse_axis_letters(line); !letters.empty()) letters_ = std::move(letters);
    if (who->end == GrblEnd::kOk) return settled_ = true, Result<void>{};
  }
  return fail(Code::kLink, "the controller does not answer `$I`; `tiltfeed reset` leads out of every state");
}

Result<GrblAnswer> GrblTalk::ask(const std::string& line, double patience) {
  if (const Result<void> there = settle(); !there) return tl::unexpected<Error>(there.error());
  return answer(line, patience, false);
}

Result<GrblAnswer> GrblTalk::answer(const std::string& line, double patience, bool identity) {
  lines_.clear();
  out_ += line + "\n";
  GrblAnswer said;
  bool known = !identity;
  Time moved = clock_.now(), look = moved + kLook;
  while (clock_.now() - moved < time_of(patience)) {
    if (stopped()) return settled_ = false, cancelled();
    if (clock_.now() >= look) {
      if (out_.empty()) out_ = "?";
      look = clock_.now() + kLook;
    }
    if (const Result<void> turned = turn(std::min(look - clock_.now(), kAskAgain)); !turned)
      return tl::unexpected<Error>(turned.error());
    while (!lines_.empty()) {
      const std::string text = std::move(lines_.front());
      lines_.pop_front();
      const GrblReplyKind kind = classify_reply(text);
      if (kind == GrblReplyKind::kStatus) {
        const std::optional<GrblStatus> status = parse_status(text);
        if (status) take_note(*status);
        if (status && status->state != "Idle" && !status->state.starts_with("Alarm")) moved = clock_.now();
        continue;
      }
      if (identity && text.starts_with("[VER:")) known = true;
      if (kind == GrblReplyKind::kOk && known) return said;
      if (kind == GrblReplyKind::kError || kind == GrblReplyKind::kAlarm || kind == GrblReplyKind::kBanner) {
        said.end = kind == GrblReplyKind::kError   ? GrblEnd::kError
                   : kind == GrblReplyKind::kAlarm ? GrblEnd::kAlarm
                                                   : GrblEnd::kRestarted;
        said.code = code_of(text);
        if (kind == GrblReplyKind::kAlarm) alarm_ = said.code;
        if (kind != GrblReplyKind::kError) settled_ = false;  // an ok may still come
        return said;
      }
      if (!text.empty() && kind != GrblReplyKind::kOk) said.said.push_back(text);
    }
  }
  settled_ = false;
  return fail(Code::kLink, "no answer to '" + wire_text(line) + "'; the machine does not move: look at it");
}

}  // namespace tiltfeed::daemon
