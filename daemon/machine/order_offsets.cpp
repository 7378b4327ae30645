// `machine offsets` and `machine probe`: what is set is read back from `$#` before it is said.

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "daemon/machine/order_parts.h"
#include "daemon/protocol/grbl_words.h"

namespace tiltfeed::daemon {

namespace {

using nlohmann::ordered_json;

constexpr std::array kSystems = {"G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"};
constexpr double kProbeFeed = 50.0;
/// Half of the last decimal that is reported, twice: what was sent and what comes back are both rounded.
constexpr double kRounded = 0.0011;

/// `$#`: places by their names, in machine coordinates; one figure alone (TLO of Grbl 1.1) is Z.
struct Parameters {
  std::map<std::string, AxisValues> places;
  bool touched = false;  ///< [PRB:..:1]
  AxisValues of(const std::string& name) const {
    const auto found = places.find(name);
    AxisValues none{};
    return found == places.end() ? none : found->second;
  }
};

Result<Parameters> read_parameters(const MachineBench& bench, GrblTalk& talk) {
  const Result<GrblAnswer> said = obeyed(talk.ask("$#"), "$#");
  if (!said) return tl::unexpected<Error>(said.error());
  Parameters found;
  for (const std::string& line : said->said) {
    const std::size_t colon = line.find(':');
    if (!line.starts_with('[') || !line.ends_with(']') || colon == line.npos) continue;
    const std::string name = line.substr(1, colon - 1);
    const std::size_t end = std::min(line.find(':', colon + 1), line.size() - 1);
    std::vector<double> values;
    for (const char *at = line.data() + colon + 1, *const stop = line.data() + end; at < stop;) {
      double value = 0.0;
      const auto parsed = std::from_chars(at, stop, value, std::chars_format::fixed);
      if (parsed.ec != std::errc()) break;
      values.push_back(value);
      at = parsed.ptr + 1;
    }
    if (name == "PRB") found.touched = line.ends_with(":1]");
    AxisValues& place = found.places[name];
    place = no_axes();
    if (values.size() == 1)
      place = {}, place[2] = values[0];
    else
      place = report_axes(values, talk.letters(), bench.machine.model);
  }
  if (!found.places.contains("G54"))
    return fail(Code::kLink, "the controller does not tell its work offsets (`$#`)");
  return found;
}

MachineAnswer shown(const Parameters& found) {
  MachineAnswer answer;
  ordered_json json = ordered_json::object();
  for (const char* name : kSystems) {
    if (!found.places.contains(name)) continue;
    answer.text +=
        std::string(name) + std::string(8 - std::string(name).size(), ' ') + describe(found.of(name)) + "\n";
    json["offsets"][name] = ordered_json::parse(axes_json(found.of(name)));
  }
  for (const auto& [name, what] :
       {std::pair("G92", "G92, on top"), std::pair("TLO", "tool length, on top")}) {
    const AxisValues extra = found.of(name);
    if (std::none_of(extra.begin(), extra.end(), [](double v) { return v != 0.0 && !std::isnan(v); }))
      continue;
    answer.text += std::string(what) + ": " + describe(extra) + "\n";
    json[name] = ordered_json::parse(axes_json(extra));
  }
  if (!answer.text.empty()) answer.text.pop_back();
  answer.json = json.dump();
  return answer;
}

/// P of G10; 0: no such system.
int system_number(const std::string& system) {
  const auto at = std::find(kSystems.begin(), kSystems.end(), system);
  return at == kSystems.end() ? 0 : static_cast<int>(at - kSystems.begin()) + 1;
}

/// G10, then `$#`: every axis must be what was meant, the named as well as the others.
Result<MachineAnswer> set_offset(const MachineBench& bench, GrblTalk& talk, const std::string& system,
                                 const AxisValues& value, const Parameters& before) {
  std::string line = "G10L2P" + std::to_string(system_number(system));
  AxisValues meant = before.of(system);
  for (std::size_t i = 0; i < kMostAxes; ++i) {
    if (std::isnan(value[i])) continue;
    meant[i] = value[i];
    line += kAxisLetters[i] + figure(value[i]);
  }
  if (const Result<GrblAnswer> done = obeyed(talk.ask(line), line); !done)
    return tl::unexpected<Error>(done.error());
  const Result<Parameters> after = read_parameters(bench, talk);
  if (!after) return tl::unexpected<Error>(after.error());
  const AxisValues is = after->of(system);
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (!std::isnan(meant[i]) && !(std::abs(is[i] - meant[i]) <= kRounded))
      return fail(Code::kLink, system + " was to be " + describe(meant) +
                                   ", and the controller says that it is " + describe(is));
  ordered_json json = {{"set", system},
                       {"offset", ordered_json::parse(axes_json(is))},
                       {"before", ordered_json::parse(axes_json(before.of(system)))}};
  return MachineAnswer{system + " set: " + describe(is) + " (was " + describe(before.of(system)) + ")",
                       json.dump()};
}

/// The offset under which `place`, machine coordinates, is `value` in program coordinates.
AxisValues offset_for(const AxisValues& place, const AxisValues& value, const Parameters& now) {
  AxisValues offset = no_axes();
  const AxisValues g92 = now.of("G92"), tool = now.of("TLO");
  for (std::size_t i = 0; i < kMostAxes; ++i) {
    const double others = (std::isnan(g92[i]) ? 0.0 : g92[i]) + (std::isnan(tool[i]) ? 0.0 : tool[i]);
    offset[i] = place[i] - others - value[i];
  }
  return offset;
}

/// The words of `$G` that a probing changes, to be sent again after it.
Result<std::string> modal_words(GrblTalk& talk) {
  const Result<GrblAnswer> said = obeyed(talk.ask("$G"), "$G");
  if (!said) return tl::unexpected<Error>(said.error());
  std::string words = "G80";
  for (const std::string& line : said->said)
    for (const char* word : {" G20", " G21", " G90", " G91", " G93", " G94", " G95"})
      if (line.starts_with("[GC:") && (line + " ").find(std::string(word) + " ") != line.npos)
        words += word + 1;
  return words;
}

struct ProbeWish {
  char letter = 'Z';
  double way = 0.0, feed = kProbeFeed;
  std::string system;  ///< to be set; empty: none
  double value = 0.0;  ///< of the touched place in it
};

Result<ProbeWish> read_probe(const MachineBench& bench, const OrderWords& words) {
  ProbeWish wish;
  OrderWords axes;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == word.npos) {
      axes.push_back(word);
      continue;
    }
    const Result<AxisWord> value = axis_word("Z" + word.substr(equals + 1));
    wish.system = word.substr(0, equals);
    if (system_number(wish.system) == 0 || !value)
      return wrong_words("probe", "'" + word + "' sets no work offset");
    wish.value = value->value;
  }
  const Result<AxisWords> asked = axis_words(axes, bench.machine.model);
  if (!asked) return tl::unexpected<Error>(asked.error());
  if (asked->letters.size() != 1) return wrong_words("probe", "one axis with its way");
  wish.letter = asked->letters[0];
  wish.way = asked->axes[kAxisLetters.find(wish.letter)];
  wish.feed = asked->feed.value_or(kProbeFeed);
  if (wish.way == 0.0) return wrong_words("probe", "the way is 0");
  return wish;
}

