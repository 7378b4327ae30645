#include "daemon/command/init_command.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "config/job.h"
#include "config/output_file.h"
#include "config/part_reading.h"
#include "daemon/command/command.h"
#include "daemon/command/progress_line.h"
#include "daemon/plan/first_job.h"
#include "pathgen/mesh/mesh_check.h"

namespace tiltfeed::daemon {

struct InitCommand::Options {
  CLI::App* command = nullptr;
  std::string part, machine, tools, material, output, progress;
  bool json = false;
  double unit_mm = 1.0;

  Result<void> work() const;
};

InitCommand::InitCommand(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.command = app.add_subcommand("init", "write the first job of a part, with the questions that are yours");
  o.command->add_option("PART", o.part, "part, as in a job")->required();
  o.command->add_option("--machine", o.machine, "machine profile (YAML)")->required();
  o.command->add_option("--tools", o.tools, "tool library to choose from; else a ball by rule");
  o.command->add_option("--material", o.material, "of the part: feeds and speed are the tool's for it")
      ->needs("--tools");
  o.command->add_option("--unit", o.unit_mm, "unit of the part's file: mm (default), inch, m")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, double>{{"mm", 1.0}, {"inch", 25.4}, {"m", 1000.0}}));
  o.command->add_option("--out", o.output,
                        "job file to write; default: PART's name with .yaml, in this folder");
  o.command->add_flag("--json", o.json, "print one JSON object");
  o.command->add_option("--progress", o.progress)->group("");
}
InitCommand::~InitCommand() = default;

bool InitCommand::called() const { return options_->command->parsed(); }

int InitCommand::run() const {
  if (const auto done = options_->work(); !done) return complain(done.error());
  return kExitDone;
}

Result<void> InitCommand::Options::work() const {
  namespace fs = std::filesystem;
  const std::string job = output.empty() ? fs::path(part).stem().string() + ".yaml" : output;
  std::error_code none;
  if (job != "-" && fs::exists(job, none))
    return fail(Code::kUsage,
                job + " is there already, and may have answers in it; name another file (--out)");
  const Result<int> to = open_progress(progress, {{"--out", job}});
  if (!to) return tl::unexpected(to.error());
  const auto profile = config::load_machine(machine);
  if (!profile) return tl::unexpected(profile.error());
  std::optional<config::ToolLibrary> library;
  if (!tools.empty()) {
    auto loaded = config::load_tool_library(tools);
    if (!loaded) return tl::unexpected(loaded.error());
    library = std::move(*loaded);
  }
  const auto read = config::read_part_file({part, unit_mm});
  if (!read) return tl::unexpected(read.error());
  const auto checked = pathgen::check_mesh(read->mesh);
  if (!checked) return tl::unexpected(checked.error());
  for (const std::string& warning : checked->warnings) std::cerr << "warning: " << warning << "\n";
  Result<std::string> text;
  {
    ProgressLine line(*to);
    text = first_job({part, unit_mm, *checked, *profile, std::move(library), material, job},
                     [&](const char* stage, double share) { return line.show(stage, share); });
  }
  if (!text) return tl::unexpected(text.error());
  // What is written is read back first.
  if (const auto understood = config::parse_job(*text, job); !understood)
    return tl::unexpected(understood.error());
  auto file = config::OutputFile::open(job);
  if (!file) return tl::unexpected(file.error());
  file->stream() << *text;
  if (auto kept = file->commit(); !kept) return kept;
  if (json)
    (job == "-" ? std::cerr : std::cout) << nlohmann::ordered_json{{"job", job}}.dump() << "\n";
  else if (job != "-")
    std::cout << job << ": answer the lines with QUESTION, then `tiltfeed check " << job
              << "` and `tiltfeed plan " << job << " --out " << fs::path(job).stem().string() << ".nc`\n";
  return {};
}

}  // namespace tiltfeed::daemon
