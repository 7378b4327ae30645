#include "daemon/machine_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <vector>

#include "kinematics/decimal.h"

namespace tiltfeed {
namespace {

// Angles from home that are tried, degrees: one small enough for any machine, then ones that show an offset.
constexpr std::array kTilts = {0.0, 10.0, -10.0, 30.0, -30.0};
constexpr std::array kTurns = {0.0, 10.0, 90.0, 180.0};
// Slow enough to press hold, mm/min.
constexpr const char* kFeed = "F300";

struct Stop {
  Joints joints;
  Pose pose;
};

/// Whole last decimals, as the control will see them.
Joints rounded(const MachineProfile& machine, const Setup& setup, Point<Part> tip, double a, double c) {
  const ProgramFormat& f = machine.format;
  a = round_decimal(a, f.rotary_decimals);
  c = round_decimal(c, f.rotary_decimals);
  if (machine.model.rotary.word == RotaryWord::kSigned && std::remainder(c, 360.0) == 0.0)
    c = round_decimal(c + 1.0 / decimal_scale(f.rotary_decimals), f.rotary_decimals);
  Joints q = solve_linear(machine.model, setup, tip, a, c);
  for (double* word : {&q.x, &q.y, &q.z}) *word = round_decimal(*word, f.linear_decimals);
  return q;
}

std::vector<Stop> stops(const MachineProfile& machine, const Setup& setup, Point<Part> tip) {
  std::vector<Stop> found;
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

std::string word(char letter, double value, int decimals) {
  return " " + (letter + decimal(value, decimals));
}

}  // namespace

Result<std::string> check_program(const MachineProfile& machine, double tool_length, double height) {
  const MachineModel& m = machine.model;
  const ProgramFormat& f = machine.format;
  Setup setup;
  setup.tool_length = tool_length;
  const Point<Part> tip{0.0, 0.0, height};
  const std::vector<Stop> places = stops(machine, setup, tip);
  if (places.empty())
    return fail(Code::kLimit, "no place to check is within the limits of " + m.name + ": " +
                                  broken_limit(m, rounded(machine, setup, tip, m.tilt.zero, m.rotary.zero))
                                      .value_or("none at home") +
                                  "; give another --height or --tool-length");
  const auto line = [](std::string text) { return text + "\n"; };
  std::string out = line("(CHECK OF " + m.name + ": THE TIP STAYS WHERE IT IS ON THE TABLE)");
  out += line("(ZERO: THE POINT OF THE ROTARY AXIS, TOOL LENGTH " + decimal(tool_length, 4) + ")");
  out += line("(EACH STOP: INDICATE THE TIP, COMPARE HOW THE TOOL LEANS)");
  out += line("G21 G90 G94 G17 G40 G49 G54");
  Joints at{0, 0, 0, m.tilt.zero, m.rotary.zero};
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& [q, pose] = places[i];
    out += line("(" + std::to_string(i + 1) + ": TIP " + decimal(pose.tip.x, 3) + " " +
                decimal(pose.tip.y, 3) + " " + decimal(pose.tip.z, 3) + " AXIS " + decimal(pose.axis.x, 4) +
                " " + decimal(pose.axis.y, 4) + " " + decimal(pose.axis.z, 4) + ")");
    out += line("(   " + leaning(pose.axis) + ")");
    out += line(
        "G1" + word('X', q.x, f.linear_decimals) + word('Y', q.y, f.linear_decimals) +
        word('Z', q.z, f.linear_decimals) +
        word(m.tilt.letter, control_word(m.tilt.word, q.a, at.a, f.rotary_decimals), f.rotary_decimals) +
        word(m.rotary.letter, control_word(m.rotary.word, q.c, at.c, f.rotary_decimals), f.rotary_decimals) +
        " " + kFeed);
    out += line("M0");
    at = q;
  }
  return out + "M2\n";
}

struct MachineCommands::Options {
  CLI::App* check = nullptr;
  std::string profile;
  double tool_length = 100.0, height = 100.0;
};

MachineCommands::MachineCommands(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  CLI::App* machine = app.add_subcommand("machine", "a machine profile and the machine in the shop");
  machine->require_subcommand(1);
  o.check = machine->add_subcommand(
      "check", "check a profile's measured places, print a test program and where the tool should be");
  o.check->add_option("PROFILE", o.profile, "machine profile (YAML)")->required();
  o.check->add_option("--tool-length", o.tool_length, "gauge line to tip, mm (100)")
      ->check(CLI::Range(0.0, 1e4));
  o.check->add_option("--height", o.height, "of the tip over the zero point, mm (100)");
}

MachineCommands::~MachineCommands() = default;

bool MachineCommands::called() const { return options_->check->parsed(); }

int MachineCommands::run() const {
  const auto machine = load_machine(options_->profile);
  const auto program = machine ? check_program(*machine, options_->tool_length, options_->height)
                               : tl::unexpected(machine.error());
  if (!program) {
    std::cerr << "tiltfeed: " << program.error().message << "\n";
    return 1;
  }
  std::cerr << options_->profile << ": " << machine->vectors.size() << " measured places agree\n";
  std::cout << *program;
  return 0;
}

}  // namespace tiltfeed
