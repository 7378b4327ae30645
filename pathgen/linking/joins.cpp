#include "pathgen/linking/joins.h"
#include "pathgen/envelope/thinning.h"

#include <algorithm>
#include <cmath>

#include "pathgen/linking/rapid_time.h"

namespace tiltfeed::pathgen {

namespace {

/// How many times faster a rapid goes than a cut, where nobody says.
constexpr double kRapidPerCut = 5.0;
/// How far back into both passes a join goes, as a share of its straight length, until it stays on the
/// surface: an outline that is hollow towards the join bends away from the straight line by less.
constexpr double kInsets[] = {0.0, 1.0 / 64.0, 1.0 / 16.0, 1.0 / 4.0};
/// Cosine of the steepest lean for which a plunge is taken to be longer.
constexpr double kLeastFacing = 0.05;

/// About how far above p a rapid ends: stock as thick as the approach is met so far up on a plane that leans.
double plunge_to(const EnvelopePoint& p, double approach) {
  return approach / std::max(dot(p.normal, p.axis), kLeastFacing);
}

}  // namespace

/// Of retract, travel and plunge, as the length (mm) that is cut in that time: from rest to rest each.
double Joins::time_over(const EnvelopePoint& a, const EnvelopePoint& b) const {
  const double z = options_.clearance_z, up = z - a.flat.z, down = z - b.flat.z;
  const double across =
      distance(travel_.pose({a.flat.x, a.flat.y, z}).tip, travel_.pose({b.flat.x, b.flat.y, z}).tip);
  const double plunge = std::min(down, plunge_to(b, options_.approach));
  const double plunged = plunge * options_.plunge_ratio;
  if (options_.cut_speed <= 0.0) return (up + across + down - plunge) / kRapidPerCut + plunged;
  const RapidRates& rapid = options_.rapid;
  const double seconds = rest_to_rest(std::max(0.0, up), rapid.linear) +
                         std::max(rest_to_rest(across, rapid.linear), turning(a, b)) +
                         rest_to_rest(std::max(0.0, down - plunge), rapid.linear);
  return seconds * options_.cut_speed + plunged;
}

/// Of tilt and table from a to b, s.
double Joins::turning(const EnvelopePoint& a, const EnvelopePoint& b) const {
  return rest_to_rest(rotary_turn(a.axis, b.axis, options_.up), options_.rapid);
}

bool Joins::may_cut(const Pass& pass) const {
  const Deformation& map = field_.deformation;
  for (std::size_t i = 0; i < pass.size(); ++i) {
    if (i > 0 && !travel_.within_tilt(pass[i - 1].axis, pass[i].axis)) return false;
    if (options_.known && !options_.known(pass[i].flat)) return false;
    if (!options_.allowed) continue;
    EnvelopePoint p = pass[i];  // a line past the seam has its points a turn on
    p.flat = map.beside(p.flat, {});
    if (!options_.allowed(p)) return false;
  }
  std::vector<std::vector<Pass>> lines{{pass}};
  return opposite_wall_.trim(lines) == 0;
}

/// On the envelope from a over the corners to b, where it is unbroken.
std::optional<Pass> Joins::along(const EnvelopePoint& a, const EnvelopePoint& b,
                                 const std::vector<Point<Flat>>& corners) {
  const double tolerance = envelope_.options().tolerance;
  Pass pass{a};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const double dx = corners[i].x - corners[i - 1].x, dy = corners[i].y - corners[i - 1].y;
    const double run = std::hypot(dx, dy);
    if (run == 0.0) continue;
    const FlatLine line{corners[i - 1].x, corners[i - 1].y, dx / run, dy / run, run};
    LineEnvelope found = envelope_.along(line);
    leave_held(found, line);
    if (found.passes.size() != 1) return std::nullopt;
    const Pass& leg = found.passes.front();
    const double missing =
        run - std::hypot(leg.back().flat.x - corners[i - 1].x, leg.back().flat.y - corners[i - 1].y);
    if (distance(leg.front().centre, pass.back().centre) > tolerance || missing > tolerance)
      return std::nullopt;
    pass.insert(pass.end(), leg.begin() + 1, leg.end());
  }
  if (distance(pass.back().centre, b.centre) > tolerance) return std::nullopt;
  if (pass.size() > 1) pass.pop_back();
  pass.push_back(b);
  return pass;
}

std::optional<Pass> Joins::between(const End& from, const End& to) {
  const EnvelopePoint &a = from.point, &b = to.point;
  const double apart = distance(a.centre, b.centre);
  if (apart > options_.join_distance) return std::nullopt;
  const double longest = time_over(a, b);
  if (apart >= longest) return std::nullopt;
  const Deformation& map = field_.deformation;
  const Point<Flat> end = map.beside(b.flat, a.flat);
  const double run = std::hypot(end.x - a.flat.x, end.y - a.flat.y);
  const auto inset = [&](Point<Flat> at, const End& e, double by) {
    const double dx = e.inward.flat.x - e.point.flat.x, dy = e.inward.flat.y - e.point.flat.y;
    const double step = std::hypot(dx, dy);
    return step > 0.0 ? Point<Flat>{at.x + dx * by / step, at.y + dy * by / step, at.z} : at;
  };
  for (const double share : kInsets) {
    std::vector<Point<Flat>> corners{a.flat, end};
    if (share > 0.0) corners = {a.flat, inset(a.flat, from, share * run), inset(end, to, share * run), end};
    std::optional<Pass> pass = along(a, b, corners);
    if (!pass) continue;
    if (!may_cut(*pass)) return std::nullopt;
    for (std::size_t i = 1; options_.straight && i < pass->size(); ++i)
      if (!options_.straight((*pass)[i - 1], (*pass)[i])) return std::nullopt;
    *pass = thinned(*pass, options_.thinning, envelope_.options());
    double way = 0.0;
    for (std::size_t i = 1; i < pass->size(); ++i) way += distance((*pass)[i - 1].centre, (*pass)[i].centre);
    if (std::max(way, options_.cut_speed * turning(a, b)) >= longest) return std::nullopt;
    return Pass(pass->begin() + 1, pass->end() - 1);
  }
  return std::nullopt;
}

std::optional<Pass> Joins::round(const EnvelopePoint& a, const Pass& to) {
  EnvelopePoint b = to.front();
  if (distance(a.centre, b.centre) > options_.join_distance) return std::nullopt;
  const Deformation& map = field_.deformation;
  const Vec3 turn = to.back().flat - to.front().flat;
  b.flat = map.beside(b.flat, a.flat) + turn;
  std::optional<Pass> pass = along(a, b, {a.flat, b.flat});
  if (!pass || !may_cut(*pass)) return std::nullopt;
  for (std::size_t i = 1; options_.straight && i < pass->size(); ++i)
    if (!options_.straight((*pass)[i - 1], (*pass)[i])) return std::nullopt;
  *pass = thinned(*pass, options_.thinning, envelope_.options());
  return Pass(pass->begin() + 1, pass->end() - 1);
}

}  // namespace tiltfeed::pathgen
