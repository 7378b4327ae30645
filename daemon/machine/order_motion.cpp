// `machine jog`, `home`, `unlock`.

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/machine/order_parts.h"
#include "daemon/protocol/grbl_words.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

constexpr char kJogCancel = static_cast<char>(0x85);
/// An idle machine for so long before it is believed that a jog is over, s.
constexpr double kIdle = 0.3;
/// A jog that does not move for so long has failed, s.
constexpr double kStuck = 5.0;
/// From the cancel to standstill, s.
constexpr double kBrakeTime = 10.0;
/// Of a continuous jog, s: one piece, and what is planned beside the way to brake. A sender that dies leaves
/// no more than that.
constexpr double kPiece = 0.1, kAhead = 0.25;
constexpr double kLeastWay = 0.001;  // mm, degrees: reports have three decimals

std::string place_text(const MachinePlace& place) { return "program " + describe(place.program); }

ordered_json place_json(const MachinePlace& place) {
  return {{"machine", ordered_json::parse(axes_json(place.machine))},
          {"program", ordered_json::parse(axes_json(place.program))}};
}

/// The real-time byte until a report shows a stand.
Result<GrblStatus> cancel_jog(GrblTalk& talk) {
  Result<GrblStatus> said;
  for (double waited = 0.0; waited < kBrakeTime; waited += 0.2) {
    if (const Result<void> sent = talk.urge(std::string(1, kJogCancel)); !sent)
      return tl::unexpected<Error>(sent.error());
    if (const Result<void> rested = talk.pause(0.2); !rested) return tl::unexpected<Error>(rested.error());
    said = talk.report();
    if (!said || said->state != "Jog") return said;
  }
  return fail(Code::kLink, "the jog was cancelled, and the machine still says that it jogs: stop it there");
}

std::string jog_line(const AxisValues& way, double feed) {
  std::string line = "$J=G91G21";
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (!std::isnan(way[i])) line += kAxisLetters[i] + figure(way[i]);
  return line + "F" + figure(feed);
}

/// Waits until the axes are where the jog leads; a stand elsewhere is an error.
class JogEnd {
 public:
  JogEnd(const MachineBench& bench, GrblTalk& talk, const AxisValues& from, const AxisValues& way)
      : bench_(bench), talk_(talk), from_(from), way_(way) {}

  Result<MachinePlace> wait() {
    Time moved = bench_.clock.now(), busy = moved;
    for (std::string before;;) {
      Result<GrblStatus> said = talk_.report();
      if (!said && said.error().code == Code::kCancelled) return stop();
      if (!said) return lost(said.error());
      const MachinePlace at = place_of(*said, talk_, bench_.machine.model);
      if (said->position != before) moved = bench_.clock.now(), before = said->position;
      const bool stands = said->state == "Idle";
      if (stands && reached(at.machine)) return at;
      if (said->state.starts_with("Alarm"))
        return fail(Code::kLink,
                    "the jog has ended in an alarm: " + grbl_state_text(said->state, talk_.alarm()));
      if (!stands) busy = bench_.clock.now();
      if (bench_.clock.now() - busy > time_of(kIdle))
        return fail(Code::kLink, "the machine stands at " + place_text(at) +
                                     ", not where the jog leads: it was ended at the machine");
      if (bench_.clock.now() - moved > time_of(kStuck))
        return fail(Code::kLink,
                    "the jog does not move the axes (state " + said->state + "): look at the machine");
    }
  }

 private:
  /// Who does not answer may hear: without a cancel the axis goes on to where the jog leads.
  tl::unexpected<Error> lost(const Error& error) {
    const bool sent = talk_.urge(std::string(1, kJogCancel)).has_value();
    return fail(error.code, error.message + (sent ? "; a cancel of the jog was sent" : "") +
                                ", and the axes may move until it is heard: look at the machine");
  }

  bool reached(const AxisValues& at) const {
    const config::PositionTolerance& allowed = bench_.link.profile.position;
    for (std::size_t i = 0; i < kMostAxes; ++i) {
      if (std::isnan(way_[i]) || std::isnan(at[i])) continue;
      const bool rotary = kAxisLetters[i] == 'A' || kAxisLetters[i] == 'B' || kAxisLetters[i] == 'C';
      // Half the way at most: a machine that has not moved is not there.
      const double near =
          std::min(rotary ? allowed.deg : allowed.mm, std::max(kLeastWay, std::abs(way_[i]) / 2));
      if (std::abs(at[i] - from_[i] - way_[i]) > near + 1e-9) return false;
    }
    return true;
  }

