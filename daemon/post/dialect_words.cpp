#include "daemon/post/dialect_words.h"

#include <charconv>
#include <cmath>

namespace tiltfeed::daemon {
namespace {

constexpr double kWholeCode = 1e-6;

bool is_letter(char c) { return c >= 'A' && c <= 'Z'; }
bool starts_number(char c) { return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.'; }

}  // namespace

std::optional<std::string> split_words(std::string_view text, DialectWords& words) {
  while (!text.empty()) {
    if (text.front() == ' ') {
      text.remove_prefix(1);
      continue;
    }
    std::size_t letters = 0;
    while (letters < text.size() && is_letter(text[letters])) ++letters;
    if (letters == 0) return "\"" + std::string(text) + "\" does not begin with a letter";
    const char letter = text.front();
    constexpr std::string_view kDirect = "=DC(";
    const bool direct = letters == 1 && text.substr(1).starts_with(kDirect);
    if (direct) text.remove_prefix(kDirect.size());
    if (!direct && (letters != 1 || text.size() == 1 || !starts_number(text[1]))) {
      words.names.emplace_back(text.substr(0, letters));
      text.remove_prefix(letters);
      const bool way =
          words.names.back() == "DR" && !text.empty() && (text.front() == '+' || text.front() == '-');
      if (way) words.ways += text.front(), text.remove_prefix(1);
      continue;
    }
    text.remove_prefix(1);
    const std::string_view digits = text.front() == '+' ? text.substr(1) : text;
    double value = 0.0;
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed);
    if (error != std::errc{} || !std::isfinite(value) ||
        (end != digits.data() + digits.size() && *end == 'E'))
      return std::string(1, letter) + ": the number is malformed";
    const auto size = static_cast<std::size_t>(end - text.data());
    constexpr std::string_view kNumbered = "GMTHD";
    if (kNumbered.find(letter) != kNumbered.npos && !(value >= 0.0 && value < kLargestNumber))
      return std::string(1, letter) + ": no code, tool or register has this number";
    const double code = letter == 'G' ? value * 10.0 : value;
    if ((letter == 'G' || letter == 'M') && std::abs(code - std::round(code)) > kWholeCode)
      return std::string(1, letter) + std::string(text.substr(0, size)) + " is no code";
    if (letter == 'G') words.g.push_back(static_cast<int>(std::lround(value * 10.0)));
    if (letter == 'M') words.m.push_back(static_cast<int>(std::lround(value)));
    if (letter != 'G' && letter != 'M') {
      if (words.has(letter)) return std::string(1, letter) + " stands twice";
      words.values[letter] = value;
      words.printed[letter] = std::string(text.substr(0, size));
    }
    text.remove_prefix(size);
    if (!direct) continue;
    if (text.empty() || text.front() != ')') return std::string(1, letter) + "=DC( without )";
    text.remove_prefix(1);
    words.direct += letter;
  }
  return std::nullopt;
}

}  // namespace tiltfeed::daemon
