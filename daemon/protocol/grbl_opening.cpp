// The opening of a Grbl session: who is there, is it idle, how large is its receive buffer?

#include <algorithm>
#include <utility>

#include "daemon/protocol/grbl_session.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Boards reset when the port opens and some start a network first: none measured takes longer.
constexpr Time kOpenTimeout = seconds(10);
/// An [OPT:] that belongs to an ok comes with it; after this pause it will not come any more.
constexpr Time kPlainOkSettle = milliseconds(250);
/// Grbl 1.1h; usable is one byte less everywhere, since a ring buffer keeps one slot free.
constexpr int kDefaultReceiveBuffer = 128;
/// Anything outside is not a receive buffer size but a damaged line.
constexpr int kMinReceiveBuffer = 16, kMaxReceiveBuffer = 1 << 20;
/// Line buffers: Grbl 1.1h has 80 bytes with the terminating zero, grblHAL and FluidNC 256.
constexpr std::size_t kShortLine = 79, kLongLine = 255;
/// N words of the Grbl family end at 10,000,000; with 'N' that is eight bytes more a line.
constexpr std::uint64_t kMostNumbered = 9'999'999;
constexpr std::size_t kNumberBytes = 8;

}  // namespace

bool GrblSession::ready() const { return status_seen_ && status_.state == "Idle"; }

void GrblSession::start_probe() {
  write("$I\n");
  probe_ = Probe::kAsked;
  identity_seen_ = false;
  plain_ok_.reset();
}

void GrblSession::end_probe() {
  probe_ = Probe::kAnswered;
  if (ready()) begin_streaming();
}

/// Only what proves itself counts here: old replies may still be on the line.
void GrblSession::on_opening_line(GrblReplyKind kind, std::string_view line) {
  last_heard_ = wire_text(line);
  switch (kind) {
    case GrblReplyKind::kBanner:
      long_lines_ = line.starts_with("GrblHAL") || line.find("FluidNC") != line.npos;
      numbers_lines_ =
          options_.number_lines && line.starts_with("GrblHAL") && options_.total <= kMostNumbered;
      probe_ = Probe::kNone;  // whatever was asked before the start is gone
      status_seen_ = false;
      next_poll_ = now_;
      break;
    case GrblReplyKind::kStatus:
      on_status(line);
      if (phase_ == Phase::kConnect) move(Event::kAnswered);
      if (ready() && probe_ == Probe::kNone) start_probe();
      if (ready() && probe_ == Probe::kAnswered) begin_streaming();
      break;
    case GrblReplyKind::kFeedback:
      if (probe_ != Probe::kAsked) break;
      if (line.find("grblHAL") != line.npos || line.find("FluidNC") != line.npos) long_lines_ = true;
      if (line.find("grblHAL") != line.npos && options_.number_lines && options_.total <= kMostNumbered)
        numbers_lines_ = true;
      if (std::string letters = parse_axis_letters(line); !letters.empty())
        axis_letters_ = std::move(letters);
      if (const auto buffers = parse_buffers(line)) {
        buffers_ = *buffers;
        identity_seen_ = true;
      }
      break;
    case GrblReplyKind::kOk:
      if (probe_ != Probe::kAsked) break;
      if (identity_seen_)
        end_probe();
      else
        plain_ok_ = now_;
      break;
    case GrblReplyKind::kError:
      if (probe_ != Probe::kAsked) break;
      if (probe_refused_) return end_probe();
      probe_refused_ = true;  // a fragment that somebody left behind spoils one line only: ask once more
      start_probe();
      break;
    case GrblReplyKind::kAlarm:
    case GrblReplyKind::kGarbled:
      break;
  }
}

