#include "daemon/command/tools_command.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "config/description.h"
#include "config/new_job.h"
#include "config/output_file.h"
#include "config/tool_import.h"
#include "daemon/command/command.h"

namespace tiltfeed::daemon {
namespace {

using nlohmann::ordered_json;

std::string dump(const ordered_json& json) {
  return json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

ordered_json as_json(const config::LibraryTool& tool) {
  ordered_json json = {
      {"id", tool.id}, {"name", tool.name}, {"number", tool.number}, {"flutes", tool.flutes}};
  if (tool.lacks.empty()) json["cutter"] = config::cutter_text(tool.cutter);
  json["lacks"] = tool.lacks;
  json["materials"] = ordered_json::array();
  for (const config::CuttingData& data : tool.data)
    json["materials"].push_back({{"material", data.material},
                                 {"spindle_rpm", data.spindle_rpm},
                                 {"cut_mm_per_min", data.cut_feed},
                                 {"plunge_mm_per_min", data.plunge_feed}});
  return json;
}

std::string as_text(const config::LibraryTool& tool) {
  std::string text = tool.id + (tool.number > 0 ? " (T" + std::to_string(tool.number) + ")" : "") +
                     (tool.name.empty() ? "" : ", " + tool.name);
  text += "\n  " + (tool.lacks.empty() ? config::cutter_text(tool.cutter) : "lacks " + joined(tool.lacks));
  for (const config::CuttingData& data : tool.data)
    text += "\n  in " + data.material + ": " + config::exact_text(data.spindle_rpm) + " 1/min, " +
            config::exact_text(data.cut_feed) + " and " + config::exact_text(data.plunge_feed) + " mm/min";
  return text + "\n";
}

}  // namespace

struct ToolsCommand::Options {
  CLI::App *command = nullptr, *list = nullptr, *import = nullptr;
  std::string library, file, output = "-";
  double unit_mm = 1.0;
  bool json = false;

  Result<void> show() const;
  Result<void> bring_in() const;
};

ToolsCommand::ToolsCommand(CLI::App& app) : options_(std::make_unique<Options>()) {
  Options& o = *options_;
  o.command =
      app.add_subcommand("tools", "a tool library: what is in it, and tools of other programs for it");
  o.command->require_subcommand(1);
  o.list = o.command->add_subcommand("list",
                                     "the tools of a library, and what those lack that no job can use yet");
  o.list->add_option("LIBRARY", o.library, "tool library (YAML)")->required();
  o.list->add_flag("--json", o.json, "print one JSON object");
  o.import = o.command->add_subcommand("import", "a library from the tools of another program");
  o.import
      ->add_option(
          "FILE", o.file,
          "LinuxCNC's tool table (.tbl), a tool bit or library of FreeCAD (.fctb, .fctl), a library of "
          "Fusion 360 exported as JSON (.json)")
      ->required();
  o.import->add_option("--out", o.output, "tool library to write (YAML); standard output if not given");
  o.import->add_option("--unit", o.unit_mm, "of a .tbl: mm or inch, the machine's")
      ->transform(CLI::CheckedTransformer(std::map<std::string, double>{{"mm", 1.0}, {"inch", 25.4}}));
  o.import->add_flag("--json", o.json,
                     "with --out: print what was brought in and what not as one JSON object");
}
ToolsCommand::~ToolsCommand() = default;

bool ToolsCommand::called() const { return options_->command->parsed(); }

int ToolsCommand::run() const {
  const auto done = options_->list->parsed() ? options_->show() : options_->bring_in();
  return done ? kExitDone : complain(done.error());
}

Result<void> ToolsCommand::Options::show() const {
  const auto read = config::load_tool_library(library);
  if (!read) return tl::unexpected(read.error());
  ordered_json all = ordered_json::array();
  for (const config::LibraryTool& tool : read->tools)
    if (json)
      all.push_back(as_json(tool));
    else
      std::cout << as_text(tool);
  if (json) show_json(dump({{"library", library}, {"tools", all}}));
  return {};
}

Result<void> ToolsCommand::Options::bring_in() const {
  if (json && output == "-")
    return fail(Code::kUsage, "--json shows what was done, so the library needs --out FILE");
  if (auto fits = config::check_outputs({{"--out", output}}, {{"FILE", file}}); !fits) return fits;
  config::ImportOptions asked;
  if (import->count("--unit") > 0) asked.unit_mm = unit_mm;
  const auto brought = config::import_tools(file, asked);
  if (!brought) return tl::unexpected(brought.error());
  for (const std::string& note : brought->notes)
    if (!json) std::cerr << "note: " << note << "\n";
  if (brought->tools.empty())
    return fail(Code::kInput, file + ": has no tool that a job can use; nothing was written");
  const std::string text =
      config::tool_library_text(brought->tools, "From " + std::filesystem::path(file).filename().string() +
                                                    " by `tiltfeed tools import`.");
  // What is written is read back first.
  const auto library_read = config::parse_tool_library(text, output);
  if (!library_read) return tl::unexpected(library_read.error());
  if (auto written = config::write_file(output, text); !written) return written;
  ordered_json lacking = ordered_json::object();
  for (const config::LibraryTool& tool : library_read->tools)
    if (!tool.lacks.empty()) lacking[tool.id] = tool.lacks;
  if (json) {
    show_json(dump({{"out", output},
                    {"tools", library_read->tools.size()},
                    {"lacks", lacking},
                    {"notes", brought->notes}}));
    return {};
  }
  std::cerr << library_read->tools.size() << (library_read->tools.size() == 1 ? " tool" : " tools");
  if (!lacking.empty())
    std::cerr << ", of which " << lacking.size()
              << " lack sizes that a job needs; `tiltfeed tools list` names them";
  std::cerr << "\n";
  return {};
}

}  // namespace tiltfeed::daemon
