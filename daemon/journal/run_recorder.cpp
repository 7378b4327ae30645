#include "daemon/journal/run_recorder.h"

#include <algorithm>
#include <chrono>
#include <fstream>

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Progress is written this often and made durable this often, so a slow disk is asked once a second.
constexpr Time kWriteInterval = milliseconds(100);
constexpr Time kSyncInterval = seconds(1);
/// A reservation should last about this long: after a power loss no more than that is uncertain.
constexpr Time kShortReserve = seconds(1), kLongReserve = seconds(4);
constexpr std::uint64_t kMinReserve = 64, kMaxReserve = 4096;
/// Sequence numbers on the ring are 16 bit and compared by their signed difference.
constexpr std::uint64_t kSequenceHalf = 1u << 15;

std::int64_t wall_ms() {
  return std::chrono::duration_cast<milliseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// True when the time has come, or when the clock went back.
bool due(const std::optional<Time>& last, Time now, Time interval) {
  return !last || now < *last || now - *last >= interval;
}

/// Nothing may follow such a record at once but one that says that blocks leave.
bool begins(RunEvent event) { return event == RunEvent::kBegan || event == RunEvent::kToolChange; }

}  // namespace

bool is_provable(LinkKind kind) { return is_ring(kind); }

Result<HostBoot> host_boot() {
  const std::string path = "/proc/sys/kernel/random/boot_id";
  std::ifstream in(path);
  std::string text, digits;
  std::getline(in, text);
  for (const char c : text)
    if (c != '-') digits += c;
  HostBoot boot{};
  if (digits.size() != 2 * boot.size()) return fail(Code::kIo, path + ": cannot be read; is /proc mounted?");
  for (std::size_t i = 0; i < boot.size(); ++i)
    boot[i] = static_cast<std::uint8_t>(std::stoul(digits.substr(2 * i, 2), nullptr, 16));
  return boot;
}

// ---- while it streams ----------------------------------------------------------------------------------

Result<RunRecorder> RunRecorder::begin(Journal& journal, const RunSubject& subject) {
  RunRecord record;
  const std::optional<RunRecord>& last = journal.content().last;
  record.run = last ? last->run + 1 : 1;
  record.link = static_cast<std::uint8_t>(subject.link);
  record.session_id = subject.session_id;
  record.job = subject.job;
  record.total = subject.total;
  record.program = subject.program;
  record.host = subject.host;
  // The tool change is made when a block after it leaves: until then it can be made again.
  if (subject.after > 0) {
    record.event = RunEvent::kToolChange;
    record.executed = record.acknowledged = subject.after - 1;
    record.offered = record.reserved = subject.after;
  }
  record.wall_ms = wall_ms();
  if (Result<void> begun = journal.start_with(record); !begun) return tl::unexpected<Error>(begun.error());
  return RunRecorder(journal, record, subject.last);
}

Result<RunRecorder> RunRecorder::go_on(Journal& journal, const RunSubject& subject, std::uint64_t may_have) {
  RunRecord record = *journal.content().last;
  record.offered = std::max(record.offered, may_have);
  record.reserved = std::max(record.reserved, may_have);
  record.host = subject.host;
  record.event = RunEvent::kBegan;
  RunRecorder recorder(journal, record, subject.last);
  if (Result<void> written = recorder.write(true); !written) return tl::unexpected<Error>(written.error());
  return recorder;
}

Result<void> RunRecorder::write(bool durable) {
  record_.wall_ms = wall_ms();
  if (Result<void> written = journal_->append(record_); !written) return written;
  return durable ? journal_->sync() : Result<void>{};
}

void RunRecorder::take(const SendState& state) {
  if (state.boot != 0) record_.boot_id = state.boot;
  // Whoever claims more than left is not believed.
  const auto grown = [this](std::uint64_t known, std::uint64_t claimed) {
    return std::max(known, std::min(claimed, record_.offered));
  };
  record_.executed = grown(record_.executed, state.executed);
  record_.acknowledged = grown(record_.acknowledged, std::max(state.acknowledged, record_.executed));
  record_.elsewhere = record_.elsewhere || state.elsewhere;
}

Result<std::uint64_t> RunRecorder::reserve(std::uint64_t next, Time now) {
  const bool durable = next > record_.reserved;
  if (next > last_ || next > record_.reserved + 1)
    return fail(Code::kInput, "block " + std::to_string(next) + " comes where " +
                                  std::to_string(std::min(record_.reserved + 1, last_)) + " of " +
                                  std::to_string(record_.total) +
                                  " was expected: the program was changed while it ran; it is stopped");
  if (durable) {
    const Time lasted = reserved_at_ ? now - *reserved_at_ : kShortReserve;
    if (lasted < kShortReserve) chunk_ = std::min(chunk_ * 2, kMaxReserve);
    if (lasted > kLongReserve) chunk_ = std::max(chunk_ / 2, kMinReserve);
    // A record that begins a run is never followed by a reservation at once: may_have_left counts on that.
    if (begins(record_.event)) {
      record_.event = RunEvent::kStreaming;
      if (const Result<void> written = write(false); !written) return tl::unexpected<Error>(written.error());
    }
    record_.reserved = std::min(next + chunk_, last_);
    reserved_at_ = now;
  }
  record_.offered = std::max(record_.offered, std::min(next + kOfferSlack - 1, record_.reserved));
  if (const Result<void> written = write(durable); !written) return tl::unexpected<Error>(written.error());
  return record_.offered;
}

