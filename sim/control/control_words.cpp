#include "sim/control/control_words.h"

#include <algorithm>
#include <cstddef>

namespace tiltfeed::sim {
namespace {

constexpr int kMostCode = 99'999;
// Whole numbers of so many digits and these powers are doubles without rounding, so their quotient is the
// double nearest to the decimal fraction.
constexpr int kMostDigits = 15;
constexpr std::array<double, kMostDigits + 1> kTens{1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                    1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

struct Number {
  double value = 0.0;
  bool point = false;
};

/// The number at `at`, which goes behind it; nothing where it has no digits, or too many.
std::optional<Number> take_number(const char*& at, const char* end) {
  Number number;
  const bool minus = at != end && *at == '-';
  if (at != end && (*at == '-' || *at == '+')) ++at;
  std::uint64_t digits = 0;
  int count = 0, decimals = 0;
  for (; at != end && (is_digit(*at) || (*at == '.' && !number.point)); ++at) {
    if (*at == '.') {
      number.point = true;
      continue;
    }
    if (++count > kMostDigits) return std::nullopt;
    digits = digits * 10 + static_cast<std::uint64_t>(*at - '0');
    if (number.point) ++decimals;
  }
  if (count == 0) return std::nullopt;
  number.value = static_cast<double>(digits) / kTens[static_cast<std::size_t>(decimals)];
  if (minus) number.value = -number.value;
  return number;
}

std::string shown(const char* from, const char* end) {
  constexpr std::ptrdiff_t kMostShown = 40;
  std::string text(from, from + std::min(end - from, kMostShown));
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return "\"" + text + "\"";
}

bool take_code(double value, std::array<int, ControlWords::kMost>& codes, std::size_t& count, double scale) {
  if (!(value >= 0.0 && value <= kMostCode) || count == codes.size()) return false;
  codes[count++] = static_cast<int>(value * scale + 0.5);
  return true;
}

/// DC(12.3) and the like behind a letter's "="; false: none of them.
bool take_way(const char*& at, const char* end, WordWay& way) {
  constexpr std::array<std::pair<std::string_view, WordWay>, 4> kWays{{{"DC(", WordWay::kShortest},
                                                                       {"ACP(", WordWay::kForward},
                                                                       {"ACN(", WordWay::kBack},
                                                                       {"AC(", WordWay::kPlain}}};
  const std::string_view rest(at, static_cast<std::size_t>(end - at));
  for (const auto& [name, meant] : kWays) {
    if (!rest.starts_with(name)) continue;
    at += name.size(), way = meant;
    return true;
  }
  return false;
}

/// A word of several letters, up to the blank behind it; brackets and what is in them belong to it.
std::string_view take_name(const char*& at, const char* end) {
  const char* const from = at;
  int open = 0;
  for (; at != end && (open > 0 || *at != ' '); ++at)
    open += *at == '(' || *at == '[' ? 1 : *at == ')' || *at == ']' ? -1 : 0;
  return {from, static_cast<std::size_t>(at - from)};
}

std::optional<std::string> take_value(char letter, const char*& at, const char* end, ControlWords& words) {
  const char* const from = at - 1;
  WordWay way = WordWay::kPlain;
  const bool equals = at != end && *at == '=';
  const bool wrapped = equals && take_way(++at, end, way);
  const auto number = take_number(at, end);
  if (!number) return shown(from, end) + ": the number is malformed";
  if (wrapped && (at == end || *at++ != ')')) return shown(from, end) + ": a ')' is missing";
  if (letter == 'G' || letter == 'M') {
    const bool taken = letter == 'G' ? take_code(number->value, words.g, words.g_count, 10.0)
                                     : take_code(number->value, words.m, words.m_count, 1.0);
    if (!taken) return shown(from, end) + ": no such code";
    return std::nullopt;
  }
  if (words.has(letter)) return shown(from, end) + ": the letter twice";
  const std::uint32_t bit = 1U << (letter - 'A');
  words.seen |= bit;
  if (number->point) words.pointed |= bit;
  words.value[static_cast<std::size_t>(letter - 'A')] = number->value;
  words.way[static_cast<std::size_t>(letter - 'A')] = way;
  return std::nullopt;
}

}  // namespace

bool ControlWords::has_g(int tenths) const {
  return std::find(g.begin(), g.begin() + g_count, tenths) != g.begin() + g_count;
}
bool ControlWords::has_m(int code) const {
  return std::find(m.begin(), m.begin() + m_count, code) != m.begin() + m_count;
}
bool ControlWords::named(std::string_view name) const {
  return std::find(names.begin(), names.begin() + name_count, name) != names.begin() + name_count;
}

std::optional<std::string> take_apart(std::string_view line, ControlWords& words) {
  words.seen = words.pointed = 0;
  words.g_count = words.m_count = words.name_count = 0;
  const char* at = line.data();
  const char* const end = at + line.size();
  while (at != end) {
    if (*at == ' ' || *at == '\t') {
      ++at;
      continue;
    }
    if (!is_letter(*at)) return shown(at, end) + " does not begin with a letter";
    const bool value = at + 1 != end && !is_letter(at[1]) && at[1] != ' ' && at[1] != '(' && at[1] != '[';
    // A parameter, Q339=+1, says nothing of an axis.
    if ((*at == 'Q' || *at == 'R') && value && line.find('=') != line.npos) {
      while (at != end && *at != ' ') ++at;
      continue;
    }
    if (value) {
      const char letter = upper(*at++);
      if (auto bad = take_value(letter, at, end, words)) return bad;
    } else if (words.name_count < words.names.size()) {
      words.names[words.name_count++] = take_name(at, end);
    } else {
      return shown(at, end) + ": too many words";
    }
  }
  return std::nullopt;
}

std::string_view bare_line(std::string_view line, config::Dialect dialect, std::string& room) {
  const bool plain = dialect == config::Dialect::kHeidenhain,
             iso = dialect == config::Dialect::kHeidenhainIso;
  const bool brackets = !plain && !iso && dialect != config::Dialect::kSiemens;
  if (const auto semicolon = line.find(';'); semicolon != line.npos) line = line.substr(0, semicolon);
  if (brackets && line.find('(') != line.npos) {
    room.clear();
    bool in_comment = false;
    for (const char c : line) {
      if (!in_comment && c != '(') room += c;
      in_comment = in_comment ? c != ')' : c == '(';
    }
    line = room;
  }
  const auto blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!line.empty() && (blank(line.back()) || (iso && line.back() == '*'))) line.remove_suffix(1);
  while (!line.empty() && blank(line.front())) line.remove_prefix(1);
  std::size_t number = 0;
  if (!plain && line.size() > 1 && upper(line[0]) == 'N' && is_digit(line[1])) number = 1;
  if (plain || number > 0)
    while (number < line.size() && is_digit(line[number])) ++number;
  line.remove_prefix(number);
  while (!line.empty() && blank(line.front())) line.remove_prefix(1);
  return line;
}

}  // namespace tiltfeed::sim
