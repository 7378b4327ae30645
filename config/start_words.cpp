#include "config/start_words.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "config/letters.h"
#include "config/program_lines.h"

namespace tiltfeed::config {
namespace {

/// A letter or a name with its number.
struct Word {
  std::string name, text;
  double value = 0.0;
};

bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }

std::vector<Word> words_of(std::string_view line) {
  std::vector<Word> words;
  for (std::size_t i = 0; i < line.size();) {
    const std::size_t begin = i;
    if (!is_upper(line[i])) {
      ++i;
      continue;
    }
    while (i < line.size() && (is_upper(line[i]) || line[i] == '_')) ++i;
    const bool named = i - begin > 1;
    while (named && i < line.size() && (is_upper(line[i]) || is_digit(line[i]) || line[i] == '_')) ++i;
    Word word{std::string(line.substr(begin, i - begin)), "", 0.0};
    while (i < line.size() &&
           (is_digit(line[i]) || std::string_view(".+-=").find(line[i]) != std::string_view::npos))
      ++i;
    word.text = std::string(line.substr(begin, i - begin));
    const std::size_t number = word.text.find_first_not_of('=', word.name.size());
    if (number != std::string::npos) word.value = std::strtod(word.text.c_str() + number, nullptr);
    words.push_back(std::move(word));
  }
  return words;
}

template <std::size_t N>
bool among(double code, const std::array<double, N>& codes) {
  return std::any_of(codes.begin(), codes.end(), [&](double c) { return std::abs(c - code) < 1e-6; });
}

bool is_tnc(Dialect dialect) { return dialect == Dialect::kHeidenhain || dialect == Dialect::kHeidenhainIso; }

bool known_g(double code, Dialect dialect) {
  // Rapid and reference places in machine coordinates, dwell, high-speed cutting, exact stop, X-Y plane, mm,
  // no compensation, scaling, mirror, work offsets, exact stop and blending, no rotation, no cycle, absolute,
  // relative, and where cycles go back to.
  constexpr std::array kAll{0.0,  4.0,  5.1,  8.0,  9.0,  17.0, 21.0, 28.0, 30.0, 40.0, 49.0,
                            50.0, 50.1, 53.0, 54.0, 55.0, 56.0, 57.0, 58.0, 59.0, 59.1, 59.2,
                            59.3, 61.0, 61.1, 64.0, 69.0, 80.0, 90.0, 91.0, 98.0, 99.0};
  constexpr std::array kFanuc{5.0, 10.6, 54.1};
  constexpr std::array kHaas{103.0, 154.0, 187.0, 255.0, 269.0};
  if (among(code, kAll)) return true;
  switch (dialect) {
    case Dialect::kFanuc:
      return among(code, kFanuc);
    case Dialect::kHaas:
      return among(code, kHaas) || among(code, kFanuc);
    case Dialect::kSiemens: {
      constexpr std::array kSiemens{60.0,  71.0,  601.0, 602.0, 603.0, 641.0,
                                    642.0, 643.0, 644.0, 645.0, 710.0};
      return among(code, kSiemens) || (code >= 505.0 && code <= 599.0);
    }
    case Dialect::kHeidenhainIso:
      return among(code, std::array{31.0, 62.0, 71.0});
    default:
      return false;
  }
}

bool known_m(double code, Dialect dialect) {
  // Spindle, tool change, subprograms and their ends.
  constexpr std::array kNone{2.0, 3.0, 4.0, 6.0, 13.0, 14.0, 17.0, 30.0, 61.0, 97.0, 98.0, 99.0, 198.0};
  if (among(code, kNone)) return false;
  if (!is_tnc(dialect)) return true;
  // Of these controls many M codes change what moves mean.
  return code < 89.0 || (code > 89.0 && code < 93.0) || code >= 200.0;
}

bool known_name(const std::string& name, Dialect dialect) {
  constexpr std::array<std::string_view, 33> kSiemens{
      "ADIS",     "ADISPOS",  "BRISK",      "COMPCAD", "COMPCURV",  "COMPOF",    "COMPON",
      "COMPSURF", "CTOL",     "CYCLE832",   "DRIVE",   "DYNFINISH", "DYNNORM",   "DYNPOS",
      "DYNPREC",  "DYNROUGH", "DYNSEMIFIN", "FFWOF",   "FFWON",     "FIFOCTRL",  "FNORM",
      "FPRAON",   "MSG",      "OTOL",       "SOFT",    "SPATH",     "STARTFIFO", "STOPFIFO",
      "STOPRE",   "SUPA",     "TRAFOOF",    "UPATH",   "WORKPIECE"};
  return dialect == Dialect::kSiemens && std::find(kSiemens.begin(), kSiemens.end(), name) != kSiemens.end();
}

/// Lines of the Klartext that are no words with numbers.
bool known_sentence(const std::string& line) {
  constexpr std::array<std::string_view, 6> kKnown{"CYCL DEF 32", "CYCL DEF 247", "BLK FORM",
                                                   "PLANE RESET", "STOP",         "TOOL DEF"};
  return std::any_of(kKnown.begin(), kKnown.end(),
                     [&](std::string_view known) { return line.substr(0, known.size()) == known; });
}

bool known(const Word& word, Dialect dialect) {
  if (word.name.size() > 1) return known_name(word.name, dialect);
  switch (word.name[0]) {
    case 'G':
      return known_g(word.value, dialect);
    case 'M':
      return known_m(word.value, dialect);
    case 'D':
    case 'H':
      return word.value == 0.0;  // a tool's offset
    case 'L':
      return dialect != Dialect::kSiemens;  // a subprogram
    default:
      return true;
  }
}

}  // namespace

std::optional<std::string> unknown_before_motion(const std::string& line, Dialect dialect) {
  const bool klartext = dialect == Dialect::kHeidenhain;
  if (klartext && known_sentence(line)) return std::nullopt;
  for (const Word& word : words_of(bare(line))) {
    if (klartext && (word.text == "L" || word.name == "FMAX" || word.text == "R0")) continue;
    if (!known(word, dialect) || (klartext && word.name == "G")) return word.text;
  }
  return std::nullopt;
}

}  // namespace tiltfeed::config
