// What a Grbl controller says: any bytes, in any pieces, never settle more lines than were sent.

#include "daemon/protocol/grbl_reply.h"
#include "daemon/protocol/grbl_session.h"
#include "tests/fuzz/fuzz_session.h"

using namespace tiltfeed;
using namespace tiltfeed::config;
using namespace tiltfeed::daemon;

FUZZ_TARGET(grbl) {
  GrblOptions options;
  options.total = kFuzzLines;
  options.longest = 10;
  GrblSession session(options, Time{0});
  drive(session, bytes,
        [](const GrblSession& s) { HOLDS(s.window() == 0 || s.in_flight_bytes() <= s.window()); });
  each_line(bytes, [](std::string_view line) {
    if (classify_reply(line) == GrblReplyKind::kOk) HOLDS(line == "ok");
    if (classify_reply(line) == GrblReplyKind::kStatus) static_cast<void>(parse_status(line));
    static_cast<void>(parse_buffers(line));
  });
}
