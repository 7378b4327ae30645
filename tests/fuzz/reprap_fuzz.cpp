// What a RepRap firmware says: any bytes never settle a line that has not left, nor one twice.

#include "daemon/protocol/reprap_reply.h"
#include "daemon/protocol/reprap_session.h"
#include "tests/fuzz/fuzz_session.h"

using namespace tiltfeed;
using namespace tiltfeed::config;
using namespace tiltfeed::daemon;

FUZZ_TARGET(reprap) {
  for (const int window : {0, 4}) {
    RepRapSession session({kFuzzLines, window}, Time{0});
    drive(session, bytes, [window](const RepRapSession& s) {
      HOLDS(s.window() >= 1 && s.window() <= 64 && (window == 0 || s.window() == 4));
    });
  }
  each_line(bytes, [](std::string_view line) {
    const RepRapReply reply = parse_reprap_reply(line);
    if (reply.kind == RepRapReplyKind::kOk) HOLDS(line.starts_with("ok"));
    if (reply.kind == RepRapReplyKind::kResend)
      HOLDS(line.find_first_of("0123456789") != line.npos || !reply.line);
  });
}
