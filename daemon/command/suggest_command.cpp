#include "daemon/command/suggest_command.h"

#include <CLI/CLI.hpp>
#include <chrono>
#include <iostream>
#include <map>
#include <optional>

#include "config/job.h"
#include "config/output_file.h"
#include "config/part_reading.h"
#include "daemon/command/command.h"
#include "daemon/command/progress_line.h"
#include "daemon/plan/suggestion_report.h"
#include "pathgen/mesh/mesh_check.h"

namespace tiltfeed::daemon {

namespace {

/// Without --cutter.
std::string usual_ball(const pathgen::Box& bounds) {
  const Vec3 size = bounds.max - bounds.min;
  return config::usual_cutter(std::max({size.x, size.y, size.z}));
}

}  // namespace

struct SuggestCommand::Options {
  CLI::App* command = nullptr;
  std::string stl, machine, cutter, output, report, progress;
  std::vector<std::string> bodies;  // of the part, as a desk asks: what it shows has its own job
  double unit_mm = 1.0;
  std::size_t pick = 1;
  bool json = false;

  Result<void> work() const;
};

SuggestCommand::SuggestCommand(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.command =
      app.add_subcommand("suggest", "propose axis modes and set-ups for a part, by what the cutter reaches");
  o.command->add_option("STL", o.stl, "part (STL, OBJ, PLY, 3MF, STEP, IGES)")->required();
  o.command->add_option("--machine", o.machine, "machine profile (YAML): its limits hold; --out needs it");
  o.command->add_option(
      "--cutter", o.cutter,
      "as in a job, \"type: ball, diameter_mm: 6, length_mm: 120, shank_length_mm: 50\", or "
      "TYPE:DIAMETER, as ball:6; else a ball of a 40th of the part's length");
  o.command->add_option("--unit", o.unit_mm, "unit of an STL, OBJ or PLY: mm (default), inch, m")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, double>{{"mm", 1.0}, {"inch", 25.4}, {"m", 1000.0}}));
  o.command->add_option("--report", o.report, "the same as --json, into a file");
  o.command->add_option("--progress", o.progress)->group("");
  o.command->add_option("--body", o.bodies)->group("");
  o.command->add_flag("--json", o.json, "print one JSON object");
  o.command->add_option("--out", o.output, "job file to write, for `tiltfeed plan`");
  o.command->add_option("--pick", o.pick, "which proposal --out takes; 1, the best, if not given")
      ->check(above_zero);
}
SuggestCommand::~SuggestCommand() = default;

bool SuggestCommand::called() const { return options_->command->parsed(); }

int SuggestCommand::run() const {
  if (const auto done = options_->work(); !done) return complain(done.error());
  return kExitDone;
}

Result<void> SuggestCommand::Options::work() const {
  if (!output.empty() && machine.empty())
    return fail(Code::kUsage, "--out writes a job, and a job names a machine: add --machine PROFILE");
  if (auto ok = config::check_outputs({{"--out", output}, {"--report", report}},
                                      {{"STL", stl}, {"--machine", machine}});
      !ok)
    return ok;
  const Result<int> to = open_progress(progress, {{"--out", output}, {"--report", report}});
  if (!to) return tl::unexpected(to.error());
  std::optional<config::MachineProfile> profile;
  if (!machine.empty()) {
    auto loaded = config::load_machine(machine);
    if (!loaded) return tl::unexpected(loaded.error());
    profile = std::move(*loaded);
  }
  const auto start = std::chrono::steady_clock::now();
  const auto read = config::read_part_file({stl, unit_mm, bodies});
  if (!read) return tl::unexpected(read.error());
  for (const std::string& note : pathgen::notes_on(*read)) std::cerr << note << "\n";
  const auto part = pathgen::check_mesh(read->mesh);
  if (!part) return tl::unexpected(part.error());
  const auto named = config::parse_cutter(cutter.empty() ? usual_ball(part->bounds) : cutter);
  if (!named) return tl::unexpected(named.error());
  pathgen::SuggestOptions asked;
  asked.tool.cutter = named->cutter;
  asked.machine = profile ? &profile->model : nullptr;
  Result<pathgen::Suggestions> found;
  {
    ProgressLine line(*to);
    found = pathgen::suggest(*part, asked,
                             [&](const char* stage, double share) { return line.show(stage, share); });
  }
  if (!found) return tl::unexpected(found.error());
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const SuggestionOutcome outcome{stl,    unit_mm, *part, *named, profile ? &*profile : nullptr,
                                  *found, seconds};
  if (!output.empty()) {
    if (pick > found->proposals.size())
      return fail(Code::kUsage, "--pick " + std::to_string(pick) + ": there are " +
                                    std::to_string(found->proposals.size()) + " proposals");
    const std::string text = config::new_job_text(job_of(outcome, pick - 1, output));
    // What is written is read back first.
    if (const auto job = config::parse_job(text, output); !job) return tl::unexpected(job.error());
    auto file = config::OutputFile::open(output);
    if (!file) return tl::unexpected(file.error());
    file->stream() << text;
    if (auto kept = file->commit(); !kept) return kept;
  }
  if (!report.empty())
    if (auto kept = config::write_file(report, suggestion_json(outcome)); !kept) return kept;
  for (const std::string& warning : part->warnings) std::cerr << "warning: " << warning << "\n";
  (output == "-" || report == "-" ? std::cerr : std::cout)
      << (json ? suggestion_json(outcome) : suggestion_text(outcome));
  return {};
}

}  // namespace tiltfeed::daemon
