// The order that leads out of every state of a controller.

#include <algorithm>

#include "daemon/machine/grbl_talk.h"
#include "daemon/machine/machine_place.h"
#include "daemon/machine/ring_talk.h"
#include "daemon/machine/stop_machine.h"

namespace tiltfeed::daemon {

namespace {

constexpr double kUnlockTime = 5.0;  // s

/// Where the controller has not obeyed the reset that turns them off; no register tells.
constexpr const char* kSpindleLeft =
    "; spindle and coolant may still be on: a program of M5, M9 and M2 turns them off";

constexpr const char* kSpindleOff = "; spindle and coolant are off";
constexpr const char* kHome = "the controller was reset: home the machine before anything else";

/// After the reset: the state of the next reports, and $X where that is an alarm. Where none comes, what the
/// stop has seen is all that is known.
Result<std::string> unlock_grbl(Link& wire, Clock& clock, const Result<std::string>& stopped) {
  GrblTalk talk(wire, clock);
  const auto settled = [](const GrblStatus& said) {
    return said.state == "Idle" || said.state.starts_with("Alarm");
  };
  Result<GrblStatus> said = talk.report_until(settled, kUnlockTime);
  if (!said && !stopped) return stopped;
  if (said && said->state == "Idle") return stopped ? *stopped : "reset";
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
  return unlock_grbl(wire, clock, stopped);
}

Result<std::string> reset_ring(const config::RingMap& map, Link& wire) {
  RingTalk talk(map, wire);
  if (const Result<void> looked = talk.look(); !looked) return tl::unexpected<Error>(looked.error());
  const RingStatus before = talk.status();
  const bool alarm = before.state == RingState::kAlarm;
  bool obeyed = true;
  const auto reset = [&] { return talk.tell(MailboxCode::kReset); };
  if (before.state == RingState::kNoSession)
    return std::string("the controller has no session and stands idle") +
           (reset() ? kSpindleOff : kSpindleLeft);
  if (alarm) obeyed = talk.tell(MailboxCode::kClearAlarm);
  if (talk.status().state == RingState::kRunning) obeyed = talk.tell(MailboxCode::kHold) && talk.stands();
  obeyed = obeyed &&
           (talk.status().session == 0 || (talk.tell(MailboxCode::kStop) && talk.tell(MailboxCode::kClose)));
  if (obeyed) {
    // The axes stand: a reset costs no place then, and nothing else of the map turns the spindle off.
    const bool off = reset();
    if (off && talk.status().state == RingState::kAlarm) return kHome;
    return "session " + std::to_string(before.session) + " is closed, its ring is empty, " +
           (alarm ? "the alarm is cleared: home the machine at the control where its axes may have slipped"
                  : "the position is kept") +
           (off ? kSpindleOff : kSpindleLeft);
  }
  if (!reset())
    return fail(Code::kLink, "the controller obeys neither 'stop' nor 'reset' (state " +
                                 std::string(ring_state_name(talk.status().state)) +
                                 "): look at the machine, stop it there");
  return kHome;
}

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
             "closed: its ring is emptied, the position is kept\n3. a reset of the controller at a stand: "
             "spindle and coolant off; where it did not stand or obey, home it then\n" +
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
  if (is_ring(link.kind)) return reset_ring(link.profile.ring, wire);
  return stop_machine(link, wire, clock);
}

}  // namespace tiltfeed::daemon
