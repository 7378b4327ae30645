#include "daemon/post/nc_arcs.h"

#include <cmath>
#include <numbers>
#include <string_view>

#include "daemon/post/printed_arc.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

constexpr double kReadInch = 25.4, kWholeTurn = 2.0 * std::numbers::pi;
constexpr double kStands = 1e-9;  // mm

bool has_poles(config::Dialect dialect) {
  return dialect == config::Dialect::kHeidenhain || dialect == config::Dialect::kHeidenhainIso;
}

/// Of I J K those of the plane's first, second and third axis.
std::string_view centre_letters(int plane) { return plane == 18 ? "KIJ" : plane == 19 ? "JKI" : "IJK"; }

struct Polar {
  double radius, angle;
};
Polar polar(const TextArc& arc, const Joints& at) {
  const ArcAxes axes = arc_axes(arc.plane);
  const double u = at.*axes.first - arc.first, v = at.*axes.second - arc.second;
  return {std::hypot(u, v), std::atan2(v, u)};
}

/// Round the centre, below 0 clockwise.
double turn_of(const TextArc& arc, const Polar& from, const Polar& to) {
  double turn = to.angle - from.angle;
  if (arc.clockwise && turn >= 0.0) turn -= kWholeTurn;
  if (!arc.clockwise && turn <= 0.0) turn += kWholeTurn;
  return turn;
}

}  // namespace

std::optional<std::string> ArcReader::misplaced(const DialectWords& words, int plane,
                                                const TextLanguage& language) const {
  for (const char letter : {'I', 'J', 'K'}) {
    if (!words.has(letter)) continue;
    if (language.dialect == config::Dialect::kHeidenhainIso && letter != 'K') continue;
    if (has_poles(language.dialect) || motion == 0)
      return std::string(1, letter) + " is understood in arcs only";
    if (letter == centre_letters(plane)[2])
      return std::string(1, letter) + " is no word of an arc in G" + std::to_string(plane);
  }
  return std::nullopt;
}

bool ArcReader::take_pole(const DialectWords& words, const TextLanguage& language) {
  const bool dialogue = words.named("CC");
  if (!has_poles(language.dialect)) return false;
  const double unit = language.inches ? kReadInch : 1.0;
  const std::string_view letters = dialogue ? "XY" : "IJ";
  for (std::size_t i = 0; i < pole.size(); ++i)
    if (words.has(letters[i])) pole[i] = words.values.at(letters[i]) * unit;
  return dialogue;
}

Result<TextArc> ArcReader::arc(const DialectWords& words, int plane, const TextLanguage& language,
                               const Joints& from, const Joints& to) const {
  if (words.has('R')) return fail(Code::kInput, "an arc by its radius is not understood; post with I J K");
  const bool dialogue = language.dialect == config::Dialect::kHeidenhain;
  TextArc arc{plane, motion == 2, 0.0, 0.0};
  if (dialogue) {
    const auto way = words.ways;
    if (way.size() != 1) return fail(Code::kInput, "an arc without DR+ or DR-");
    arc.clockwise = way.front() == '-';
  }
  const ArcAxes axes = arc_axes(plane);
  const std::string_view letters = centre_letters(plane);
  if (has_poles(language.dialect)) {
    if (!pole[0] || !pole[1]) return fail(Code::kInput, "an arc before its centre is said");
    arc.first = *pole[0], arc.second = *pole[1];
  } else {
    if (!words.has(letters[0]) && !words.has(letters[1]))
      return fail(Code::kInput, std::string("an arc without ") + letters[0] + " and " + letters[1]);
    const double unit = language.inches ? kReadInch : 1.0;
    const auto offset = [&](char letter) { return words.has(letter) ? words.values.at(letter) * unit : 0.0; };
    arc.first = from.*axes.first + offset(letters[0]);
    arc.second = from.*axes.second + offset(letters[1]);
  }
  const Polar begin = polar(arc, from), end = polar(arc, to);
  if (std::abs(end.radius - begin.radius) > kReadRadiusError || begin.radius < kReadRadiusError)
    return fail(Code::kInput, "the arc begins " + decimal(begin.radius, 4) + " mm from its centre and ends " +
                                  decimal(end.radius, 4) + " mm from it");
  if (std::hypot(to.*axes.first - from.*axes.first, to.*axes.second - from.*axes.second) < kStands)
    return fail(Code::kInput, "a full circle in one block is not understood");
  if (std::abs(to.*axes.third - from.*axes.third) > kStands || to.a != from.a || to.c != from.c)
    return fail(Code::kInput, "an arc in which another axis moves is not understood");
  return arc;
}

Joints along_arc(const TextArc& arc, const Joints& from, const Joints& to, double share) {
  if (share >= 1.0) return to;
  const ArcAxes axes = arc_axes(arc.plane);
  const Polar begin = polar(arc, from), end = polar(arc, to);
  const double angle = begin.angle + share * turn_of(arc, begin, end),
               radius = begin.radius + share * (end.radius - begin.radius);
  Joints at = from;
  at.*axes.first = arc.first + radius * std::cos(angle);
  at.*axes.second = arc.second + radius * std::sin(angle);
  return at;
}

double arc_length(const TextArc& arc, const Joints& from, const Joints& to) {
  const Polar begin = polar(arc, from), end = polar(arc, to);
  return std::abs(turn_of(arc, begin, end)) * 0.5 * (begin.radius + end.radius);
}

}  // namespace tiltfeed::daemon
