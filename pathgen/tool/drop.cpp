#include "pathgen/tool/drop.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tiltfeed::pathgen {

namespace {

/// The rounded edge against an edge of the part: largest error of the contact's place, as a share of the
/// tool's radius. The contact normal is that exact where kSeam is still met; the height has its square.
constexpr double kArcError = 1e-12;
constexpr int kMaxSteps = 60;  ///< halving alone needs 40
/// What lies lower by so much (mm), and is not so steep (squared sine), is seen to lie lower whatever is
/// rounded.
constexpr double kClearlyLower = 1e-6, kNotSteep = 1e-3;
constexpr double kFar = std::numeric_limits<double>::infinity();
/// As a share of the tool's radius: a root that is further than this from a border is on that side of it,
/// whatever is rounded.
constexpr double kClearly = 1e-9;

/// Where a piece touches: at this distance from the axis and height over the ring centre.
struct Place {
  double d = 0.0, height = 0.0;
};

/// (C5) `lateral`: from the axis to the contact; `height`: of the contact over the ring centre.
Vec3 twist(const ToolPiece& piece, Vec3 normal, Vec3 axis, Vec3 lateral, double height) {
  return normal * (height + piece.above_reference) - lateral * dot(normal, axis);
}

/// The equation of tube_run() times d cos(tau), which has its sign, at u; and how fast that changes with u.
double tube_excess(const ToolPiece& piece, double p, double k, double u, double& rate) {
  const double e = piece.flat, r = piece.corner;
  const double d = std::sqrt(p * p + u * u), s = std::clamp((d - e) / r, 0.0, 1.0);
  const double c = std::sqrt((1.0 - s) * (1.0 + s)), turn = u / d;
  rate = s + u * turn / r - k * (c > 0.0 ? c - s / c * d / r : 0.0) * turn;
  return s * u - k * c * d;
}

/// (C2) How far along a line from its foot a rounded edge touches it that passes the axis at distance p and
/// climbs with slope k over the ground: tan(tau) u / d = k, with d = e + r sin(tau) and u = sqrt(d^2 - p^2).
/// Sought is u, on which d hangs smoothly: where the line is nearly level u is small against p, and a root
/// for d would lose it. Monotone; infinite where even the upper end of the arc, at `last`, is too gentle.
double tube_run(const ToolPiece& piece, double p, double k, double last) {
  const double e = piece.flat, r = piece.corner, end = e + r * std::sin(last);
  const double first = p < e ? std::sqrt(e * e - p * p) : 0.0;
  if (end <= p) return kFar;
  if (k < kLevel) return first;
  double low = first, high = std::sqrt(end * end - p * p);
  double rate = 0.0;
  if (tube_excess(piece, p, k, high, rate) < 0.0) return kFar;
  const double fine = kArcError * (e + r);
  double u = std::clamp(k * p, low, high);
  for (int i = 0; i < kMaxSteps && high - low > fine; ++i) {
    const double over = tube_excess(piece, p, k, u, rate);
    (over > 0.0 ? high : low) = u;
    const double next = rate > 0.0 ? u - over / rate : low;
    const double step = next > low && next < high ? next : 0.5 * (low + high);
    if (std::abs(step - u) < fine && next == step) return step;
    u = step;
  }
  return u;
}

/// Does a rounded edge touch that line beyond [low, high], whether with its arc or with what is above it?
/// Told by at most two places of the arc; no where rounding might tell otherwise.
bool touches_beyond(const ToolPiece& piece, double p, double k, double low, double high) {
  const double e = piece.flat, r = piece.corner, end = e + r * piece.taper_cos;
  if (r <= 0.0 || end <= p || k < kLevel) return false;
  const double first = p < e ? std::sqrt(e * e - p * p) : 0.0, most = std::sqrt(end * end - p * p);
  const double spare = kClearly * (e + r), before = low - spare, behind = high + spare;
  double rate = 0.0;
  if (behind < first - spare) return true;
  if (behind > first && behind < most - spare && tube_excess(piece, p, k, behind, rate) < 0.0) return true;
  return before > first + spare && before < most - spare && tube_excess(piece, p, k, before, rate) > 0.0;
}

}  // namespace

