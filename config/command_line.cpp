#include "config/command_line.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "config/key_names.h"

namespace tiltfeed::config {

namespace {

using nlohmann::ordered_json;

CommandOption describe(const CLI::Option& option) {
  CommandOption one;
  one.positional = option.get_positional();
  for (const std::string& name : option.get_snames()) one.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) one.names.push_back("--" + name);
  if (one.positional) one.names = {option.get_name(true)};
  one.text = option.get_description();
  one.required = option.get_required();
  if (option.get_expected_max() > 0 && option.get_type_size_max() > 0) {
    const std::string type = option.get_type_name();
    one.number = type.starts_with("UINT") || type.starts_with("INT");
    one.value = one.number || type.starts_with("FLOAT") ? "NUMBER" : "TEXT";
    if (type.find('{') != type.npos) one.value = "WORD";  // one of a list
    if (const std::size_t limits = type.find('['); limits != type.npos)
      one.text += ", " + type.substr(limits + 1, type.rfind(']') - limits - 1);
    if (const std::string usual = option.get_default_str(); !usual.empty()) one.text += " (" + usual + ")";
  }
  return one;
}

std::vector<const CLI::App*> shown_commands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* one) { return !one->get_group().empty(); });
}

/// Where a word was not understood: the innermost command that was given.
struct Stray {
  const CLI::App* app;
  std::string path, word;
};

Stray stray_in(const CLI::App& app, const std::string& path) {
  for (const CLI::App* const inner : app.get_subcommands())
    if (Stray found = stray_in(*inner, path + " " + inner->get_name()); !found.word.empty()) return found;
  const std::vector<std::string> left = app.remaining(false);
  return {&app, path, left.empty() ? "" : left.front()};
}

std::vector<std::string> words_of(const CLI::App& app, bool options) {
  std::vector<std::string> words;
  if (!options)
    for (const CLI::App* const one : shown_commands(app)) words.push_back(one->get_name());
  if (options)
    for (const CLI::Option* const one : app.get_options())
      if (!one->get_group().empty())
        for (const std::string& name : one->get_lnames()) words.push_back("--" + name);
  return words;
}

std::string program_name(const CLI::App& app) {
  const std::string name = app.get_name();
  return name.substr(name.rfind('/') + 1);
}

}  // namespace

Command describe_command_line(const CLI::App& app, const std::string& name) {
  Command command{name, app.get_description(), {}, {}};
  for (const CLI::Option* const option : app.get_options())
    if (!option->get_group().empty()) command.options.push_back(describe(*option));
  for (const CLI::App* const inner : shown_commands(app))
    command.commands.push_back(describe_command_line(*inner, inner->get_name()));
  return command;
}

namespace {

ordered_json as_json(const Command& command) {
  ordered_json object = {{"name", command.name},
                         {"text", command.text},
                         {"options", ordered_json::array()},
                         {"commands", ordered_json::array()}};
  for (const CommandOption& one : command.options)
    object["options"].push_back({{"names", one.names},
                                 {"value", one.value},
                                 {"text", one.text},
                                 {"positional", one.positional},
                                 {"required", one.required},
                                 {"number", one.number}});
  for (const Command& inner : command.commands) object["commands"].push_back(as_json(inner));
  return object;
}

Command from_json(const ordered_json& object) {
  Command command{object.at("name"), object.at("text"), {}, {}};
  for (const ordered_json& one : object.at("options"))
    command.options.push_back({one.at("names"), one.at("value"), one.at("text"), one.at("positional"),
                               one.at("required"), one.at("number")});
  for (const ordered_json& inner : object.at("commands")) command.commands.push_back(from_json(inner));
  return command;
}

}  // namespace

std::string command_json(const Command& command) { return as_json(command).dump(); }

Result<Command> read_command_json(const std::string& text) {
  try {
    return from_json(ordered_json::parse(text));
  } catch (const ordered_json::exception& error) {
    return fail(Code::kInput, std::string("no description of a command line: ") + error.what());
  }
}

bool report_parse_end(const CLI::App& app, const CLI::ParseError& error) {
  const std::string name = program_name(app);
  const Stray stray = error.get_exit_code() == 0 ? Stray{&app, name, ""} : stray_in(app, name);
  if (stray.word.empty()) return app.exit(error) == 0;
  const bool option = stray.word.starts_with("-");
  const std::vector<std::string> known = words_of(*stray.app, option);
  const std::string word = stray.word.substr(0, option ? stray.word.find('=') : stray.word.npos);
  std::cerr << stray.path << ": " << (option ? "there is no option " : "not understood: ") << word;
  if (!known.empty()) std::cerr << "; the nearest is " << nearest_key(word, known);
  std::cerr << "\nRun with --help for more information.\n";
  return false;
}

}  // namespace tiltfeed::config
