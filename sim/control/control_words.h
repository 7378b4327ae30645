#pragma once
// The words of a line of program text in any dialect, as its control takes the line apart.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "config/program_format.h"

namespace tiltfeed::sim {

/// How an axis word says its place.
enum class WordWay : std::uint8_t {
  kPlain,     ///< X12.3, X=12.3
  kShortest,  ///< C=DC(12.3): the shorter way
  kForward,   ///< C=ACP(12.3)
  kBack       ///< C=ACN(12.3)
};

struct ControlWords {
  static constexpr std::size_t kMost = 16;
  std::uint32_t seen = 0, pointed = 0;  ///< a bit a letter: there, and with a decimal point
  std::array<double, 26> value;         ///< of the letters seen
  std::array<WordWay, 26> way;
  std::array<int, kMost> g, m;  ///< G codes in tenths
  std::size_t g_count = 0, m_count = 0;
  std::array<std::string_view, kMost>
      names;  ///< words of several letters, with what stands in their brackets
  std::size_t name_count = 0;

  /// Of kNoLetter, too: an axis that the machine does not have has no word.
  bool has(char letter) const { return letter >= 'A' && (seen >> (letter - 'A') & 1U) != 0; }
  bool has_point(char letter) const { return (pointed >> (letter - 'A') & 1U) != 0; }
  double operator[](char letter) const { return value[static_cast<std::size_t>(letter - 'A')]; }
  bool has_g(int tenths) const;
  bool has_m(int code) const;
  bool named(std::string_view name) const;
};

/// Takes apart a line without its comment, number and end. Wrong: a letter twice, a number that is none, in
/// words; nothing: it is well.
std::optional<std::string> take_apart(std::string_view line, ControlWords& words);
/// The line without comment, block number and end of block; the text of a comment that is not closed is one.
std::string_view bare_line(std::string_view line, config::Dialect dialect, std::string& room);

}  // namespace tiltfeed::sim
