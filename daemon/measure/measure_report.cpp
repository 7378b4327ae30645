#include "daemon/measure/measure_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

using nlohmann::ordered_json;

constexpr double kExpected = 2.0;  // standard deviations that are told as "within"

std::string word(const RotaryAxis& axis, double value) {
  return axis.present ? axis.letter + decimal(value, 3) : std::string();
}

std::string place_text(const MachineModel& m, const BallPlace& at) {
  const std::string tilt = word(m.tilt, at.tilt), rotary = word(m.rotary, at.rotary);
  return tilt + (tilt.empty() || rotary.empty() ? "" : " ") + rotary;
}

/// "A 3 words from -60 to 60".
std::string turned(const Measured& m, const RotaryAxis& axis, double BallPlace::*part) {
  if (!axis.present) return "";
  std::set<double> words;
  for (const PlaceRest& one : m.fit.places) words.insert(one.at.*part);
  const std::string letter(1, axis.letter);
  if (words.size() == 1) return letter + " stands at " + decimal(*words.begin(), 3) + " in all places";
  return letter + " stands at " + std::to_string(words.size()) + " words from " + decimal(*words.begin(), 3) +
         " to " + decimal(*words.rbegin(), 3);
}

std::string joined(const std::vector<std::string>& all, const char* between = ", ") {
  std::string text;
  for (const std::string& one : all) text += (text.empty() || one.empty() ? "" : between) + one;
  return text;
}

std::string measured_with(const Measured& m) {
  const std::size_t places = m.readings.places.size(), readings = m.readings.all.size();
  return std::to_string(places) + " places, " +
         (m.readings.touches ? std::to_string(readings) + " touches, " : "") + "noise of a reading " +
         decimal(m.fit.noise, 5) + " mm" +
         (m.fit.condition > 0 ? ", condition " + decimal(m.fit.condition, 1) : "");
}

std::string spread_text(const ProfileChange& one) {
  if (*one.unit == '\0') return "";
  return decimal(one.spread, 5) + (std::string(one.unit) == "deg" ? " degrees" : " mm");
}

/// The least angle between tool and rotary axis that this machine leaves; 0: it can stand along it.
double out_of_reach(const MachineModel& m) {
  if (!m.tilt.present || !m.rotary.present) return 0.0;
  const double off =
      angle_between(m.tilt.direction, m.spindle) - angle_between(m.tilt.direction, m.rotary.direction);
  return Angle::from_radians(std::abs(off)).degrees();
}

/// What holds for tools of other lengths, and where a direction was not seen.
std::string spindle_text(const Measured& m) {
  if (!m.machine.tilt.present) return "";
  const double before = out_of_reach(m.before.model), now = out_of_reach(m.machine);
  if (m.fit.spindle && now > before + 1e-4)
    return "the spindle is measured: the tool comes no nearer than " + decimal(now, 4) +
           " degrees to the axis of " + m.machine.rotary.letter +
           ", and a path that goes there is refused; leave one of the two tool lengths out, and the spindle "
           "is "
           "taken as square as the axes are";
  if (m.fit.spindle) return "";
  return "all tools are about as long, so the spindle's direction was not measured" +
         std::string(m.machine.rotary.present ? ": it is taken to lean as the axes do" : "") +
         "; 0.1 degrees of it move the tip of a tool that is 100 mm longer by up to 0.35 mm: to measure it, "
         "repeat "
         "some places with a stylus at least " +
         decimal(kTwoLengths, 0) + " mm longer";
}

