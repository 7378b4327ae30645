// "Resend: n": what the firmware has, what it wants again, and when that is not believed.

#include <utility>

#include "daemon/protocol/reprap_session.h"

namespace tiltfeed::daemon {

namespace {

/// The same number asked for so often, one after the other: it will never arrive.
constexpr int kMostRepeats = 10;
/// After a resend the lines that were on their way are refused, too, each with a resend of its own. Nothing
/// is sent until that is over: longer than a window of lines and the reply latency of an adapter together.
constexpr Time kQuiet = std::chrono::milliseconds(60);

}  // namespace

/// The firmware takes lines strictly in order: asking for n says that it has all lines before n.
void RepRapSession::on_resend(const RepRapReply& reply) {
  last_heard_ = now_;
  resend_ok_due_ = true;
  const std::optional<std::uint64_t> last = std::exchange(last_line_, std::nullopt);
  std::uint64_t number = reply.line.value_or(0);
  const std::uint64_t first = next_number_ - history_.size();
  std::uint64_t first_known = first;
  if (last && number != *last + 1) number = *last + 1;  // one of the two is damaged: judged by the window
  if (!reply.line && !last) return;
  if (number < first && last && reply.line && *reply.line == *last + 1) {
    if (!take_back(number)) return;
    first_known = next_number_ - history_.size();
  }
  if (number < first_known || number > due_) return;  // outside the window: damaged
  if (std::exchange(rounds_begun_, false)) {
    ++resends_;
    repeats_ = number == repeated_number_ ? repeats_ + 1 : 1;
  }
  repeated_number_ = number;
  quiet_until_ = now_ + kQuiet;
  if (repeats_ > kMostRepeats)
    return fault(Code::kLink, "the firmware asks for line number " + std::to_string(number) +
                                  " again and again: the line is disturbed, or it cannot take this line");
  if (number > first) {
    if (!probing_) owed_ += number - first;
    probes_ = 0;
  }
  probing_ = false;
  settle_before(number);
  if (is_final(phase_)) return;
  due_ = number;
}

/// An ok was taken for that of another line: what the firmware still wants becomes unsettled again.
bool RepRapSession::take_back(std::uint64_t number) {
  if (settled_.empty() || settled_.front().number > number) return false;
  while (!settled_.empty() && settled_.back().number >= number) {
    history_.push_front(std::move(settled_.back()));
    settled_.pop_back();
    if (history_.front().kind != Kind::kLine) continue;
    --acknowledged_;
    recent_.take_back();
  }
  owed_ = 0;
  return true;
}

}  // namespace tiltfeed::daemon