/// Errors: kLimit when the program has a line that this controller cannot take.
Result<void> GrblSession::check_buffers() {
  int receive = buffers_.receive > 0 ? buffers_.receive : largest_receive_free_;
  if (receive < kMinReceiveBuffer || receive > kMaxReceiveBuffer) receive = kDefaultReceiveBuffer;
  window_ = static_cast<std::size_t>(receive - 1);
  if (options_.receive_buffer > 0) window_ = static_cast<std::size_t>(options_.receive_buffer);
  std::size_t limit = long_lines_ ? kLongLine : kShortLine;
  if (options_.max_line > 0) limit = static_cast<std::size_t>(options_.max_line);
  limit = std::min(limit, window_ - 1);
  if (numbers_lines_ && options_.longest + kNumberBytes > limit) numbers_lines_ = false;
  if (options_.longest <= limit) return {};
  return fail(Code::kLimit, "line " + std::to_string(options_.longest_line) + " has " +
                                std::to_string(options_.longest) + " bytes, this controller takes " +
                                std::to_string(limit) +
                                "; nothing was sent: post the program with shorter lines");
}

void GrblSession::begin_streaming() {
  if (const Result<void> fits = check_buffers(); !fits)
    return fault(fits.error().code, fits.error().message, false);
  last_report_ = last_progress_ = now_;
  if (options_.check && !checked_) {
    move(Event::kCheckBegins);
    put({0, "$C"}, Kind::kCheckOn);
  } else {
    move(Event::kReady);
    watch_.begin(place().value_or(no_axes()));
  }
}

/// A controller that takes $C and goes on as before would cut the program as it is read.
void GrblSession::follow_check() {
  const bool asked = !in_flight_.empty() && in_flight_.front().kind == Kind::kCheckOn;
  if (checked_ || asked) return;
  if (status_.state.starts_with("Check")) {
    check_proved_ = true;
    return;
  }
  if (!check_proved_)
    return fault(Code::kLink,
                 "the controller answers $C and is in state " + status_.state +
                     ", not in check mode: leave out wire.check",
                 false);
  left_check_ = true;
  std::uint64_t sent = options_.before + acknowledged_;
  std::uint64_t last = last_checked_;
  for (const Flight& flight : in_flight_)
    if (flight.kind == Kind::kLine && reached_wire(flight)) ++sent, last = flight.line.number;
  stood_ = {options_.before, sent, {first_checked_, last}};
  fault(Code::kLink,
        "the controller has left check mode while it read the program (state " + status_.state +
            "), so the rest of it has moved the machine",
        true);
}

/// The banner after check mode: the same controller, so only its state is asked for again.
void GrblSession::restart_after_check() {
  move(Event::kChecked);
  in_flight_.clear();
  in_flight_bytes_ = 0;
  recent_.clear();
  acknowledged_ = 0;
  ended_ = false;
  rewind_ = true;
  probe_ = Probe::kNone;
  status_seen_ = false;
  opened_ = next_poll_ = now_;
}

bool GrblSession::wants_rewind() { return std::exchange(rewind_, false); }

void GrblSession::check_opening_time() {
  if (plain_ok_ && now_ - *plain_ok_ >= kPlainOkSettle) {
    plain_ok_.reset();
    return end_probe();
  }
  if (now_ - opened_ < kOpenTimeout) return;
  if (status_seen_ && !ready())
    return fault(Code::kLink,
                 "the machine is not idle but in state " + status_.state +
                     (status_.state == "Check" ? " (it reads and does not move)" : "") +
                     "; nothing was sent: `tiltfeed reset` leads out of every state",
                 false);
  if (last_heard_.empty())
    return fault(Code::kLink, "no answer within 10 s; check the power, the cable and the baud rate", false);
  fault(Code::kLink,
        "what answers does not speak Grbl (last heard: '" + last_heard_ + "'); check the baud rate", false);
}

Time GrblSession::deadline() const {
  if (plain_ok_) return std::min(next_poll_, *plain_ok_ + kPlainOkSettle);
  return next_poll_;
}

}  // namespace tiltfeed::daemon