  Result<MachinePlace> stop() {
    GrblTalk last(bench_.wire, bench_.clock);
    const Result<GrblStatus> said = cancel_jog(last);
    if (!said) return tl::unexpected<Error>(said.error());
    const Result<GrblStatus> there = last.report_with_offset();
    if (!there) return tl::unexpected<Error>(there.error());
    return fail(Code::kCancelled, "the jog was stopped on request at " +
                                      place_text(place_of(*there, last, bench_.machine.model)));
  }

  const MachineBench& bench_;
  GrblTalk& talk_;
  const AxisValues &from_, &way_;
};

MachineAnswer jogged(const MachinePlace& at) {
  ordered_json json = place_json(at);
  json["done"] = true;
  return {"jog done: " + place_text(at), json.dump()};
}

Result<MachineAnswer> grbl_jog_step(const MachineBench& bench, const OrderWords& words) {
  const MachineModel& machine = bench.machine.model;
  const Result<AxisWords> asked = axis_words(words, machine);
  if (!asked) return tl::unexpected<Error>(asked.error());
  if (asked->letters.empty()) return wrong_words("jog", "no axis is named");
  const double feed =
      asked->feed.value_or(std::min(kUsualJogFeed, highest_feed(machine, asked->axes, false)));
  if (const Result<void> allowed = feed_allowed(machine, asked->axes, feed, false); !allowed)
    return tl::unexpected<Error>(allowed.error());
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  const Result<GrblStatus> before = idle_machine(talk, "jog");
  if (!before) return tl::unexpected<Error>(before.error());
  const MachinePlace from = place_of(*before, talk, machine);
  AxisValues to = no_axes();
  for (std::size_t i = 0; i < kMostAxes; ++i) {
    to[i] = from.program[i] + asked->axes[i];
    if (!std::isnan(asked->axes[i]) && std::isnan(to[i]))
      return fail(Code::kLink,
                  "the controller does not tell where " + std::string(1, kAxisLetters[i]) +
                      " is in program coordinates, so its travel cannot be held; nothing was sent");
  }
  if (const Result<void> inside = within_travel(machine, to); !inside)
    return tl::unexpected<Error>(inside.error());
  const std::string line = jog_line(asked->axes, feed);
  const Result<GrblAnswer> taken = obeyed(talk.ask(line), line);
  if (!taken && taken.error().code == Code::kCancelled) {
    GrblTalk last(bench.wire, bench.clock);
    static_cast<void>(cancel_jog(last));
  }
  if (!taken) return tl::unexpected<Error>(taken.error());
  const Result<MachinePlace> at = JogEnd(bench, talk, from.machine, asked->axes).wait();
  if (!at) return tl::unexpected<Error>(at.error());
  return jogged(*at);
}

/// At the limit what is planned is driven to its end; else the axes brake now.
Result<MachineAnswer> end_of_jog(const MachineBench& bench, bool at_limit) {
  GrblTalk last(bench.wire, bench.clock);
  Result<GrblStatus> said =
      at_limit ? last.report_until([](const GrblStatus& s) { return s.state != "Jog"; }, 600.0)
               : cancel_jog(last);
  if (said) said = last.report_with_offset();
  if (!said) return tl::unexpected<Error>(said.error());
  if (said->state != "Idle")
    return fail(Code::kLink, "the jog has ended in " + grbl_state_text(said->state, last.alarm()));
  MachineAnswer answer = jogged(place_of(*said, last, bench.machine.model));
  if (at_limit) answer.text += ", at the end of its travel";
  return answer;
}

