#include "daemon/machine/stop_machine.h"

#include <cassert>

#include "daemon/protocol/grbl_reply.h"
#include "daemon/protocol/reprap_session.h"
#include "daemon/protocol/session.h"
#include "daemon/wire/modbus_map.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Real-time bytes may be lost like any other, so each is repeated so often.
constexpr Time kRepeat = milliseconds(200);
/// From feed hold to standstill: longer than any axis needs to brake.
constexpr Time kStandTime = seconds(10);
/// From reset to banner.
constexpr Time kResetTime = seconds(3);
static_assert(kStandTime + kResetTime < kSafeStopLimit);

/// Feed hold; when the axes stand a reset, which at a stand keeps the position, forgets the lines that are
/// still in the controller, and turns spindle and coolant off.
class GrblStop {
 public:
  GrblStop(Link& wire, Clock& clock) : wire_(wire), clock_(clock), asked_(clock.now()) {}

  Result<std::string> run() {
    const Time began = clock_.now();
    while (clock_.now() - began < kStandTime && !(stands_ && clock_.now() - began >= kRepeat))
      if (const Result<void> turned = turn("!?"); !turned) return tl::unexpected<Error>(turned.error());
    const Time reset = clock_.now();
    banner_ = false;  // one that came before the reset is that of opening the wire
    asked_ = reset - kRepeat;
    while (clock_.now() - reset < kResetTime && !banner_)
      if (const Result<void> turned = turn("\x18"); !turned) return tl::unexpected<Error>(turned.error());
    return verdict();
  }

 private:
  Result<void> turn(const char* bytes) {
    const Time now = clock_.now();
    if (now >= asked_) {
      out_ = bytes;
      asked_ = now + kRepeat;
    }
    std::string in;
    const Result<std::size_t> taken = wire_.exchange(out_, asked_ - now, in);
    if (!taken) return tl::unexpected<Error>(taken.error());
    out_.erase(0, *taken);
    for (const char c : in) {
      if (c == '\n')
        on_line(), line_.clear();
      else if (line_.size() < kMaxReplyLine)
        line_ += c;
    }
    return {};
  }

  void on_line() {
    if (line_.ends_with('\r')) line_.pop_back();
    const GrblReplyKind kind = classify_reply(line_);
    banner_ = banner_ || kind == GrblReplyKind::kBanner;
    alarm_ = alarm_ || kind == GrblReplyKind::kAlarm;
    if (kind != GrblReplyKind::kStatus) return;
    const std::optional<GrblStatus> status = parse_status(line_);
    if (!status) return;
    seen_ = status->state;
    const bool alarm = seen_.starts_with("Alarm");  // the axes stand, the position is lost
    alarm_ = alarm_ || alarm;
    stands_ = alarm || is_standing(seen_);
  }

  Result<std::string> verdict() const {
    if (!banner_)
      return fail(Code::kLink, "feed hold and reset were sent, and the controller has not answered" +
                                   (seen_.empty() ? "" : " the reset (last state: " + seen_ + ")") +
                                   ": look at the machine, stop it there if it moves or its spindle turns");
    if (!stands_ || alarm_)
      return fail(Code::kLink,
                  "the controller was reset, spindle and coolant are off, but the machine " +
                      std::string(alarm_ ? "is in alarm" : "was not seen to stand (" + seen_ + ")") +
                      ": its position is not to be trusted, home it before anything else");
    return "held, then reset at a stand: spindle and coolant are off, the position is kept, what was in the "
           "controller is forgotten";
  }

  Link& wire_;
  Clock& clock_;
  std::string out_, line_, seen_;
  Time asked_;
  bool stands_ = false, banner_ = false, alarm_ = false;
};

/// There is no hold, and M410 would drop the planned moves but not those still queued as text, which would
/// then be cut from the wrong place. So what the firmware has runs to its end, and M5 and M9 come after it.
Result<std::string> stop_reprap(Link& wire, Clock& clock) {
  RepRapSession session({2, 1}, clock.now());
  int pushed = 0;
  const Time began = clock.now();
  while (!is_final(session.phase()) && clock.now() - began < kSafeStopLimit) {
    for (; pushed < 2 && session.wants_work(); ++pushed) session.push({0, pushed == 0 ? "M5" : "M9"});
    if (pushed == 2) session.end_of_program();
    const Time now = clock.now();
    std::string in;
    const Result<std::size_t> taken =
        wire.exchange(session.output(now), std::min(session.deadline() - now, kRepeat), in);
    if (!taken) return tl::unexpected<Error>(taken.error());
    session.sent(*taken);
    session.receive(in, clock.now());
  }
  if (session.phase() == Phase::kDone)
    return "the lines that the firmware had have run, then spindle and coolant were turned off (this "
           "firmware has no hold)";
  std::string in;  // behind whatever the firmware still has, and whatever it says
  static_cast<void>(wire.exchange("\nM5\nM9\n", kRepeat, in));
  return fail(Code::kLink,
              "M5 and M9 were sent, and the firmware has not said that it took them" +
                  (is_final(session.phase()) ? " (" + session.error().message + ")" : std::string()) +
                  ": look at the machine, stop it there if it moves or its spindle turns");
}

/// The stop value until it is answered, then the status until the drive stands: both may be repeated.
Result<std::string> stop_drive(const config::DriveMap& map, Link& wire, Clock& clock) {
  const std::string stop = pack_request({map.stop, 0, 0, {static_cast<std::uint16_t>(map.stop_value)}});
  const std::string look = pack_request({0, map.status, 1, {}});
  bool told = false;
  for (const Time began = clock.now(); clock.now() - began < kStandTime;) {
    std::string in;
    const Result<std::size_t> taken = wire.exchange(told ? look : stop, Time::zero(), in);
    if (!taken) return tl::unexpected<Error>(taken.error());
    const ModbusReply reply = unpack_reply(in);
    if (told && reply.outcome == kReplyOk && reply.words.size() == 1 &&
        (reply.words.front() & map.moving_mask) != map.moving_value)
      return "the drive was told to stop, and stands (spindle and coolant are not its own)";
    told = told || reply.outcome == kReplyOk;
    in.clear();
    static_cast<void>(wire.exchange({}, reply.outcome == kReplyOk ? time_of(map.settle) : kRepeat, in));
  }
  return fail(Code::kLink, std::string("the drive ") +
                               (told ? "was told to stop, and does not say that it stands"
                                     : "does not answer to its stop value") +
                               ": look at the machine, stop it there if it moves");
}

}  // namespace

Result<std::string> stop_machine(const LinkSpec& link, Link& wire, Clock& clock) {
  assert(is_drive(link.kind) || link.kind == LinkKind::kGrbl || link.kind == LinkKind::kRepRap);
  if (is_drive(link.kind)) return stop_drive(link.profile.drive, wire, clock);
  return link.kind == LinkKind::kGrbl ? GrblStop(wire, clock).run() : stop_reprap(wire, clock);
}

}  // namespace tiltfeed::daemon
