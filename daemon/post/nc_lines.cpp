#include "daemon/post/nc_lines.h"

#include <sstream>

namespace tiltfeed::daemon {

std::optional<std::string> strip_line(std::string& line, config::Dialect dialect,
                                      std::vector<std::string>& comments) {
  while (!line.empty() && line.back() == ' ') line.pop_back();
  if (const auto semicolon = line.find(';'); semicolon != std::string::npos) {
    comments.push_back(line.substr(semicolon + 1));
    line.resize(semicolon);
  }
  // A Sinumerik's parentheses hold arguments.
  const bool brackets = dialect != config::Dialect::kSiemens;
  for (auto open = line.find('('); brackets && open != std::string::npos; open = line.find('(')) {
    const auto close = line.find(')', open);
    if (close == std::string::npos) return "comment without ')'";
    comments.push_back(line.substr(open + 1, close - open - 1));
    line.erase(open, close - open + 1);
  }
  while (!line.empty() && (line.back() == '*' || line.back() == ' ')) line.pop_back();
  std::size_t from = 0;
  const bool plain = dialect == config::Dialect::kHeidenhain;
  if (!plain && !line.empty() && line[0] == 'N') from = 1;
  if (plain || from == 1)
    while (from < line.size() && line[from] >= '0' && line[from] <= '9') ++from;
  line.erase(0, from);
  while (!line.empty() && line.front() == ' ') line.erase(0, 1);
  return std::nullopt;
}

void take_header(std::string_view comment, NcProgram& program) {
  std::istringstream in{std::string(comment)};
  std::string mark, word;
  if (!(in >> mark) || mark != "TILTFEED" || !(in >> word)) return;
  TextOperation& operation = program.operations.back();
  if (word == "part") {
    in >> word;
    Vec3 v;
    if (word == "zero" && in >> v.x >> v.y >> v.z) operation.part_zero = v;
    if (word == "zero" || !program.name.empty()) return;
    program.name = word;
    while (in >> word) {
      double value = 0.0;
      if (word.size() > 1 && word[0] == 'D' && std::istringstream(word.substr(1)) >> value)
        operation.diameter = value;
    }
  } else if (word == "tool" && in >> word && word == "length") {
    double value = 0.0;
    if (!(in >> value)) return;
    if (!operation.blocks.empty()) program.operations.emplace_back();
    program.operations.back().tool_length = value;
  } else if (word == "each") {
    program.own_offsets =
        program.own_offsets || comment.find("each plane has its own work offset") != comment.npos;
  } else if (word == "fixture") {
    Vec3 v;
    if (in >> v.x >> v.y >> v.z) operation.fixture_deg = v;
  }
}

}  // namespace tiltfeed::daemon
