#include "daemon/manual/sources.h"

#include <sstream>

#include "config/job_catalogue.h"
#include "config/machine_files.h"

namespace tiltfeed::daemon {

namespace {

using config::Command;
using config::CommandOption;

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::string without_stop(std::string text) {
  while (!text.empty() && text.back() == '.') text.pop_back();
  return text;
}

std::string term_of(const CommandOption& option) {
  std::string term;
  for (const std::string& name : option.names) term += (term.empty() ? "" : ", ") + name;
  return term + (option.value.empty() || option.positional ? "" : " " + option.value);
}

std::string call_of(const Command& command, const std::string& name) {
  std::string call = name;
  for (const CommandOption& one : command.options)
    if (!one.positional && one.required) call += " " + one.names.back() + " " + one.value;
  call += " [OPTIONS]";
  for (const CommandOption& one : command.options)
    if (one.positional) call += one.required ? " " + one.names[0] : " [" + one.names[0] + "]";
  return call + (command.commands.empty() ? "" : " COMMAND");
}

void add_options(const Command& command, std::vector<Part>& parts) {
  for (const CommandOption& one : command.options)
    parts.push_back(
        {PartKind::kItem, one.text + (one.required && !one.positional ? " (required)" : ""), term_of(one)});
}

void add_commands(const Command& command, const std::string& name, std::vector<Part>& parts) {
  for (const Command& inner : command.commands) {
    const std::string own = name + " " + inner.name;
    parts.push_back({PartKind::kSubheading, call_of(inner, own)});
    parts.push_back({PartKind::kText, inner.text});
    add_options(inner, parts);
    add_commands(inner, own, parts);
  }
}

/// Without marks of Markdown: **bold**, `code`, [text](address).
std::string plain_words(const std::string& text) {
  std::string out;
  bool code = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '`') {
      code = !code;
    } else if (!code && text.compare(i, 2, "**") == 0) {
      ++i;
    } else if (!code && text.compare(i, 2, "](") == 0 && text.find(')', i) != text.npos) {
      i = text.find(')', i);
    } else if (code || text[i] != '[' || text.find("](", i) == text.npos) {
      out += text[i];
    }
  }
  return out;
}

std::vector<std::string> cells(const std::string& row) {
  std::vector<std::string> found;
  std::string cell;
  bool code = false;
  for (std::size_t i = 1; i < row.size(); ++i) {
    if (row[i] == '`') code = !code;
    if (row[i] != '|' || code) {
      cell += row[i];
      continue;
    }
    const std::size_t from = cell.find_first_not_of(' ');
    found.push_back(
        from == cell.npos ? "" : plain_words(cell.substr(from, cell.find_last_not_of(' ') - from + 1)));
    cell.clear();
  }
  return found;
}

/// A table row as an item: its first cell, then the others, behind their headings where there are several.
Part row_part(const std::vector<std::string>& head, const std::vector<std::string>& row) {
  Part part{PartKind::kItem, "", row.empty() ? "" : row[0]};
  for (std::size_t i = 1; i < row.size(); ++i) {
    const bool named = row.size() > 2 && i < head.size() && !head[i].empty();
    part.text += (part.text.empty() ? "" : "; ") + (named ? head[i] + ": " : "") + row[i];
  }
  return part;
}

/// The lines of a Markdown file, one after the other.
class MarkdownReader {
 public:
  explicit MarkdownReader(std::vector<Part>& parts) : parts_(parts) {}

  void take(const std::string& line) {
    const bool fence = line.starts_with("```");
    if (fence || source_) return take_source(line, fence);
    const bool row = line.starts_with("|");
    if (!row) head_.clear();
    if (row) {
      take_row(line);
    } else if (line.starts_with("#")) {
      const std::size_t depth = line.find_first_not_of('#');
      begin(depth <= 2 ? PartKind::kHeading : PartKind::kSubheading, line.substr(depth));
      open_ = false;
    } else if (line.starts_with("* ")) {
      begin(PartKind::kItem, line.substr(2));
    } else if (line.find_first_not_of(' ') == line.npos) {
      open_ = false;
    } else if (open_) {
      parts_.back().text += " " + plain_words(line);
    } else {
      begin(PartKind::kText, line);
    }
  }

