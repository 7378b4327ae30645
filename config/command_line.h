#pragma once
// A program's command line as data: what its manual page, its help and its completion are made of, and what a
// misspelt word is held against. The description is the one that the parser itself has.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace tiltfeed::config {

struct CommandOption {
  std::vector<std::string> names;  ///< "--out", "-h"; of a positional its one word, "JOB"
  std::string value;               ///< "TEXT"; empty for a flag
  std::string text;
  bool positional = false, required = false, number = false;  ///< number: a whole one
};

/// Without what is hidden.
struct Command {
  std::string name, text;
  std::vector<CommandOption> options;
  std::vector<Command> commands;
};

/// The word that makes a program print its description (JSON) and end.
inline constexpr const char* kDescribeWord = "--describe-command-line";

Command describe_command_line(const CLI::App& app, const std::string& name);
std::string command_json(const Command& command);
/// What command_json wrote. Errors: kInput.
Result<Command> read_command_json(const std::string& text);

/// Help and version go to standard output; of a wrong word the nearest right one is told, on standard error.
/// True where the user asked for what was shown.
bool report_parse_end(const CLI::App& app, const CLI::ParseError& error);

}  // namespace tiltfeed::config
