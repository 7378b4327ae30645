#include "daemon/manual/completion.h"

#include <algorithm>

namespace tiltfeed::daemon {

namespace {

using config::Command;
using config::CommandOption;

/// Prints the numbers of the service's jobs; nothing where no service answers.
constexpr const char* kJobs = "tiltfeed list 2>/dev/null | sed -n '2,$s/^ *\\([0-9][0-9]*\\) .*/\\1/p'";

/// What can follow the words `path` ("machine jog").
struct Place {
  std::string path;
  const Command* command;
};

void collect(const Command& command, const std::string& path, std::vector<Place>& places) {
  places.push_back({path, &command});
  for (const Command& inner : command.commands)
    collect(inner, path.empty() ? inner.name : path + " " + inner.name, places);
}

std::vector<Place> places_of(const Command& program) {
  std::vector<Place> places;
  collect(program, "", places);
  return places;
}

bool takes_job(const Command& command) {
  return std::any_of(command.options.begin(), command.options.end(), [](const CommandOption& one) {
    return one.positional && one.number && one.names[0] == "JOB";
  });
}

/// Within '...' of sh.
std::string sh_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

/// Within '...' of fish.
std::string fish_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + "'";
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string function_of(const Command& program) {
  std::string name = "_" + program.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

/// A pattern of `case` that all paths of the program match, but for the empty one.
std::string known_paths(const std::vector<Place>& places) {
  std::string pattern;
  for (const Place& place : places)
    if (!place.path.empty()) pattern += (pattern.empty() ? "" : "|") + sh_quoted(place.path);
  return pattern.empty() ? "''" : pattern;
}

std::string words_of(const Command& command) {
  std::string words;
  for (const Command& inner : command.commands) words += " " + inner.name;
  for (const CommandOption& one : command.options)
    if (!one.positional) words += " " + one.names.back();
  return words.empty() ? words : words.substr(1);
}

}  // namespace

std::string bash_completion(const Command& program) {
  const std::vector<Place> places = places_of(program);
  const std::string function = function_of(program);
  std::string out = "# bash completion of " + program.name + "\n" + function +
                    "() {\n  local cur=${COMP_WORDS[COMP_CWORD]} path='' words='' i next\n"
                    "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
                    "    next=\"${path:+$path }${COMP_WORDS[i]}\"\n    case $next in\n      " +
                    known_paths(places) + ") path=$next ;;\n    esac\n  done\n  case $path in\n";
  for (const Place& place : places) {
    out += "    " + sh_quoted(place.path) + ") words=" + sh_quoted(words_of(*place.command));
    if (takes_job(*place.command))
      out += "\n      [[ $cur == -* ]] || words=\"$(" + std::string(kJobs) + ") $words\"";
    out += " ;;\n";
  }
  return out +
         "  esac\n  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$cur\")\n}\n"
         "complete -o bashdefault -o default -F " +
         function + " " + program.name + "\n";
}

std::string zsh_completion(const Command& program) {
  const std::vector<Place> places = places_of(program);
  std::string out =
      "#compdef " + program.name +
      "\nlocal at='' next\ninteger i\nlocal -a list\n"
      "for ((i = 2; i < CURRENT; ++i)); do\n  next=\"${at:+$at }${words[i]}\"\n  case $next in\n    (" +
      known_paths(places) + ") at=$next ;;\n  esac\ndone\ncase $at in\n";
  const auto entry = [](const std::string& name, const std::string& text) {
    return "\n      " + sh_quoted(name + ":" + one_line(text));
  };
  for (const Place& place : places) {
    out += "  (" + sh_quoted(place.path) + ")\n    list=(";
    for (const Command& inner : place.command->commands) out += entry(inner.name, inner.text);
    for (const CommandOption& one : place.command->options)
      if (!one.positional) out += entry(one.names.back(), one.text);
    out += ")\n";
    if (takes_job(*place.command)) out += "    list+=(${(f)\"$(" + std::string(kJobs) + ")\"})\n";
    out += "    ;;\n";
  }
  return out + "esac\n_describe '" + program.name + "' list\n_files\n";
}

std::string fish_completion(const Command& program) {
  const std::vector<Place> places = places_of(program);
  const std::string function = "_" + function_of(program) + "_at";
  std::string paths;
  for (const Place& place : places)
    if (!place.path.empty()) paths += " " + fish_quoted(place.path);
  std::string out = "# fish completion of " + program.name + "\nfunction " + function +
                    "\n    set -l at ''\n    for word in (commandline -opc)[2..-1]\n"
                    "        set -l next (string trim -- \"$at $word\")\n"
                    "        contains -- $next" +
                    paths + "\n        and set at $next\n    end\n    test \"$at\" = \"$argv[1]\"\nend\n";
  for (const Place& place : places) {
    const std::string begin =
        "complete -c " + program.name + " -n " + fish_quoted(function + " \"" + place.path + "\"");
    for (const Command& inner : place.command->commands)
      out += begin + " -a " + inner.name + " -d " + fish_quoted(one_line(inner.text)) + "\n";
    for (const CommandOption& one : place.command->options) {
      if (one.positional) continue;
      out += begin + " -l " + one.names.back().substr(2) + (one.value.empty() ? "" : " -r") + " -d " +
             fish_quoted(one_line(one.text)) + "\n";
    }
    if (takes_job(*place.command)) out += begin + " -a " + fish_quoted("(" + std::string(kJobs) + ")") + "\n";
  }
  return out;
}

}  // namespace tiltfeed::daemon
