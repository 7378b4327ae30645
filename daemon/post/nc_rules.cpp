#include "daemon/post/nc_rules.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <istream>
#include <span>
#include <string_view>

#include "config/table_home.h"
#include "daemon/post/nc_lines.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

// Codes that exclude each other, in tenths: motion, distances, feed, cutter side, plane.
constexpr std::array<std::array<int, 7>, 5> kGroups{{{0, 10, 20, 30, 330, 800, 810},
                                                     {900, 910, -1, -1, -1, -1, -1},
                                                     {930, 940, 950, -1, -1, -1, -1},
                                                     {400, 410, 420, -1, -1, -1, -1},
                                                     {170, 180, 190, -1, -1, -1, -1}}};
constexpr std::array<std::array<int, 4>, 2> kMachineGroups{{{3, 4, 5, -1}, {0, 1, 2, 30}}};
constexpr std::array<int, 11> kMachineCodes{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 30};
constexpr std::array<int, 6> kHeidenhainCodes{91, 126, 127, 128, 129, 140};

template <class Group>
bool several(const std::vector<int>& codes, const Group& group) {
  return std::count_if(codes.begin(), codes.end(), [&](int code) {
           return std::find(group.begin(), group.end(), code) != group.end();
         }) > 1;
}

/// The M codes of a profile's line.
void add_codes(const std::string& line, std::vector<int>& codes) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const bool begins = i == 0 || !std::isalnum(static_cast<unsigned char>(line[i - 1]));
    if (line[i] == 'M' && begins && std::isdigit(static_cast<unsigned char>(line[i + 1])))
      codes.push_back(static_cast<int>(std::strtol(line.c_str() + i + 1, nullptr, 10)));
  }
}

/// Of axes it states U, V or W alone, and none of them is a rotary of ours.
bool moves_only_others(const std::string& line, const TextLanguage& language) {
  constexpr std::string_view kAxes = "XYZABCUVW", kOthers = "UVW", kNumber = "0123456789.-+=";
  bool others = false;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const bool begins = i == 0 || !std::isalpha(static_cast<unsigned char>(line[i - 1]));
    if (!begins || kAxes.find(line[i]) == kAxes.npos || kNumber.find(line[i + 1]) == kNumber.npos) continue;
    if (kOthers.find(line[i]) == kOthers.npos || line[i] == language.tilt || line[i] == language.rotary)
      return false;
    others = true;
  }
  return others;
}

/// A reference point is gone to by way of the words beside it: only incremental zeros name no place.
std::optional<std::string> reference_point(const DialectWords& words, bool incremental) {
  const bool axes = words.has('X') || words.has('Y') || words.has('Z');
  const bool zeros = std::all_of(words.values.begin(), words.values.end(),
                                 [](const auto& one) { return one.second == 0.0; });
  if (axes && zeros && (incremental || words.has_g(910))) return std::nullopt;
  return "G28 goes by way of a place that is not read; only G91 G28 with zeros is understood";
}

/// P and R mean something beside few words only.
std::optional<std::string> letters(const DialectWords& words, const TextLanguage& language) {
  const bool dwell = words.has_g(40);
  const bool offset = words.has_g(541) || words.has_g(1540);
  if (words.has('P') && !dwell && !words.has_g(640) && !offset)
    return "P is understood in G4, G64, G54.1 and G154 only";
  if (offset && !(words.has('P') && words.values.at('P') >= 1.0 &&
                  words.values.at('P') == std::floor(words.values.at('P'))))
    return "G54.1 and G154 want P with the number of the work offset";
  const bool plain = language.dialect == config::Dialect::kHeidenhain;
  if (words.has('R') && !(plain && words.values.at('R') == 0.0)) return "R is not understood";
  for (const char letter : {'T', 'H', 'D'})
    if (words.has(letter) && words.values.at(letter) != std::floor(words.values.at(letter)))
      return std::string(1, letter) + " wants a whole number";
  const bool moves = words.has('Y') || words.has('Z') || words.has(language.tilt) ||
                     words.has(language.rotary) || (words.has('X') && words.has('P'));
  if (dwell && (moves || words.g.size() > 1)) return "G4 stands with other words; let it stand alone";
  return std::nullopt;
}

}  // namespace

TextLanguage text_language(const config::MachineProfile& machine) {
  const MachineModel& model = machine.model;
  const config::ProgramFormat& format = machine.format;
  TextLanguage language{format.dialect,  model.tilt.letter, model.rotary.letter,
                        model.tilt.word, model.rotary.word, format.inches};
  for (const std::string& line : {format.retract, format.clamp_tilt, format.unclamp_tilt, format.clamp_rotary,
                                  format.unclamp_rotary, format.through_on, format.through_off})
    add_codes(line, language.own_codes);
  language.through_on = format.through_on;
  language.swivel_data = format.swivel_data;
  for (const config::TableTurn& turn : config::table_turns(model))
    language.table.push_back({turn.axis->letter, turn.axis->zero});
  for (const auto* lines : {&format.start, &format.end})
    for (std::string line : *lines) {
      add_codes(line, language.own_codes);
      std::vector<std::string> comments;
      if (!strip_line(line, format.dialect, comments) && moves_only_others(line, language))
        language.other_axes.push_back(line);
    }
  return language;
}

std::optional<std::string> misread(const DialectWords& words, const TextLanguage& language,
                                   bool incremental) {
  for (const auto& group : kGroups)
    if (several(words.g, group)) return "two G codes of one kind stand in the line";
  for (const auto& group : kMachineGroups)
    if (several(words.m, group)) return "two M codes of one kind stand in the line";
  const bool tnc =
      language.dialect == config::Dialect::kHeidenhain || language.dialect == config::Dialect::kHeidenhainIso;
  const auto among = [](const auto& codes, int code) {
    return std::find(codes.begin(), codes.end(), code) != codes.end();
  };
  for (const int code : words.m)
    if (!among(kMachineCodes, code) && !(tnc && among(kHeidenhainCodes, code)) &&
        std::find(language.own_codes.begin(), language.own_codes.end(), code) == language.own_codes.end())
      return "M" + std::to_string(code) + " is not understood, and no line of the machine profile has it";
  if (words.has_g(280))
    if (auto bad = reference_point(words, incremental)) return bad;
  return letters(words, language);
}

bool is_work_offset(int tenths, config::Dialect dialect) {
  if (tenths >= 540 && tenths <= 590 && tenths % 10 == 0) return true;
  if (tenths >= 591 && tenths <= 593) return dialect == config::Dialect::kRs274;
  if (tenths == 541) return dialect == config::Dialect::kFanuc;
  if (tenths == 1540) return dialect == config::Dialect::kHaas;
  return dialect == config::Dialect::kSiemens && tenths >= 5050 && tenths <= 5990 && tenths % 10 == 0;
}

LineRead read_bounded_line(std::istream& in, std::string& line, std::size_t most) {
  line.clear();
  std::streambuf* const buffer = in.rdbuf();
  for (int c = buffer->sbumpc(); c != std::char_traits<char>::eof(); c = buffer->sbumpc()) {
    if (c == '\r' && buffer->sgetc() == '\n') buffer->sbumpc();
    if (c == '\n' || c == '\r') return LineRead::kLine;
    if (line.size() == most) return LineRead::kTooLong;
    line += static_cast<char>(c);
  }
  in.setstate(std::ios::eofbit);
  return line.empty() ? LineRead::kEnd : LineRead::kLine;
}

}  // namespace tiltfeed::daemon
