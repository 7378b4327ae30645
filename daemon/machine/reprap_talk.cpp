#include "daemon/machine/reprap_talk.h"

#include <algorithm>
#include <utility>

#include "daemon/machine/talk_parts.h"
#include "daemon/protocol/grbl_words.h"
#include "daemon/protocol/reprap_session.h"
#include "daemon/protocol/session.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Time kTurn = milliseconds(20);
/// Boards reset when the port opens; a bootloader and an SD card take their time.
constexpr Time kOpenTime = seconds(15), kGreetAgain = seconds(2);
/// After a refusal its ok and those of what was still on its way come; they belong to nothing.
constexpr Time kQuiet = milliseconds(60);
/// Marlin says "busy" every two seconds while it works.
constexpr Time kSilence = seconds(6);
constexpr int kMostRepeats = 10, kMostPlaces = 3;

tl::unexpected<Error> halted(const std::string& line) {
  return fail(Code::kLink, "the firmware has halted: '" + line + "'" + marlin_meaning(line) +
                               "; home the machine before anything else");
}

/// Why the firmware does not do a line; empty: it does.
std::string refusal_of(const std::string& line, RepRapReplyKind kind) {
  const bool refused = kind == RepRapReplyKind::kHalted || line.find("Unknown command") != line.npos ||
                       line.find("Printer stopped") != line.npos;
  return refused ? "'" + line + "'" + marlin_meaning(line) : "";
}

}  // namespace

RepRapTalk::RepRapTalk(Link& wire, Clock& clock, std::function<bool()> stopped)
    : wire_(wire), clock_(clock), stopped_(std::move(stopped)) {}

Result<void> RepRapTalk::turn() {
  const Result<std::size_t> taken = wire_.exchange(out_, kTurn, in_);
  if (!taken) return tl::unexpected<Error>(taken.error());
  out_.erase(0, *taken);
  return {};
}

/// The oldest whole line, printable. False: there is none.
bool RepRapTalk::take_line(std::string& line) {
  for (std::size_t end = in_.find('\n'); end != in_.npos; end = in_.find('\n')) {
    std::string one = in_.substr(0, end);
    in_.erase(0, end + 1);
    while (one.ends_with('\r') || one.ends_with(' ')) one.pop_back();
    if (one.empty()) continue;
    line = wire_text(one.substr(0, kMaxReplyLine));
    return true;
  }
  if (in_.size() > kMaxReplyLine) in_.clear();
  return false;
}

Result<void> RepRapTalk::settle() {
  if (settled_) return {};
  firmware_.clear();
  std::string line, last;
  bool agreed = false;
  for (const Time began = clock_.now(); !agreed && clock_.now() - began < kOpenTime;) {
    // The empty line ends whatever fragment is left in the firmware.
    out_ += "\n" + reprap_frame(0, "M110N0") + "\n";
    for (const Time asked = clock_.now(); !agreed && clock_.now() - asked < kGreetAgain;) {
      if (stopped()) return cancelled();
      if (const Result<void> turned = turn(); !turned) return turned;
      while (!agreed && take_line(line)) {
        const RepRapReplyKind kind = parse_reprap_reply(line).kind;
        if (line.find("halted") != line.npos) return halted(line);
        restarted_ = restarted_ || kind == RepRapReplyKind::kStart;
        agreed = kind == RepRapReplyKind::kOk;
        last = line;
      }
    }
  }
  if (!agreed && parse_reprap_reply(last).kind == RepRapReplyKind::kBusy)
    return fail(Code::kLink,
                "the firmware is still at work ('" + last + "'): ask again when the machine stands");
  if (!agreed)
    return fail(Code::kLink,
                last.empty()
                    ? "no answer within 15 s; check the power, the cable and the baud rate. "
                      "A firmware that has halted answers nothing until its reset button"
                    : "what answers does not speak RepRap (last heard: '" + last + "'); check the baud rate");
  number_ = 1;
  const Result<RepRapAnswer> who = exchange("M115", 10.0, false);
  if (!who) return tl::unexpected<Error>(who.error());
  settled_ = true;
  return {};
}

Result<RepRapAnswer> RepRapTalk::ask(const std::string& line, double patience) {
  if (const Result<void> there = settle(); !there) return tl::unexpected<Error>(there.error());
  return exchange(line, patience, false);
}

