#include "daemon/journal/control_state.h"

#include <algorithm>
#include <array>

#include "daemon/post/dialect.h"
#include "daemon/post/nc_lines.h"
#include "daemon/post/nc_rules.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

constexpr double kThrough = 3.0;

int decimals_of(const std::string& printed) {
  const std::size_t point = printed.find('.');
  return point == printed.npos ? 0 : static_cast<int>(printed.size() - point - 1);
}

/// Blanks between words say nothing.
std::string without_blanks(std::string text) {
  std::erase(text, ' ');
  return text;
}

}  // namespace

void ControlState::take_comment(const std::string& text) {
  constexpr std::array<std::string_view, 4> kOfTool{"TILTFEED operation ", "TILTFEED tool length ",
                                                    "TILTFEED part zero ", "TILTFEED fixture "};
  const auto kind = std::find_if(kOfTool.begin(), kOfTool.end(),
                                 [&](std::string_view head) { return text.starts_with(head); });
  if (kind == kOfTool.end()) return;
  // They stand in this order before each tool.
  std::erase_if(of_tool, [&](const std::string& known) {
    return std::any_of(kind, kOfTool.end(), [&](std::string_view head) { return known.starts_with(head); });
  });
  of_tool.push_back(text);
}

/// Lines of the profile, and of the high-speed function.
bool ControlState::take_own(const std::string& line) {
  const std::string bare = without_blanks(line);
  const auto is = [&](const std::string& own) { return !own.empty() && bare == without_blanks(own); };
  if (is(format_->through_on)) return coolants = {kThrough}, true;
  if (is(format_->through_off)) coolants.clear();  // it may be M9
  bool own = false;
  // One word may be for both axes.
  if (is(format_->unclamp_tilt)) clamp_tilt_.reset(), own = true;
  if (is(format_->unclamp_rotary)) clamp_rotary_.reset(), own = true;
  if (is(format_->clamp_tilt)) clamp_tilt_ = format_->clamp_tilt, own = true;
  if (is(format_->clamp_rotary)) clamp_rotary_ = format_->clamp_rotary, own = true;
  clamps.clear();
  if (clamp_tilt_) clamps.push_back(*clamp_tilt_);
  if (clamp_rotary_ && clamp_rotary_ != clamp_tilt_) clamps.push_back(*clamp_rotary_);
  if (own) return true;
  const bool fanuc = format_->dialect == config::Dialect::kFanuc && bare.starts_with("G5.1Q"),
             haas = format_->dialect == config::Dialect::kHaas && bare.starts_with("G187");
  if (fanuc || haas) smoothing = is(table_of(format_->dialect).smooth_off) ? "" : line;
  return fanuc || haas;
}

void ControlState::take_words(const DialectWords& words, const std::string& line) {
  for (const int code : words.g) {
    if (code >= 0 && code <= 30 && code % 10 == 0) motion = code / 10;
    if (code == 170 || code == 180 || code == 190) plane = code / 10;
    if (code == 400) compensated = false;
    if (code == 410 || code == 420) compensated = true;
    if (code == 610 || code == 640) corner = line;
    if (code == 900 || code == 910) incremental = code == 910;
    if (code == 930 || code == 940) {
      if (inverse != (code == 930)) feed.clear();
      inverse = code == 930;
    }
    if (is_work_offset(code, format_->dialect)) {
      const bool numbered = code == 541 || code == 1540;
      offset = (code % 10 == 0 ? "G" + std::to_string(code / 10)
                               : "G" + std::to_string(code / 10) + "." + std::to_string(code % 10)) +
               (numbered && words.has('P') ? " P" + words.printed.at('P') : "");
    }
    // The machine's own place, a tool length or plane that begins or ends.
    constexpr std::array<int, 12> kAway{280, 300, 430, 434, 490, 530, 531, 682, 690, 2340, 2540, 2550};
    away = away || std::find(kAway.begin(), kAway.end(), code) != kAway.end();
  }
  for (const int code : words.m) {
    if (code == 3 || code == 4) turn = code;
    if (code == 5) turn = 0;
    if (code == 6) away = true;
    if (code == 7 || code == 8) {
      const double kind = code == 8 ? 1.0 : 2.0;
      std::erase(coolants, kind);
      coolants.push_back(kind);
    }
    if (code == 9) coolants.clear();
  }
  if (words.has('S')) speed = words.values.at('S');
  if (words.has('F') && !words.has_g(40)) feed = words.printed.at('F');
  for (const auto& [letter, printed] : words.printed) {
    const bool linear = letter >= 'X' && letter <= 'Z', turns = letter >= 'A' && letter <= 'C';
    if (linear) linear_decimals = std::max(linear_decimals, decimals_of(printed));
    if (turns) rotary_decimals = std::max(rotary_decimals, decimals_of(printed));
  }
}

void ControlState::take(std::string_view raw) {
  std::string line(raw);
  std::vector<std::string> comments;
  if (strip_line(line, format_->dialect, comments)) return;
  for (const std::string& text : comments) {
    const std::size_t first = text.find_first_not_of(' ');
    if (first != text.npos) take_comment(text.substr(first));
  }
  if (line.empty() || take_own(line)) return;
  DialectWords words;
  if (!split_words(line, words)) take_words(words, line);
}

std::vector<std::string> ControlState::lines_behind(const ControlState& way) const {
  std::vector<std::string> lines = clamps;
  if (speed != way.speed) lines.push_back("S" + decimal(speed, 3));
  if (corner != way.corner && !corner.empty()) lines.push_back(corner);
  if (plane != way.plane) lines.push_back("G" + std::to_string(plane));
  if (inverse != way.inverse) lines.emplace_back(inverse ? "G93" : "G94");
  if (!inverse && !feed.empty() && (feed != way.feed || way.inverse)) lines.push_back("F" + feed);
  if (motion == 0 && way.motion != 0) lines.emplace_back("G0");
  if (motion == 1 && way.motion != 1) lines.emplace_back("G1");
  return lines;
}

}  // namespace tiltfeed::daemon
