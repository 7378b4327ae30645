#pragma once
// The words of a line of G-code: what they are, which go together, what is refused.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "sim/gcode/fault.h"

namespace tiltfeed::sim {

/// Why a line is refused.
struct Mistake {
  Fault fault = Fault::kNone;
  std::string message;
};
using Check = std::optional<Mistake>;

inline Check mistake(Fault fault, std::string message) { return Mistake{fault, std::move(message)}; }

// The modal groups of RS274; one code of each may stand on a line.
enum Group {
  kNonModal,
  kMotion,
  kPlane,
  kDistance,
  kFeedMode,
  kUnits,
  kCutterRadius,
  kToolLength,
  kOffset,
  kPathControl,
  kSpindleMode,
  kStopping,
  kToolChange,
  kSpindle,
  kCoolant,
  kGroups
};

inline constexpr int kAbsent = -1;
inline constexpr int kRelative = 910;      ///< G91
inline constexpr int kMachinePlace = 530;  ///< G53

/// The words of one line. G codes are kept in tenths (G61.1 = 611).
struct Words {
  std::array<double, 26> value;  ///< of the letters that were seen
  std::uint32_t seen;            ///< bit per letter
  std::array<int, kGroups> code;

  Words() { clear(); }
  void clear() { seen = 0, code.fill(kAbsent); }
  bool empty() const {
    return seen == 0 && std::all_of(code.begin(), code.end(), [](int c) { return c == kAbsent; });
  }
  /// False for what is no letter, as an axis that the machine lacks.
  bool has(char letter) const { return letter >= 'A' && letter <= 'Z' && (seen >> (letter - 'A') & 1U) != 0; }
  double operator[](char letter) const { return value[static_cast<std::size_t>(letter - 'A')]; }
};

/// Most lines: takes the words of one that has no comment and no number of more digits than a double keeps.
/// False: the line is another, or has a mistake; strip() and take_word() then say which.
bool take_plain_words(std::string_view line, char tilt, char rotary, bool relative_known, Words& words);
/// Drops blanks and comments, turns to upper case.
Check strip(std::string_view line, std::string& text);
/// The word at the begin of `rest`, which is taken off. `tilt` and `rotary` are the letters of those axes.
Check take_word(std::string_view& rest, char tilt, char rotary, bool relative_known, Words& words);

}  // namespace tiltfeed::sim
