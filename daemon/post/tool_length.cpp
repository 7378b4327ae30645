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
constexpr const char* kInPlanes = "planes take the control's";
// The header prints lengths with four decimals.
constexpr double kPrinted = 1e-4;
constexpr std::size_t kLongestLine = 65536;  // read in pieces beyond

}  // namespace

Result<BakedLengths> baked_lengths(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(Code::kIo, path + ": cannot be opened");
  BakedLengths baked;
  std::vector<double>& lengths = baked.lengths;
  bool& planes = baked.planes;
  std::string line;
  for (LineRead got = LineRead::kLine; got != LineRead::kEnd;) {
    got = read_bounded_line(in, line, kLongestLine);
    const std::size_t mark = line.find(kLengthMark);
    // In planes X and Y go over each plane's first place before the control counts its own length.
    const bool counts = mark != std::string::npos && (line.find("in the words", mark) != std::string::npos ||
                                                      line.find(kInPlanes, mark) != std::string::npos);
    if (!counts) continue;
    planes = planes || line.find(kInPlanes, mark) != std::string::npos;
    double length = 0.0;
    if (std::istringstream(line.substr(mark + std::string(kLengthMark).size())) >> length)
      lengths.push_back(length);
  }
  if (in.bad()) return fail(Code::kIo, path + ": cannot be read");
  return baked;
}

Result<void> check_tool_length(const std::string& path, double length) {
  const auto baked = baked_lengths(path);
  if (!baked) return tl::unexpected(baked.error());
  const std::vector<double>* const lengths = &baked->lengths;
  if (lengths->empty() || std::any_of(lengths->begin(), lengths->end(),
                                      [&](double one) { return std::abs(one - length) <= kPrinted; }))
    return {};
  std::string known;
  for (const double one : *lengths) known += (known.empty() ? "" : ", ") + decimal(one, 4);
  if (baked->planes)
    return fail(Code::kInput,
                path + ": it is planned for a tool of " + known + " mm, the tool in the spindle is " +
                    decimal(length, 4) +
                    " mm long: X and Y go over the first place of each tilted plane for the planned "
                    "length, and the tool would come to it on a slant; post it again with that "
                    "length, or change the tool");
  return fail(Code::kInput, path + ": its words are for a tool of " + known +
                                " mm, the tool in the spindle is " + decimal(length, 4) +
                                " mm long; post it again with that length, or change the tool");
}

}  // namespace tiltfeed::daemon
