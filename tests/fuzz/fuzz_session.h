#pragma once
// Drives a session of lines by fuzzed bytes: how much the wire takes, what comes back and in which pieces, an
// operator's orders, time. Holds whatever the bytes: counts never cross, and done means everything.

#include <algorithm>
#include <string>
#include <string_view>

#include "daemon/program/line_reader.h"
#include "daemon/protocol/session.h"
#include "tests/fuzz/fuzz.h"

namespace tiltfeed {
using namespace daemon;

inline constexpr std::uint64_t kFuzzLines = 50;

/// `look` is called after each round with the session.
template <class Session, class Look>
void drive(Session& session, std::string_view bytes, Look look) {
  constexpr int kFirstOrder = 250;  // bytes from here are orders
  Time now{0};
  std::uint64_t pushed = 0;
  std::size_t at = 0;
  bool ended = false;
  const auto byte = [&] { return at < bytes.size() ? static_cast<unsigned char>(bytes[at++]) : 0; };
  while (at < bytes.size() && !is_final(session.phase())) {
    while (session.wants_work() && !ended) {
      if (pushed == kFuzzLines) {
        session.end_of_program();
        ended = true;
        break;
      }
      Line line;
      line.number = ++pushed;
      line.text = "G1X" + std::to_string(pushed);
      line.alone = line.waits = pushed % 17 == 0;
      session.push(line);
    }
    const std::size_t offered = session.output(now).size();
    session.sent(std::min<std::size_t>(offered, byte()));
    const std::size_t size = std::min<std::size_t>(byte(), bytes.size() - at);
    session.receive(bytes.substr(at, size), now);
    at += size;
    const int wish = byte();
    if (wish >= kFirstOrder) session.command({static_cast<Order>(wish - kFirstOrder), wish}, now);
    now += std::chrono::milliseconds(byte() * 20);
    const SendState state = session.state();
    HOLDS(state.executed <= state.acknowledged && state.acknowledged <= state.sent);
    HOLDS(state.sent <= kFuzzLines && (state.sent <= pushed || state.executed == 0));
    HOLDS(state.uncertain.first <= state.uncertain.last && state.uncertain.last <= pushed);
    look(session);
  }
  HOLDS(session.phase() != Phase::kDone || session.state().acknowledged == kFuzzLines);
  HOLDS(!is_final(session.phase()) || session.phase() == Phase::kDone || !session.error().message.empty());
}

/// Each line of the bytes by itself.
template <class Parse>
void each_line(std::string_view bytes, Parse parse) {
  for (std::size_t start = 0; start < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\n', start), bytes.size());
    parse(bytes.substr(start, end - start));
    start = end + 1;
  }
}

}  // namespace tiltfeed
