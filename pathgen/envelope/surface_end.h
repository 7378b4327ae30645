#pragma once
// Where along a line the surface ends: it is looked for between a point of the envelope and a place beyond.

#include "pathgen/envelope/straight_moves.h"
#include "pathgen/surface/flat_bins.h"

namespace tiltfeed::pathgen {

/// The end is found this closely (mm). It is usually on a flank: a ball of radius R is then within
/// sqrt(2 R kEndStep) of the end of the flank.
inline constexpr double kEndStep = 1e-7;

/// The run coordinate to look at next between two samples, of which one is a hit; `looks`: how often that was
/// asked between them. Just beyond where the end should be, or just before it, and every fourth time half
/// way, so that it is found anyhow.
double next_look(const ClSurface& surface, const Deformation& map, const FlatLine& line, const Sample& left,
                 const Sample& right, int looks);

}  // namespace tiltfeed::pathgen
