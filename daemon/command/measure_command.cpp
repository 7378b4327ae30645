#include "daemon/command/measure_command.h"

#include <CLI/CLI.hpp>
#include <ctime>
#include <iostream>

#include "config/machine_profile.h"
#include "config/output_file.h"
#include "config/yaml_tree.h"
#include "daemon/command/command.h"
#include "daemon/measure/measure_report.h"
#include "daemon/measure/rest_picture.h"

namespace tiltfeed::daemon {

namespace {

constexpr double kUsualNoise = 0.002;  // mm: of a touch probe
constexpr int kMostPlaces = 40;

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  char text[16];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%d", &parts)};
}

}  // namespace

struct MeasureCommand::Options {
  CLI::App* command = nullptr;
  std::string profile, readings, output, picture;
  double tool_length = -1.0, noise = kUsualNoise, wanted = 0.006;
  int places = kMostPlaces;
  bool write = false, keep_weak = false, json = false;

  Result<int> work() const;
  Result<int> propose(const config::MachineProfile& machine) const;
  Result<void> write_profile(const std::string& text, const Measured& measured) const;
};

MeasureCommand::MeasureCommand(CLI::App& machine) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.command = machine.add_subcommand(
      "measure",
      "pivots, directions and zeros of both rotaries from a ball measured at several of their places");
  o.command->add_option("PROFILE", o.profile, "machine profile (YAML)")->required();
  o.command->add_option("READINGS", o.readings,
                        "CSV: tilt_deg, rotary_deg, x_mm, y_mm, z_mm, tool_length_mm, and place for touches "
                        "(daemon/measure/README.md); without it a table of places to measure at is printed");
  o.command->add_option("--tool-length", o.tool_length, "gauge line to the stylus ball's centre, mm")
      ->check(CLI::Range(0.0, 1e4));
  o.command->add_option("--tip", o.wanted, "places are proposed until the tip is within this, mm (0.006)")
      ->check(CLI::Range(1e-4, 1.0));
  o.command->add_option("--places", o.places, "most places to propose (40)")->check(CLI::Range(1, 200));
  o.command
      ->add_option("--noise", o.noise,
                   "of X, Y and Z of a place, mm (0.002), for proposals before any reading")
      ->check(CLI::Range(1e-5, 0.1));
  CLI::Option* const write =
      o.command->add_flag("--write", o.write, "change the profile's values in its file");
  o.command->add_option("--out", o.output, "write the changed profile to this file")->excludes(write);
  o.command->add_option("--picture", o.picture, "draw what is left of each place to this SVG file");
  o.command->add_flag(
      "--keep-weak", o.keep_weak,
      "write values that the places tell badly, too (condition above 30); the profile says so");
  o.command->add_flag("--json", o.json, "print one JSON object");
}
MeasureCommand::~MeasureCommand() = default;

bool MeasureCommand::called() const { return options_->command->parsed(); }

int MeasureCommand::run() const {
  const Result<int> status = options_->work();
  return status ? *status : complain(status.error());
}

Result<int> MeasureCommand::Options::propose(const config::MachineProfile& machine) const {
  if (!machine.model.tilt.present && !machine.model.rotary.present)
    return fail(Code::kInput, machine.model.name + " has no rotary axis, so there is no pivot to measure");
  if (write || !output.empty() || !picture.empty())
    return fail(Code::kUsage, "--write, --out and --picture need READINGS");
  const PivotFit nothing = nothing_measured(machine.model, std::max(0.0, tool_length), false);
  const std::vector<NextPlace> next = next_places(nothing, machine.model, noise, wanted / 2.0, places);
  if (next.empty())
    return fail(Code::kInput, "the tip is within " + std::to_string(wanted) + " mm without any measuring");
  if (json) {
    std::cout << places_json(profile, next) << "\n";
    return kExitDone;
  }
  std::cout << empty_table(machine.model, next);
  std::cerr << next.size() << " places; with readings of " << noise << " mm noise the tip will be within "
            << 2.0 * next.back().tip
            << " mm. The ball: beside the rotary's axis, where the stylus reaches it at all "
            << "places; leave out what it does not reach, and see.\n";
  return kExitDone;
}

Result<void> MeasureCommand::Options::write_profile(const std::string& text, const Measured& measured) const {
  const Result<MeasuredProfile> changed =
      measured_profile(text, measured.before, measured.machine, measured.changes, remarks(measured, today()));
  if (!changed) return tl::unexpected<Error>(changed.error());
  if (changed->check_dropped)
    std::cerr << profile
              << ": places under check do not agree with what was measured; they are remarks now\n";
  return config::write_file(write ? profile : output, changed->text);
}

Result<int> MeasureCommand::Options::work() const {
  std::vector<config::NamedFile> inputs{{"READINGS", readings}};
  if (!write) inputs.push_back({"PROFILE", profile});
  const auto outputs = config::check_outputs(
      {{"--out", output}, {"--picture", picture}, {"--write", write ? profile : ""}}, inputs);
  if (!outputs) return tl::unexpected<Error>(outputs.error());
  const Result<std::string> text = config::read_config_text(profile);
  if (!text) return tl::unexpected<Error>(text.error());
  const auto machine = config::parse_machine(*text, profile);
  if (!machine) return tl::unexpected<Error>(machine.error());
  if (readings.empty()) return propose(*machine);
  const Result<std::string> table = config::read_config_text(readings);
  if (!table) return tl::unexpected<Error>(table.error());
  const auto read = read_ball_readings(*table, readings, machine->model, tool_length);
  if (!read) return tl::unexpected<Error>(read.error());
  const Result<Measured> measured = measure(*text, *machine, *read, wanted, places);
  if (!measured) return tl::unexpected<Error>(measured.error());
  if (!picture.empty())
    if (const auto drawn = config::write_file(
            picture, rest_picture(measured->fit, machine->model, read->places, measured->next));
        !drawn)
      return tl::unexpected<Error>(drawn.error());
  std::cout << (json ? report_json(*measured) + "\n" : report_text(*measured));
  const bool usable = measured->fit.untold.empty() && (measured->good() || keep_weak);
  if (!measured->good()) std::cerr << "tiltfeed: " << doubts(*measured) << "\n";
  if (!usable) return kExitFailed;
  if (write || !output.empty())
    if (const auto written = write_profile(*text, *measured); !written)
      return tl::unexpected<Error>(written.error());
  return kExitDone;
}

}  // namespace tiltfeed::daemon
