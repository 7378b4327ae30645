// Where a Grbl controller says that the axes are, against where the program leads.

#include <algorithm>
#include <cmath>

#include "daemon/protocol/grbl_session.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;

/// Positions have three decimals in mm; with four they are inches.
constexpr int kMostDecimals = 3;
/// A status report has no checksum, so one strange place is asked for again.
constexpr int kStrangeReports = 2;
/// Offsets come with every tenth report of a machine that stands (Grbl 1.1, grblHAL).
constexpr int kMostOffsetPolls = 40;
constexpr Time kProofPoll = milliseconds(20);
/// A drive that follows late arrives within this many polls.
constexpr int kMostProofPolls = 25;

}  // namespace

double GrblSession::rounding() const { return 0.5 * std::pow(10.0, -status_.decimals); }

/// The reported place in the program's coordinates, as far as it can be known.
std::optional<AxisValues> GrblSession::place() const {
  const std::size_t count = status_.axes.size();
  if (count == 0 || count > kMostAxes || status_.decimals > kMostDecimals) return std::nullopt;
  if (!status_.in_work && offset_.size() != count) return std::nullopt;
  const std::string_view letters =
      axis_letters_.size() == count ? std::string_view(axis_letters_) : kAxisLetters.substr(0, 3);
  AxisValues place = no_axes();
  for (std::size_t i = 0; i < std::min(count, letters.size()); ++i)
    if (const std::size_t axis = kAxisLetters.find(letters[i]); axis != kAxisLetters.npos)
      place[axis] = status_.axes[i] - (status_.in_work ? 0.0 : offset_[i]);
  return place;
}

/// Another offset means other places of all lines: they are known again when they are stated again.
void GrblSession::take_offset() {
  if (status_.offset.empty() || status_.offset == offset_) return;
  if (!offset_.empty() && !is_opening(phase_)) watch_.unsettle();
  offset_ = status_.offset;
}

void GrblSession::follow_position() {
  const std::string& state = status_.state;
  if (state.starts_with("Check"))
    return fault(Code::kLink, "the controller is in check mode: it answers and moves nothing", false);
  const bool by_hand = phase_ == Phase::kToolChange || state == "Tool" || state == "Jog";
  if (by_hand_ && !by_hand) watch_.unsettle();
  by_hand_ = by_hand;
  const bool on_its_way = state == "Run" || state == "Idle" || state.starts_with("Hold");
  const std::optional<AxisValues> at = place();
  if (!at || by_hand || !on_its_way) return;
  const std::string wrong = watch_.judge(*at, rounding());
  if (wrong.empty()) {
    strange_ = 0;
    return;
  }
  next_poll_ = now_;
  if (++strange_ < kStrangeReports) return;
  fault(Code::kLink,
        "the machine is at " + describe(*at) + ", and " + wrong +
            ": it has read another program than was sent, or has moved otherwise; home it",
        true);
}

/// After the ok of the barrier: the axes stand at the program's end, as far as they are reported.
void GrblSession::prove_end() {
  if (!proving_ || phase_ != Phase::kDrain) return;
  const std::optional<AxisValues> at = place();
  const bool told = at || (!status_.axes.empty() && status_.decimals <= kMostDecimals);
  const int most = at ? kMostProofPolls : kMostOffsetPolls;
  if (!watch_.knows_end() || !told || (at && watch_.at_end(*at, rounding())) ||
      (!at && proof_polls_ >= most)) {
    recent_.clear();
    return move(Event::kProved);
  }
  if (++proof_polls_ <= most) {
    next_poll_ = std::min(next_poll_, now_ + kProofPoll);
    return;
  }
  fault(Code::kLink,
        "every line was answered, but the machine is at " + describe(*at) +
            " and not at the program's end, " + describe(watch_.end()) + ": it has not moved as programmed",
        true);
}

/// The axes stand for good: only lines that pass there can have run in part. Ln: names the one in execution,
/// else the place does, with every line that comes near it.
void GrblSession::narrow_range() {
  std::vector<std::uint64_t> open;
  for (std::size_t i = 0; i < recent_.size(); ++i) open.push_back(recent_.number(i));
  for (const Flight& flight : in_flight_)
    if (flight.kind == Kind::kLine && reached_wire(flight)) open.push_back(flight.line.number);
  LineRange lines;
  if (numbers_lines_ && status_.line > 0) lines.first = lines.last = static_cast<std::uint64_t>(status_.line);
  if (const auto at = place(); lines.first == 0 && at) lines = watch_.lines_at(*at, rounding());
  const auto first = std::find(open.begin(), open.end(), lines.first);
  const auto last = std::find(open.begin(), open.end(), lines.last);
  if (first == open.end() || last == open.end()) return;
  const std::uint64_t run = options_.before + acknowledged_ - recent_.size();
  stood_ = {run + static_cast<std::uint64_t>(first - open.begin()),
            run + static_cast<std::uint64_t>(last - open.begin()) + 1, lines};
}

}  // namespace tiltfeed::daemon