 private:
  void begin(PartKind kind, const std::string& line) {
    const std::size_t from = line.find_first_not_of(' ');
    parts_.push_back({kind, plain_words(from == line.npos ? "" : line.substr(from))});
    open_ = true;
  }
  void take_source(const std::string& line, bool fence) {
    if (!fence) {
      parts_.back().text += line + "\n";
    } else {
      source_ = !source_;
      open_ = false;
      if (source_) parts_.push_back({PartKind::kSource, ""});
    }
  }
  void take_row(const std::string& line) {
    open_ = false;
    if (head_.empty()) {
      head_ = cells(line);
    } else if (line.find_first_not_of("|-: ") != line.npos) {
      parts_.push_back(row_part(head_, cells(line)));
    }
  }

  std::vector<Part>& parts_;
  std::vector<std::string> head_;  // of the table that is open
  bool source_ = false, open_ = false;
};

}  // namespace

Page command_page(const Command& command, const std::string& name, bool deep) {
  Page page{name, 1, without_stop(first_line(command.text)), {}};
  for (char& c : page.name)
    if (c == ' ') c = '-';
  page.parts = {{PartKind::kHeading, "synopsis"},
                {PartKind::kText, call_of(command, name)},
                {PartKind::kHeading, "description"},
                {PartKind::kText, command.text}};
  if (!command.options.empty()) page.parts.push_back({PartKind::kHeading, "options"});
  add_options(command, page.parts);
  if (command.commands.empty()) return page;
  page.parts.push_back({PartKind::kHeading, "commands"});
  if (deep) return add_commands(command, name, page.parts), page;
  for (const Command& inner : command.commands)
    page.parts.push_back({PartKind::kItem, inner.text, name + " " + inner.name});
  return page;
}

Page keys_page(const std::string& name, const std::string& what, const std::string& text) {
  Page page{name, 5, what, {{PartKind::kHeading, "description"}}};
  std::istringstream lines(text);
  std::string above;
  for (std::string line; std::getline(lines, line) && line.starts_with("#");)
    above += " " + line.substr(std::min<std::size_t>(2, line.size()));
  page.parts.push_back({PartKind::kText, above});
  page.parts.push_back({PartKind::kHeading, "keys"});
  page.parts.push_back({PartKind::kText, "Each with a value as an example; sections are before the point."});
  for (const config::DescribedKey& key : config::described_keys(text))
    page.parts.push_back(
        {PartKind::kItem, key.words, key.path + (key.value.empty() ? "" : ": " + key.value)});
  return page;
}

Page markdown_page(const std::string& name, const std::string& what, const std::string& text) {
  Page page{name, 7, what, {}};
  MarkdownReader reader(page.parts);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) reader.take(line);
  return page;
}

std::vector<Topic> topics() {
  std::vector<Topic> all = {
      {"job-file", keys_page("tiltfeed-job-file", "what is made, and how", config::example_job_text())}};
  for (const config::MachineFile& machine : config::machine_files())
    if (std::string(machine.name) == "generic-ac")
      all.push_back({"machine-profile", keys_page("tiltfeed-machine-profile",
                                                  "what the shop knows of a machine", machine.text)});
  all.push_back({"tools-file", keys_page("tiltfeed-tools-file", "the tools of a shop",
                                         shipped_text("config/tools/example.yaml"))});
  all.push_back({"service-file", keys_page("tiltfeed-service-file", "the service of one machine",
                                           shipped_text("config/service.yaml"))});
  all.push_back({"desk-file", keys_page("tiltfeed-desk-file", "where the page is served, and to whom",
                                        shipped_text("config/desk.yaml"))});
  all.push_back({"api", markdown_page("tiltfeed-api", "requests on the service's socket",
                                      shipped_text("daemon/service/API.md"))});
  all.push_back({"modbus", markdown_page("tiltfeed-modbus", "the ring and the plain drive, maps of registers",
                                         shipped_text("daemon/wire/MODBUS.md"))});
  all.push_back(
      {"controls", markdown_page("tiltfeed-controls", "tilted planes, arcs and other options of controls",
                                 shipped_text("daemon/post/CONTROLS.md"))});
  return all;
}

}  // namespace tiltfeed::daemon
