#include "pathgen/envelope/heights.h"

#include <algorithm>
#include <cmath>

#include "kinematics/basics/units.h"

namespace tiltfeed::pathgen {

namespace {

/// So far beyond the end of a pass the surface is taken to be gone (mm): more than the envelope's own search
/// for the end, less than any tolerance.
constexpr double kBeyondEnd = 1e-6;
/// Steeper than this (rise over run) is searched as a wall, by halving.
constexpr double kSteep = 4.0;
/// How far aside of where a straight surface would cross, in finenesses; and nearest to an end (share).
constexpr double kAside = 0.4, kLeastShare = 0.01;

}  // namespace

FlatLine line_between(Place a, Place b) {
  const double length = distance(a, b);
  if (length == 0.0) return {a.x, a.y, 1.0, 0.0, 0.0};
  return {a.x, a.y, (b.x - a.x) / length, (b.y - a.y) / length, length};
}

Place Heights::folded(Place p) const {
  if (map_.frame().mode != AxisMode::kPoint) return p;
  const double pole = kPi / 2.0 * map_.scale_y();
  if (std::abs(p.y) <= pole) return p;
  const double half = map_.period_x() / 2.0;
  return {p.x > 0.0 ? p.x - half : p.x + half, std::copysign(2.0 * pole, p.y) - p.y};
}

/// Outside a point or line, what is too near to it lies below: the tool is free above. Elsewhere the column
/// ends above.
bool Heights::may_be_shut() const { return map_.s() < 0.0 || map_.frame().mode == AxisMode::kCircle; }

EnvelopePoint Heights::contact(Place p) {
  const Place f = folded(p);
  if (const auto point = envelope_.at(f.x, f.y)) return *point;
  EnvelopePoint none;
  none.flat.z = kNoSurface;
  if (const auto patch = envelope_.shut_by(); patch && may_be_shut())
    none.flat.z = kShut, none.patch = *patch;
  return none;
}

double Heights::at(Place p) { return contact(p).flat.z; }

bool Heights::is_over(Place p, double z) {
  // There what is too low shuts its column.
  if (may_be_shut() && map_.s() > 0.0) return at(p) > z;
  const Place f = folded(p);
  return envelope_.rises_over(f.x, f.y, z) || (envelope_.shut_by() && may_be_shut());
}

bool Heights::cut_is_over(Place p, double z) {
  if (!envelope_.has_guards()) return is_over(p, z);
  const Place f = folded(p);
  return envelope_.cutter_height(f.x, f.y) > z;
}

bool Heights::keeps_under(double top, Place a, Place b, Pass& points) {
  points.clear();
  const LineEnvelope found = envelope_.along_short(line_between(a, b), top);
  for (const Pass& pass : found.passes) points.insert(points.end(), pass.begin(), pass.end());
  if (!found.too_near.empty() && may_be_shut()) return false;
  return std::all_of(points.begin(), points.end(), [&](const EnvelopePoint& p) { return p.flat.z <= top; });
}

std::vector<HeightSample> Heights::profile(const FlatLine& line, double z) {
  std::vector<HeightSample> samples;
  const auto gap = [&](double from, double to) {
    if (to - from <= 2.0 * kBeyondEnd) return;
    for (double run : {from, to}) samples.push_back({run, at({line.x_at(run), line.y_at(run)})});
  };
  double end = 0.0;
  const LineEnvelope found =
      envelope_.is_crowded(line) ? envelope_.along_short(line, z) : envelope_.along(line, z);
  for (const Pass& pass : found.passes) {
    const auto run_of = [&](const EnvelopePoint& p) {
      return (p.flat.x - line.x) * line.dx + (p.flat.y - line.y) * line.dy;
    };
    gap(end, run_of(pass.front()) - kBeyondEnd);
    for (const EnvelopePoint& p : pass) samples.push_back({run_of(p), p.flat.z});
    end = run_of(pass.back()) + kBeyondEnd;
  }
  gap(end, line.length);
  return samples;
}

void bisect(Heights& heights, double level, double fineness, Place& outside, Place& inside) {
  if (distance(outside, inside) <= fineness) return;
  double low = heights.at(outside), high = heights.at(inside);
  for (int step = 0; distance(outside, inside) > fineness; ++step) {
    const double gap = distance(outside, inside);
    double share = 0.5;
    // Where the surface is no wall, two looks to either side of where a straight one crosses, then a halving.
    if (step % 3 != 2 && high > low && high - low < kSteep * gap) {
      const double aside = (step % 3 == 0 ? kAside : -kAside) * fineness / gap;
      share = std::clamp((level - low) / (high - low) + aside, kLeastShare, 1.0 - kLeastShare);
    }
    const Place middle = lerp(outside, inside, share);
    const double z = heights.at(middle);
    if (z > level) {
      inside = middle, high = z;
    } else {
      outside = middle, low = z;
    }
  }
}

}  // namespace tiltfeed::pathgen
