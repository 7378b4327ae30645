#include "pathgen/lean/lean_stations.h"

#include <algorithm>

#include "pathgen/envelope/thinning.h"

namespace tiltfeed::pathgen {

namespace {

/// Leans below this, rad, are none.
constexpr double kNoLean = 1e-12;
/// Places nearer to a point of the pass than this, mm, are that point.
constexpr double kSamePlace = 1e-9;

Vec3 square_to(Vec3 axis, Vec3 wished) {
  const Vec3 aside = wished - axis * dot(axis, wished);
  if (squared_length(aside) > 1e-12) return normalized(aside);
  return normalized(cross(axis, std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
}

Vec3 way(const EnvelopePoint& from, const EnvelopePoint& to) {
  const Vec3 moved = to.centre - from.centre;
  return squared_length(moved) > 0.0 ? normalized(moved) : Vec3{};
}

void place_frame(LeanStation& s, Vec3 wished) {
  s.first = square_to(s.point.axis, wished), s.second = cross(s.point.axis, s.first);
}

}  // namespace

Vec3 LeanStation::axis(LeanAngle lean) const {
  const double size = lean.size();
  if (size <= kNoLean) return point.axis;
  return normalized(point.axis * std::cos(size) +
                    (first * lean.u + second * lean.v) * (std::sin(size) / size));
}

LeanAngle LeanStation::lean_of(Vec3 axis) const {
  const double size = angle_between(point.axis, axis), u = dot(axis, first), v = dot(axis, second),
               across = std::hypot(u, v);
  if (size <= kNoLean || across <= 0.0) return {};
  return {u * size / across, v * size / across};
}

Vec3 LeanStation::direction(LeanAngle lean) {
  const double size = lean.size();
  if (size <= kNoLean) return {0, 0, 1};
  const double share = std::sin(size) / size;
  return {lean.u * share, lean.v * share, std::cos(size)};
}

PassFrames::PassFrames(const Pass& pass, const Deformation& map) : map_(map) {
  for (std::size_t i = 0; i < pass.size(); ++i) {
    LeanStation s{.point = pass[i], .given = true};
    const Vec3 ahead = pass.size() > 1 ? pass[1].centre - pass[0].centre : Vec3{};
    place_frame(s, points_.empty() ? ahead : points_.back().first);
    if (i > 0) s.run = points_.back().run + distance(pass[i - 1].centre, pass[i].centre);
    if (i > 0) s.before = way(pass[i - 1], pass[i]);
    if (i + 1 < pass.size()) s.ahead = way(pass[i], pass[i + 1]);
    points_.push_back(s);
  }
}

LeanStation PassFrames::at(double run) const {
  const auto next = std::lower_bound(points_.begin(), points_.end(), run - kSamePlace,
                                     [](const LeanStation& s, double at) { return s.run < at; });
  if (next == points_.end()) return points_.back();
  if (next == points_.begin() || next->run <= run + kSamePlace) return *next;
  const LeanStation& before = *(next - 1);
  const double share = (run - before.run) / (next->run - before.run);
  LeanStation s{.point = on_move(before.point, next->point, share, map_),
                .run = run,
                .before = before.ahead,
                .ahead = before.ahead};
  place_frame(s, before.first);
  return s;
}

std::vector<LeanStation> PassFrames::between(double from, double to, double spacing) const {
  std::vector<double> fixed{from};
  for (const LeanStation& s : points_)
    if (s.run > from + kSamePlace && s.run < to - kSamePlace) fixed.push_back(s.run);
  if (to > from + kSamePlace) fixed.push_back(to);
  std::vector<LeanStation> out{at(from)};
  for (std::size_t i = 1; i < fixed.size(); ++i) {
    const double pieces = std::max(1.0, std::ceil((fixed[i] - fixed[i - 1]) / spacing - kSamePlace));
    for (double k = 1.0; k < pieces; ++k)
      out.push_back(at(fixed[i - 1] + (fixed[i] - fixed[i - 1]) * k / pieces));
    out.push_back(at(fixed[i]));
  }
  return out;
}

}  // namespace tiltfeed::pathgen
