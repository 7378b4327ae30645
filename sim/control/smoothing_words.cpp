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

namespace {

/// The number behind a word of the line; nothing: the word is not there.
std::optional<double> behind(std::string_view line, std::string_view word) {
  const std::size_t at = line.find(word);
  if (at == line.npos) return std::nullopt;
  return std::strtod(std::string(line.substr(at + word.size())).c_str(), nullptr);
}

/// The second number of CYCLE832(.
std::optional<double> cycle_mode(std::string_view line) {
  const std::size_t comma = line.find(',');
  return comma == line.npos ? std::nullopt : behind(line.substr(comma), ",");
}

constexpr double kWithLeans = 10.0;  // a Sinumerik's mode has this added where degrees are stated

}  // namespace

std::optional<bool> is_smoothing_mode(std::string_view line, Dialect dialect, config::Smoothing wanted) {
  if (!smooths(line, dialect) || !smoothing_after(line, dialect).value_or(true)) return std::nullopt;
  const double step = wanted == config::Smoothing::kRough  ? 0.0
                      : wanted == config::Smoothing::kSemi ? 1.0
                                                           : 2.0;
  std::optional<double> stated;
  double meant = step == 0.0 ? 1.0 : 0.0;  // Heidenhain
  if (dialect == Dialect::kHaas) stated = behind(line, " P"), meant = 1.0 + step;
  if (dialect == Dialect::kSiemens) {
    stated = cycle_mode(line), meant = 3.0 - step;
    if (stated && *stated >= kWithLeans) *stated -= kWithLeans;
  }
  if (dialect == Dialect::kHeidenhain) stated = behind(line, "HSC-MODE:");
  if (dialect == Dialect::kHeidenhainIso) stated = behind(line, " P01 ");
  if (!stated) return std::nullopt;
  return *stated == meant;
}

std::optional<double> smoothing_leans(std::string_view line, Dialect dialect) {
  if (!smooths(line, dialect)) return std::nullopt;
  if (dialect == Dialect::kHeidenhain) return behind(line, " TA");
  if (dialect == Dialect::kHeidenhainIso) return behind(line, " P02 ");
  if (dialect != Dialect::kSiemens || cycle_mode(line).value_or(0.0) < kWithLeans) return std::nullopt;
  return behind(line.substr(line.rfind(',')), ",");
}

}  // namespace tiltfeed::sim
