#pragma once
// The words of one line of program text, in any dialect: G and M codes, names, letters with their numbers.

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tiltfeed::daemon {

/// Codes and tool numbers lie below.
inline constexpr double kLargestNumber = 1e8;

struct DialectWords {
  std::vector<int> g;  ///< in tenths: G43.4 is 434
  std::vector<int> m;
  std::vector<std::string> names;       ///< TRAORI, FMAX, L ...
  std::map<char, double> values;        ///< the others
  std::map<char, std::string> printed;  ///< their numbers as they stand
  std::string ways;                     ///< signs of DR+ and DR-
  std::string direct;                   ///< of these, the letters whose number stands as C=DC(10)

  bool has(char letter) const { return values.contains(letter); }
  bool has_g(int tenths) const { return std::find(g.begin(), g.end(), tenths) != g.end(); }
  bool has_m(int code) const { return std::find(m.begin(), m.end(), code) != m.end(); }
  bool named(std::string_view name) const {
    return std::find(names.begin(), names.end(), name) != names.end();
  }
};

/// Splits a line without comment and number; what is wrong as text: a letter twice, a number that is none.
std::optional<std::string> split_words(std::string_view text, DialectWords& words);

}  // namespace tiltfeed::daemon
