#pragma once
// From the end of one pass to the start of the next on the envelope. (L5) in pathgen/linking/README.md.

#include <optional>

#include "pathgen/envelope/envelope.h"
#include "pathgen/linking/travel.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

class Joins {
 public:
  Joins(const ClField& field, const Linking& options, OppositeWall& opposite_wall, Envelope& envelope,
        const Travel& travel)
      : field_(field),
        options_(options),
        opposite_wall_(opposite_wall),
        envelope_(envelope),
        travel_(travel) {}

  /// An end of a pass, and the pass's point next to it (the end itself in a pass of one point).
  struct End {
    EnvelopePoint point, inward;
  };
  /// The points between a and b, thinned, both left out: along the straight flat line or, where the surface
  /// ends short of that, a little way back into both passes. Nothing when the ends are further apart than
  /// join_distance, the envelope has a gap there, a point may not be cut or is blocked on the opposite wall,
  /// or going up and over is quicker.
  std::optional<Pass> between(const End& a, const End& b);
  /// The points between a and the first point of the closed row `to` a turn on, thinned, both left out: along
  /// the straight flat line. Nothing as above, but for the time.
  std::optional<Pass> round(const EnvelopePoint& a, const Pass& to);

 private:
  double time_over(const EnvelopePoint& a, const EnvelopePoint& b) const;
  double turning(const EnvelopePoint& a, const EnvelopePoint& b) const;
  bool may_cut(const Pass& pass) const;
  std::optional<Pass> along(const EnvelopePoint& a, const EnvelopePoint& b,
                            const std::vector<Point<Flat>>& corners);

  const ClField& field_;
  const Linking& options_;
  OppositeWall& opposite_wall_;
  Envelope& envelope_;
  const Travel& travel_;
};

}  // namespace tiltfeed::pathgen
