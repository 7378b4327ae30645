// `machine status`: what the controller says of itself, in words.

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/machine/machine_place.h"
#include "daemon/machine/order_parts.h"
#include "daemon/machine/reprap_talk.h"
#include "daemon/machine/ring_talk.h"
#include "daemon/protocol/grbl_words.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

/// A rotary word as an angle within half a turn, and the whole turns beside it.
struct Unwound {
  double angle = 0.0;
  long turns = 0;
};
Unwound unwind(double word) {
  const double angle = std::remainder(word, 360.0);
  return {angle, std::lround((word - angle) / 360.0)};
}

/// A machine that stands says so at once, s.
constexpr double kAtOnce = 2.0;

struct Texts {
  std::string text;
  ordered_json json = ordered_json::object();

  void line(const std::string& name, const std::string& value) {
    text += name + std::string(name.size() < 9 ? 9 - name.size() : 1, ' ') + value + "\n";
  }
  void rotaries(const AxisValues& program, const MachineModel& machine) {
    for (std::size_t i = 0; i < kMostAxes; ++i) {
      const auto travel = travel_of(machine, kAxisLetters[i]);
      if (!travel || !travel->rotary || std::isnan(program[i])) continue;
      const std::string letter(1, kAxisLetters[i]);
      const auto [angle, turns] = unwind(program[i]);
      if (turns != 0)
        line(letter, figure(angle) + " degrees, " + std::to_string(std::labs(turns)) +
                         (std::labs(turns) == 1 ? " turn " : " turns ") + (turns > 0 ? "on" : "back"));
      json["rotaries"][letter] = {{"word", program[i]}, {"angle", angle}, {"turns", turns}};
    }
  }
  void program(const AxisValues& at, const MachineModel& machine) {
    const std::string place = describe(at);
    line("program", place.empty() ? "not known: the controller does not tell where the axes are" : place);
    if (!place.empty()) json["program"] = ordered_json::parse(axes_json(at));
    rotaries(at, machine);
  }
  MachineAnswer answer() {
    if (!text.empty()) text.pop_back();
    return {text, json.dump()};
  }
};

std::string inputs_in_words(const std::string& letters) {
  constexpr std::pair<char, const char*> kInputs[] = {
      {'P', "probe"}, {'O', "probe not connected"}, {'D', "door"},       {'H', "hold"}, {'S', "start"},
      {'R', "reset"}, {'E', "emergency stop"},      {'M', "motor fault"}};
  std::string text;
  for (const char letter : letters) {
    std::string word = std::string("limit ") + letter;
    for (const auto& [is, name] : kInputs)
      if (is == letter) word = name;
    text += (text.empty() ? "" : ", ") + word;
  }
  return text;
}

Result<void> ring_state(const MachineBench& bench, Texts& out) {
  RingTalk talk(bench.link.profile.ring, bench.wire);
  if (const Result<void> looked = talk.look(); !looked) return looked;
  const RingStatus& said = talk.status();
  std::string state = ring_state_name(said.state);
  out.json["state"] = state;
  if (said.session != 0) {
    state +=
        ", session " + std::to_string(said.session) + ", " + std::to_string(said.free_slots) + " slots free";
    out.json["session"] = said.session;
  }
  if (said.alarm != 0) {
    state += ", alarm " + std::to_string(said.alarm) + " (the number is the controller's own)";
    out.json["alarm"] = said.alarm;
  }
  out.line("state", state);
  if (said.line != 0) out.line("line", std::to_string(said.line)), out.json["line"] = said.line;
  out.line("override", "feed " + std::to_string(said.feed_override) + " %");
  out.json["override"] = {{"feed", said.feed_override}};
  return {};
}

}  // namespace

