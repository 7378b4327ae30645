#include "daemon/post/tool_length.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "daemon/post/nc_rules.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

constexpr const char* kLengthMark = "TILTFEED tool length ";
// The header prints lengths with four decimals.
constexpr double kPrinted = 1e-4;
constexpr std::size_t kLongestLine = 65536;  // read in pieces beyond

}  // namespace

Result<std::vector<double>> baked_lengths(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(Code::kIo, path + ": cannot be opened");
  std::vector<double> lengths;
  std::string line;
  for (LineRead got = LineRead::kLine; got != LineRead::kEnd;) {
    got = read_bounded_line(in, line, kLongestLine);
    const std::size_t mark = line.find(kLengthMark);
    if (mark == std::string::npos || line.find("in the words", mark) == std::string::npos) continue;
    double length = 0.0;
    if (std::istringstream(line.substr(mark + std::string(kLengthMark).size())) >> length)
      lengths.push_back(length);
  }
  if (in.bad()) return fail(Code::kIo, path + ": cannot be read");
  return lengths;
}

Result<void> check_tool_length(const std::string& path, double length) {
  const auto lengths = baked_lengths(path);
  if (!lengths) return tl::unexpected(lengths.error());
  if (lengths->empty() || std::any_of(lengths->begin(), lengths->end(),
                                      [&](double one) { return std::abs(one - length) <= kPrinted; }))
    return {};
  std::string known;
  for (const double one : *lengths) known += (known.empty() ? "" : ", ") + decimal(one, 4);
  return fail(Code::kInput, path + ": its words are for a tool of " + known +
                                " mm, the tool in the spindle is " + decimal(length, 4) +
                                " mm long; post it again with that length, or change the tool");
}

}  // namespace tiltfeed::daemon