/// (C3)
bool drop_on_vertex(const ToolPiece& piece, const Point<Part>& v, const AxisLine& line, ClHit& hit,
                    double least) {
  const Vec3 w = line.base - v;
  const double aw = dot(line.axis, w);
  const Vec3 off = w - line.axis * aw;  // from the vertex to the axis
  const double dd = squared_length(off);
  if (dd > piece.outer * piece.outer) return false;
  if (piece.is_ball()) {
    hit.z = -aw + std::sqrt(piece.corner * piece.corner - dd);
    if (hit.z - piece.above_reference < least) return false;
    hit.normal = (w + line.axis * hit.z) / piece.corner;
    hit.z -= piece.above_reference;
    hit.twist = hit.normal * piece.above_reference;
    return true;
  }
  const double d = std::sqrt(dd), over = d - piece.flat;
  double below = 0.0;  // the ring centre
  if (over <= 0.0) {
    below = piece.corner;
    hit.normal = line.axis;
  } else if (over <= piece.corner * piece.taper_cos) {
    below = std::sqrt(std::max(piece.corner * piece.corner - over * over, 0.0));
    hit.normal = (off * (over / d) + line.axis * below) / piece.corner;
  } else {
    if (!piece.has_cone()) return false;
    below = -piece.cone_height(d);
    hit.normal = off * (piece.taper_cos / d) + line.axis * piece.taper_sin;
  }
  hit.z = -aw + below - piece.above_reference;
  hit.twist = twist(piece, hit.normal, line.axis, -off, -below);
  return hit.z >= least;
}

namespace {

/// (C2) A ball, or the ball of a taper: the cylinder round the edge, as if that had no ends. False where it
/// meets none, or another part of the tool does.
bool drop_ball_on_line(const ToolPiece& piece, const Vec3& w, const Vec3& e, const AxisLine& line,
                       ClHit& hit) {
  const double radius = piece.corner, per_ee = 1.0 / squared_length(e);
  const Vec3 a = line.axis - e * (dot(line.axis, e) * per_ee);
  const Vec3 o = w - e * (dot(w, e) * per_ee);
  const double aa = squared_length(a), ao = dot(a, o);
  const double disc = ao * ao - aa * (squared_length(o) - radius * radius);
  if (disc < 0.0 || aa < kSteepest) return false;
  hit.z = (-ao + std::sqrt(disc)) / aa;
  hit.normal = (o + a * hit.z) / radius;
  return dot(hit.normal, line.axis) >= piece.taper_sin || !piece.has_cone();
}

/// Does the cylinder round the edge lie lower than z on the line all over? Told without root or quotient; no
/// where rounding might tell otherwise.
bool ball_stays_under(double radius, const Vec3& w, const Vec3& e, const Vec3& axis, double z) {
  const double ee = squared_length(e), ae = dot(axis, e), we = dot(w, e), square = ee - ae * ae;
  if (square < kNotSteep * ee) return false;
  // The height h meets square h^2 + 2 half h + rest = 0.
  const double half = dot(axis, w) * ee - ae * we,
               rest = (squared_length(w) - radius * radius) * ee - we * we;
  const double above = square * (z - kClearlyLower) + half;
  return above > 0.0 && half * half - square * rest < above * above;
}

/// Does the ball whose centre is at height z touch the line of `e` between its ends? Then the hit's rest.
bool settle_ball(const ToolPiece& piece, const Vec3& w, const Vec3& e, double slack, const AxisLine& line,
                 ClHit& hit) {
  const double ee = squared_length(e), along = dot(w + line.axis * hit.z, e),
               beyond = std::max(-along, along - ee);
  if (beyond > 0.0 && beyond * beyond > slack * slack * ee) return false;
  hit.z -= piece.above_reference;
  hit.twist = hit.normal * piece.above_reference;
  return true;
}

}  // namespace

