// The order that leads out of every state of a controller.

#include <algorithm>

#include "daemon/machine/grbl_talk.h"
#include "daemon/machine/machine_place.h"
#include "daemon/machine/stop_machine.h"
#include "daemon/wire/modbus_map.h"

namespace tiltfeed {

namespace {

using std::chrono::milliseconds;

constexpr Time kLook = milliseconds(50);
constexpr double kUnlockTime = 5.0;  // s
constexpr int kMostTries = 100;

/// After the reset: the state of the next reports, and $X where that is an alarm.
Result<std::string> unlock_grbl(Link& wire, Clock& clock, const std::string& done) {
  GrblTalk talk(wire, clock);
  const auto settled = [](const GrblStatus& said) {
    return said.state == "Idle" || said.state.starts_with("Alarm");
  };
  Result<GrblStatus> said = talk.report_until(settled, kUnlockTime);
  if (said && said->state == "Idle") return done;
  if (said) {
    if (const Result<void> sent = talk.urge("$X\n"); !sent) return tl::unexpected<Error>(sent.error());
    said = talk.report_until([](const GrblStatus& now) { return now.state == "Idle"; }, kUnlockTime);
  }
  if (said) return "reset and unlocked: its position is not to be trusted, home it before anything else";
  return fail(Code::kLink, "the controller was reset and does not say that it is idle: look at the machine");
}

Result<std::string> reset_grbl(const LinkSpec& link, Link& wire, Clock& clock) {
  const Result<std::string> stopped = stop_machine(link, wire, clock);
  // An alarm is told as an error of the stop, and is what is to be left here.
  return unlock_grbl(wire, clock, stopped ? *stopped : "reset");
}

/// One mailbox command at a time, each with the number after the newest that was acknowledged.
class RingReset {
 public:
  RingReset(const RingMap& map, Link& wire) : map_(map), wire_(wire) {}

  Result<std::string> run() {
    if (const Result<void> looked = look(); !looked) return tl::unexpected<Error>(looked.error());
    if (status_.state == RingState::kNoSession) return "the controller has no session and stands idle";
    const std::uint16_t session = status_.session;
    const bool alarm = status_.state == RingState::kAlarm;
    bool obeyed = true;
    if (alarm) obeyed = tell(MailboxCode::kClearAlarm);
    if (status_.state == RingState::kRunning) obeyed = tell(MailboxCode::kHold) && stands();
    obeyed = obeyed && (status_.session == 0 || (tell(MailboxCode::kStop) && tell(MailboxCode::kClose)));
    if (obeyed)
      return "session " + std::to_string(session) + " is closed, its ring is empty, the position is kept" +
             (alarm ? "; the alarm is cleared" : "");
    if (!tell(MailboxCode::kReset))
      return fail(Code::kLink, "the controller obeys neither 'stop' nor 'reset' (state " +
                                   std::string(ring_state_name(status_.state)) +
                                   "): look at the machine, stop it there");
    return "the controller was reset: home the machine before anything else";
  }

 private:
  Result<std::optional<std::vector<std::uint16_t>>> exchange(const ModbusRequest& request) {
    std::string in;
    const Result<std::size_t> taken = wire_.exchange(pack_request(request), Time::zero(), in);
    if (!taken) return tl::unexpected<Error>(taken.error());
    const ModbusReply reply = unpack_reply(in);
    if (reply.outcome == kReplyOk && reply.words.size() == request.read_count) return reply.words;
    in.clear();
    static_cast<void>(wire_.exchange({}, kLook, in));
    return std::nullopt;
  }

  /// Errors: kLink where no status comes.
  Result<void> look() {
    for (int tries = 0; tries < kMostTries; ++tries) {
      const auto words = exchange({0, map_.status, kStatusWords, {}});
      if (!words) return tl::unexpected<Error>(words.error());
      if (!*words) continue;
      status_ = parse_ring_status(**words, map_.low_word_first);
      if (!status_.torn) return {};
    }
    return fail(Code::kLink, "no usable status from the controller; check the cable and the unit number");
  }

  /// Repeated until its number comes back. False where it was refused or never was acknowledged.
  bool tell(MailboxCode code) {
    const auto seq = static_cast<std::uint16_t>(status_.command_ack + 1);
    const auto words = encode_mailbox(status_.session, seq, code, 0, map_.low_word_first);
    for (int tries = 0; tries < kMostTries; ++tries) {
      if (!exchange({map_.mailbox, 0, 0, words}) || !look()) return false;
      if (status_.command_ack == seq) return status_.command_result == 0;
      std::string in;
      static_cast<void>(wire_.exchange({}, kLook, in));
    }
    return false;
  }

  bool stands() {
    for (int tries = 0; tries < kMostTries; ++tries) {
      if (!look()) return false;
      if (status_.state != RingState::kRunning) return true;
      std::string in;
      static_cast<void>(wire_.exchange({}, kLook, in));
    }
    return false;
  }

  const RingMap& map_;
  Link& wire_;
  RingStatus status_;
};

}  // namespace

std::string reset_preview(const LinkSpec& link) {
  const std::string what = "What is on the machine is given up; nothing goes on with it afterwards.\n";
  switch (link.kind) {
    case LinkKind::kGrbl:
      return "1. feed hold, until the axes stand\n2. reset: buffers emptied, spindle and coolant off, check "
             "mode left; the position is kept\n3. where it is in alarm: unlocked ($X); then home it before "
             "anything else\n" +
             what;
    case LinkKind::kModbusTcp:
    case LinkKind::kModbusRtu:
      return "1. an alarm is cleared; a machine that runs is held\n2. the controller's session is stopped "
             "and "
             "closed: its ring is emptied, the position is kept\n3. where it does not obey: a reset of the "
             "controller; then home it\n" +
             what;
    case LinkKind::kRepRap:
      return "1. the lines that the firmware has run to their end: it has no hold\n2. spindle and coolant "
             "off "
             "(M5, M9)\n" +
             what;
    case LinkKind::kDriveTcp:
    case LinkKind::kDriveRtu:
      return "1. the stop value, until the drive stands\n" + what;
    case LinkKind::kDrip:
      break;
  }
  return "nothing can be sent: a CNC control takes no reset from the wire that feeds it; reset it at the "
         "control\n";
}

Result<std::string> reset_machine(const LinkSpec& link, Link& wire, Clock& clock) {
  if (link.kind == LinkKind::kDrip)
    return fail(Code::kUsage,
                "a CNC control takes no reset from the wire that feeds it; reset it at the control");
  if (link.kind == LinkKind::kGrbl) return reset_grbl(link, wire, clock);
  if (is_ring(link.kind)) return RingReset(link.profile.ring, wire).run();
  return stop_machine(link, wire, clock);
}

}  // namespace tiltfeed
