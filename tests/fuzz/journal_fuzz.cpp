// Journals of any content: what is concluded never says that less may have run than the records do, and never
// that nothing has run where the journal is not whole.

#include "daemon/journal/run_recorder.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;
using namespace tiltfeed::config;
using namespace tiltfeed::daemon;

FUZZ_TARGET(journal) {
  const JournalContent content = read_journal(bytes);
  HOLDS(content.records * kRecordBytes <= bytes.size() && content.damaged <= content.records);
  RunSubject now;
  now.total = 1000;
  if (!content.last) {
    const ResumeDecision lost = decide_resume(content, now);
    HOLDS(lost.way == ResumeWay::kUncertain && lost.executed == 0 && lost.may_have == now.total);
    return;
  }
  const RunRecord& last = *content.last;
  const auto again = encode_record(last, 7);
  HOLDS(decode_record({again.data(), again.size()}, 7) == last);
  now.program = last.program;
  now.total = last.total;
  now.host = last.host;
  now.link = static_cast<LinkKind>(last.link);
  const ResumeDecision decision = decide_resume(content, now);
  HOLDS(decision.may_have >= decision.executed && decision.may_have >= last.offered);
  HOLDS(decision.may_have <= last.total);
  if (content.lost > 1) HOLDS(decision.may_have > last.reserved || last.reserved == last.total);
  if (content.lost > 0) HOLDS(decision.may_have >= last.reserved);
  if (!content.ended) HOLDS(decision.may_have == last.total);
  if (decision.way == ResumeWay::kContinue) HOLDS(is_provable(now.link) && last.boot_id != 0);
  if (decision.way == ResumeWay::kFresh) HOLDS(last.reserved == 0 && content.lost <= 1 && content.ended);
}
