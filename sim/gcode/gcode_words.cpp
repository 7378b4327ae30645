#include "sim/gcode/gcode_words.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>

namespace tiltfeed::sim {
namespace {

constexpr double kLargestLineNumber = 4294967295.0;  // Block::line is 32 bits wide
constexpr double kLargestCode = 9999.0;              // beyond any G, M or T number; keeps the int casts exact

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return c >= 'A' && c <= 'Z'; }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

// Of what is no word: it runs to the next letter, which may be far in a file that is no program.
constexpr std::size_t kMostShown = 40;

/// The word that starts at `text`, for messages: printable.
std::string word_at(std::string_view text) {
  std::size_t end = 1;
  while (end < text.size() && !is_letter(text[end])) ++end;
  std::string shown(text.substr(0, std::min(end, kMostShown)));
  for (char& c : shown)
    if (c < ' ' || c > '~') c = '?';
  return "'" + shown + (end > kMostShown ? "...'" : "'");
}

struct Known {
  int code;  ///< G in tenths
  Group group;
};
constexpr Known kGCodes[] = {
    {0, kMotion},        {10, kMotion},        {40, kNonModal},    {530, kNonModal}, {170, kPlane},
    {210, kUnits},       {400, kCutterRadius}, {490, kToolLength}, {540, kOffset},   {550, kOffset},
    {560, kOffset},      {570, kOffset},       {580, kOffset},     {590, kOffset},   {610, kPathControl},
    {611, kPathControl}, {640, kPathControl},  {800, kMotion},     {900, kDistance}, {930, kFeedMode},
    {940, kFeedMode},    {970, kSpindleMode},  {20, kMotion},      {30, kMotion},    {180, kPlane},
    {190, kPlane}};
constexpr Known kMCodes[] = {{0, kStopping}, {1, kStopping}, {2, kStopping}, {30, kStopping},
                             {3, kSpindle},  {4, kSpindle},  {5, kSpindle},  {6, kToolChange},
                             {7, kCoolant},  {8, kCoolant},  {9, kCoolant}};

struct RefusedCode {
  int tenths;
  const char* why;
};
constexpr RefusedCode kRefusedGCodes[] = {
    {200, "inches are refused; use G21 and mm"},
    {280, "going home is refused, its way is not in the program"},
    {300, "going home is refused, its way is not in the program"},
    {434, "tool centre control is not in this machine; post without it"},
    {910, "incremental words are refused; use G90"}};

/// The group of a code, or the reason why it is refused.
Check find_group(char letter, int code, const std::string_view rest, bool relative_known, Group& group) {
  if (letter == 'G' && code == kRelative && relative_known) {
    group = kDistance;
    return std::nullopt;
  }
  const std::span<const Known> known = letter == 'G' ? std::span<const Known>(kGCodes) : kMCodes;
  for (const Known& entry : known) {
    if (entry.code != code) continue;
    group = entry.group;
    return std::nullopt;
  }
  if (letter == 'G')
    for (const RefusedCode& refused : kRefusedGCodes)
      if (refused.tenths == code) return mistake(Fault::kUnsupported, word_at(rest) + ": " + refused.why);
  return mistake(Fault::kUnsupported, word_at(rest) + ": this machine has no such code");
}

Check take_code(char letter, double value, std::string_view rest, bool relative_known, Words& words) {
  const double scaled = letter == 'G' ? value * 10.0 : value;
  if (value < 0.0 || value > kLargestCode || std::abs(scaled - std::round(scaled)) > 1e-6)
    return mistake(Fault::kNotInteger, word_at(rest) + ": not a code number");
  const int number = static_cast<int>(std::lround(scaled));
  Group group = kNonModal;
  if (Check bad = find_group(letter, number, rest, relative_known, group)) return bad;
  if (words.code[group] != kAbsent)
    return mistake(Fault::kModalConflict, word_at(rest) + ": a second code of the same modal group");
  words.code[group] = number;
  return std::nullopt;
}

Check take_value(char letter, double value, std::string_view rest, Words& words) {
  const std::uint32_t bit = 1U << (letter - 'A');
  if ((words.seen & bit) != 0) return mistake(Fault::kRepeatedWord, word_at(rest) + ": the letter twice");
  const auto whole = [&] { return value == std::floor(value); };
  if (letter == 'N' && (!whole() || value < 0.0 || value > kLargestLineNumber))
    return mistake(Fault::kLineNumber, word_at(rest) + ": line numbers are whole, 0 to 4294967295");
  if (letter == 'T' && !whole()) return mistake(Fault::kNotInteger, word_at(rest) + ": not a tool number");
  if (value < 0.0 && (letter == 'F' || letter == 'S' || letter == 'T' || letter == 'P'))
    return mistake(Fault::kNegative, word_at(rest) + ": must not be negative");
  words.seen |= bit;
  words.value[static_cast<std::size_t>(letter - 'A')] = value;
  return std::nullopt;
}

bool is_blank(char c) { return c == ' ' || c == '\t'; }
bool is_code(char letter) { return letter == 'G' || letter == 'M'; }
bool is_known(char letter, char tilt, char rotary) {
  const bool axis = letter == 'X' || letter == 'Y' || letter == 'Z' || letter == tilt || letter == rotary;
  return is_code(letter) || axis || letter == 'N' || letter == 'F' || letter == 'S' || letter == 'T' ||
         letter == 'P' || letter == 'I' || letter == 'J' || letter == 'K';
}

// Whole numbers of so many digits and these powers are doubles without rounding, so their quotient is the
// double nearest to the decimal fraction.
constexpr std::ptrdiff_t kMostDigits = 15;
constexpr std::array<double, kMostDigits + 1> kTens{1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                    1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

/// The number at `at`, which goes to its end; nothing where it has no digits, or more than kMostDigits.
std::optional<double> plain_number(const char*& at, const char* end) {
  const bool negative = at != end && *at == '-';
  if (negative) ++at;
  std::uint64_t digits = 0;
  const auto take_digits = [&] {
    const char* const begin = at;
    for (; at != end && is_digit(*at) && at - begin <= kMostDigits; ++at)
      digits = digits * 10 + static_cast<std::uint64_t>(*at - '0');
    return at - begin;
  };
  std::ptrdiff_t count = take_digits(), decimals = 0;
  if (at != end && *at == '.') ++at, decimals = take_digits(), count += decimals;
  if (count == 0 || count > kMostDigits) return std::nullopt;
  const double value = static_cast<double>(digits) / kTens[static_cast<std::size_t>(decimals)];
  return negative ? -value : value;
}

}  // namespace

bool take_plain_words(std::string_view line, char tilt, char rotary, bool relative_known, Words& words) {
  const char* at = line.data();
  const char* const end = at + line.size();
  while (true) {
    while (at != end && is_blank(*at)) ++at;
    if (at == end) return true;
    const char letter = upper(*at++);
    // After a number an E would be an exponent, even on a machine with an axis E.
    if (!is_letter(letter) || letter == 'E' || !is_known(letter, tilt, rotary)) return false;
    const auto value = plain_number(at, end);
    if (!value) return false;
    const Check bad = is_code(letter) ? take_code(letter, *value, line, relative_known, words)
                                      : take_value(letter, *value, line, words);
    if (bad) return false;
  }
}

Check strip(std::string_view line, std::string& text) {
  text.clear();
  bool in_comment = false;
  for (const char c : line) {
    if (in_comment) {
      if (c == '(') return mistake(Fault::kNoLetter, "a comment inside a comment; remove the inner '('");
      in_comment = c != ')';
      continue;
    }
    if (c == ';') break;
    if (c == '(') {
      in_comment = true;
    } else if (!is_blank(c)) {
      text.push_back(upper(c));
    }
  }
  if (in_comment) return mistake(Fault::kNoLetter, "the comment has no ')'");
  return std::nullopt;
}

Check take_word(std::string_view& rest, char tilt, char rotary, bool relative_known, Words& words) {
  const char letter = rest[0];
  if (!is_letter(letter)) return mistake(Fault::kNoLetter, word_at(rest) + ": a letter is expected");
  if (!is_known(letter, tilt, rotary))
    return mistake(Fault::kUnsupported, word_at(rest) + ": this machine has no word " + letter);
  const char* first = rest.data() + 1;
  const char* const last = rest.data() + rest.size();
  if (first != last && *first == '+') ++first;
  const char* const digits = first != last && *first == '-' ? first + 1 : first;
  double value = 0.0;
  // from_chars would also take "inf", "nan" and, after our '+', a '-'.
  const bool starts_well =
      digits != last && (is_digit(*digits) || *digits == '.') && (digits == first || *(first - 1) != '+');
  const auto [end, error] = starts_well ? std::from_chars(first, last, value, std::chars_format::fixed)
                                        : std::from_chars_result{first, std::errc::invalid_argument};
  const bool exponent = end != last && *end == 'E';
  if (error != std::errc() || exponent || (end != last && !is_letter(*end)))
    return mistake(Fault::kBadNumber, word_at(rest) + ": the number is malformed (digits, one point, no E)");
  Check bad = is_code(letter) ? take_code(letter, value, rest, relative_known, words)
                              : take_value(letter, value, rest, words);
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return bad;
}

}  // namespace tiltfeed::sim