/// One axis, in pieces, as long as the operator holds it and travel is left.
Result<MachineAnswer> grbl_jog_on(const MachineBench& bench, const JogOn& wish) {
  const MachineModel& machine = bench.machine.model;
  const auto [letter, sign, asked] = wish;
  const AxisTravel travel = *travel_of(machine, letter);
  const std::size_t axis = kAxisLetters.find(letter);
  AxisValues way = no_axes();
  way[axis] = sign;
  const double feed = asked.value_or(std::min(kUsualJogFeed, highest_feed(machine, way, false)));
  if (const Result<void> allowed = feed_allowed(machine, way, feed, false); !allowed)
    return tl::unexpected<Error>(allowed.error());
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  Result<GrblStatus> said = idle_machine(talk, "jog");
  if (!said) return tl::unexpected<Error>(said.error());
  double planned = place_of(*said, talk, machine).program[axis];
  if (std::isnan(planned))
    return fail(Code::kLink,
                "the controller does not tell where " + std::string(1, letter) +
                    " is in program coordinates, so its travel cannot be held; nothing was sent");
  const double limit = sign > 0 ? travel.max : travel.min, speed = feed / 60.0;
  const double braking = travel.acceleration > 0.0 ? speed * speed / (2.0 * travel.acceleration) : 0.0;
  bool at_limit = false;
  while (bench.held() && !bench.stopped() && !at_limit) {
    const double here = place_of(*said, talk, machine).program[axis], left = (limit - planned) * sign;
    if ((planned - here) * sign < speed * kAhead + braking) {
      way[axis] = sign * std::floor(std::min(left - kLeastWay, speed * kPiece) * 1000.0) / 1000.0;
      if (std::abs(way[axis]) < kLeastWay) {
        at_limit = true;
        break;
      }
      const std::string line = jog_line(way, feed);
      if (const Result<GrblAnswer> taken = obeyed(talk.ask(line), line); !taken) {
        GrblTalk last(bench.wire, bench.clock);
        static_cast<void>(cancel_jog(last));
        return tl::unexpected<Error>(taken.error());
      }
      planned += way[axis];
    }
    said = talk.report();
    if (!said) break;
  }
  return end_of_jog(bench, at_limit);
}

}  // namespace

Result<MachineAnswer> grbl_jog(const MachineBench& bench, const OrderWords& words) {
  const auto wish = continuous_jog(words, bench.machine.model);
  if (!wish) return tl::unexpected<Error>(wish.error());
  return *wish ? grbl_jog_on(bench, **wish) : grbl_jog_step(bench, words);
}

Result<MachineAnswer> grbl_home(const MachineBench& bench, const OrderWords& words) {
  const bool one = words.size() == 1 && words[0].size() == 1 && travel_of(bench.machine.model, words[0][0]);
  if (!words.empty() && !one) return wrong_words("home", "one axis of this machine, or none");
  const std::string line = "$H" + (one ? words[0] : "");
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  const Result<GrblStatus> before = talk.report();
  if (!before) return tl::unexpected<Error>(before.error());
  if (before->state != "Idle" && !before->state.starts_with("Alarm")) {
    const Result<GrblStatus> refused = idle_machine(talk, "home");
    if (!refused) return tl::unexpected<Error>(refused.error());
  }
  const Result<GrblAnswer> done = obeyed(talk.ask(line, kHomeTime), line);
  if (!done && done.error().code == Code::kCancelled) {
    GrblTalk last(bench.wire, bench.clock);  // a feed hold does not end homing
    const Result<void> sent = last.urge("\x18");
    return fail(Code::kCancelled,
                sent ? "homing was stopped by a reset on request: home again" : sent.error().message);
  }
  if (!done) return tl::unexpected<Error>(done.error());
  const Result<GrblStatus> after = talk.report_with_offset();
  if (!after) return tl::unexpected<Error>(after.error());
  if (after->state != "Idle")
    return fail(Code::kLink, "homing was answered, but the machine is not idle: " +
                                 grbl_state_text(after->state, talk.alarm()));
  const MachinePlace at = place_of(*after, talk, bench.machine.model);
  ordered_json json = place_json(at);
  json["homed"] = true;
  return MachineAnswer{
      "homed" + (one ? " " + words[0] : "") + ": machine " + describe(at.machine) + ", " + place_text(at),
      json.dump()};
}

Result<MachineAnswer> grbl_unlock(const MachineBench& bench, const OrderWords& words) {
  if (!words.empty()) return wrong_words("unlock", "takes no words");
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  Result<GrblStatus> said = talk.report();
  if (!said) return tl::unexpected<Error>(said.error());
  if (!said->state.starts_with("Alarm"))
    return MachineAnswer{
        "the machine is not locked: " + grbl_state_text(said->state, 0) + "; nothing was sent",
        R"({"unlocked":false})"};
  if (const Result<GrblAnswer> done = obeyed(talk.ask("$X"), "$X"); !done)
    return tl::unexpected<Error>(done.error());
  said = talk.report();
  if (!said) return tl::unexpected<Error>(said.error());
  if (said->state.starts_with("Alarm"))
    return fail(Code::kLink, "still locked: " + grbl_state_text(said->state, talk.alarm()) +
                                 "; where unlocking is not enough `tiltfeed reset` is");
  return MachineAnswer{"unlocked: " + grbl_state_text(said->state, 0) +
                           "; its position is not to be trusted where the axes may have slipped: home it",
                       R"({"unlocked":true})"};
}

}  // namespace tiltfeed::daemon
