// What a CNC control says to a drip feed: any bytes. After DC3 nothing leaves until DC1, and never more than
// the wire sends in the time that is promised.

#include "daemon/protocol/drip_session.h"
#include "tests/fuzz/fuzz_session.h"

using namespace tiltfeed;
using namespace tiltfeed::config;
using namespace tiltfeed::daemon;

FUZZ_TARGET(drip) {
  DripOptions options;
  options.total = kFuzzLines;
  for (const bool wait : {true, false}) {
    options.format.wait_for_start = wait;
    DripSession session(options, Time{0});
    drive(session, bytes, [](DripSession& s) {
      if (s.state().machine == "XOFF") HOLDS(s.output(s.deadline()).empty());
    });
  }
}
