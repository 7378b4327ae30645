#pragma once
// How many points a pass has: those that add nothing go, others are put in where moves are too long. (E4) in
// pathgen/envelope/README.md.

#include <cstdint>
#include <functional>
#include <vector>

#include "pathgen/envelope/envelope.h"

namespace tiltfeed::pathgen {

/// Cuts the points for which `unwanted` holds out of the passes, which so become more and shorter. Returns
/// how many.
std::uint64_t leave_out(std::vector<Pass>& passes, const std::function<bool(const EnvelopePoint&)>& unwanted);

/// Cuts out of what was found along the line where shank or holder alone hold the tool: they raise it, and
/// do not send it where the cutting part has nothing to cut. There they are not known whole: (G2).
void leave_held(LineEnvelope& found, const FlatLine& line);

/// Drops points that a straight move between their neighbours passes within `tolerance` (mm), as long as the
/// axis turns at most options.max_axis_step in one move and the move is no longer than options.max_distance.
/// Keeps the first and the last.
Pass thinned(const Pass& pass, double tolerance, const EnvelopeOptions& options);

/// The place at the share `f` of the straight move from a to b; it has the contact of b.
EnvelopePoint on_move(const EnvelopePoint& a, const EnvelopePoint& b, double f, const Deformation& map);
/// The pass with points put into its straight moves where they are longer than `max_distance` (mm).
Pass spaced(Pass pass, const Deformation& map, double max_distance);

}  // namespace tiltfeed::pathgen
