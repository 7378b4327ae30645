#include "config/program_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "config/letters.h"

namespace tiltfeed::config {
namespace {

bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || c == '_'; }

/// The numbers behind a letter that is no part of a word, in tenths: G5.1 is 51.
std::vector<int> codes(const std::string& words, char letter) {
  std::vector<int> found;
  for (std::size_t i = 0; i + 1 < words.size(); ++i)
    if (words[i] == letter && is_digit(words[i + 1]) && (i == 0 || !is_letter(words[i - 1])))
      found.push_back(static_cast<int>(std::lround(10.0 * std::strtod(words.c_str() + i + 1, nullptr))));
  return found;
}

template <std::size_t N>
bool any(const std::vector<int>& codes, const std::array<int, N>& of) {
  return std::any_of(codes.begin(), codes.end(),
                     [&](int code) { return std::find(of.begin(), of.end(), code) != of.end(); });
}

/// The letters of axes that have a number.
std::string axes_of(const std::string& words) {
  constexpr std::string_view kAxes = "XYZABCUVW", kNumber = "0123456789.-+=";
  std::string axes;
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const bool begins = i == 0 || words[i - 1] == ' ' || is_digit(words[i - 1]);
    if (begins && kAxes.find(words[i]) != kAxes.npos && kNumber.find(words[i + 1]) != kNumber.npos)
      axes += words[i];
  }
  return axes;
}

bool states_an_axis(const std::string& words) { return !axes_of(words).empty(); }

/// Of a line before motion; nothing: it leaves the words that follow as they are meant.
std::optional<std::string> changes_what_follows(const std::string& words) {
  const std::vector<int> g = codes(words, 'G'), m = codes(words, 'M');
  if (any(g, std::array{200, 700, 7000})) return "selects inches; the words are mm";
  if (any(m, std::array{20, 300, 990})) return "ends the program before its first motion";
  const bool named = words.find("TRAORI") != words.npos || words.find("PLANE SPATIAL") != words.npos;
  if (named || any(g, std::array{434, 435, 682, 2340, 2540}) || any(m, std::array{1280}))
    return "begins a tool centre point function or a tilted plane; the program does so itself where the "
           "profile has tcp";
  return std::nullopt;
}

}  // namespace

std::string bare(const std::string& line) {
  std::string out;
  int depth = 0;
  for (const char c : line) {
    depth += c == '(' ? 1 : 0;
    if (depth == 0) out += c;
    depth -= c == ')' ? 1 : 0;
  }
  return out;
}

bool in_machine_coordinates(const std::string& line) {
  const std::string words = bare(line);
  for (const char* own : {"G53", "G28", "G30", "SUPA", "M91", "M92"})
    if (words.find(own) != words.npos) return true;
  return false;
}

bool moves_the_tool(const std::string& line) {
  return !in_machine_coordinates(line) && states_an_axis(bare(line));
}

std::optional<std::string> breaks_words(const std::vector<std::string>& lines, bool before_motion) {
  std::string incremental;  // the line that said so
  for (const std::string& line : lines) {
    const std::string words = bare(line), quoted = "\"" + line + "\" ";
    const std::vector<int> g = codes(words, 'G');
    if (any(g, std::array{910})) incremental = line;
    if (any(g, std::array{900})) incremental.clear();
    if (any(g, std::array{280, 300}) && incremental.empty() && states_an_axis(words))
      return quoted +
             "goes by way of a place in the part's coordinates; expected G91 G28 Z0, and G90 in the next "
             "line";
    if (!before_motion) continue;
    if (const auto wrong = changes_what_follows(words)) return quoted + *wrong;
  }
  if (incremental.empty()) return std::nullopt;
  return "\"" + incremental + "\" leaves incremental words (G91) in force; expected G90 behind it";
}

std::optional<std::string> no_retract(const std::string& line, Dialect dialect) {
  const std::string words = bare(line), axes = axes_of(words);
  const std::vector<int> g = codes(words, 'G'), m = codes(words, 'M');
  const bool tnc = dialect == Dialect::kHeidenhain || dialect == Dialect::kHeidenhainIso;
  const bool elsewhere =
      tnc ? any(m, std::array{910, 920})
          : any(g, std::array{530}) || (dialect == Dialect::kSiemens && words.find("SUPA") != words.npos);
  if (elsewhere && axes == "Z") return std::nullopt;
  const std::string expected = std::string("; expected Z alone with ") +
                               (tnc                            ? "M91 or M92"
                                : dialect == Dialect::kSiemens ? "SUPA or G53"
                                                               : "G53") +
                               ", default, or none";
  const std::string quoted = "\"" + line + "\" ";
  if (!elsewhere) return quoted + "is no way in machine coordinates" + expected;
  if (axes.find('Z') == axes.npos) return quoted + "does not move Z" + expected;
  return quoted + "moves more than Z while the tool may be in the part" + expected;
}

}  // namespace tiltfeed::config
