// Where a RepRap firmware says that the axes are, once every line has run.

#include "daemon/protocol/reprap_session.h"

namespace tiltfeed::daemon {

namespace {

/// M114 prints two decimals. Its answer has no checksum, so one that is wrong is asked for again.
constexpr double kRounding = 0.005;
constexpr int kMostPlaces = 3;

}  // namespace

void RepRapSession::ask_place() {
  place_.reset();
  append({0, "M114"}, Kind::kPlace);
}

void RepRapSession::take_place(std::string_view line) {
  if (const std::optional<AxisValues> place = parse_reprap_place(line)) place_ = place;
}

/// The ok of M114. A firmware that tells no place has the barrier's word only.
void RepRapSession::prove_end() {
  if (place_ && watch_.knows_end() && !watch_.at_end(*place_, kRounding)) {
    if (++places_ < kMostPlaces) return ask_place();
    return fault(Code::kLink, "every line was answered, but the machine is at " + describe(*place_) +
                                  " and not at the program's end, " + describe(watch_.end()) +
                                  ": it has read another program than was sent");
  }
  recent_.clear();
  move(Event::kProved);
}

}  // namespace tiltfeed::daemon
