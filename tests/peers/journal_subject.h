#pragma once
// What a run of the journal's tests is of.

#include "daemon/files/sha256.h"
#include "daemon/journal/run_recorder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

inline RunSubject subject_of(std::uint64_t total, LinkKind kind = LinkKind::kModbusTcp) {
  RunSubject subject;
  subject.job = 4;
  subject.total = total;
  subject.program = sha256("program");
  subject.link = kind;
  subject.session_id = 99;
  subject.host[0] = 1;
  return subject;
}

}  // namespace tiltfeed
