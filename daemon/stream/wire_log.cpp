#include "daemon/stream/wire_log.h"

#include <cstdio>

namespace tiltfeed::daemon {

void WireLog::close(Side& side, Time at) {
  side.lines.push_back({order_++, at, std::move(side.open)});
  side.open.clear();
  if (side.lines.size() > kLines) side.lines.pop_front();
}

void WireLog::take(Way way, std::string_view bytes, Time at) {
  constexpr char kDigits[] = "0123456789abcdef";
  Side& side = sides_[way == Way::kOut ? 0 : 1];
  if (messages_) {
    for (std::size_t i = 0; i < bytes.size() && side.open.size() < kLongest; ++i) {
      const auto byte = static_cast<unsigned char>(bytes[i]);
      side.open += kDigits[byte >> 4];
      side.open += kDigits[byte & 15];
      if (i % 2 == 1) side.open += ' ';
    }
    return close(side, at);
  }
  for (const char c : bytes) {
    if (c == '\n') {
      close(side, at);
    } else if (side.open.size() < kLongest) {
      const auto byte = static_cast<unsigned char>(c);
      if (byte >= ' ' && byte < 0x7F)
        side.open += c;
      else
        side.open += std::string("\\x") + kDigits[byte >> 4] + kDigits[byte & 15];
    }
  }
}

std::string WireLog::text() const {
  std::string out;
  char stamp[40];
  std::size_t next[2] = {0, 0};
  for (;;) {
    int pick = -1;
    for (int s = 0; s < 2; ++s) {
      if (next[s] == sides_[s].lines.size()) continue;
      if (pick < 0 || sides_[s].lines[next[s]].order < sides_[pick].lines[next[pick]].order) pick = s;
    }
    if (pick < 0) break;
    const Entry& entry = sides_[pick].lines[next[pick]++];
    std::snprintf(stamp, sizeof stamp, "%.6f %c ", std::chrono::duration<double>(entry.at).count(),
                  pick == 0 ? '>' : '<');
    out += stamp + entry.text + "\n";
  }
  for (int s = 0; s < 2; ++s)
    if (!sides_[s].open.empty()) out += (s == 0 ? "(open) > " : "(open) < ") + sides_[s].open + "\n";
  return out;
}

}  // namespace tiltfeed::daemon
