#include "daemon/command/manual_command.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "config/beside_program.h"
#include "config/command_line.h"
#include "config/key_names.h"
#include "config/output_file.h"
#include "daemon/command/command.h"
#include "daemon/doctor/host.h"
#include "daemon/manual/completion.h"
#include "daemon/manual/sources.h"

namespace tiltfeed::daemon {

namespace {

using config::Command;

/// Of a program beside this one, by itself. Errors: kIo, kInput.
Result<Command> description_of(const std::string& program) {
  const Result<std::string> file = config::program_beside(program);
  if (!file) return tl::unexpected<Error>(file.error());
  const std::string text = output_of(*file, {config::kDescribeWord});
  if (text.empty()) return fail(Code::kIo, *file + ": does not start; it belongs beside tiltfeed");
  return config::read_command_json(text);
}

Command* find(Command& in, const std::string& name) {
  const auto found = std::find_if(in.commands.begin(), in.commands.end(),
                                  [&](const Command& one) { return one.name == name; });
  return found == in.commands.end() ? nullptr : &*found;
}

/// All programs; the commands that tiltfeed hands over have the words of who carries them out.
Result<std::vector<Command>> all_programs(const CLI::App& app) {
  std::vector<Command> programs = {config::describe_command_line(app, "tiltfeed")};
  const auto take = [&](Command& command, const Command& from) {
    command.options = from.options;
    command.commands = from.commands;
  };
  for (const auto& [name, word] : {std::pair("tiltfeed-sim", "verify"), std::pair("tiltfeed-desk", "desk"),
                                   std::pair("tiltfeed-cad", "")}) {
    const Result<std::string> file = config::program_beside(name);
    if (name != std::string("tiltfeed-sim") && file && ::access(file->c_str(), F_OK) != 0) continue;
    Result<Command> other = description_of(name);
    if (!other) return tl::unexpected<Error>(other.error());
    Command* const here = find(programs[0], word);
    const Command* const there = find(*other, word);
    if (here != nullptr) take(*here, there != nullptr ? *there : *other);
    programs.push_back(std::move(*other));
  }
  return programs;
}

std::vector<Page> pages_of(const std::vector<Command>& programs) {
  std::vector<Page> pages = {command_page(programs[0], "tiltfeed", false)};
  for (const Command& command : programs[0].commands)
    if (command.name != "desk") pages.push_back(command_page(command, "tiltfeed " + command.name, true));
  for (std::size_t i = 1; i < programs.size(); ++i)
    pages.push_back(command_page(programs[i], programs[i].name, true));
  for (Topic& topic : topics()) pages.push_back(std::move(topic.page));
  for (Page& page : pages) {
    page.parts.push_back({PartKind::kHeading, "see also"});
    page.parts.push_back({PartKind::kText, page.name == "tiltfeed"
                                               ? "tiltfeed-sim(1), tiltfeed-desk(1), tiltfeed-cad(1), "
                                                 "tiltfeed-job-file(5), "
                                                 "tiltfeed-machine-profile(5), tiltfeed-tools-file(5), "
                                                 "tiltfeed-service-file(5), "
                                                 "tiltfeed-desk-file(5), "
                                                 "tiltfeed-api(7), tiltfeed-modbus(7), tiltfeed-controls(7)"
                                               : "tiltfeed(1)"});
  }
  return pages;
}

Result<void> put(const std::string& path, const std::string& text) {
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), error);
  if (error) return fail(Code::kIo, path + ": " + error.message());
  return config::write_file(path, text);
}

}  // namespace

struct ManualCommand::Options {
  explicit Options(CLI::App& line) : app(line) {}
  CLI::App &app, *help = nullptr, *write = nullptr;
  std::string version, topic, folder, date;
  bool as_json = false;

  int run_help() const;
  int show(const Page& page) const;
  Result<void> run_write() const;
};

ManualCommand::ManualCommand(CLI::App& app, const std::string& version)
    : options_(std::make_unique<Options>(app)) {
  Options& o = *options_;
  o.version = version;
  std::string names;
  for (const Topic& topic : topics()) names += (names.empty() ? "" : ", ") + topic.name;
  o.help = app.add_subcommand("help", "a command, a kind of file or a protocol, as in its manual page");
  o.help->add_option("TOPIC", o.topic, "a command; or " + names);
  o.help->add_flag("--json", o.as_json, "print one JSON object");
  o.write = app.add_subcommand("write-manual", "manual pages and completion, as below /usr/share")->group("");
  o.write->add_option("FOLDER", o.folder)->required();
  o.write->add_option("--date", o.date)->required();
}

ManualCommand::~ManualCommand() = default;

bool ManualCommand::called() const { return options_->help->parsed() || options_->write->parsed(); }

int ManualCommand::run() const {
  if (options_->help->parsed()) return options_->run_help();
  const Result<void> written = options_->run_write();
  return written ? kExitDone : complain(written.error());
}

int ManualCommand::Options::show(const Page& page) const {
  const std::string text = plain_text(page);
  if (as_json)
    return show_json(nlohmann::ordered_json({{"name", page.name}, {"text", text}})
                         .dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
  std::cout << text;
  return kExitDone;
}

int ManualCommand::Options::run_help() const {
  for (const Topic& one : topics())
    if (one.name == topic) return show(one.page);
  const Result<std::vector<Command>> programs = all_programs(app);
  if (!programs) return complain(programs.error());
  if (topic.empty()) return show(command_page(programs->front(), "tiltfeed", false));
  std::vector<std::string> known;
  for (const Command& one : programs->front().commands) {
    if (one.name == topic) return show(command_page(one, "tiltfeed " + one.name, true));
    known.push_back(one.name);
  }
  for (const Topic& one : topics()) known.push_back(one.name);
  return complain(
      {Code::kUsage, "there is no topic " + topic + "; the nearest is " + config::nearest_key(topic, known)});
}

Result<void> ManualCommand::Options::run_write() const {
  const Result<std::vector<Command>> programs = all_programs(app);
  if (!programs) return tl::unexpected<Error>(programs.error());
  std::vector<std::pair<std::string, std::string>> files;
  for (const Page& page : pages_of(*programs))
    files.emplace_back("man/man" + std::to_string(page.section) + "/" + page.file(),
                       man_text(page, date, version));
  for (const Command& one : *programs) {
    files.emplace_back("bash-completion/completions/" + one.name, bash_completion(one));
    files.emplace_back("zsh/vendor-completions/_" + one.name, zsh_completion(one));
    files.emplace_back("fish/vendor_completions.d/" + one.name + ".fish", fish_completion(one));
  }
  for (const auto& [path, text] : files)
    if (const Result<void> written = put(folder + "/" + path, text); !written) return written;
  return {};
}

}  // namespace tiltfeed::daemon
