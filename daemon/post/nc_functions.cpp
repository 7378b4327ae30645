#include "daemon/post/nc_functions.h"

#include <sstream>
#include <utility>

#include "daemon/post/nc_rules.h"

namespace tiltfeed::daemon {

void FunctionReader::next_tool(int number) {
  if (number != operation().tool_number && !operation().blocks.empty()) program_.operations.emplace_back();
  operation().tool_number = number;
}

void FunctionReader::event(EventKind kind, double value) {
  if (kind == EventKind::kSpindle && value == std::exchange(spindle_, value)) return;
  if (kind == EventKind::kCoolant && value == std::exchange(coolant_, value)) return;
  operation().events.push_back({operation().blocks.size(), kind, value, ""});
}

std::optional<std::string> FunctionReader::tool_call(const std::string& text) {
  std::istringstream in(text);
  for (std::string word; in >> word;) {
    double value = 0.0;
    const bool speed = word[0] == 'S';
    if (word == "Z" || !(std::istringstream(word.substr(speed ? 1 : 0)) >> value)) continue;
    if (!speed && !(value >= 0.0 && value < kLargestNumber)) return "the tool's number is too large";
    if (!speed) next_tool(static_cast<int>(value));
    if (speed) speed_ = value;
    if (speed && turn_ != 0) event(EventKind::kSpindle, turn_ == 4 ? -value : value);
  }
  return std::nullopt;
}

void FunctionReader::machine_codes(const DialectWords& words) {
  if (words.has('T')) {
    selected_ = static_cast<int>(words.values.at('T'));
    // Where a code changes the tool T alone only makes it ready, but before the first of these.
    if (!changes_by_code_ && !words.has_g(510)) next_tool(selected_);
    changing_ = language_.dialect == config::Dialect::kGrbl;  // its M0 is the tool change
  }
  if (words.has('S')) speed_ = words.values.at('S');
  for (const int code : words.m) {
    if (code == 6 && selected_ >= 0) changes_by_code_ = true, next_tool(selected_);
    if (code == 3 || code == 4) turn_ = code;
    if (code == 5) turn_ = 0, event(EventKind::kSpindle, 0.0);
    if (code == 7) event(EventKind::kCoolant, 2.0);
    if (code == 8) event(EventKind::kCoolant, 1.0);
    if (code == 9) event(EventKind::kCoolant, 0.0);
    if (code == 0 && !std::exchange(changing_, false)) event(EventKind::kStop, 0.0);
    if (code == 1) event(EventKind::kOptionalStop, 0.0);
  }
  if (words.has_m(3) || words.has_m(4) || (words.has('S') && turn_ != 0))
    event(EventKind::kSpindle, turn_ == 4 ? -speed_ : speed_);
}

void FunctionReader::compensation(const DialectWords& words, int plane) {
  const bool left = words.has_g(410) || words.named("RL"), right = words.has_g(420) || words.named("RR"),
             off = words.has_g(400) || (language_.dialect == config::Dialect::kHeidenhain && words.has('R')),
             edge = language_.dialect == config::Dialect::kSiemens;
  // Only there a plane is said to who posts the program again; arcs make their own.
  if ((left || right) && plane != std::exchange(told_plane_, plane)) event(EventKind::kPlane, plane);
  if (left || right)
    event(left ? EventKind::kCutterLeft : EventKind::kCutterRight,
          words.has('D') ? words.values.at('D') : 0.0);
  if (off && compensated_) event(EventKind::kCutterOff, 0.0);
  if (left || right || off) compensated_ = left || right;
  const char letter = edge ? 'D' : 'H';
  if (!words.has(letter)) return;
  const int stated = static_cast<int>(words.values.at(letter));
  if (stated == 0) return;  // none is in force, as before a retract
  operation().length_register = stated == (edge ? 1 : operation().tool_number) ? 0 : stated;
}

std::optional<std::string> FunctionReader::dwell(const DialectWords& words) {
  for (const char letter : {'P', 'F', 'X'}) {
    if (!words.has(letter)) continue;
    // Fanuc and Haas: a P without a point is in milliseconds.
    const bool short_p = letter == 'P' && (language_.dialect == config::Dialect::kFanuc ||
                                           language_.dialect == config::Dialect::kHaas);
    if (words.values.at(letter) < 0.0) return "G4 has a time below 0";
    const bool milli = short_p && words.printed.at('P').find('.') == std::string::npos;
    event(EventKind::kDwell, words.values.at(letter) * (milli ? 1e-3 : 1.0));
    return std::nullopt;
  }
  return "G4 has no time";
}

}  // namespace tiltfeed::daemon
