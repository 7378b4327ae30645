#include "pathgen/linking/over_envelope.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

bool over_envelope(const ClField& field, Envelope& envelope, Point<Flat> from, Point<Flat> to) {
  const double dx = to.x - from.x, dy = to.y - from.y, run = std::hypot(dx, dy);
  const double tolerance = envelope.options().tolerance;
  const auto under = [&](const EnvelopePoint& p, double z) {
    return (p.flat.z - z) * std::max(0.0, dot(p.normal, p.axis)) * static_cast<double>(p.lever) <= tolerance;
  };
  // Where columns may be shut, a gap in the envelope need not be air.
  const bool gaps_are_air = field.index.covering().empty();
  if (run <= tolerance) {
    const auto p = envelope.at(to.x, to.y);
    return p ? under(*p, std::min(from.z, to.z)) : gaps_are_air;
  }
  const LineEnvelope found = envelope.along({from.x, from.y, dx / run, dy / run, run});
  if (!found.too_near.empty()) return false;
  double covered = 0.0;
  for (const Pass& pass : found.passes)
    for (const EnvelopePoint& p : pass) {
      const double at = ((p.flat.x - from.x) * dx + (p.flat.y - from.y) * dy) / (run * run);
      if (!under(p, from.z + (to.z - from.z) * at)) return false;
      if (&p == &pass.front()) covered -= at * run;
      if (&p == &pass.back()) covered += at * run;
    }
  return gaps_are_air || covered >= run - tolerance;
}

}  // namespace tiltfeed::pathgen
