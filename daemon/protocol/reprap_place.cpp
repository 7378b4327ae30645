// Where a RepRap firmware says that the axes are, once every line has run.

#include <algorithm>
#include <charconv>
#include <cmath>

#include "daemon/protocol/reprap_session.h"

namespace tiltfeed {

namespace {

/// M114 prints two decimals. Its answer has no checksum, so one that is wrong is asked for again.
constexpr double kRounding = 0.005;
constexpr int kMostPlaces = 3;

}  // namespace

void RepRapSession::ask_place() {
  place_.reset();
  append({0, "M114"}, Kind::kPlace);
}

/// "X:1.00 Y:2.00 Z:3.00 A:4.00 E:0.00 Count X:80 ...": up to Count, which are steps.
void RepRapSession::take_place(std::string_view line) {
  if (!line.starts_with("X:")) return;
  AxisValues place = no_axes();
  while (!line.empty() && !line.starts_with("Count")) {
    const std::string_view word = line.substr(0, line.find(' '));
    line.remove_prefix(std::min(word.size() + 1, line.size()));
    if (word.empty()) continue;
    double value = 0.0;
    const bool named = word.size() > 2 && word[1] == ':';
    const auto parsed = std::from_chars(word.data() + (named ? 2 : 0), word.data() + word.size(), value,
                                        std::chars_format::fixed);
    if (!named || parsed.ec != std::errc() || parsed.ptr != word.data() + word.size() ||
        !std::isfinite(value))
      return;
    if (const std::size_t axis = kAxisLetters.find(word[0]); axis != kAxisLetters.npos) place[axis] = value;
  }
  place_ = place;
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

}  // namespace tiltfeed
