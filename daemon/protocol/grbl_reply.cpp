#include "daemon/protocol/grbl_reply.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

/// A whole field as a number from 0 up, or -1.
int number(std::string_view text) {
  int value = -1;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = parsed.ec == std::errc() && parsed.ptr == text.data() + text.size();
  return whole && value >= 0 ? value : -1;
}

/// Takes the text up to `separator` (or the end) off `rest`.
std::string_view take_field(std::string_view& rest, char separator) {
  const std::size_t end = std::min(rest.find(separator), rest.size());
  const std::string_view field = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return field;
}

/// "1.000,-2.500": all of it or nothing. `decimals`: of the first figure.
std::vector<double> figures(std::string_view text, int& decimals) {
  std::vector<double> values;
  const std::string_view first = text.substr(0, text.find(','));
  decimals = first.find('.') == first.npos ? 0 : static_cast<int>(first.size() - first.find('.') - 1);
  do {
    const std::string_view one = take_field(text, ',');
    double value = 0.0;
    const auto parsed = std::from_chars(one.data(), one.data() + one.size(), value, std::chars_format::fixed);
    if (parsed.ec != std::errc() || parsed.ptr != one.data() + one.size() || !std::isfinite(value)) return {};
    values.push_back(value);
  } while (!text.empty());
  return values;
}

}  // namespace

GrblReplyKind classify_reply(std::string_view line) {
  if (line == "ok") return GrblReplyKind::kOk;
  if (line.starts_with("error")) return GrblReplyKind::kError;
  if (line.starts_with("ALARM")) return GrblReplyKind::kAlarm;
  if (line.starts_with("Grbl")) return GrblReplyKind::kBanner;
  if (line.empty()) return GrblReplyKind::kGarbled;
  switch (line.front()) {
    case '<':
      return line.size() > 2 && line.back() == '>' ? GrblReplyKind::kStatus : GrblReplyKind::kGarbled;
    case '[':
      return line.back() == ']' ? GrblReplyKind::kFeedback : GrblReplyKind::kGarbled;
    case '$':
    case '>':
      return GrblReplyKind::kFeedback;
    default:
      return GrblReplyKind::kGarbled;
  }
}

std::string parse_axis_letters(std::string_view line) {
  if (!line.starts_with("[AXS:") || line.back() != ']') return "";
  line.remove_prefix(5);
  line.remove_suffix(1);
  const int count = number(take_field(line, ':'));
  return count == static_cast<int>(line.size()) ? std::string(line) : "";
}

bool is_standing(std::string_view state) {
  for (const std::string_view one : {"Hold:0", "Hold", "Idle", "Tool", "Door:0", "Check"})
    if (state == one) return true;
  return false;
}

std::optional<GrblStatus> parse_status(std::string_view line) {
  line.remove_prefix(1);
  line.remove_suffix(1);
  GrblStatus status;
  // Grbl 0.9 separates by commas, all later ones by bars.
  const std::string_view state = take_field(line, line.find('|') != line.npos ? '|' : ',');
  const std::string_view word = state.substr(0, state.find(':'));
  const bool letters = std::all_of(word.begin(), word.end(),
                                   [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); });
  if (word.empty() || !letters) return std::nullopt;
  status.state = wire_text(state);
  while (!line.empty()) {
    std::string_view field = take_field(line, '|');
    if (field.starts_with("Bf:")) {
      field.remove_prefix(3);
      status.planner_free = number(take_field(field, ','));
      status.receive_free = number(take_field(field, ','));
    } else if (field.starts_with("MPos:") || field.starts_with("WPos:") || field.starts_with("Ln:")) {
      status.position += field;
      status.in_work = status.in_work || field.starts_with("WPos:");
      if (!field.starts_with("Ln:")) status.axes = figures(field.substr(5), status.decimals);
      if (field.starts_with("Ln:")) status.line = number(field.substr(3));
    } else if (int ignored = 0; field.starts_with("WCO:")) {
      status.offset = figures(field.substr(4), ignored);
    } else if (field.starts_with("FS:")) {
      const std::vector<double> speeds = figures(field.substr(3), ignored);
      if (speeds.size() >= 2) status.feed = speeds[0], status.spindle = speeds[1];
    } else if (field.starts_with("Pn:")) {
      status.inputs = wire_text(field.substr(3));
    } else if (field.starts_with("A:")) {
      status.switched = wire_text(field.substr(2));
    } else if (field.starts_with("Ov:")) {
      field.remove_prefix(3);
      status.feed_override = number(take_field(field, ','));
      status.rapid_override = number(take_field(field, ','));
      status.spindle_override = number(take_field(field, ','));
    }
  }
  return status;
}

std::optional<GrblBuffers> parse_buffers(std::string_view line) {
  if (!line.starts_with("[OPT:") || line.back() != ']') return std::nullopt;
  line.remove_prefix(5);
  line.remove_suffix(1);
  take_field(line, ',');
  GrblBuffers buffers;
  buffers.planner = number(take_field(line, ','));
  buffers.receive = number(take_field(line, ','));
  if (buffers.planner < 0 || buffers.receive < 0) return std::nullopt;
  return buffers;
}

}  // namespace tiltfeed::daemon
