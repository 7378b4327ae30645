#include "sim/control/smoothing_words.h"

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

}  // namespace tiltfeed::sim
