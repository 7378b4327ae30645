#include "kinematics/cl_text/apt_arc.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "kinematics/basics/decimal.h"
#include "kinematics/basics/units.h"

namespace tiltfeed {
namespace {

// The ends of a printed arc are equally far from its centre but for the file's decimals.
constexpr double kRadiusShare = 1e-3;
constexpr double kRadiusSlack = 0.01;  // mm
constexpr double kNoRadius = 1e-6;     // mm
// More corners than this in one arc come from a wrong number.
constexpr double kMostChords = 1e5;

/// A place as height over the circle's plane, distance from its axis and direction there.
struct Polar {
  double height = 0.0, radius = 0.0;
  Vec3 out;  ///< from the axis, not unit
};

Polar polar(Vec3 centre, Vec3 axis, Point<Part> at) {
  const Vec3 d = from_origin(at) - centre;
  const double height = dot(d, axis);
  const Vec3 out = d - axis * height;
  return {height, length(out), out};
}

}  // namespace

AptVerdict read_circle(const AptRecord& record, AptArc& arc) {
  std::array<double, 11> v{};
  std::size_t count = 0;
  if (record.has("TIMES"))
    return mistake(
        "CIRCLE/ with TIMES (a helix of several turns) is not understood; let the CAM system write "
        "it as straight moves");
  if (auto bad = record.numbers(v, count)) return bad;
  if (count != 6 && count != 7 && count != 11)
    return mistake(
        "CIRCLE/ has " + std::to_string(count) +
        " numbers; expected centre and axis (6), with a radius (7), or with tolerances and tool (11)");
  const Vec3 axis{v[3], v[4], v[5]};
  if (!(std::abs(length(axis) - 1.0) < kRadiusShare))
    return mistake("CIRCLE/: its axis is not of length 1", record.places[3]);
  arc = {{v[0], v[1], v[2]},
         normalized(axis) * (count == 11 ? -1.0 : 1.0),
         count > 6 ? v[6] : 0.0,
         count > 6,
         count == 7,
         0,
         0.0};
  return std::nullopt;
}

bool lies_on(const AptArc& arc, Vec3 centre, Vec3 axis, Point<Part> point, double slack) {
  return std::abs(polar(centre, axis, point).radius - arc.radius) <= slack;
}

AptVerdict chords(AptArc& arc, Vec3 centre, Vec3 axis, Point<Part> from, Point<Part> to, double tolerance,
                  double same, std::vector<Point<Part>>& corners) {
  const Polar a = polar(centre, axis, from), b = polar(centre, axis, to);
  const double radius = std::max(a.radius, b.radius);
  const double slack = std::max(kRadiusSlack, kRadiusShare * radius);
  if (!(std::min(a.radius, b.radius) > kNoRadius))
    return mistake("an arc about a centre that one of its ends is at");
  if (std::abs(a.radius - b.radius) > slack)
    return mistake("the ends of the arc are " + decimal(a.radius, 4) + " and " + decimal(b.radius, 4) +
                   " mm from its centre");
  if (arc.radius_stated && std::abs(arc.radius - radius) > slack)
    return mistake("the ends of the arc are " + decimal(radius, 4) +
                   " mm from its centre, and CIRCLE/ states " + decimal(arc.radius, 4) + " mm");
  double sweep = std::atan2(dot(cross(a.out, b.out), axis), dot(a.out, b.out));
  const bool whole = length(a.out - b.out) <= same;
  if (whole)
    sweep = 2.0 * kPi;
  else if (sweep <= 0.0)
    sweep += 2.0 * kPi;
  if (arc.goes_on && arc.points > 0 && (whole || sweep > kPi / 2.0 || arc.first_sweep > kPi))
    return mistake(
        "the points behind CIRCLE/ do not go round in its axis's sense; let the CAM system write "
        "straight moves");
  if (arc.points++ == 0) arc.first_sweep = sweep;
  const double step = 2.0 * std::acos(std::max(0.0, 1.0 - tolerance / radius));
  const double count = std::max(1.0, std::ceil(sweep / step));
  if (!(count <= kMostChords)) return mistake("the arc has too many chords for this tolerance");
  const Vec3 x = a.out / a.radius, y = cross(axis, x);
  for (double k = 1.0; k < count; k += 1.0) {
    const double f = k / count, angle = f * sweep;
    const Vec3 out = (x * std::cos(angle) + y * std::sin(angle)) * (a.radius + f * (b.radius - a.radius));
    const Vec3 at = centre + axis * (a.height + f * (b.height - a.height)) + out;
    corners.push_back({at.x, at.y, at.z});
  }
  corners.push_back(to);
  return std::nullopt;
}

}  // namespace tiltfeed
