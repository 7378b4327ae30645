#pragma once
// One run and its journal: what must be on the disk before a block may leave, and, after a run was cut off,
// what is known of the machine and how it may go on.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "daemon/journal/journal.h"
#include "daemon/stream/stream.h"
#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

/// The link's controller counts what it executed and keeps the count when we are gone: the Modbus ring.
bool is_provable(LinkKind kind);
/// Of the running kernel. Errors: kIo.
Result<HostBoot> host_boot();

/// What a run is of.
struct RunSubject {
  std::uint64_t job = 0, total = 0;
  Sha256 program{};
  LinkKind link = LinkKind::kGrbl;
  std::uint16_t session_id = 0;
  HostBoot host{};
  /// The run begins after so many blocks, the newest of them the tool change that was made; 0: at the start.
  std::uint64_t after = 0;
  /// Its last block; before the program's end: a tool change comes then.
  std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
};

/// Writes the journal while a run streams. Properties, whatever the clock does: 1 a block leaves only after
/// a durable record that allows it and names the controller's boot_id. 2 What a killed process leaves says at
/// most kOfferSlack blocks more than left. 3 That all blocks are executed is durable before the session is
/// closed.
class RunRecorder {
 public:
  /// A new run; the journal holds nothing else afterwards. Errors: kIo.
  static Result<RunRecorder> begin(Journal& journal, const RunSubject& subject);
  /// The run that the journal holds goes on; blocks to `may_have` may have left. Requires: it has one.
  /// Errors: kIo.
  static Result<RunRecorder> go_on(Journal& journal, const RunSubject& subject, std::uint64_t may_have);

  /// StreamHooks::reserve: allows block `next` and perhaps some more. Errors: kIo: it must not leave.
  Result<std::uint64_t> reserve(std::uint64_t next, Time now);
  /// StreamHooks::progress. Errors: kIo.
  Result<void> progress(const SendState& state, Time now);
  /// The run has ended. Errors: kIo.
  Result<void> end(RunEvent event, const SendState& state);
  const RunRecord& record() const { return record_; }

 private:
  RunRecorder(Journal& journal, const RunRecord& record, std::uint64_t last)
      : journal_(&journal), record_(record), last_(std::min(last, record.total)) {}
  Result<void> write(bool durable);
  void take(const SendState& state);

  Journal* journal_;
  RunRecord record_;
  std::uint64_t last_;  ///< block of this run
  std::uint64_t chunk_ = 64;
  std::optional<Time> reserved_at_, written_at_, synced_at_;
};

/// Blocks that a record may claim beyond those that left: spares a write for each turn.
inline constexpr std::uint64_t kOfferSlack = 16;

enum class ResumeWay {
  kFresh,       ///< nothing was sent: begins with the first block
  kContinue,    ///< the controller's counters decide: `ring`
  kFinished,    ///< every block is executed
  kToolChange,  ///< the operator changes the tool, then it goes on after that block
  kUncertain,   ///< nothing moves by itself: an operator decides where to re-enter
};

struct ResumeDecision {
  ResumeWay way = ResumeWay::kUncertain;
  std::uint64_t executed = 0;  ///< blocks that have surely run
  std::uint64_t may_have = 0;  ///< blocks executed + 1 to this one may have run
  bool elsewhere = false;  ///< the axes were not where the executed blocks lead: perhaps those have not run
  Attachment ring;         ///< of kContinue
  std::string text;        ///< for the operator: why, and the range in blocks
};

/// "blocks 8 to 20 may have run, earlier ones have, later ones have not". `total`: of the program.
std::string range_text(const ResumeDecision& decision, std::uint64_t total);

/// Of a run that was begun: its journal held a record before anybody could call it that. Properties: executed
/// <= may_have; what the journal cannot show any more may have run. Pure. `program` and `total` of `now` are
/// those of the file as it is, `host` is the running kernel's.
ResumeDecision decide_resume(const JournalContent& journal, const RunSubject& now);

}  // namespace tiltfeed::daemon
