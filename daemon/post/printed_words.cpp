#include "daemon/post/printed_words.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>

#include "kinematics/basics/units.h"

namespace tiltfeed::daemon {
namespace {

// F has so many significant digits, so its error is at most half of 1e-4 of it.
constexpr int kFeedDigits = 5;
// The least F that kMaxDecimals can print with kFeedError; in G93 blocks of up to 69 days.
constexpr double kLeastFeed = 1e-5;

/// Decimals that give `value` kFeedDigits significant digits.
int feed_decimals(double value) {
  int decimals = kFeedDigits - 1;
  while (decimals > 0 && value >= decimal_scale(kFeedDigits - decimals)) --decimals;
  for (double scaled = value; scaled < 1.0 && decimals < kMaxDecimals; scaled *= 10.0) ++decimals;
  return decimals;
}

}  // namespace

PrintedWords::PrintedWords(const config::ProgramFormat& format, const MachineModel& machine)
    : format_(format),
      table_(table_of(format.dialect)),
      tilt_(machine.tilt),
      rotary_(machine.rotary),
      inverse_(!format.tcp && format.feed_mode == config::FeedMode::kInverseTime),
      unit_(config::unit_of(format)) {}

char* PrintedWords::number(char* out, double value, int decimals) const {
  char* const end = write_decimal(out, value, decimals);
  if (!table_.point || std::memchr(out, '.', static_cast<std::size_t>(end - out)) != nullptr) return end;
  *end = '.';
  return end + 1;
}

char* PrintedWords::value(char* out, double value, int decimals) const {
  assert(round_decimal(value, decimals) == value);
  if (table_.plus && value >= 0.0) *out++ = '+';
  return number(out, value, decimals);
}

char* PrintedWords::axis(char* out, char letter, double value, int decimals) const {
  *out++ = ' ';
  *out++ = letter;
  return this->value(out, value, decimals);
}

/// A rotary word as the control counts turns.
char* PrintedWords::turn(char* out, const RotaryAxis& rotary, double from, double to) const {
  const int decimals = format_.rotary_decimals;
  const double word = control_word(rotary.word, to, from, decimals);
  const std::string_view open = table_.shorter_open, close = table_.shorter_close;
  if (rotary.word != RotaryWord::kShortest || open.empty()) return axis(out, rotary.letter, word, decimals);
  *out++ = ' ';
  *out++ = rotary.letter;
  out = value(std::copy(open.begin(), open.end(), out), word, decimals);
  return std::copy(close.begin(), close.end(), out);
}

char* PrintedWords::slide(char* out, char letter, double place) const {
  assert(config::printed_place(format_, place) == place);
  const double word = unit_ == 1.0 ? place : round_decimal(place / unit_, format_.linear_decimals);
  return axis(out, letter, word, format_.linear_decimals);
}

char* PrintedWords::axes(char* out, const Joints& from, const Joints& to, bool all) const {
  if (all || to.x != from.x) out = slide(out, 'X', to.x);
  if (all || to.y != from.y) out = slide(out, 'Y', to.y);
  if (all || to.z != from.z) out = slide(out, 'Z', to.z);
  if (tilt_.present && (all || to.a != from.a)) out = turn(out, tilt_, from.a, to.a);
  if (rotary_.present && (all || to.c != from.c)) out = turn(out, rotary_, from.c, to.c);
  return out;
}

char* PrintedWords::rotaries(char* out, const Joints& to) const {
  if (tilt_.present) out = turn(out, tilt_, 0.0, to.a);
  return rotary_.present ? turn(out, rotary_, 0.0, to.c) : out;
}

char* PrintedWords::place(char* out, const Joints& to) const {
  return slide(slide(out, 'X', to.x), 'Y', to.y);
}

char* PrintedWords::height(char* out, const Joints& to) const { return slide(out, 'Z', to.z); }

char* PrintedWords::arc(char* out, const Joints& to, const PrintedArc& arc) const {
  const ArcAxes axes = arc_axes(arc.plane);
  constexpr std::array<double Joints::*, 3> kPlaces{&Joints::x, &Joints::y, &Joints::z};
  for (std::size_t i = 0; i < kPlaces.size(); ++i)
    if (kPlaces[i] != axes.third) out = slide(out, "XYZ"[i], to.*kPlaces[i]);
  if (*table_.pole_letters != '\0') return out;
  for (std::size_t i = 0; i < kPlaces.size(); ++i)
    if (kPlaces[i] != axes.third)
      out = slide(out, "IJK"[i], kPlaces[i] == axes.first ? arc.first : arc.second);
  return out;
}

char* PrintedWords::pole(char* out, const Joints& from, const PrintedArc& arc) const {
  const ArcAxes axes = arc_axes(arc.plane);
  char* const end =
      slide(slide(out, table_.pole_letters[0], config::printed_place(format_, from.*axes.first + arc.first)),
            table_.pole_letters[1], config::printed_place(format_, from.*axes.second + arc.second));
  return std::copy(out + 1, end, out);  // without the blank in front
}

/// The way that F per minute measures, in the unit of the linear words or degrees.
double PrintedWords::way(const Joints& from, const Joints& to) const {
  const double linear = std::hypot(to.x - from.x, to.y - from.y, to.z - from.z) / unit_;
  const double turned = std::hypot(to.a - from.a, to.c - from.c);
  const bool tip_only = format_.tcp || format_.feed_measure == config::FeedMeasure::kXyz;
  if (tip_only) return linear > 0.0 ? linear : turned;
  if (format_.feed_measure == config::FeedMeasure::kDegrees) return std::hypot(linear, turned);
  return std::hypot(linear, Angle::from_degrees(turned).radians() * format_.feed_radius);
}

FeedWord PrintedWords::feed_of(const BlockStep& step) const {
  // (K10) G93: F = 1/T in 1/min.
  if (inverse_) {
    const double f = 60.0 / step.seconds;
    if (!(f <= format_.max_inverse_time)) return {format_.max_inverse_time, true};
    const double least = std::max(kLeastFeed, 1.0 / decimal_scale(table_.feed_decimals));
    return {std::max(f, least), f < least};
  }
  const bool tip_moves = step.from.x != step.to.x || step.from.y != step.to.y || step.from.z != step.to.z;
  const bool of_tip = format_.tcp || format_.tilted_planes;
  const double f = of_tip && tip_moves
                       ? step.tip_feed / unit_
                       : (step.arc > 0.0 ? step.arc / unit_ : way(step.from, step.to)) * 60.0 / step.seconds;
  const double least = std::max(kLeastFeed, 1.0 / decimal_scale(table_.feed_decimals));
  const double most = format_.max_feed / (tip_moves ? unit_ : 1.0);
  if (!(f <= most)) return {most, true};
  if (f < least) return {least, true};
  return {f, false};
}

char* PrintedWords::feed(char* out, double value) const {
  *out++ = ' ';
  *out++ = 'F';
  return number(out, value, std::min(feed_decimals(value), table_.feed_decimals));
}

}  // namespace tiltfeed::daemon