Result<RepRapAnswer> RepRapTalk::obey(const std::string& line, double patience) {
  Result<RepRapAnswer> answer = ask(line, patience);
  if (answer && !answer->refusal.empty())
    return fail(Code::kLink, "the firmware answers to '" + wire_text(line) + "': " + answer->refusal);
  return answer;
}

/// `quick`: to be asked once only, and not to be waited for longer than `patience` even if it is busy.
Result<RepRapAnswer> RepRapTalk::exchange(const std::string& text, double patience, bool quick) {
  const std::uint64_t number = number_++;
  const std::string frame = reprap_frame(number, text) + "\n";
  const bool identity = text == "M115" && firmware_.empty();
  out_ += frame;
  RepRapAnswer answer;
  Time heard = clock_.now(), sent = heard;
  Time again{};  // a refused line goes out then
  bool refused = false;
  for (int repeats = 0;;) {
    if (stopped()) return cancelled();
    if (const Result<void> turned = turn(); !turned) return tl::unexpected<Error>(turned.error());
    const Time now = clock_.now();
    for (std::string line; take_line(line);) {
      const RepRapReply reply = parse_reprap_reply(line);
      if (!quick) heard = now;
      if (reply.kind == RepRapReplyKind::kStart) {
        settled_ = false;
        return fail(Code::kLink, "the firmware has restarted; home the machine before anything else");
      }
      if (line.find("halted") != line.npos || line.starts_with("!!")) return settled_ = false, halted(line);
      if (reply.kind == RepRapReplyKind::kBusy && reply.paused && !quick)
        return fail(Code::kLink, "the firmware waits for its operator (M0): answer it at the machine");
      if (reply.kind == RepRapReplyKind::kResend && reply.line) {
        if (*reply.line == number + 1) return answer;  // it has the line; its ok was lost
        if (*reply.line == number && !refused) refused = true, again = now + kQuiet, ++repeats;
        continue;
      }
      if (refused || reply.kind == RepRapReplyKind::kError || reply.kind == RepRapReplyKind::kBusy) continue;
      if (line.starts_with("FIRMWARE_NAME:")) firmware_ = line.substr(14, line.find(" SOURCE_CODE") - 14);
      if (line == "Cap:EMERGENCY_PARSER:1") emergency_ = true;
      if (reply.kind == RepRapReplyKind::kOk) {
        const bool ours = reply.line ? *reply.line == number : !identity || !firmware_.empty();
        if (ours) return answer;
        continue;
      }
      if (answer.refusal.empty()) answer.refusal = refusal_of(line, reply.kind);
      if (answer.said.size() < kMostReplies) answer.said.push_back(line);
    }
    if (refused && now >= again) {
      out_ += frame;
      refused = false;
      sent = heard = now;
    } else if (!quick && !refused && now - std::max(heard, sent) >= kSilence) {
      out_ += frame;  // a firmware that has it asks for the next
      sent = now;
    }
    if (repeats > kMostRepeats || now - heard >= time_of(patience)) {
      settled_ = false;
      if (!answer.refusal.empty()) return halted(answer.refusal);
      return fail(Code::kLink, "no answer to '" + wire_text(text) +
                                   "': look at the machine. A firmware that has halted answers nothing until "
                                   "its reset button");
    }
  }
}

Result<bool> RepRapTalk::stands_within(double seconds) {
  if (const Result<void> there = settle(); !there) return tl::unexpected<Error>(there.error());
  const Time began = clock_.now();
  const Result<RepRapAnswer> done = exchange("M400", seconds, true);
  if (done) return true;
  if (done.error().code == Code::kLink && clock_.now() - began >= time_of(seconds)) return false;
  return tl::unexpected<Error>(done.error());
}

Result<AxisValues> RepRapTalk::place() {
  if (const Result<RepRapAnswer> stood = obey("M400"); !stood) return tl::unexpected<Error>(stood.error());
  for (int tries = 0; tries < kMostPlaces; ++tries) {
    const Result<RepRapAnswer> said = obey("M114");
    if (!said) return tl::unexpected<Error>(said.error());
    for (const std::string& line : said->said)
      if (const auto at = parse_reprap_place(line)) return *at;
  }
  return fail(Code::kLink, "the firmware does not tell where its axes are (M114)");
}

Result<AxisValues> RepRapTalk::quick_stop() {
  const std::function<bool()> before = std::exchange(stopped_, {});
  if (emergency_) {
    out_ += "M410\n";
    settled_ = false;  // what waited may be answered, or not
  }
  Result<AxisValues> at = place();
  stopped_ = before;
  return at;
}

}  // namespace tiltfeed::daemon