/// How far the tip goes from one model to the other while the words stay, the work zero on either's own axis.
double tip_between(const MachineModel& from, const MachineModel& to, double tool_length) {
  double most = 0.0;
  Setup setup;
  setup.tool_length = tool_length;
  const auto between = [](const RotaryAxis& axis, double share) {
    const double low = std::max(axis.min, axis.zero - kWorkTilt),
                 high = std::min(axis.max, axis.zero + kWorkTilt);
    return axis.present ? low + (high - low) * share : axis.zero;
  };
  for (const double tilt : {0.0, 0.25, 0.5, 0.75, 1.0})
    for (const double rotary : {0.0, 0.33, 0.67, 1.0})
      for (const double x : {-kWorkSide, kWorkSide})
        for (const double z : {0.0, kWorkHeight}) {
          const Joints a =
              solve_linear(from, setup, {x, x, z}, between(from.tilt, tilt), between(from.rotary, rotary));
          const Joints b = solve_linear(to, setup, {x, x, z}, a.a, a.c);
          most = std::max(most, std::hypot(a.x - b.x, a.y - b.y, a.z - b.z));
        }
  return most;
}

ordered_json json_of(const std::vector<NextPlace>& places) {
  ordered_json all = ordered_json::array();
  for (const NextPlace& one : places)
    all.push_back(
        {{"tilt_deg", one.at.tilt}, {"rotary_deg", one.at.rotary}, {"tip_mm", kExpected * one.tip}});
  return all;
}

}  // namespace

Result<Measured> measure(const std::string& text, const config::MachineProfile& before,
                         const BallReadings& readings, double wanted, int most_next) {
  const Result<PivotFit> fit = fit_pivots(before.model, readings);
  if (!fit) return tl::unexpected<Error>(fit.error());
  Measured m;
  m.before = before;
  m.readings = readings;
  m.fit = *fit;
  m.wanted = wanted;
  m.values = spreads(*fit, before.model);
  m.machine = settled(fit->found, before.model, fit->spindle, fit->tool_length);
  m.changes = profile_changes(text, *fit, m.values, before.model);
  m.tip = tip_spread(*fit, before.model, fit->known);
  m.tip_before = tip_between(before.model, m.machine, fit->tool_length);
  // X, Y, Z of a centre from touches in all directions: each tells a third of each.
  const double touches =
      static_cast<double>(readings.all.size()) / static_cast<double>(readings.places.size());
  const double centre = std::max(fit->noise, 1e-6) * (readings.touches ? std::sqrt(3.0 / touches) : 1.0);
  m.next = next_places(*fit, before.model, centre, wanted / kExpected, most_next);
  return m;
}

std::string places_text(const MachineModel& machine, const std::vector<NextPlace>& next) {
  std::vector<std::string> all;
  for (const NextPlace& one : next) all.push_back(place_text(machine, one.at));
  return joined(all);
}

std::string doubts(const Measured& m) {
  if (m.good()) return "";
  const MachineModel& model = m.before.model;
  const std::string words =
      joined({turned(m, model.tilt, &BallPlace::tilt), turned(m, model.rotary, &BallPlace::rotary)});
  const std::string add =
      m.next.empty() ? "" : "; measure at these places, too: " + places_text(model, m.next);
  if (!m.fit.untold.empty())
    return "these places do not tell " + joined(m.fit.untold) + " (" + std::to_string(m.fit.rank) + " of " +
           std::to_string(m.fit.full_rank) + " numbers are seen): " + words + add;
  return "the condition is " + decimal(m.fit.condition, 1) + ", above " + decimal(kMostCondition, 0) +
         ": these places tell the values badly, the tip only within " + decimal(kExpected * m.tip, 4) +
         " mm; " + words + add;
}

