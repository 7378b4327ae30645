#include "pathgen/creases/kinks.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

using Across = std::array<double, 2>;

/// The least cosine between normal and axis by which a slope is divided.
constexpr double kLeastFacing = 1e-9;

/// What z' changes by in a step of 1 mm of x' and of y'.
Across gradient(const EnvelopePoint& p, const Deformation& map) {
  const Deformation::Steps step = map.steps(p.flat);
  const double facing = std::max(dot(p.normal, p.axis), kLeastFacing);
  return {-dot(p.normal, step.x) / facing, -dot(p.normal, step.y) / facing};
}

double norm(Across v) { return std::hypot(v[0], v[1]); }
Across unit(Across v) {
  const double length = norm(v);
  return {v[0] / length, v[1] / length};
}

}  // namespace

/// Do the normals turn by the least angle from a to b, or does the way leave either's tangent plane by it?
bool KinkSearch::may_kink(const EnvelopePoint& a, const EnvelopePoint& b) const {
  const double least = options_.least_angle.radians();
  if (angle_between(a.normal, b.normal) >= least) return true;
  const Vec3 way = b.centre - a.centre;
  const double off = std::max(std::abs(dot(a.normal, way)), std::abs(dot(b.normal, way)));
  return off >= length(way) * std::sin(least);
}

void KinkSearch::search(const FlatLine& line, double from, const EnvelopePoint& a, double to,
                        const EnvelopePoint& b, std::vector<Kink>& kinks) {
  if (!may_kink(a, b)) return;
  if (to - from <= kKinkStep) return judge(line, 0.5 * (from + to), a, b, kinks);
  const double run = 0.5 * (from + to);
  const auto middle = envelope_.at(line.x_at(run), line.y_at(run));
  if (!middle) return;
  search(line, from, a, run, *middle, kinks);
  search(line, run, *middle, to, b, kinks);
}

void KinkSearch::judge(const FlatLine& line, double run, const EnvelopePoint& a, const EnvelopePoint& b,
                       std::vector<Kink>& kinks) const {
  if (!envelope_.is_cut(a) || !envelope_.is_cut(b)) return;
  const Across before = gradient(a, field_.deformation), behind = gradient(b, field_.deformation);
  const auto along = [&](Across g) { return g[0] * line.dx + g[1] * line.dy; };
  const double drop = a.flat.z - b.flat.z;
  Kink kink{run, drop > 0.0 ? b : a, {}, true};
  if (std::abs(drop) >= options_.least_cliff) {
    // The wall stands along the axis: the other contact's normal is square to it.
    if (dot(kink.point.normal, kink.point.axis) < std::sin(options_.least_angle.radians())) return;
    const EnvelopePoint& high = drop > 0.0 ? a : b;
    const Deformation::Steps step = field_.deformation.steps(high.flat);
    const Across out{dot(high.normal, step.x) / dot(step.x, step.x),
                     dot(high.normal, step.y) / dot(step.y, step.y)};
    const double sign = drop > 0.0 ? 1.0 : -1.0;
    constexpr double kUpright = 0.5;  // cosine: a flat end stands on the wall's upper edge
    kink.aside = dot(high.normal, high.axis) < kUpright ? unit(out) : Across{sign * line.dx, sign * line.dy};
    kinks.push_back(kink);
    return;
  }
  if (angle_between(a.normal, b.normal) < options_.least_angle.radians()) return;
  if (!(along(behind) > along(before))) return;  // convex
  const Across across = unit({behind[0] - before[0], behind[1] - before[1]});
  const bool behind_is_gentle = norm(behind) < norm(before);
  kink.aside = behind_is_gentle ? across : Across{-across[0], -across[1]};
  kink.steep = std::max(norm(behind), norm(before)) > kSteepSide;
  kink.point = behind_is_gentle ? b : a;
  kinks.push_back(kink);
}

std::vector<Kink> KinkSearch::along(const FlatLine& line) {
  std::vector<Kink> kinks;
  if (!(line.length > 0.0)) return kinks;
  for (const Pass& pass : envelope_.along(line).passes)
    for (std::size_t i = 0; i + 1 < pass.size(); ++i)
      search(line, line.run_of(pass[i].flat.x, pass[i].flat.y), pass[i],
             line.run_of(pass[i + 1].flat.x, pass[i + 1].flat.y), pass[i + 1], kinks);
  return kinks;
}

}  // namespace tiltfeed::pathgen
