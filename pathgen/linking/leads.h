#pragma once
// Tangential arcs into and out of a pass, in the plane of its direction and the tool axis. (L6) in
// pathgen/linking/README.md.

#include <vector>

#include "pathgen/envelope/envelope.h"
#include "pathgen/linking/travel.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

class Leads {
 public:
  Leads(const ClField& field, const Linking& options, OppositeWall& opposite_wall, Envelope& envelope,
        const Travel& travel)
      : field_(field),
        options_(options),
        opposite_wall_(opposite_wall),
        envelope_(envelope),
        travel_(travel) {}

  /// The arc from the end `end` of a pass outwards and up; `next` is the pass's point next to it. Each is the
  /// place of the CL reference, `end` itself left out; the last is where the arc points along the axis of
  /// `end`. Empty where the pass climbs away from its end too steeply, the envelope is in the way, the arc
  /// ends above the clearance surface, tilts too far, or is blocked on the opposite wall.
  std::vector<Point<Flat>> arc(const EnvelopePoint& end, const EnvelopePoint& next);

 private:
  std::vector<Point<Flat>> shape(const EnvelopePoint& end, const EnvelopePoint& next) const;
  bool free_above(Point<Flat> place);

  const ClField& field_;
  const Linking& options_;
  OppositeWall& opposite_wall_;
  Envelope& envelope_;
  const Travel& travel_;
};

}  // namespace tiltfeed::pathgen
