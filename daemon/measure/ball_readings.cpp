#include "daemon/measure/ball_readings.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>

namespace tiltfeed::daemon {
namespace {

constexpr double kMostMm = 100'000.0, kMostDegrees = 1'000'000.0;
// Words of one place are typed or reported alike.
constexpr double kSameWord = 1e-6;
constexpr const char* kColumns[] = {"tilt_deg", "rotary_deg",     "x_mm", "y_mm",
                                    "z_mm",     "tool_length_mm", "place"};

/// A file's lines as values by column.
class Table {
 public:
  Table(std::string path, const MachineModel& machine, double tool_length)
      : path_(std::move(path)), machine_(machine), tool_length_(tool_length) {}

  Result<void> head(const std::vector<std::string>& cells, int line) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (std::find(std::begin(kColumns), std::end(kColumns), cells[i]) == std::end(kColumns))
        return wrong(line, "unknown column '" + cells[i].substr(0, 40) +
                               "'; expected tilt_deg, rotary_deg, x_mm, y_mm, z_mm, tool_length_mm, place");
      if (!columns_.emplace(cells[i], i).second) return wrong(line, "column " + cells[i] + " is there twice");
    }
    const auto needs = [&](const char* name, bool is) { return is && !columns_.contains(name); };
    for (const auto& [name, is] : {std::pair{"tilt_deg", machine_.tilt.present},
                                   {"rotary_deg", machine_.rotary.present},
                                   {"x_mm", true},
                                   {"y_mm", true},
                                   {"z_mm", true},
                                   {"tool_length_mm", tool_length_ < 0.0}})
      if (needs(name, is))
        return wrong(line, std::string("column ") + name + " is missing" +
                               (std::string(name) == "tool_length_mm" ? "; or state --tool-length" : ""));
    return {};
  }

  Result<void> row(const std::vector<std::string>& cells, int line, BallReadings& out) {
    if (cells.size() != columns_.size())
      return wrong(line, std::to_string(cells.size()) + " values; expected " +
                             std::to_string(columns_.size()) + ", as the first line has columns");
    BallReading one;
    one.line = line;
    one.at.tool_length = tool_length_;
    for (const auto& [name, to, most] : {std::tuple{"tilt_deg", &one.at.tilt, kMostDegrees},
                                         {"rotary_deg", &one.at.rotary, kMostDegrees},
                                         {"x_mm", &one.axes.x, kMostMm},
                                         {"y_mm", &one.axes.y, kMostMm},
                                         {"z_mm", &one.axes.z, kMostMm},
                                         {"tool_length_mm", &one.at.tool_length, kMostMm}})
      if (const Result<void> read = number(cells, name, most, line, *to); !read) return read;
    if (one.at.tool_length < 0.0) return wrong(line, "tool_length_mm is below 0");
    return place(cells, line, one, out);
  }

 private:
  tl::unexpected<Error> wrong(int line, const std::string& what) const {
    return fail(Code::kInput, path_ + ":" + std::to_string(line) + ": " + what);
  }

  Result<void> number(const std::vector<std::string>& cells, const char* name, double most, int line,
                      double& to) const {
    const auto column = columns_.find(name);
    if (column == columns_.end()) return {};
    const std::string& text = cells[column->second];
    const char* const first = text.data() + (text.starts_with('+') ? 1 : 0);
    const auto parsed = std::from_chars(first, text.data() + text.size(), to);
    if (text.empty() || parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() ||
        !(std::abs(to) <= most))
      return wrong(line, std::string(name) + ": '" + text.substr(0, 40) + "' is no number up to " +
                             std::to_string(static_cast<long>(most)));
    return {};
  }

  Result<void> place(const std::vector<std::string>& cells, int line, BallReading& one, BallReadings& out) {
    const auto column = columns_.find("place");
    const std::string name =
        column == columns_.end() ? std::to_string(out.all.size() + 1) : cells[column->second];
    if (name.empty()) return wrong(line, "place is empty; expected the number or name of the place");
    const auto known = std::find(out.places.begin(), out.places.end(), name);
    one.place = static_cast<int>(known - out.places.begin());
    if (known == out.places.end()) {
      out.places.push_back(name);
      first_.push_back(one);
    } else {
      const BallReading& first = first_[static_cast<std::size_t>(one.place)];
      if (std::abs(first.at.tilt - one.at.tilt) > kSameWord ||
          std::abs(first.at.rotary - one.at.rotary) > kSameWord || first.at.tool_length != one.at.tool_length)
        return wrong(line, "place " + name + " has other words or another tool length in line " +
                               std::to_string(first.line));
    }
    out.all.push_back(one);
    if (out.all.size() > kMostReadings)
      return wrong(line, "more than " + std::to_string(kMostReadings) + " readings");
    return {};
  }

  std::string path_;
  const MachineModel& machine_;
  double tool_length_;
  std::map<std::string, std::size_t> columns_;
  std::vector<BallReading> first_;
};

}  // namespace

std::vector<std::string> cells_of(const std::string& line, char between) {
  std::vector<std::string> cells;
  std::istringstream in(line + between);
  for (std::string cell; std::getline(in, cell, between);) {
    const std::size_t first = cell.find_first_not_of(" \t\r"), last = cell.find_last_not_of(" \t\r");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
  }
  return cells;
}

Result<BallReadings> read_ball_readings(const std::string& text, const std::string& path,
                                        const MachineModel& machine, double tool_length) {
  Table table(path, machine, tool_length);
  BallReadings out;
  std::istringstream in(text);
  int line = 0;
  bool headed = false;
  for (std::string row; std::getline(in, row);) {
    ++line;
    const std::size_t first = row.find_first_not_of(" \t\r");
    if (first == std::string::npos || row[first] == '#') continue;
    const std::vector<std::string> cells = cells_of(row, row.find(';') != std::string::npos ? ';' : ',');
    const Result<void> read = headed ? table.row(cells, line, out) : table.head(cells, line);
    if (!read) return tl::unexpected<Error>(read.error());
    headed = true;
  }
  if (out.all.empty()) return fail(Code::kInput, path + ": has no readings");
  std::stable_sort(out.all.begin(), out.all.end(),
                   [](const BallReading& a, const BallReading& b) { return a.place < b.place; });
  std::vector<int> count(out.places.size());
  for (const BallReading& one : out.all) ++count[static_cast<std::size_t>(one.place)];
  out.touches = out.all.size() > out.places.size();
  for (std::size_t i = 0; i < count.size(); ++i)
    if (out.touches && count[i] < kFewestTouches)
      return fail(Code::kInput, path + ": place " + out.places[i] + " has " + std::to_string(count[i]) +
                                    " touches; expected at least " + std::to_string(kFewestTouches) +
                                    ", or one line a place with the axes centred on the ball");
  return out;
}

}  // namespace tiltfeed::daemon
