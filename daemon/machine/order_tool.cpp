// `machine tool`: the steps of a tool change. The guided change of the command line is made of them.

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/machine/order_parts.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

constexpr double kParkTime = 300.0;  // s
constexpr const char* kTop = "G53 G0 Z0";

/// Spindle and coolant off, the tool off the part along the machine's Z: the profile's own retract line.
Result<MachineAnswer> park(const MachineBench& bench) {
  const std::string& stated = bench.machine.format.retract;
  const bool usual = stated.empty() || stated == "default";
  if (stated == "none")
    return fail(Code::kUsage, "the profile states no retract line (program.retract: none); jog the tool off");
  const std::string retract = usual ? kTop : stated;
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  if (const Result<GrblStatus> said = idle_machine(talk, "tool park"); !said)
    return tl::unexpected<Error>(said.error());
  for (const std::string& line : {std::string("M5"), std::string("M9"), retract, std::string("G4 P0")}) {
    const Result<GrblAnswer> done = obeyed(talk.ask(line, kParkTime), line);
    if (!done && done.error().code == Code::kCancelled)
      return tl::unexpected<Error>(stopped_by_operator(bench, "the parking"));
    if (!done) return tl::unexpected<Error>(done.error());
  }
  const Result<GrblStatus> said = talk.report_with_offset();
  if (!said) return tl::unexpected<Error>(said.error());
  const MachinePlace at = place_of(*said, talk, bench.machine.model);
  const bool top = !usual || std::abs(at.machine[2]) <= bench.link.profile.position.mm;
  const bool off = said->spindle <= 0.0 && said->switched.empty();
  if (said->state != "Idle" || !top || !off)
    return fail(Code::kLink, "not parked: state " + said->state + ", machine " + describe(at.machine) +
                                 (off ? "" : ", spindle or coolant is still on"));
  return MachineAnswer{
      "parked: machine " + describe(at.machine) + ", spindle and coolant off",
      ordered_json({{"parked", true}, {"machine", ordered_json::parse(axes_json(at.machine))}}).dump()};
}

/// The plate's height and the tool's length: each from the other.
Result<MachineAnswer> measure(const MachineBench& bench, const OrderWords& words) {
  OrderWords probing;
  std::optional<double> setter, length;
  for (const std::string& word : words) {
    const bool is_setter = word.starts_with("setter="), is_length = word.starts_with("length=");
    if (!is_setter && !is_length) {
      probing.push_back(word);
      continue;
    }
    const Result<AxisWord> value = axis_word("Z" + word.substr(7));
    if (!value) return wrong_words("tool", "'" + word + "' has no number");
    (is_setter ? setter : length) = value->value;
  }
  if (setter.has_value() == length.has_value())
    return wrong_words("tool", "setter= gives the length, length= gives the setter");
  const Result<MachineAnswer> touched = grbl_probe(bench, probing);
  if (!touched) return touched;
  const auto at = ordered_json::parse(touched->json)["machine"].value("Z", std::nan(""));
  if (!std::isfinite(at) || probing.empty() || (probing[0][0] != 'Z' && probing[0][0] != 'z'))
    return fail(Code::kUsage, "a tool's length is measured along Z");
  const double found = setter ? at - *setter : at - *length;
  const char* const name = setter ? "length" : "setter";
  if (setter && found <= 0.0)
    return fail(Code::kLimit, "the tool would be " + figure(found) +
                                  " mm long: setter= is the machine Z at which the "
                                  "gauge line itself would touch");
  return MachineAnswer{std::string(name) + "=" + figure(found) + " (touched at machine Z" + figure(at) + ")",
                       ordered_json({{name, found}, {"touched", at}}).dump()};
}

}  // namespace

Result<MachineAnswer> grbl_tool(const MachineBench& bench, const OrderWords& words) {
  if (words.size() == 1 && words[0] == "park") return park(bench);
  if (!words.empty() && words[0] == "measure") return measure(bench, {words.begin() + 1, words.end()});
  return wrong_words("tool", "this is none of its forms");
}

}  // namespace tiltfeed::daemon
