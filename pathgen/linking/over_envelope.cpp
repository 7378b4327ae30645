#include "pathgen/linking/over_envelope.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// Of the rounding of the cutter: so far moves of ways far over the envelope may leave it.
constexpr double kCoarse = 0.125;
/// In such a move the axis turns by no more, rad.
constexpr double kCoarseTurn = 0.1;

/// Is the envelope `under` (a point of it, the height of the move there) all along the move?
template <class Under>
bool is_over(const ClField& field, Envelope& envelope, Point<Flat> from, Point<Flat> to, const Under& under) {
  const double dx = to.x - from.x, dy = to.y - from.y, run = std::hypot(dx, dy);
  const double tolerance = envelope.options().tolerance;
  // Where columns may be shut, a gap in the envelope need not be air.
  const bool gaps_are_air = field.index.covering().empty();
  const double lower = std::min(from.z, to.z);
  if (run <= tolerance) {
    const auto p = envelope.at(to.x, to.y);
    return p ? under(*p, lower) : gaps_are_air;
  }
  const LineEnvelope found = envelope.along({from.x, from.y, dx / run, dy / run, run}, lower);
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

}  // namespace

bool over_envelope(const ClField& field, Envelope& envelope, Point<Flat> from, Point<Flat> to) {
  const double tolerance = envelope.options().tolerance;
  return is_over(field, envelope, from, to, [&](const EnvelopePoint& p, double z) {
    return (p.flat.z - z) * std::max(0.0, dot(p.normal, p.axis)) * static_cast<double>(p.lever) <= tolerance;
  });
}

EnvelopeOptions far_over_options(const ClSurface& surface, EnvelopeOptions options, double clearance) {
  const ToolPiece& cutter = surface.pieces().front();
  const double rounding = cutter.corner > 0.0 ? cutter.corner : cutter.outer;
  options.tolerance = std::max(options.tolerance, std::min(kCoarse * rounding, clearance / 4.0));
  options.max_axis_step = std::max(options.max_axis_step, kCoarseTurn);
  options.turn_tolerance = std::max(options.turn_tolerance, options.tolerance);
  return options;
}

bool far_over_envelope(const ClField& field, Envelope& coarse, Point<Flat> from, Point<Flat> to) {
  const double spare = 2.0 * coarse.options().tolerance;
  return is_over(field, coarse, from, to,
                 [spare](const EnvelopePoint& p, double z) { return p.flat.z + spare <= z; });
}

}  // namespace tiltfeed::pathgen
