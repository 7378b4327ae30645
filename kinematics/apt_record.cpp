#include "kinematics/apt_record.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <limits>
#include <string>
#include <string_view>

namespace tiltfeed {
namespace {

constexpr std::array<std::string_view, 5> kTextWords{"PARTNO", "PPRINT", "TPRINT", "REMARK", "INSERT"};

constexpr std::array<std::string_view, 20> kBends{
    "CYCLE",  "CIRCLE", "CUTCOM", "ROTABL", "ROTATE", "INDEX", "TRACUT", "COPY",   "TRANS", "ORIGIN",
    "MOVARC", "INDIRV", "INDIRP", "GOFWD",  "GOLFT",  "GORGT", "GOBACK", "SPLINE", "NURBS", "MIRROR"};
constexpr std::array<std::string_view, 17> kInforms{
    "TOOLPATH", "MULTAX", "MACHIN", "TOLER", "INTOL",  "OUTTOL", "NOPOST", "CLPRNT", "TPRINT",
    "REMARK",   "MSYS",   "CSYS",   "PAINT", "PREFUN", "SEQNO",  "LEADER", "DISPLY"};

template <std::size_t N>
bool among(const std::array<std::string_view, N>& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

bool blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Upper case, without blanks.
std::string tight(std::string_view text) {
  std::string out;
  for (const char c : text)
    if (!blank(c)) out += upper(c);
  return out;
}

/// The number that a word is, with E or D before an exponent; NaN for "nan", "inf" and beyond a double;
/// nothing when it is no number.
std::optional<double> number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  std::string plain(text);
  std::replace(plain.begin(), plain.end(), 'D', 'E');
  double value = 0.0;
  const auto [end, error] = std::from_chars(plain.data(), plain.data() + plain.size(), value);
  if (end != plain.data() + plain.size() || error == std::errc::invalid_argument) return std::nullopt;
  if (error != std::errc{} || !std::isfinite(value)) return std::numeric_limits<double>::quiet_NaN();
  return value;
}

/// The text word that a record begins with, or nothing.
std::string_view text_word(const std::string& text) {
  const std::string head = tight(std::string_view(text).substr(0, 6));
  const auto found = std::find(kTextWords.begin(), kTextWords.end(), head);
  return found != kTextWords.end() ? *found : std::string_view{};
}

}  // namespace

bool AptRecord::has(const std::string& name) const {
  return std::find(words.begin(), words.end(), name) != words.end();
}

std::optional<std::string> AptRecord::numbers(std::span<double> values, std::size_t& count) const {
  count = 0;
  for (const std::string& one : words) {
    const std::string place = word + "/: number " + std::to_string(count + 1);
    if (one.empty()) return place + " is missing";
    const auto value = number(one);
    if (!value || !std::isfinite(*value))
      return place + ", \"" + one + "\", is no number; write it as decimal";
    if (count == values.size()) return word + "/ has more than " + std::to_string(count) + " numbers";
    values[count++] = *value;
  }
  return std::nullopt;
}

std::optional<double> AptRecord::first_number() const {
  for (const std::string& one : words)
    if (const auto value = number(one)) return value;
  return std::nullopt;
}

std::optional<double> AptRecord::number_after(const std::string& name) const {
  const auto found = std::find(words.begin(), words.end(), name);
  if (found == words.end() || std::next(found) == words.end()) return std::nullopt;
  const auto value = number(*std::next(found));
  return value ? *value : std::numeric_limits<double>::quiet_NaN();
}

bool bends_path(const AptRecord& record) {
  return among(kBends, record.word) && !record.has("OFF") && !record.has("NOMORE");
}

bool only_informs(const AptRecord& record) {
  return among(kInforms, record.word) || (among(kBends, record.word) && !bends_path(record));
}

bool AptRecords::next(AptRecord& record) {
  text_.clear();
  bool goes_on = false;
  while (text_.empty() || goes_on) {
    if (!std::getline(in_, raw_)) {
      if (text_.empty()) return false;
      break;
    }
    ++line_;
    std::string_view line = raw_;
    line = trimmed(line.substr(0, line.find("$$")));
    if (text_.empty()) record.line = line_;
    goes_on = line.ends_with('$');
    if (goes_on) line.remove_suffix(1);
    text_ += line;
  }
  record.words.clear();
  record.text.clear();
  if (const std::string_view word = text_word(text_); !word.empty()) {
    record.word = word;
    record.text = trimmed(std::string_view(text_).substr(std::min<std::size_t>(6, text_.size())));
    if (record.text.starts_with('/')) record.text.erase(0, 1);
    return true;
  }
  const std::string all = tight(text_);
  const std::size_t slash = all.find('/');
  record.word = all.substr(0, slash);
  if (slash == std::string::npos) return true;
  for (std::size_t from = slash + 1;;) {
    const std::size_t comma = std::min(all.find(',', from), all.size());
    record.words.push_back(all.substr(from, comma - from));
    if (comma == all.size()) return true;
    from = comma + 1;
  }
}

}  // namespace tiltfeed
