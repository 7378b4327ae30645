#include "sim/control/smoothing_words.h"

#include <cstdlib>
#include <string>

namespace tiltfeed::sim {
namespace {

using config::Dialect;

/// With a number behind it, or nothing.
bool is_word(std::string_view line, std::string_view word) {
  return line == word || (line.starts_with(word) && line[word.size()] == ' ');
}

}  // namespace

bool smooths(std::string_view line, Dialect dialect) {
  switch (dialect) {
    case Dialect::kFanuc:
      return line.starts_with("G5.1 Q");
    case Dialect::kHaas:
      return is_word(line, "G187");
    case Dialect::kSiemens:
      return line.starts_with("CYCLE832(");
    case Dialect::kHeidenhain:
      return line.starts_with("CYCL DEF 32.");
    case Dialect::kHeidenhainIso:
      return is_word(line, "G62");
    case Dialect::kRs274:
    case Dialect::kGrbl:
      break;
  }
  return false;
}

std::optional<bool> smoothing_after(std::string_view line, Dialect dialect) {
  if (!smooths(line, dialect)) return std::nullopt;
  switch (dialect) {
    case Dialect::kFanuc:
      return line != "G5.1 Q0";
    case Dialect::kSiemens:
      return !line.starts_with("CYCLE832(0,0");
    case Dialect::kHeidenhain:
      // The first line of the cycle says that a tolerance comes.
      if (!line.starts_with("CYCL DEF 32.1")) return std::nullopt;
      return line.find('T') != line.npos;
    default:
      return line.find(' ') != line.npos;
  }
}

std::optional<double> smoothing_within(std::string_view line, Dialect dialect) {
  const std::string_view mark = dialect == Dialect::kHaas            ? " E"
                                : dialect == Dialect::kSiemens       ? "CYCLE832("
                                : dialect == Dialect::kHeidenhain    ? "32.1 T"
                                : dialect == Dialect::kHeidenhainIso ? " T"
                                                                     : "";
  const std::size_t at = mark.empty() ? line.npos : line.find(mark);
  if (!smooths(line, dialect) || at == line.npos) return std::nullopt;
  return std::strtod(std::string(line.substr(at + mark.size())).c_str(), nullptr);
}

}  // namespace tiltfeed::sim
