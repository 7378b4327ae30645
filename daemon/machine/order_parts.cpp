#include "daemon/machine/order_parts.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "daemon/machine/stop_machine.h"
#include "daemon/protocol/grbl_words.h"
#include "daemon/protocol/session.h"
#include "daemon/wire/wire_text.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {

/// A word at the very end of the travel goes through binary fractions and the report's three decimals.
constexpr double kTravelSlack = 0.001;
constexpr int kDecimals = 3;

}  // namespace

std::string figure(double value) { return decimal(value, kDecimals); }

Result<AxisWord> axis_word(const std::string& text) {
  AxisWord word;
  const char* const end = text.data() + text.size();
  if (text.size() > 1) {
    word.letter = static_cast<char>(text[0] >= 'a' && text[0] <= 'z' ? text[0] - 'a' + 'A' : text[0]);
    const char* const begin = text.data() + (text[1] == '+' ? 2 : 1);
    const auto parsed = std::from_chars(begin, end, word.value, std::chars_format::fixed);
    if (word.letter >= 'A' && word.letter <= 'Z' && parsed.ec == std::errc() && parsed.ptr == end &&
        std::isfinite(word.value) && std::abs(word.value) < 1e6)
      return word;
  }
  return fail(Code::kUsage, "'" + wire_text(text) + "' is no letter with a number, as X-10.5");
}

Result<AxisWords> axis_words(const OrderWords& words, const MachineModel& machine) {
  AxisWords found;
  for (const std::string& text : words) {
    const Result<AxisWord> word = axis_word(text);
    if (!word) return tl::unexpected<Error>(word.error());
    const std::size_t axis = kAxisLetters.find(word->letter);
    if (word->letter == 'F' && !found.feed && word->value > 0.0) {
      found.feed = word->value;
    } else if (axis != kAxisLetters.npos && std::isnan(found.axes[axis]) &&
               travel_of(machine, word->letter)) {
      found.axes[axis] = word->value;
      found.letters += word->letter;
    } else {
      return fail(Code::kUsage,
                  "'" + wire_text(text) +
                      "' is no axis of this machine, is there twice, or an F that is not above 0");
    }
  }
  return found;
}

std::optional<AxisTravel> travel_of(const MachineModel& m, char letter) {
  const auto linear = [](const LinearAxis& a) {
    return AxisTravel{a.min, a.max, a.velocity, a.acceleration, false};
  };
  if (letter == 'X') return linear(m.x);
  if (letter == 'Y') return linear(m.y);
  if (letter == 'Z') return linear(m.z);
  for (const RotaryAxis* a : {&m.tilt, &m.rotary})
    if (a->present && a->letter == letter)
      return AxisTravel{a->min, a->max, a->velocity, a->acceleration, true};
  return std::nullopt;
}

Result<void> within_travel(const MachineModel& machine, const AxisValues& to) {
  for (std::size_t i = 0; i < kMostAxes; ++i) {
    const char letter = kAxisLetters[i];
    const auto travel = travel_of(machine, letter);
    if (!travel || std::isnan(to[i]) || !(travel->min < travel->max)) continue;
    const bool low = to[i]<travel->min - kTravelSlack, high = to[i]> travel->max + kTravelSlack;
    if (!low && !high) continue;
    const std::string unit = travel->rotary ? " degrees" : " mm";
    return fail(Code::kLimit,
                std::string(1, letter) + " would go to " + figure(to[i]) + unit + ", its travel " +
                    (low ? "begins at " + figure(travel->min) : "ends at " + figure(travel->max)) +
                    " (machine profile, program coordinates); nothing was sent");
  }
  return {};
}

MachinePlace place_of(const GrblStatus& status, const GrblTalk& talk, const MachineModel& machine) {
  MachinePlace place;
  if (status.decimals > kDecimals) return place;  // with four they are inches
  const AxisValues at = report_axes(status.axes, talk.letters(), machine);
  const bool known = talk.offset().size() == status.axes.size();
  const AxisValues offset = known ? report_axes(talk.offset(), talk.letters(), machine) : no_axes();
  for (std::size_t i = 0; i < kMostAxes; ++i) {
    place.machine[i] = status.in_work ? at[i] + offset[i] : at[i];
    place.program[i] = status.in_work ? at[i] : at[i] - offset[i];
  }
  return place;
}

