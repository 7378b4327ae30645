// Requests: what is understood is written and understood again.

#include "daemon/service/api.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;
using namespace tiltfeed::daemon;

FUZZ_TARGET(api) {
  const auto request = parse_request(bytes);
  if (!request) {
    HOLDS(request.error().code == Code::kUsage);
    const std::string refusal = write_refusal(request.error());
    return HOLDS(refusal.find('\n') == refusal.size() - 1);
  }
  std::string line = write_request(*request);
  HOLDS(line.back() == '\n' && line.find('\n') == line.size() - 1);
  line.pop_back();
  const auto again = parse_request(line);
  HOLDS(again && again->op == request->op && again->job == request->job && again->block == request->block &&
        again->from == request->from && again->queue == request->queue &&
        again->confirmed == request->confirmed);
  if (request->op != ApiOp::kMachine) return;
  HOLDS(again->order == request->order && again->held == request->held && again->stop == request->stop);
  HOLDS(request->order != 0 || (again->command == request->command && again->words == request->words));
}
