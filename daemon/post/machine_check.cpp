#include "daemon/post/machine_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "daemon/post/dialect.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

// Angles from home that are tried, degrees: one small enough for any machine, then ones that show an offset.
constexpr std::array kTilts = {0.0, 10.0, -10.0, 30.0, -30.0};
constexpr std::array kTurns = {0.0, 10.0, 90.0, 180.0};
constexpr double kFeed = 300.0;  // mm/min: slow enough to press hold

/// Whole last decimals, as the control will see them.
Joints rounded(const config::MachineProfile& machine, const Setup& setup, Point<Part> tip, double a,
               double c) {
  const config::ProgramFormat& f = machine.format;
  a = round_decimal(a, f.rotary_decimals);
  c = round_decimal(c, f.rotary_decimals);
  if (machine.model.rotary.word == RotaryWord::kSigned && std::remainder(c, 360.0) == 0.0)
    c = round_decimal(c + 1.0 / decimal_scale(f.rotary_decimals), f.rotary_decimals);
  Joints q = solve_linear(machine.model, setup, tip, a, c);
  for (double* word : {&q.x, &q.y, &q.z}) *word = round_decimal(*word, f.linear_decimals);
  return q;
}

std::vector<CheckStop> stops(const config::MachineProfile& machine, const Setup& setup, Point<Part> tip) {
  std::vector<CheckStop> found;
  const auto add = [&](double tilt, double turn) {
    const MachineModel& m = machine.model;
    const Joints q = rounded(machine, setup, tip, m.tilt.zero + tilt, m.rotary.zero + turn);
    if (within_limits(m, q)) found.push_back({q, forward(m, setup, q)});
  };
  for (const double tilt : kTilts) add(tilt, 0.0);
  for (const double turn : kTurns)
    if (turn != 0.0) add(0.0, turn);
  for (const double tilt : {30.0, -30.0}) add(tilt, 90.0);
  return found;
}

/// "+X" and the like: where the shank leans, seen by someone who turns with the table.
std::string leaning(Vec3 axis) {
  constexpr double kLeans = 0.05;  // about 3 degrees: what an eye sees
  std::string text;
  if (std::abs(axis.x) > kLeans) text += axis.x > 0 ? " +X" : " -X";
  if (std::abs(axis.y) > kLeans) text += axis.y > 0 ? " +Y" : " -Y";
  return text.empty() ? "stands upright" : "leans to" + text;
}

/// A word, with a blank in front; some controls count last digits where a whole number has no point.
std::string word(const config::ProgramFormat& format, char letter, double value, int decimals) {
  const std::string text = decimal(value, decimals);
  const bool bare = table_of(format.dialect).point && text.find('.') == text.npos;
  return " " + (letter + text) + (bare ? "." : "");
}

std::string turn(const config::ProgramFormat& format, const RotaryAxis& axis, double to, double from) {
  const int decimals = format.rotary_decimals;
  return axis.present ? word(format, axis.letter, control_word(axis.word, to, from, decimals), decimals) : "";
}

}  // namespace

Result<std::vector<CheckStop>> check_stops(const config::MachineProfile& machine, double tool_length,
                                           double height, double aside) {
  const MachineModel& m = machine.model;
  Setup setup;
  setup.tool_length = tool_length;
  const Point<Part> tip{aside, 0.0, height};
  std::vector<CheckStop> places = stops(machine, setup, tip);
  if (places.empty())
    return fail(Code::kLimit, "no place to check is within the limits of " + m.name + ": " +
                                  broken_limit(m, rounded(machine, setup, tip, m.tilt.zero, m.rotary.zero))
                                      .value_or("none at home") +
                                  "; give another --height, --aside or --tool-length");
  return places;
}

Result<std::string> check_program(const config::MachineProfile& machine, double tool_length, double height,
                                  double aside) {
  const MachineModel& m = machine.model;
  const config::ProgramFormat& f = machine.format;
  const auto places = check_stops(machine, tool_length, height, aside);
  if (!places) return tl::unexpected<Error>(places.error());
  const auto line = [](std::string text) { return text + "\n"; };
  std::string out = line("(CHECK OF " + m.name + ": THE TIP STAYS WHERE IT IS ON THE TABLE)");
  out += line("(ZERO: THE POINT OF THE ROTARY AXIS, TOOL LENGTH " + decimal(tool_length, 4) + ")");
  out += line("(EACH STOP: INDICATE THE TIP, COMPARE HOW THE TOOL LEANS)");
  // A Sinumerik or a Heidenhain reads neither these remarks nor G49.
  if (f.dialect == config::Dialect::kSiemens || f.dialect == config::Dialect::kHeidenhain ||
      f.dialect == config::Dialect::kHeidenhainIso)
    out += line("(WORDS OF RS274: ENTER EACH PLACE BY HAND, WITHOUT TOOL LENGTH AND TCP)");
  out += line("G21 G90 G94 G17 G40 G49 G54");
  Joints at{0, 0, 0, m.tilt.zero, m.rotary.zero};
  for (std::size_t i = 0; i < places->size(); ++i) {
    const auto& [q, pose] = (*places)[i];
    out += line("(" + std::to_string(i + 1) + ": TIP " + decimal(pose.tip.x, 3) + " " +
                decimal(pose.tip.y, 3) + " " + decimal(pose.tip.z, 3) + " AXIS " + decimal(pose.axis.x, 4) +
                " " + decimal(pose.axis.y, 4) + " " + decimal(pose.axis.z, 4) + ")");
    out += line("(   " + leaning(pose.axis) + ")");
    out += line("G1" + word(f, 'X', q.x, f.linear_decimals) + word(f, 'Y', q.y, f.linear_decimals) +
                word(f, 'Z', q.z, f.linear_decimals) + turn(f, m.tilt, q.a, at.a) +
                turn(f, m.rotary, q.c, at.c) + word(f, 'F', kFeed, 0));
    out += line("M0");
    at = q;
  }
  return out + "M2\n";
}

}  // namespace tiltfeed::daemon
