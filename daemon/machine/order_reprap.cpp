// What an operator asks of a RepRap firmware (Marlin): moves, homing, offsets, tool park. It has no real-time
// bytes: each motion is told in pieces that are short, or ended by M410.

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/machine/order_parts.h"
#include "daemon/machine/reprap_talk.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

/// A piece of a motion that nothing can end before its end, s.
constexpr double kBlindPiece = 0.25;
constexpr double kProvableWay = 0.02;  // mm, degrees: what two decimals can prove
constexpr double kMoveTime = 60.0;

ordered_json place_json(const AxisValues& at) { return {{"program", ordered_json::parse(axes_json(at))}}; }

std::string noted(const RepRapTalk& talk, std::string text) {
  return talk.restarted() ? text + " (" + kRestartedText + ")" : text;
}

/// Those of `at` that this machine has, in words.
AxisValues known_axes(const AxisValues& at, const MachineModel& machine) {
  AxisValues known = no_axes();
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (travel_of(machine, kAxisLetters[i])) known[i] = at[i];
  return known;
}

class RepRapJog {
 public:
  explicit RepRapJog(const MachineBench& bench)
      : bench_(bench), talk_(bench.wire, bench.clock, bench.stopped) {}

  /// Where the axes stand, which must be told for those of `way`; millimetres and absolute words from here
  /// on.
  Result<void> begin(const AxisValues& way) {
    const Result<AxisValues> at = talk_.place();
    if (!at) return tl::unexpected<Error>(at.error());
    at_ = *at;
    for (std::size_t i = 0; i < kMostAxes; ++i)
      if (!std::isnan(way[i]) && std::isnan(at_[i]))
        return fail(Code::kLink, "the firmware does not tell where " + std::string(1, kAxisLetters[i]) +
                                     " is, so its travel cannot be held; nothing was sent");
    return {};
  }
  Result<void> modes() {
    // A firmware without inches does not know G21, and needs none.
    if (const auto done = talk_.ask("G21"); !done) return tl::unexpected<Error>(done.error());
    if (const auto done = talk_.obey("G90"); !done) return tl::unexpected<Error>(done.error());
    return {};
  }
  /// One piece, to its end. Errors: kCancelled, with the place; kLink: it stands elsewhere.
  Result<void> go(const AxisValues& way, double feed) {
    std::string line = "G1";
    AxisValues to = at_;
    for (std::size_t i = 0; i < kMostAxes; ++i)
      if (!std::isnan(way[i])) to[i] += way[i], line += ' ' + std::string(1, kAxisLetters[i]) + figure(to[i]);
    const Result<RepRapAnswer> taken = talk_.obey(line + " F" + figure(feed), kMoveTime);
    if (!taken && taken.error().code == Code::kCancelled) return stop();
    if (!taken) return tl::unexpected<Error>(taken.error());
    const Result<AxisValues> there = talk_.place();
    if (!there && there.error().code == Code::kCancelled) return stop();
    if (!there) return tl::unexpected<Error>(there.error());
    at_ = *there;
    for (std::size_t i = 0; i < kMostAxes; ++i) {
      if (std::isnan(way[i])) continue;
      const auto travel = travel_of(bench_.machine.model, kAxisLetters[i]);
      const config::PositionTolerance& allowed = bench_.link.profile.position;
      const double near = std::min(travel->rotary ? allowed.deg : allowed.mm, std::abs(way[i]) / 2);
      if (!(std::abs(at_[i] - to[i]) <= std::max(near, kRepRapRounding + 1e-9)))
        return fail(Code::kLink, "the machine stands at " + text() +
                                     ", not where the jog leads: the firmware "
                                     "has cut it (not homed, a limit, a switch)");
    }
    return {};
  }

  const AxisValues& at() const { return at_; }
  std::string text() const { return "program " + describe(known_axes(at_, bench_.machine.model)); }
  /// Nothing can end a motion but its own end.
  bool blind() const { return !talk_.emergency(); }
  MachineAnswer done(const std::string& more) const {
    ordered_json json = place_json(known_axes(at_, bench_.machine.model));
    json["done"] = true;
    return {noted(talk_, "jog done: " + text() + more), json.dump()};
  }

 private:
  Result<void> stop() {
    const Result<AxisValues> at = talk_.quick_stop();
    if (!at) return tl::unexpected<Error>(at.error());
    at_ = *at;
    return fail(Code::kCancelled, "the jog was stopped on request at " + text());
  }

  const MachineBench& bench_;
  RepRapTalk talk_;
  AxisValues at_ = no_axes();
};

double length_of(const AxisValues& way, const MachineModel& machine) {
  double all = 0.0, linear = 0.0;
  for (std::size_t i = 0; i < kMostAxes; ++i) {
    const auto travel = travel_of(machine, kAxisLetters[i]);
    if (!travel || std::isnan(way[i])) continue;
    all = std::hypot(all, way[i]);
    if (!travel->rotary) linear = std::hypot(linear, way[i]);
  }
  return linear > 0.0 ? linear : all;
}

