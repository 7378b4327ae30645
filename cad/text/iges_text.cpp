#include "cad/text/iges_text.h"

#include <array>
#include <charconv>
#include <cstdint>
#include <vector>

namespace tiltfeed::cad {
namespace {

constexpr std::size_t kColumns = 80, kLetter = 72, kField = 8;
constexpr std::string_view kSections = "SGDPT";

/// A right-justified whole number; -1: none.
std::int64_t whole(std::string_view field) {
  const std::size_t first = field.find_first_not_of(' ');
  if (first == field.npos) return -1;
  field.remove_prefix(first);
  std::int64_t value = -1;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  const bool blank = std::string_view(end, static_cast<std::size_t>(field.data() + field.size() - end))
                         .find_first_not_of(' ') == std::string_view::npos;
  return error == std::errc{} && blank ? value : -1;
}

/// The two lines of a directory entry: its type and its parameters' lines.
struct Entry {
  std::int64_t number = 0, type = 0, first = 0, lines = 0;
  std::string name() const { return "D" + std::to_string(number) + " (type " + std::to_string(type) + ")"; }
};

}  // namespace

Result<void> check_iges_text(std::string_view text, const std::string& file) {
  std::array<std::int64_t, 5> counts{};
  std::size_t section = 0;
  std::uint64_t number = 0;
  std::vector<Entry> entries;
  std::string_view last;
  const auto wrong = [&](const std::string& what) {
    return fail(Code::kInput, file + ":" + std::to_string(number) + ": " + what + "; export the part again");
  };
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
    ++number;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.find_first_not_of(" \x1a") == line.npos || section == kSections.size() - 1) {
      if (section == kSections.size() - 1) break;  // after the last line nothing counts
      continue;
    }
    if (line.size() < kColumns)
      return wrong("a line of IGES has 80 columns, and this one " + std::to_string(line.size()));
    const std::size_t at = kSections.find(line[kLetter]);
    if (at == kSections.npos || at < section)
      return wrong(std::string("section '") + line[kLetter] + "' in column 73 is none that may follow '" +
                   kSections[section] + "'");
    section = at;
    if (whole(line.substr(kLetter + 1, 7)) != ++counts[section])
      return wrong("its number in columns 74 to 80 is not " + std::to_string(counts[section]) +
                   ": a line is missing or out of place");
    if (section == 2) {
      if (counts[2] % 2 == 1)
        entries.push_back({counts[2], whole(line.substr(0, kField)), whole(line.substr(kField, kField)), 0});
      else
        entries.back().lines = whole(line.substr(3 * kField, kField));
    }
    last = line;
  }
  if (section != kSections.size() - 1)
    return wrong("the IGES file is cut short: it has no line of section T");
  for (std::size_t i = 0; i + 1 < kSections.size(); ++i) {
    const std::string_view field = last.substr(i * kField, kField);
    if (field[0] != kSections[i] || whole(field.substr(1)) != counts[i])
      return wrong("the last line says '" + std::string(field) + "', and section " + kSections[i] + " has " +
                   std::to_string(counts[i]) + " lines");
  }
  if (counts[2] % 2 == 1) return wrong("section D has an odd number of lines");
  if (entries.empty()) return wrong("it has no entities");
  for (const Entry& entry : entries)
    if (entry.type < 0 ||
        (entry.type > 0 && (entry.first < 1 || entry.lines < 1 || entry.first + entry.lines - 1 > counts[3])))
      return fail(Code::kInput, file + ": " + entry.name() + " has no parameters: it names lines P" +
                                    std::to_string(entry.first) + " and " + std::to_string(entry.lines) +
                                    " in all, of " + std::to_string(counts[3]) + "; export the part again");
  return {};
}

}  // namespace tiltfeed::cad