/// Where the probe touched, machine coordinates. Errors: kLink, in words; kCancelled.
Result<AxisValues> touch(const MachineBench& bench, GrblTalk& talk, const ProbeWish& wish, double to) {
  const Result<std::string> modal = modal_words(talk);
  if (!modal) return tl::unexpected<Error>(modal.error());
  const std::string line = std::string("G21G90G94G38.2") + wish.letter + figure(to) + "F" + figure(wish.feed);
  const Result<GrblAnswer> done = obeyed(talk.ask(line), line);
  if (!done && done.error().code == Code::kCancelled)
    return tl::unexpected<Error>(stopped_by_operator(bench, "the probing"));
  if (!done) return tl::unexpected<Error>(done.error());
  if (const Result<GrblAnswer> back = obeyed(talk.ask(*modal), *modal); !back)
    return tl::unexpected<Error>(back.error());
  const Result<Parameters> found = read_parameters(bench, talk);
  if (!found) return tl::unexpected<Error>(found.error());
  if (!found->touched || !found->places.contains("PRB"))
    return fail(Code::kLink, "the probing ended, and the controller does not say that the probe touched");
  return found->of("PRB");
}

}  // namespace

Result<MachineAnswer> grbl_offsets(const MachineBench& bench, const OrderWords& words) {
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  const bool here = words.size() > 1 && words[1] == "here";
  AxisWords values;
  if (!words.empty()) {
    if (system_number(words[0]) == 0)
      return wrong_words("offsets", "G54 to G59, G59.1, G59.2 and G59.3 can be set");
    Result<AxisWords> read = axis_words({words.begin() + (here ? 2 : 1), words.end()}, bench.machine.model);
    if (!read) return tl::unexpected<Error>(read.error());
    values = *read;
    if (values.letters.empty() || values.feed)
      return wrong_words("offsets", "name the axes and their values");
  }
  const Result<GrblStatus> said = idle_machine(talk, "offsets");
  if (!said) return tl::unexpected<Error>(said.error());
  const Result<Parameters> before = read_parameters(bench, talk);
  if (!before) return tl::unexpected<Error>(before.error());
  if (words.empty()) return shown(*before);
  if (!before->places.contains(words[0]))
    return fail(Code::kUsage, "this controller has no " + words[0] + "; nothing was sent");
  AxisValues offset = values.axes;
  if (here) offset = offset_for(place_of(*said, talk, bench.machine.model).machine, values.axes, *before);
  for (const char letter : values.letters)
    if (std::isnan(offset[kAxisLetters.find(letter)]))
      return fail(Code::kLink, "the controller does not tell where its axes are; nothing was sent");
  return set_offset(bench, talk, words[0], offset, *before);
}