Result<MachineAnswer> reprap_jog_step(const MachineBench& bench, const OrderWords& words) {
  const MachineModel& machine = bench.machine.model;
  const Result<AxisWords> asked = axis_words(words, machine);
  if (!asked) return tl::unexpected<Error>(asked.error());
  if (asked->letters.empty()) return wrong_words("jog", "no axis is named");
  for (const double one : asked->axes)
    if (std::abs(one) < kProvableWay)
      return fail(Code::kLimit, "this firmware tells its place with two decimals: a jog is at least " +
                                    figure(kProvableWay) + " mm or degrees; nothing was sent");
  const double feed = asked->feed.value_or(std::min(kUsualJogFeed, highest_feed(machine, asked->axes, true)));
  if (const auto allowed = feed_allowed(machine, asked->axes, feed, true); !allowed)
    return tl::unexpected<Error>(allowed.error());
  RepRapJog jog(bench);
  if (const auto begun = jog.begin(asked->axes); !begun) return tl::unexpected<Error>(begun.error());
  AxisValues to = jog.at();
  for (std::size_t i = 0; i < kMostAxes; ++i) to[i] += asked->axes[i];
  if (const auto inside = within_travel(machine, to); !inside) return tl::unexpected<Error>(inside.error());
  if (const auto set = jog.modes(); !set) return tl::unexpected<Error>(set.error());
  // Without an emergency parser a motion ends by its own end only: so it is told in pieces.
  const double piece = std::max(feed / 60.0 * kBlindPiece, 2 * kProvableWay);
  const int pieces =
      jog.blind() ? std::max(1, static_cast<int>(std::ceil(length_of(asked->axes, machine) / piece))) : 1;
  const AxisValues from = jog.at();
  for (int i = 1; i <= pieces; ++i) {
    AxisValues way = asked->axes;
    for (std::size_t k = 0; k < kMostAxes; ++k) way[k] = from[k] + asked->axes[k] * i / pieces - jog.at()[k];
    if (const auto gone = jog.go(way, feed); !gone) return tl::unexpected<Error>(gone.error());
    if (i < pieces && bench.stopped())
      return fail(Code::kCancelled, "the jog was stopped on request at " + jog.text());
  }
  return jog.done("");
}

/// Each piece to its end: the firmware tells no place while it moves, and has no cancel of its own.
Result<MachineAnswer> reprap_jog_on(const MachineBench& bench, const JogOn& wish) {
  const MachineModel& machine = bench.machine.model;
  const AxisTravel travel = *travel_of(machine, wish.letter);
  const std::size_t axis = kAxisLetters.find(wish.letter);
  AxisValues way = no_axes();
  way[axis] = wish.sign;
  const double feed = wish.feed.value_or(std::min(kUsualJogFeed, highest_feed(machine, way, true)));
  if (const auto allowed = feed_allowed(machine, way, feed, true); !allowed)
    return tl::unexpected<Error>(allowed.error());
  RepRapJog jog(bench);
  if (const auto begun = jog.begin(way); !begun) return tl::unexpected<Error>(begun.error());
  if (const auto set = jog.modes(); !set) return tl::unexpected<Error>(set.error());
  const double limit = wish.sign > 0 ? travel.max : travel.min;
  bool at_limit = false;
  while (bench.held() && !bench.stopped() && !at_limit) {
    const double left = (limit - jog.at()[axis]) * wish.sign;
    const double step = std::min(left, std::max(feed / 60.0 * kBlindPiece, kProvableWay));
    at_limit = left < kProvableWay;
    if (at_limit) break;
    way[axis] = wish.sign * step;
    if (const auto gone = jog.go(way, feed); !gone) return tl::unexpected<Error>(gone.error());
  }
  return jog.done(at_limit ? ", at the end of its travel" : "");
}

Result<AxisValues> place_after(RepRapTalk& talk, const std::vector<std::string>& lines, double patience) {
  for (const std::string& line : lines)
    if (const auto done = talk.obey(line, patience); !done) return tl::unexpected<Error>(done.error());
  return talk.place();
}

}  // namespace

Result<MachineAnswer> reprap_jog(const MachineBench& bench, const OrderWords& words) {
  const auto wish = continuous_jog(words, bench.machine.model);
  if (!wish) return tl::unexpected<Error>(wish.error());
  return *wish ? reprap_jog_on(bench, **wish) : reprap_jog_step(bench, words);
}