Result<GrblStatus> idle_machine(GrblTalk& talk, const char* command) {
  Result<GrblStatus> said = talk.report_with_offset();
  if (!said) return said;
  if (said->state == "Idle") return said;
  const std::string remedy =
      said->state.starts_with("Alarm") ? "" : "; `tiltfeed reset` leads out of every state";
  return fail(Code::kLink, std::string(command) + " needs an idle machine. " +
                               grbl_state_text(said->state, talk.alarm()) + remedy + "; nothing was sent");
}

Result<GrblAnswer> obeyed(Result<GrblAnswer> answer, const std::string& line) {
  if (!answer || answer->end == GrblEnd::kOk) return answer;
  const std::string to = " to '" + wire_text(line) + "'";
  if (answer->end == GrblEnd::kError)
    return fail(Code::kLink, "the controller answers" + to + ": " + grbl_error_text(answer->code));
  if (answer->end == GrblEnd::kAlarm)
    return fail(Code::kLink, "the controller answers" + to + ": " + grbl_alarm_text(answer->code));
  return fail(Code::kLink,
              "the controller has restarted instead of answering" + to + ": home it before anything else");
}

double highest_feed(const MachineModel& machine, const AxisValues& way, bool linear_first) {
  double length = 0.0, linear = 0.0, highest = 1e9;
  for (std::size_t i = 0; i < kMostAxes; ++i) {
    const auto travel = travel_of(machine, kAxisLetters[i]);
    if (!travel || std::isnan(way[i])) continue;
    length = std::hypot(length, way[i]);
    if (!travel->rotary) linear = std::hypot(linear, way[i]);
  }
  if (linear_first && linear > 0.0) length = linear;
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (const auto travel = travel_of(machine, kAxisLetters[i]); travel && std::abs(way[i]) > 0.0)
      highest = std::min(highest, travel->velocity * length / std::abs(way[i]));
  return highest;
}

Result<void> feed_allowed(const MachineModel& machine, const AxisValues& way, double feed,
                          bool linear_first) {
  const double highest = highest_feed(machine, way, linear_first);
  if (feed <= highest * (1.0 + 1e-9)) return {};
  return fail(Code::kLimit, "F" + figure(feed) + " is above what the axes can do on this way, " +
                                figure(highest) + " (machine profile); nothing was sent");
}

Result<std::optional<JogOn>> continuous_jog(const OrderWords& words, const MachineModel& machine) {
  if (words.empty() || words[0].size() != 2 || (words[0][1] != '+' && words[0][1] != '-'))
    return std::nullopt;
  const char letter = static_cast<char>(words[0][0] & ~0x20);
  const Result<AxisWords> rest = axis_words({words.begin() + 1, words.end()}, machine);
  if (!rest) return tl::unexpected<Error>(rest.error());
  if (!travel_of(machine, letter) || !rest->letters.empty())
    return wrong_words("jog", "one axis of this machine at a time goes on");
  return JogOn{letter, words[0][1] == '+' ? 1.0 : -1.0, rest->feed};
}

std::optional<int> override_percent(const OrderWords& words) {
  if (words.size() != 2) return std::nullopt;
  const char* const end = words[1].data() + words[1].size();
  int percent = 0;
  if (std::from_chars(words[1].data(), end, percent).ptr != end) return std::nullopt;
  if (percent < kMinOverride || percent > kMaxOverride) return std::nullopt;
  return percent;
}

Error stopped_by_operator(const MachineBench& bench, const char* what) {
  const Result<std::string> stopped = stop_machine(bench.link, bench.wire, bench.clock);
  return {Code::kCancelled,
          std::string(what) + " was stopped on request: " + (stopped ? *stopped : stopped.error().message)};
}

std::string axes_json(const AxisValues& axes) {
  std::string json;
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (!std::isnan(axes[i]))
      json += (json.empty() ? "{\"" : ",\"") + std::string(1, kAxisLetters[i]) + "\":" + figure(axes[i]);
  return json.empty() ? "{}" : json + "}";
}

}  // namespace tiltfeed::daemon
