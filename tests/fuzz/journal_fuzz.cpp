// Journals of any content: what is concluded never says that less may have run than the records do.

#include "daemon/run_journal.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;

FUZZ_TARGET(journal) {
  const JournalContent content = read_journal(bytes);
  HOLDS(content.records * kRecordBytes <= bytes.size() && content.damaged <= content.records);
  if (!content.last) return;
  const RunRecord& last = *content.last;
  const auto again = encode_record(last, 7);
  HOLDS(decode_record({again.data(), again.size()}, 7) == last);
  RunSubject now;
  now.program = last.program;
  now.total = last.total;
  now.host = last.host;
  now.link = static_cast<LinkKind>(last.link);
  const ResumeDecision decision = decide_resume(content, now);
  HOLDS(decision.may_have >= decision.executed && decision.may_have >= last.offered);
  if (decision.way == ResumeWay::kContinue) HOLDS(is_provable(now.link) && last.boot_id != 0);
  if (decision.way == ResumeWay::kFresh) HOLDS(last.offered == 0);
}