Result<MachineAnswer> grbl_probe(const MachineBench& bench, const OrderWords& words) {
  const Result<ProbeWish> wish = read_probe(bench, words);
  if (!wish) return tl::unexpected<Error>(wish.error());
  const MachineModel& machine = bench.machine.model;
  GrblTalk talk(bench.wire, bench.clock, bench.stopped);
  const Result<GrblStatus> said = idle_machine(talk, "probe");
  if (!said) return tl::unexpected<Error>(said.error());
  const std::size_t axis = kAxisLetters.find(wish->letter);
  const MachinePlace from = place_of(*said, talk, machine);
  AxisValues to = no_axes();
  to[axis] = from.program[axis] + wish->way;
  if (std::isnan(to[axis]))
    return fail(Code::kLink,
                "the controller does not tell where its axes are in program coordinates; nothing was sent");
  if (const Result<void> inside = within_travel(machine, to); !inside)
    return tl::unexpected<Error>(inside.error());
  const Result<AxisValues> at = touch(bench, talk, *wish, to[axis]);
  if (!at) return tl::unexpected<Error>(at.error());
  AxisValues program = no_axes();
  for (std::size_t i = 0; i < kMostAxes; ++i) program[i] = (*at)[i] - (from.machine[i] - from.program[i]);
  MachineAnswer answer;
  answer.text = "touched at machine " + describe(*at) + ", program " + describe(program);
  ordered_json json = {{"touched", true},
                       {"machine", ordered_json::parse(axes_json(*at))},
                       {"program", ordered_json::parse(axes_json(program))}};
  if (!wish->system.empty()) {
    const Result<Parameters> now = read_parameters(bench, talk);
    if (!now) return tl::unexpected<Error>(now.error());
    AxisValues value = no_axes();
    value[axis] = wish->value;
    const Result<MachineAnswer> set =
        set_offset(bench, talk, wish->system, offset_for(*at, value, *now), *now);
    if (!set) return set;
    answer.text += "\n" + set->text;
    json.update(ordered_json::parse(set->json));
  }
  answer.json = json.dump();
  return answer;
}

}  // namespace tiltfeed::daemon