std::string report_text(const Measured& m) {
  std::string text = m.before.path + ": " + measured_with(m) + "\n";
  for (const ProfileChange& one : m.changes)
    text += "  " + one.key + ": " + one.after + (*one.unit != '\0' ? ", spread " + spread_text(one) : "") +
            "; was " + (one.before.empty() ? "not stated" : one.before) + "\n";
  for (const ValueSpread& one : m.values)
    if (one.value.key == "square" && one.told)
      text += std::string("  ") + m.machine.tilt.letter + " and " + m.machine.rotary.letter + " are " +
              decimal(one.value.parts[0], 5) + " degrees apart, spread " + decimal(one.spread[0], 5) +
              " degrees\n";
  if (m.fit.untold.empty())
    text += "  tip within " + decimal(kExpected * m.tip, 4) +
            " mm (two standard deviations at the worst pose) for " + "tools about " +
            decimal(m.fit.tool_length, 1) + " mm long; the profile puts it up to " +
            decimal(m.tip_before, 3) + " mm elsewhere\n";
  if (const std::string spindle = spindle_text(m); !spindle.empty()) text += "  " + spindle + "\n";
  if (m.good() && !m.next.empty())
    text += "  to bring the tip within " + decimal(kExpected * m.next.back().tip, 4) +
            " mm, measure at these places, too: " + places_text(m.before.model, m.next) + "\n";
  return text;
}

std::string report_json(const Measured& m) {
  ordered_json json = {{"profile", m.before.path},
                       {"places", m.readings.places.size()},
                       {"readings", m.readings.all.size()},
                       {"noise_mm", m.fit.noise},
                       {"rank", m.fit.rank},
                       {"full_rank", m.fit.full_rank},
                       {"condition", m.fit.condition},
                       {"untold", m.fit.untold},
                       {"tip_mm", kExpected * m.tip},
                       {"tip_before_mm", m.tip_before},
                       {"spindle_measured", m.fit.spindle}};
  if (m.readings.touches) json["radius_mm"] = m.fit.found.radius;
  for (const ProfileChange& one : m.changes)
    json["values"].push_back({{"key", one.key},
                              {"value", one.after},
                              {"was", one.before},
                              {"spread", one.spread},
                              {"unit", one.unit}});
  json["next"] = json_of(m.next);
  for (std::size_t i = 0; i < m.fit.places.size(); ++i) {
    const Vec3 rest = m.fit.places[i].rest;
    json["rest"].push_back(
        {{"place", m.readings.places[i]}, {"x_mm", rest.x}, {"y_mm", rest.y}, {"z_mm", rest.z}});
  }
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

std::vector<std::string> remarks(const Measured& m, const std::string& date) {
  std::vector<std::string> lines{"# Measured " + date +
                                 " by `tiltfeed machine measure`: " + measured_with(m) + "."};
  lines.push_back("# The tip is within " + decimal(kExpected * m.tip, 4) +
                  " mm (two standard deviations at the worst pose), tools about " +
                  decimal(m.fit.tool_length, 1) + " mm long.");
  if (const std::string why = doubts(m); !why.empty()) lines.push_back("# KNOWN BADLY: " + why);
  for (const ProfileChange& one : m.changes)
    lines.push_back("#   " + one.key + ": " + (*one.unit != '\0' ? "spread " + spread_text(one) + ", " : "") +
                    "was " + (one.before.empty() ? "not stated" : one.before));
  return lines;
}

std::string places_json(const std::string& profile, const std::vector<NextPlace>& places) {
  return ordered_json({{"profile", profile}, {"next", json_of(places)}})
      .dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

std::string empty_table(const MachineModel& machine, const std::vector<NextPlace>& places) {
  const bool tilts = machine.tilt.present, turns = machine.rotary.present;
  std::string text = std::string(tilts ? "tilt_deg," : "") + (turns ? "rotary_deg," : "") +
                     "x_mm,y_mm,z_mm,tool_length_mm\n";
  std::vector<NextPlace> sorted = places;  // few turns of the axes
  std::stable_sort(sorted.begin(), sorted.end(), [](const NextPlace& a, const NextPlace& b) {
    return std::pair(a.at.tilt, a.at.rotary) < std::pair(b.at.tilt, b.at.rotary);
  });
  for (const NextPlace& one : sorted)
    text += (tilts ? decimal(one.at.tilt, 3) + "," : "") + (turns ? decimal(one.at.rotary, 3) + "," : "") +
            ",,," + decimal(one.at.tool_length, 3) + "\n";
  return text;
}

}  // namespace tiltfeed::daemon
