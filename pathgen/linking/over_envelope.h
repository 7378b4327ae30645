#pragma once
// Is a straight move of the CL reference clear of the part? The envelope under it tells.

#include "pathgen/envelope/envelope.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

/// Is the move on or over the envelope along all of its flat line, within the envelope's tolerance? Requires:
/// `envelope` is that of `field`.
bool over_envelope(const ClField& field, Envelope& envelope, Point<Flat> from, Point<Flat> to);

}  // namespace tiltfeed::pathgen
