#pragma once
// Is a straight move of the CL reference clear of the part? The envelope under it tells.

#include "pathgen/envelope/envelope.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

/// Is the move on or over the envelope along all of its flat line, within the envelope's tolerance? Requires:
/// `envelope` is that of `field`.
bool over_envelope(const ClField& field, Envelope& envelope, Point<Flat> from, Point<Flat> to);

/// Options of an envelope that costs far less along a line, for far_over_envelope(). `clearance`, mm: what a
/// way over the clearance surface keeps of it.
EnvelopeOptions far_over_options(const ClSurface& surface, EnvelopeOptions options, double clearance);

/// Is the move over the envelope by twice the tolerance of `coarse` all along? If not, over_envelope() knows.
/// Between two points of it the envelope rises over both by less: no further than the tolerance at a
/// rounding's top (E2). Requires: `coarse` is an envelope of `field` with far_over_options().
bool far_over_envelope(const ClField& field, Envelope& coarse, Point<Flat> from, Point<Flat> to);

}  // namespace tiltfeed::pathgen