Result<MachineAnswer> reprap_home(const MachineBench& bench, const OrderWords& words) {
  const bool one = words.size() == 1 && words[0].size() == 1 && travel_of(bench.machine.model, words[0][0]);
  if (!words.empty() && !one) return wrong_words("home", "one axis of this machine, or none");
  RepRapTalk talk(bench.wire, bench.clock, bench.stopped);
  const Result<AxisValues> at = place_after(talk, {"G28" + (one ? " " + words[0] : "")}, kHomeTime);
  if (!at && at.error().code == Code::kCancelled) {
    const Result<AxisValues> stood = talk.quick_stop();
    return fail(Code::kCancelled,
                stood ? "homing was stopped on request: home again" : stood.error().message);
  }
  if (!at) return tl::unexpected<Error>(at.error());
  const AxisValues known = known_axes(*at, bench.machine.model);
  ordered_json json = place_json(known);
  json["homed"] = true;
  return MachineAnswer{"homed" + (one ? " " + words[0] : "") + ": program " + describe(known), json.dump()};
}

/// M999 ends a stop after an error; a firmware that was killed answers nothing, which settle() tells.
Result<MachineAnswer> reprap_unlock(const MachineBench& bench, const OrderWords& words) {
  if (!words.empty()) return wrong_words("unlock", "takes no words");
  RepRapTalk talk(bench.wire, bench.clock, bench.stopped);
  if (const auto done = talk.obey("M999 S1"); !done) return tl::unexpected<Error>(done.error());
  return MachineAnswer{
      "M999 was taken: a firmware that had stopped after an error goes on (it does not tell whether it had); "
      "home it",
      R"({"unlocked":true})"};
}

/// G92 in the system chosen: what the axes are called here. The firmware lists no offsets.
Result<MachineAnswer> reprap_offsets(const MachineBench& bench, const OrderWords& words) {
  const bool here = words.size() > 2 && words[1] == "here";
  const std::string_view systems[] = {"G92", "G54", "G55",   "G56",   "G57",
                                      "G58", "G59", "G59.1", "G59.2", "G59.3"};
  if (!here || std::find(std::begin(systems), std::end(systems), words[0]) == std::end(systems))
    return wrong_words(
        "offsets",
        "a RepRap firmware neither lists its offsets nor takes them by value; `offsets G92 here "
        "X0`, and where it has work systems `offsets G55 here X0`, are possible");
  const Result<AxisWords> read = axis_words({words.begin() + 2, words.end()}, bench.machine.model);
  if (!read) return tl::unexpected<Error>(read.error());
  if (read->letters.empty() || read->feed) return wrong_words("offsets", "name the axes and their values");
  RepRapTalk talk(bench.wire, bench.clock, bench.stopped);
  const Result<AxisValues> before = talk.place();
  if (!before) return tl::unexpected<Error>(before.error());
  std::string line = "G92";
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (!std::isnan(read->axes[i])) line += ' ' + std::string(1, kAxisLetters[i]) + figure(read->axes[i]);
  std::vector<std::string> lines{line};
  const bool system = words[0] != "G92";
  if (system) lines.insert(lines.begin(), words[0]);
  const Result<AxisValues> after = place_after(talk, lines, 10.0);
  if (!after) return tl::unexpected<Error>(after.error());
  for (const char letter : read->letters) {
    const std::size_t i = kAxisLetters.find(letter);
    if (!(std::abs((*after)[i] - read->axes[i]) <= kRepRapRounding + 1e-9))
      return fail(Code::kLink, line + " was taken, and the firmware says that it is at " +
                                   describe(known_axes(*after, bench.machine.model)));
  }
  const AxisValues known = known_axes(*after, bench.machine.model);
  ordered_json json = place_json(known);
  json["set"] = words[0];
  return MachineAnswer{noted(talk, words[0] + " set: here is program " + describe(known) +
                                       (system ? "; " + words[0] + " is in force now" : "") +
                                       "; jogs keep to the profile's travels in these values"),
                       json.dump()};
}

Result<MachineAnswer> reprap_tool(const MachineBench& bench, const OrderWords& words) {
  if (words.size() != 1 || words[0] != "park")
    return wrong_words("tool", "over a RepRap link park and change (with the length entered) are possible");
  const std::string& stated = bench.machine.format.retract;
  if (stated == "none")
    return fail(Code::kUsage, "the profile states no retract line (program.retract: none); jog the tool off");
  const std::string retract = stated.empty() || stated == "default" ? "G53 G0 Z0" : stated;
  RepRapTalk talk(bench.wire, bench.clock, bench.stopped);
  const Result<AxisValues> at = place_after(talk, {"M5", "M9", retract}, kMoveTime);
  if (!at && at.error().code == Code::kCancelled) {
    const Result<AxisValues> stood = talk.quick_stop();
    return fail(Code::kCancelled, stood ? "the parking was stopped on request" : stood.error().message);
  }
  if (!at) return tl::unexpected<Error>(at.error());
  const AxisValues known = known_axes(*at, bench.machine.model);
  ordered_json json = place_json(known);
  json["parked"] = true;
  return MachineAnswer{"parked: program " + describe(known) + ", M5 and M9 were taken", json.dump()};
}

}  // namespace tiltfeed::daemon
