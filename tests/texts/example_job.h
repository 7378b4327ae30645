#pragma once
// config/jobs/example.yaml line by line, so that tests can use each key or leave it out.

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "config/job.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;

inline const std::string kExample = SOURCE_DIR "/config/jobs/example.yaml";

inline std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A line of the example job. Keys that the example does not use are there as comments: "  # key: value".
struct Line {
  std::string text;     ///< with the key in use
  std::string section;  ///< dotted path, empty at the root
  std::string key;      ///< empty: the line has none
  std::size_t indent = 0;
  bool used = false;               ///< not a comment
  bool explained = false;          ///< by a comment behind it, or in the line above where it opens a section
  std::vector<std::string> users;  ///< the words in "[a, b]" at the comment's start
};

inline std::vector<Line> example_lines() {
  static const std::regex kKey("( *)(# )?(- )?([a-z_]+):( .*)?");
  std::vector<Line> lines;
  std::vector<std::pair<std::size_t, std::string>> open;  // indents and paths of the sections around
  std::istringstream in(text_of(kExample));
  for (std::string text; std::getline(in, text);) {
    Line line;
    line.text = text;
    std::smatch match;
    if (std::regex_match(text, match, kKey) && match.length(1) <= 6) {
      line.used = match.length(2) == 0;
      line.text = match.str(1) + match.str(3) + match.str(4) + ":" + match.str(5);
      line.key = match.str(4);
      line.indent = static_cast<std::size_t>(match.length(1) + match.length(3));
      while (!open.empty() && open.back().first >= line.indent) open.pop_back();
      if (!open.empty()) line.section = open.back().second;
      const std::string rest = match.str(5);
      const std::size_t comment = rest.find('#');
      line.explained = comment != std::string::npos || (!lines.empty() && lines.back().text[0] == '#');
      if (rest.find_first_not_of(' ') == comment)
        open.emplace_back(line.indent, (line.section.empty() ? "" : line.section + ".") + line.key);
      std::string users = comment == std::string::npos ? "" : rest.substr(comment);
      if (users.starts_with("# [")) {
        users = users.substr(3, users.find(']') - 3);
        std::replace(users.begin(), users.end(), ',', ' ');
        std::istringstream words(users);
        line.users = {std::istream_iterator<std::string>(words), {}};
      }
    }
    lines.push_back(line);
  }
  return lines;
}

/// The job with the given lines in use or not.
inline std::string written(const std::vector<Line>& lines) {
  std::string text;
  for (const Line& line : lines) text += (line.key.empty() || line.used ? line.text : "") + "\n";
  return text;
}

inline Result<Job> parse_example(const std::vector<Line>& lines) {
  return parse_job(written(lines), kExample);
}

}  // namespace tiltfeed
