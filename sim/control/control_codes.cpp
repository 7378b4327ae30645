// ControlReader's codes of the machine: tools, spindle, coolant, stops, dwells.

#include <algorithm>
#include <string>

#include "sim/control/control_reader.h"

namespace tiltfeed::sim {
namespace {

// M codes that jump, repeat or move.
constexpr std::array kRefusedM{94, 97, 98, 99, 140};

}  // namespace

/// Lines of the profile's own are not asked.
bool ControlReader::posts(int code) const {
  constexpr std::array kPlaces{91, 92, 126, 127, 128, 129};
  return code <= 9 || code == 30 ||
         (tnc() && std::find(kPlaces.begin(), kPlaces.end(), code) != kPlaces.end());
}

ControlReader::Wrong ControlReader::machine_codes(const ControlWords& words,
                                                  std::vector<ControlBlock>& blocks) {
  if (words.has('T') && !words.has_g(510)) {
    selected_ = static_cast<int>(std::clamp(words['T'], 0.0, kMostTool));
    const bool at_once = dialect_ == config::Dialect::kHeidenhainIso;
    if (tool_ == kToolNotSaid || at_once) tool_ = selected_;
  }
  if (words.has('S')) spindle_ = words['S'];
  for (std::size_t i = 0; i < words.m_count; ++i) {
    const int code = words.m[i];
    if (std::find(kRefusedM.begin(), kRefusedM.end(), code) != kRefusedM.end())
      return "M" + std::to_string(code) + " is refused: it moves, or runs another program";
    if (posted_ && !retract_ && !posts(code))
      return "M" + std::to_string(code) +
             " is no word of a posted program, and no line of the profile is this one";
    const bool by_hand = code == 0 && dialect_ == config::Dialect::kGrbl && selected_ != kToolNotSaid;
    if (code == 6 || by_hand) tool_ = selected_;
    if (code == 128 || code == 129)
      if (auto wrong = set_tcp(code == 128)) return wrong;
    if (code == 126 || code == 127) shortest_ = code == 126;
    if (code == 2 || code == 30) ended_ = true;
    const bool after = code <= 2 || code == 30;
    if (!after && code <= 9) put_code(blocks, code);
  }
  return std::nullopt;
}

ControlReader::Wrong ControlReader::dwell(const ControlWords& words, std::vector<ControlBlock>& blocks) {
  for (const char letter : {'P', 'F', 'X'}) {
    if (!words.has(letter)) continue;
    Block block;
    block.op = Op::kDwell, block.target = at_, block.line = lines_, block.tool = tool_;
    block.feed = words[letter] * (letter == 'P' && counts_points_ && !words.has_point('P') ? 1e-3 : 1.0);
    block.spindle = spindle_;
    blocks.push_back({block, tcp_, fresh_});
    return std::nullopt;
  }
  return "a dwell without a time";
}

ControlReader::Wrong ControlReader::tool_call(std::string_view line, std::vector<ControlBlock>& blocks) {
  ControlWords words;
  std::string_view rest = line.substr(line.find("CALL") + 4);
  while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
  std::size_t digits = 0;
  int number = 0;
  while (digits < rest.size() && rest[digits] >= '0' && rest[digits] <= '9')
    number = std::min(number * 10 + (rest[digits++] - '0'), 99'999'999);
  if (digits > 0) selected_ = tool_ = number, put_code(blocks, 6);
  if (auto bad = take_apart(rest.substr(digits), words)) return bad;
  for (std::size_t i = 0; i < words.name_count; ++i)
    if (words.names[i] != "Z")
      return "\"" + std::string(words.names[i]) +
             "\" in a tool call is not understood: it changes the tool's axis or size";
  if (words.has('S')) spindle_ = words['S'];
  return std::nullopt;
}

}  // namespace tiltfeed::sim