Result<MachineAnswer> grbl_status(const MachineBench& bench, const OrderWords& words) {
  if (!words.empty()) return wrong_words("status", "takes no words");
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  GrblStatus said;
  int overrides[3] = {-1, -1, -1};
  constexpr int kOverrideReports = 25;  // they come with each twentieth
  for (int i = 0; i < kOverrideReports && overrides[0] < 0; ++i) {
    const Result<GrblStatus> report = talk.report_with_offset();
    if (!report) return tl::unexpected<Error>(report.error());
    said = *report;
    if (said.feed_override >= 0)
      overrides[0] = said.feed_override, overrides[1] = said.rapid_override,
      overrides[2] = said.spindle_override;
  }
  const MachineModel& machine = bench.machine.model;
  const MachinePlace place = place_of(said, talk, machine);
  Texts out;
  out.line("state", grbl_state_text(said.state, talk.alarm()));
  out.json["state"] = said.state;
  if (talk.alarm() != 0 && said.state.starts_with("Alarm")) out.json["alarm"] = talk.alarm();
  out.line("machine", describe(place.machine));
  const std::string program = describe(place.program);
  out.line("program", program.empty() ? "not known: the controller does not tell its work offset" : program);
  out.json["machine"] = ordered_json::parse(axes_json(place.machine));
  out.json["program"] = ordered_json::parse(axes_json(place.program));
  out.rotaries(place.program, machine);
  if (said.feed >= 0) {
    out.line("speed", "feed " + figure(said.feed) + ", spindle " + figure(said.spindle));
    out.json["feed"] = said.feed, out.json["spindle"] = said.spindle;
  }
  if (overrides[0] >= 0) {
    out.line("override", "feed " + std::to_string(overrides[0]) + " %, rapid " +
                             std::to_string(overrides[1]) + " %, spindle " + std::to_string(overrides[2]) +
                             " %");
    out.json["override"] = {{"feed", overrides[0]}, {"rapid", overrides[1]}, {"spindle", overrides[2]}};
  }
  if (!said.inputs.empty()) {
    out.line("inputs", inputs_in_words(said.inputs));
    out.json["inputs"] = said.inputs;
  }
  return out.answer();
}

Result<MachineAnswer> ring_status(const MachineBench& bench, const OrderWords& words) {
  if (!words.empty()) return wrong_words("status", "takes no words");
  const auto at = read_place(bench.link, bench.machine.model, bench.wire, bench.clock);
  if (!at) return tl::unexpected<Error>(at.error());
  Texts out;
  if (const Result<void> told = ring_state(bench, out); !told) return tl::unexpected<Error>(told.error());
  const MachineModel& machine = bench.machine.model;
  AxisValues program = no_axes();
  const auto set = [&](char letter, double value) {
    if (const std::size_t i = kAxisLetters.find(letter); i != kAxisLetters.npos) program[i] = value;
  };
  if (*at) {
    set('X', (*at)->x), set('Y', (*at)->y), set('Z', (*at)->z);
    if (machine.tilt.present) set(machine.tilt.letter, (*at)->a);
    if (machine.rotary.present) set(machine.rotary.letter, (*at)->c);
  }
  out.program(program, machine);
  return out.answer();
}

Result<MachineAnswer> reprap_status(const MachineBench& bench, const OrderWords& words) {
  if (!words.empty()) return wrong_words("status", "takes no words");
  RepRapTalk talk(bench.wire, bench.clock, bench.stopped);
  const Result<bool> stands = talk.stands_within(kAtOnce);
  if (!stands) return tl::unexpected<Error>(stands.error());
  Texts out;
  out.line("state", *stands ? "it stands" : "Busy: it moves, or waits for its operator (M0)");
  out.json["state"] = *stands ? "Idle" : "Busy";
  out.line("firmware", talk.firmware());
  out.json["firmware"] = talk.firmware();
  if (talk.restarted()) {
    out.line("note", kRestartedText);
    out.json["restarted"] = true;
  }
  if (*stands) {
    const Result<AxisValues> at = talk.place();
    if (!at) return tl::unexpected<Error>(at.error());
    out.program(*at, bench.machine.model);
  }
  return out.answer();
}

Result<MachineAnswer> drive_status(const MachineBench& bench, const OrderWords& words) {
  if (!words.empty()) return wrong_words("status", "takes no words");
  const config::DriveMap& map = bench.link.profile.drive;
  const auto said = read_registers(bench.wire, map.status, 1);
  if (!said) return tl::unexpected<Error>(said.error());
  const int word = said->front();
  const bool alarm = (word & map.fault_mask) != 0, moves = (word & map.moving_mask) == map.moving_value;
  Texts out;
  out.line("state", std::string(alarm   ? "Alarm"
                                : moves ? "it moves"
                                        : "it stands") +
                        ", status register " + std::to_string(word));
  out.json = {{"state", alarm ? "Alarm" : moves ? "Busy" : "Idle"}, {"register", word}};
  out.program(no_axes(), bench.machine.model);
  return out.answer();
}

}  // namespace tiltfeed::daemon