bool drop_on_edge(const ToolPiece& piece, const Point<Part>& p, const Point<Part>& q, double slack,
                  const AxisLine& line, ClHit& hit, double least) {
  const Vec3 w = line.base - p, e = q - p;
  const bool ball = piece.is_ball();
  if (ball && ball_stays_under(piece.corner, w, e, line.axis, least + piece.above_reference)) return false;
  const bool on_ball = piece.flat == 0.0 && drop_ball_on_line(piece, w, e, line, hit);
  if (on_ball) return settle_ball(piece, w, e, slack, line, hit) && hit.z >= least;
  if (ball) return false;
  const Vec3 a = line.axis;
  const double rise = dot(e, a);
  Vec3 flat = e - a * rise;  // the edge over the ground
  const double run = length(flat);
  if (run * run < kSteepest * squared_length(e)) return false;
  flat = flat / run;
  const double climb = std::abs(rise) / run;
  if (rise < 0.0) flat = -flat;          // uphill
  const double height = -dot(w, a);      // of p over the line's base
  const Vec3 side = -w + a * dot(w, a);  // from the axis to p
  const double u_p = dot(side, flat), u_q = rise < 0.0 ? u_p - run : u_p + run;
  const Vec3 nearest = side - flat * u_p;  // foot of the axis on the edge's ground line
  const double away = length(nearest);
  if (away >= piece.outer) return false;
  const double beyond = slack / std::sqrt(1.0 + climb * climb);  // over the ground
  const double low = std::min(u_p, u_q) - beyond, high = std::max(u_p, u_q) + beyond;
  // No higher than the arc's lowest place on the highest of the edge that is near enough.
  const double top =
      height + climb * (std::min(high, piece.outer) - u_p) + piece.corner - piece.above_reference;
  if (top < least - kClearlyLower || touches_beyond(piece, away, climb, low, high)) return false;
  double u = 0.0;
  Place at;
  const double last = piece.has_cone() ? std::atan2(piece.taper_cos, piece.taper_sin) : kPi / 2.0;
  bool rim = false;
  if (climb < kLevel && away <= piece.flat) {  // it lies on the flat bottom
    const double half = std::sqrt(piece.flat * piece.flat - away * away);
    if (low > half || high < -half) return false;
    u = std::clamp(0.0, std::max(low, -half), std::min(high, half));
    at = {std::hypot(away, u), -piece.corner};
    hit.normal = a;
  } else {
    u = piece.corner > 0.0 ? tube_run(piece, away, climb, last) : kFar;
    const bool on_arc = u < kFar;
    double sine = 0.0, cosine = 0.0;  // of the place on the arc
    if (on_arc) {
      at.d = std::sqrt(away * away + u * u);
      sine = std::clamp((at.d - piece.flat) / piece.corner, 0.0, 1.0);
      cosine = std::sqrt((1.0 - sine) * (1.0 + sine));
      at.height = -piece.corner * cosine;
    } else {
      const double share = piece.has_cone() ? climb * piece.taper_sin / piece.taper_cos : 1.0;  // u / d
      const double d = share < 1.0 ? away / std::sqrt(1.0 - share * share) : piece.outer;
      const double foot = piece.flat + piece.corner * piece.taper_cos;  // where the cone begins
      rim = d >= piece.outer || d < foot;
      at.d = std::clamp(d, foot, piece.outer);
      at.height = piece.has_cone() ? piece.cone_height(at.d) : 0.0;
      u = std::sqrt(std::max(at.d * at.d - away * away, 0.0));
    }
    if (u < low || u > high) return false;
    const Vec3 out = (nearest + flat * u) / at.d;  // from the axis to the contact
    if (rim) {
      hit.normal = normalized(cross(flat + a * climb, cross(a, out)));
      if (dot(hit.normal, a) < 0.0) hit.normal = -hit.normal;
    } else if (on_arc) {
      hit.normal = a * cosine - out * sine;
    } else {
      hit.normal = a * piece.taper_sin - out * piece.taper_cos;
    }
  }
  hit.twist = twist(piece, hit.normal, a, nearest + flat * u, at.height);
  hit.z = height + climb * (u - u_p) - at.height - piece.above_reference;
  return hit.z >= least;
}

/// (C1)
bool drop_on_facet(const ToolPiece& piece, const Point<Part>& a, const Point<Part>& b, const Point<Part>& c,
                   const Vec3& n, double slack, const AxisLine& line, ClHit& hit, double least) {
  const double along = dot(n, line.axis);
  if (along < kSteepest) return false;
  const double gap = dot(n, line.base - a);
  Point<Part> contact;
  if (piece.is_ball()) {
    hit.z = (piece.corner - gap) / along;
    if (hit.z - piece.above_reference < least) return false;
    contact = line.base + line.axis * hit.z - n * piece.corner;
    hit.twist = n * piece.above_reference;
  } else {
    const Vec3 lateral = n - line.axis * along;
    const double across = length(lateral);
    Place at{piece.flat + piece.corner * across, -piece.corner * along};
    if (along < piece.taper_sin) at = {piece.outer, piece.cone_height(piece.outer)};
    if (across < kLevel) at.d = 0.0;
    hit.z = (at.d * across - at.height * along - gap) / along;
    const Vec3 aside = at.d > 0.0 ? -lateral * (at.d / across) : Vec3{};
    contact = line.base + line.axis * (hit.z + at.height) + aside;
    hit.twist = twist(piece, n, line.axis, aside, at.height);
  }
  hit.normal = n;
  hit.z -= piece.above_reference;
  if (hit.z < least) return false;
  const auto inside_of = [&](const Point<Part>& from, const Point<Part>& to) {
    const Vec3 side = to - from;
    const double depth = dot(cross(n, side), contact - from);
    return depth >= 0.0 || depth * depth <= slack * slack * squared_length(side);
  };
  return inside_of(a, b) && inside_of(b, c) && inside_of(c, a);
}

}  // namespace tiltfeed::pathgen
