// What a Grbl controller says: any bytes, in any pieces, never settle more lines than were sent.

#include "daemon/grbl_reply.h"
#include "daemon/grbl_session.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;

FUZZ_TARGET(grbl) {
  GrblOptions options;
  options.total = 50;
  options.longest = 10;
  Time now{0};
  GrblSession session(options, now);
  std::uint64_t pushed = 0, taken = 0;
  std::size_t at = 0;
  const auto byte = [&] { return at < bytes.size() ? static_cast<unsigned char>(bytes[at++]) : 0; };
  while (at < bytes.size() && !is_final(session.phase())) {
    while (session.wants_work() && pushed < 50) {
      Line line;
      line.number = ++pushed;
      line.text = "G1X" + std::to_string(pushed);
      line.alone = pushed % 17 == 0;
      session.push(line);
    }
    if (pushed == 50) session.end_of_program();
    const std::size_t offered = session.output(now).size();
    const std::size_t sent = std::min<std::size_t>(offered, byte());
    session.sent(sent);
    taken += sent;
    const std::size_t size = std::min<std::size_t>(byte(), bytes.size() - at);
    session.receive(bytes.substr(at, size), now);
    at += size;
    const int wish = byte();
    if (wish >= 250) session.command({static_cast<Order>(wish - 250), wish}, now);
    now += std::chrono::milliseconds(byte() * 20);
    const SendState state = session.state();
    HOLDS(state.executed <= state.acknowledged && state.acknowledged <= state.sent && state.sent <= pushed);
    HOLDS(session.window() == 0 || session.in_flight_bytes() <= session.window());
  }
  HOLDS(session.phase() != Phase::kDone || session.state().acknowledged == 50);
  for (std::size_t start = 0; start < bytes.size();) {
    const std::size_t end = std::min(bytes.find('\n', start), bytes.size());
    const std::string_view line = bytes.substr(start, end - start);
    if (classify_reply(line) == GrblReplyKind::kOk) HOLDS(line == "ok");
    if (classify_reply(line) == GrblReplyKind::kStatus) static_cast<void>(parse_status(line));
    static_cast<void>(parse_buffers(line));
    start = end + 1;
  }
}