Result<void> RunRecorder::progress(const SendState& state, Time now) {
  const bool bound = state.boot != 0 && record_.boot_id == 0;
  const RunEvent end = last_ < record_.total ? RunEvent::kToolChange : RunEvent::kExecuted;
  const bool finished = record_.event != end && record_.total > 0 && state.executed == last_;
  const bool news = state.executed > record_.executed || state.acknowledged > record_.acknowledged;
  if (!bound && !finished && !(news && due(written_at_, now, kWriteInterval))) return {};
  take(state);
  record_.event = finished ? end : RunEvent::kStreaming;
  written_at_ = now;
  const bool durable = bound || finished || due(synced_at_, now, kSyncInterval);
  if (durable) synced_at_ = now;
  return write(durable);
}

Result<void> RunRecorder::end(RunEvent event, const SendState& state) {
  take(state);
  record_.event = event;
  return write(true);
}

// ---- after it was cut off ------------------------------------------------------------------------------

namespace {

ResumeDecision uncertain(ResumeDecision decision, const std::string& why, const RunSubject& now,
                         std::uint64_t total) {
  // A drive does not tell where its axes are, so that nothing can enter a program for it.
  const std::string on =
      is_drive(now.link) ? "submit a program of what is left" : "re-enter with --from BLOCK";
  decision.way = ResumeWay::kUncertain;
  decision.text = why + "; " + range_text(decision, total) + "; ";
  decision.text += (decision.may_have > decision.executed ? "look at the machine, then " : "") + on;
  return decision;
}

/// The last block that may have left.
std::uint64_t may_have_left(const JournalContent& journal, const RunSubject& now) {
  const RunRecord& last = *journal.last;
  if (!journal.ended) return last.total;
  // Each record that is lost may have been a reservation, but for the one after that which begins a run.
  const std::uint64_t lost = journal.lost - (journal.lost > 0 && begins(last.event));
  if (lost > (last.total - last.reserved) / (kMaxReserve + 1)) return last.total;
  if (lost > 0) return last.reserved + lost * (kMaxReserve + 1);
  // The reservation was durable before anything left; `offered` is only as good as this host's memory.
  return last.host == now.host && journal.damaged + journal.lost == 0 ? last.offered : last.reserved;
}

}  // namespace

std::string range_text(const ResumeDecision& decision, std::uint64_t total) {
  if (decision.may_have <= decision.executed) return std::to_string(decision.executed) + " blocks have run";
  return numbered("block", {decision.executed + 1, decision.may_have}) + " may have run" +
         (decision.executed == 0 ? ""
          : decision.elsewhere   ? ", earlier ones may not have: the axes were not where they lead"
                                 : ", earlier ones have") +
         (decision.may_have < total ? ", later ones have not" : "");
}

ResumeDecision decide_resume(const JournalContent& journal, const RunSubject& now) {
  ResumeDecision decision;
  if (!journal.last) {
    decision.may_have = now.total;
    return uncertain(decision, "the journal of this run is lost or damaged", now, now.total);
  }
  const RunRecord& last = *journal.last;
  decision.executed = last.executed;
  decision.elsewhere = last.elsewhere;
  decision.may_have = may_have_left(journal, now);
  if (last.program != now.program || last.total != now.total)
    return uncertain(decision, "the program is not the one that was running", now, last.total);
  if (last.executed == last.total) {
    decision.way = ResumeWay::kFinished;
    decision.text =
        "all " + std::to_string(last.total) +
        (is_drive(now.link) ? " blocks were sent; this link proves no more" : " blocks are executed");
    return decision;
  }
  if (last.event == RunEvent::kToolChange && journal.whole()) {
    decision.way = ResumeWay::kToolChange;
    decision.may_have = decision.executed;
    decision.text = "the program stands before a tool change; " + std::to_string(decision.executed) +
                    " blocks have run, later ones have not";
    return decision;
  }
  if (decision.may_have == 0) {
    decision.way = ResumeWay::kFresh;
    decision.text = "nothing was sent";
    return decision;
  }
  const std::string loss = journal.whole() ? "" : "a part of the journal is lost or damaged, and ";
  if (!is_provable(static_cast<LinkKind>(last.link)) || last.link != static_cast<std::uint8_t>(now.link))
    return uncertain(decision, loss + "this link cannot prove what was executed", now, last.total);
  if (last.boot_id == 0 || decision.may_have - decision.executed >= kSequenceHalf)
    return uncertain(decision, loss + "the journal does not say enough to ask the controller", now,
                     last.total);
  decision.way = ResumeWay::kContinue;
  decision.ring = {last.session_id, last.boot_id, last.acknowledged, decision.may_have, decision.executed};
  decision.text = range_text(decision, last.total);
  return decision;
}

}  // namespace tiltfeed::daemon
