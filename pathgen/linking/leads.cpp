#include "pathgen/linking/leads.h"

#include <algorithm>
#include <cmath>

#include "pathgen/linking/over_envelope.h"

namespace tiltfeed::pathgen {

namespace {

/// Where a pass climbs away from its end by more than this slope, an arc would have to come from far below
/// it: at this slope it dips 0.3 of its radius below the end.
const double kSteepestSine = std::sqrt(0.5);
/// An arc shorter than this (rad) is as good as none: the pass comes down the axis itself.
constexpr double kLeastArc = 0.01;
/// An arc has at least this many moves, so that its first one is tangential.
constexpr double kLeastMoves = 8.0;
/// An arc of more moves turns the axis too fast to be of use.
constexpr double kMostMoves = 1000.0;
/// Points nearer than this (mm) give no direction.
constexpr double kNoDirection = 1e-6;

}  // namespace

/// The arc about end + radius * up, `up` square to the direction u into the pass, on the axis's side:
/// end + radius (up (1 - cos turn) - u sin turn), until it points along the axis.
std::vector<Point<Flat>> Leads::shape(const EnvelopePoint& end, const EnvelopePoint& next) const {
  const Vec3 chord = next.centre - end.centre;
  if (length(chord) < kNoDirection) return {};
  const Vec3 u = normalized(chord);
  const double sine = dot(u, end.axis);
  if (sine > kSteepestSine) return {};
  const double whole = std::acos(std::clamp(-sine, -1.0, 1.0));
  if (whole < kLeastArc) return {};
  const Vec3 up = normalized(end.axis - u * sine);
  const Deformation& map = field_.deformation;
  // Chords lie towards the centre, away from the surface, by radius * step^2 / 8.
  const double by_chord = whole / std::sqrt(8.0 * options_.thinning / options_.lead_radius);
  double count = std::ceil(std::max(kLeastMoves, by_chord));
  for (;;) {
    std::vector<Point<Flat>> places;
    Point<Flat> last = end.flat;
    Vec3 axis = end.axis;
    double widest = 0.0;
    for (double k = 1.0; k <= count; ++k) {
      const double turn = whole * k / count;
      const Vec3 away = up * (1.0 - std::cos(turn)) - u * std::sin(turn);
      const Point<Flat> f = map.beside(map.flatten(end.centre + away * options_.lead_radius), last);
      if (!map.in_column(f, kLeastAxisDistance)) return {};
      const Vec3 there = map.axis_line(f.x, f.y).axis;
      widest = std::max(widest, length(cross(axis, there)));
      places.push_back(f);
      last = f, axis = there;
    }
    const double allowed = envelope_.options().max_axis_step;
    if (widest <= allowed) return places;
    if (count > kMostMoves) return {};
    count = std::ceil(count * std::max(1.1, widest / allowed));
  }
}

/// Could the tool come down to this place from the clearance surface, and go back?
bool Leads::free_above(Point<Flat> place) {
  if (place.z > options_.clearance_z) return false;
  const AxisLine line = field_.deformation.axis_line(place.x, place.y);
  EnvelopePoint p;
  p.flat = place, p.centre = line.base + line.axis * place.z, p.axis = line.axis;
  std::vector<std::vector<Pass>> lines{{Pass{p}}};
  return opposite_wall_.trim(lines) == 0;
}

std::vector<Point<Flat>> Leads::arc(const EnvelopePoint& end, const EnvelopePoint& next) {
  std::vector<Point<Flat>> places = shape(end, next);
  if (places.empty() || !free_above(places.back())) return {};
  Point<Flat> from = end.flat;
  for (const Point<Flat>& to : places) {
    const Pose a = travel_.pose(from), b = travel_.pose(to);
    const bool clear = (!options_.known || options_.known(to)) && travel_.within_tilt(a.axis, b.axis) &&
                       over_envelope(field_, envelope_, from, to) && opposite_wall_.travel_clear(a, b);
    if (!clear) return {};
    from = to;
  }
  return places;
}

}  // namespace tiltfeed::pathgen
