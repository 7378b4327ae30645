#include "sim/motion/trace.h"

#include <array>
#include <charconv>
#include <istream>
#include <ostream>
#include <string_view>

namespace tiltfeed::sim {
namespace {

constexpr int kTimeDecimals = 6;  // 1 microsecond
constexpr int kAxisDecimals = 6;  // two more than any control prints
constexpr int kPoseDecimals = 9;  // below the rounding of the kinematics at machine size (1e-9 mm)
constexpr int kRateDecimals = 6;
constexpr std::size_t kFields = 19;

/// One CSV row. Sized for the longest: 19 fixed-point numbers of up to 309 digits each do not fit, so put()
/// falls back to what a broken machine would print, "nan", and the reader refuses it.
class Row {
 public:
  void put(double value, int decimals) {
    const auto [end, error] = std::to_chars(at_, limit(), value, std::chars_format::fixed, decimals);
    if (error == std::errc()) {
      at_ = end;
      *at_++ = ',';
    } else {
      put(std::string_view("nan"));
    }
  }
  void put(std::uint64_t value) {
    at_ = std::to_chars(at_, limit(), value).ptr;
    *at_++ = ',';
  }
  void put(std::string_view text) {
    at_ = text.copy(at_, text.size()) + at_;
    *at_++ = ',';
  }
  std::string_view line() {
    *(at_ - 1) = '\n';
    return {text_.data(), static_cast<std::size_t>(at_ - text_.data())};
  }

 private:
  static constexpr std::size_t kFieldBytes = 40;  // 1e15 mm with 9 decimals and more
  char* limit() { return at_ + kFieldBytes - 1; }
  std::array<char, kFields * kFieldBytes> text_;
  char* at_ = text_.data();
};

void put_op(const Block& command, Row& row) {
  switch (command.op) {
    case Op::kRapid:
      return row.put(std::string_view("rapid"));
    case Op::kFeed:
      return row.put(std::string_view(command.inverse_time ? "inverse" : "feed"));
    case Op::kDwell:
      return row.put(std::string_view("dwell"));
    case Op::kMCode: {
      std::array<char, 16> text{'M'};
      const char* end = std::to_chars(text.data() + 1, text.data() + text.size(), command.m_code).ptr;
      return row.put(std::string_view(text.data(), static_cast<std::size_t>(end - text.data())));
    }
  }
}

template <class Number>
bool read_number(std::string_view field, Number& value) {
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size() && !field.empty();
}

bool read_op(std::string_view field, Block& command) {
  if (field == "rapid") {
    command.op = Op::kRapid;
  } else if (field == "feed" || field == "inverse") {
    command.op = Op::kFeed;
    command.inverse_time = field == "inverse";
  } else if (field == "dwell") {
    command.op = Op::kDwell;
  } else {
    command.op = Op::kMCode;
    return !field.empty() && field[0] == 'M' && read_number(field.substr(1), command.m_code);
  }
  return true;
}

/// The name of the first field that is wrong, or nothing.
std::string_view read_row(std::string_view line, TraceRow& row) {
  std::string_view names = kTraceHeader;
  Block& command = row.command;
  Joints& q = command.target;
  double* const numbers[] = {&row.start,
                             &row.end,
                             &q.x,
                             &q.y,
                             &q.z,
                             &q.a,
                             &q.c,
                             &command.feed,
                             &row.pose.tip.x,
                             &row.pose.tip.y,
                             &row.pose.tip.z,
                             &row.pose.axis.x,
                             &row.pose.axis.y,
                             &row.pose.axis.z,
                             &row.peak_rate,
                             &row.peak_acceleration};
  const auto next = [](std::string_view& text) {
    const std::size_t comma = text.find(',');
    const std::string_view field = text.substr(0, comma);
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
    return field;
  };
  for (std::size_t i = 0; i < kFields; ++i) {
    const std::string_view name = next(names), field = next(line);
    const bool good = i == 0   ? read_number(field, row.block)
                      : i == 1 ? read_number(field, command.line)
                      : i == 2 ? read_op(field, command)
                               : read_number(field, *numbers[i - 3]) && std::isfinite(*numbers[i - 3]);
    if (!good) return name;
  }
  if (command.op == Op::kMCode) {
    command.spindle = command.feed;
    command.feed = 0.0;
  }
  return line.empty() ? std::string_view{} : "the end of the row";
}

}  // namespace

void write_trace_header(std::ostream& out) { out << kTraceHeader << '\n'; }

void write_trace_row(const TraceRow& row, std::ostream& out) {
  const Block& command = row.command;
  const Joints& q = command.target;
  Row text;
  text.put(row.block);
  text.put(std::uint64_t{command.line});
  put_op(command, text);
  text.put(row.start, kTimeDecimals);
  text.put(row.end, kTimeDecimals);
  for (const double axis : {q.x, q.y, q.z, q.a, q.c}) text.put(axis, kAxisDecimals);
  text.put(command.op == Op::kMCode ? command.spindle : command.feed, kAxisDecimals);
  const Pose& pose = row.pose;
  for (const double value : {pose.tip.x, pose.tip.y, pose.tip.z, pose.axis.x, pose.axis.y, pose.axis.z})
    text.put(value, kPoseDecimals);
  for (const double peak : {row.peak_rate, row.peak_acceleration}) text.put(peak, kRateDecimals);
  const std::string_view line = text.line();
  out.write(line.data(), static_cast<std::streamsize>(line.size()));
}

Result<std::vector<TraceRow>> read_trace(std::istream& in, const std::string& name) {
  std::string line;
  if (!std::getline(in, line) || line != kTraceHeader)
    return fail(Code::kInput, name + ":1: not a trace; its first line must be " + kTraceHeader);
  std::vector<TraceRow> rows;
  for (std::uint64_t number = 2; std::getline(in, line) && !in.eof(); ++number) {
    TraceRow row;
    const std::string_view wrong = read_row(line, row);
    if (!wrong.empty())
      return fail(Code::kInput, name + ":" + std::to_string(number) + ": " + std::string(wrong) +
                                    " is missing or malformed");
    rows.push_back(row);
  }
  if (in.bad()) return fail(Code::kIo, name + ": cannot be read to its end");
  return rows;
}

}  // namespace tiltfeed::sim
