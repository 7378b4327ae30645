#include "kinematics/cl_text/apt_record.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <istream>
#include <iterator>
#include <limits>

namespace tiltfeed {
namespace {

constexpr std::array<std::string_view, 5> kTextWords{"PARTNO", "PPRINT", "TPRINT", "REMARK", "INSERT"};

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

/// The text word that a record begins with, or nothing.
std::string_view text_word(std::string_view text) {
  std::string head;
  for (const char c : text.substr(0, 6))
    if (!blank(c)) head += upper(c);
  const auto found = std::find(kTextWords.begin(), kTextWords.end(), head);
  return found != kTextWords.end() ? *found : std::string_view{};
}

}  // namespace

std::optional<double> apt_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const char* const behind = text.data() + text.size();
  if (const auto read = std::from_chars(text.data(), behind, value);
      read.ptr == behind && read.ec == std::errc{} && std::isfinite(value))
    return value;
  std::string plain(text);
  std::replace(plain.begin(), plain.end(), 'D', 'E');
  const auto [end, error] = std::from_chars(plain.data(), plain.data() + plain.size(), value);
  if (end != plain.data() + plain.size() || error == std::errc::invalid_argument) return std::nullopt;
  if (error != std::errc{} || !std::isfinite(value)) return std::numeric_limits<double>::quiet_NaN();
  return value;
}

bool AptRecord::has(std::string_view name) const {
  return std::find(words.begin(), words.end(), name) != words.end();
}

AptVerdict AptRecord::numbers(std::span<double> values, std::size_t& count) const {
  count = 0;
  for (const std::string& one : words) {
    const auto value = apt_number(one);
    if (!value || !std::isfinite(*value)) {
      const std::string number = word + "/: number " + std::to_string(count + 1);
      if (one.empty()) return mistake(number + " is missing", places[count]);
      return mistake(number + ", \"" + one + "\", is no number; write it as decimal", places[count]);
    }
    if (count == values.size())
      return mistake(word + "/ has more than " + std::to_string(count) + " numbers", places[count]);
    values[count++] = *value;
  }
  return std::nullopt;
}

std::optional<double> AptRecord::first_number() const {
  for (const std::string& one : words)
    if (const auto value = apt_number(one)) return value;
  return std::nullopt;
}

std::size_t AptRecord::count_numbers(AptPlace* second) const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < words.size(); ++i)
    if (apt_number(words[i]) && ++count == 2 && second != nullptr) *second = places[i];
  return count;
}

std::optional<AptPlace> AptRecord::number_behind_number() const {
  for (std::size_t i = 1; i < words.size(); ++i)
    if (apt_number(words[i - 1]) && apt_number(words[i])) return places[i];
  return std::nullopt;
}

std::optional<double> AptRecord::number_after(std::string_view name) const {
  const auto found = std::find(words.begin(), words.end(), name);
  if (found == words.end() || std::next(found) == words.end()) return std::nullopt;
  const auto value = apt_number(*std::next(found));
  return value ? *value : std::numeric_limits<double>::quiet_NaN();
}

AptPlace AptRecords::place_of(std::size_t offset) const {
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), offset,
                                      [](std::size_t at, const Piece& one) { return at < one.offset; });
  const Piece& piece = *std::prev(after);
  return {piece.place.line, piece.place.column + static_cast<std::uint32_t>(offset - piece.offset)};
}

/// `text_` into its word and what is behind the slash.
void AptRecords::split(AptRecord& record) const {
  const auto take = [&](std::string_view piece, std::string& out) {
    out.resize(piece.size());
    char* to = out.data();
    for (const char c : piece)
      if (!blank(c)) *to++ = upper(c);
    out.resize(static_cast<std::size_t>(to - out.data()));
  };
  const std::string_view text = text_;
  std::size_t at = std::min(text.find('/'), text.size());
  take(text.substr(0, at), record.word);
  while (at < text.size()) {
    const std::size_t end = std::min(text.find(',', at + 1), text.size());
    const std::string_view piece = text.substr(at + 1, end - at - 1);
    const auto first = std::find_if_not(piece.begin(), piece.end(), blank);
    // A word that is missing stands where its slash or comma does.
    record.places.push_back(
        place_of(first == piece.end() ? at : static_cast<std::size_t>(first - text.begin())));
    take(piece, record.words.emplace_back());
    at = end;
  }
}

bool AptRecords::next(AptRecord& record) {
  text_.clear();
  pieces_.clear();
  bool goes_on = false;
  while (text_.empty() || goes_on) {
    if (!std::getline(in_, raw_)) {
      if (text_.empty()) return false;
      break;
    }
    if (++line_ == 1 && raw_.starts_with(kByteOrderMark)) raw_.erase(0, kByteOrderMark.size());
    const std::string_view whole = raw_;
    std::string_view line = trimmed(whole.substr(0, whole.find("$$")));
    if (text_.empty()) pieces_.clear();
    pieces_.push_back({text_.size(), {line_, static_cast<std::uint32_t>(line.data() - whole.data()) + 1}});
    goes_on = line.ends_with('$');
    if (goes_on) line.remove_suffix(1);
    text_ += line;
  }
  record.place = pieces_.front().place;
  record.word.clear();
  record.words.clear();
  record.places.clear();
  record.text.clear();
  if (const std::string_view word = text_word(text_); !word.empty()) {
    record.word = word;
    record.text = trimmed(std::string_view(text_).substr(std::min<std::size_t>(6, text_.size())));
    if (record.text.starts_with('/')) record.text.erase(0, 1);
    return true;
  }
  split(record);
  return true;
}

}  // namespace tiltfeed
