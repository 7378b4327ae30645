#include "daemon/protocol/reprap_reply.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace tiltfeed::daemon {

namespace {

/// The digits at the start of `text`; nothing when there is none, or when something else follows them.
std::optional<std::uint64_t> whole_number(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  if (text.starts_with('N')) text.remove_prefix(1);
  std::uint64_t value = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

RepRapReply parse_ok(std::string_view rest) {
  RepRapReply reply{RepRapReplyKind::kOk};
  while (!rest.empty()) {
    if (rest.front() != ' ') return {};  // "okay", "ok[]": a fragment is never counted
    rest.remove_prefix(1);
    const std::string_view word = rest.substr(0, rest.find(' '));
    rest.remove_prefix(word.size());
    if (word.empty()) continue;
    const auto value = whole_number(word.substr(1));
    if (word.front() == 'N' && value) reply.line = value;
    if (word.front() == 'B' && value && *value <= 1024) reply.free_commands = static_cast<int>(*value);
  }
  return reply;
}

/// Errors of one line, which the firmware asks for again.
bool concerns_a_line(std::string_view text) {
  for (const std::string_view mark : {"Line Number", "checksum", "Checksum"})
    if (text.find(mark) != text.npos) return true;
  return false;
}

}  // namespace

RepRapReply parse_reprap_reply(std::string_view line) {
  constexpr std::string_view kLastLine = "Last Line:";
  if (line.starts_with("ok")) return parse_ok(line.substr(2));
  if (line.starts_with("Resend:")) return {RepRapReplyKind::kResend, whole_number(line.substr(7))};
  if (line.starts_with("rs ")) return {RepRapReplyKind::kResend, whole_number(line.substr(3))};
  if (line.starts_with("!!")) return {RepRapReplyKind::kHalted};
  if (line.starts_with("Error:")) {
    RepRapReply reply{concerns_a_line(line) ? RepRapReplyKind::kError : RepRapReplyKind::kHalted};
    if (const std::size_t at = line.find(kLastLine); at != line.npos)
      reply.line = whole_number(line.substr(at + kLastLine.size()));
    return reply;
  }
  if (line.starts_with("echo:busy") || line.starts_with("busy:")) {
    RepRapReply reply{RepRapReplyKind::kBusy};
    reply.paused = line.find("paused") != line.npos;
    return reply;
  }
  if (line == "start") return {RepRapReplyKind::kStart};
  if (line.starts_with("FIRMWARE_NAME:") || line.starts_with("Cap:")) return {RepRapReplyKind::kIdentity};
  return {};
}

std::optional<AxisValues> parse_reprap_place(std::string_view line) {
  if (!line.starts_with("X:")) return std::nullopt;
  AxisValues place = no_axes();
  while (!line.empty() && !line.starts_with("Count")) {
    const std::string_view word = line.substr(0, line.find(' '));
    line.remove_prefix(std::min(word.size() + 1, line.size()));
    if (word.empty()) continue;
    double value = 0.0;
    const bool named = word.size() > 2 && word[1] == ':';
    const auto parsed = std::from_chars(word.data() + (named ? 2 : 0), word.data() + word.size(), value,
                                        std::chars_format::fixed);
    if (!named || parsed.ec != std::errc() || parsed.ptr != word.data() + word.size() ||
        !std::isfinite(value))
      return std::nullopt;
    if (const std::size_t axis = kAxisLetters.find(word[0]); axis != kAxisLetters.npos) place[axis] = value;
  }
  return place;
}

}  // namespace tiltfeed::daemon
