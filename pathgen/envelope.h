#pragma once
// The upper envelope of one slice: the highest CL point on each axis line, so that neither ball nor straight
// shank cuts into the part. (E1)..(E4) in pathgen/README.md.

#include <cstdint>
#include <functional>
#include <vector>

#include "pathgen/cl_surface.h"
#include "pathgen/deformation.h"
#include "pathgen/slices.h"

namespace tiltfeed {

/// A point of the envelope, exactly on the CL surface.
struct EnvelopePoint {
  Point<Flat> flat;
  Point<Part> centre;  ///< of the ball
  Vec3 axis;           ///< unit, from tip to shank
  Vec3 normal;         ///< unit, from contact point to ball centre
  PatchId patch = 0;
};

/// A pass: an unbroken row of envelope points in rising run coordinate.
using Pass = std::vector<EnvelopePoint>;

struct EnvelopeOptions {
  double tolerance =
      0.003;  ///< largest distance of the envelope from the straight move between two points, mm
  double max_axis_step = 0.02;  ///< largest turn of the axis between two points, rad
};

/// Nearer than this to the point, line or circle (mm) the axis turns too fast to be of use: nothing is
/// machined there.
inline constexpr double kLeastAxisDistance = 0.1;

struct SliceEnvelope {
  std::vector<Pass> passes;
  std::vector<PatchId> too_near;  ///< patches left out for kLeastAxisDistance, each once
};

/// Points on the envelope of slice k, dense enough that straight moves of the ball's centre between them stay
/// within options.tolerance of it. Steep flanks are points whose axis lines lie at most tolerance / 10 apart.
/// A gap in the surface ends a pass.
SliceEnvelope upper_envelope(const ClSurface& surface, const Deformation& deformation, const Slices& slices,
                             std::size_t k, const EnvelopeOptions& options);

/// Cuts the points for which `unwanted` holds out of the passes, which so become more and shorter. Returns
/// how many.
std::uint64_t leave_out(std::vector<std::vector<Pass>>& slices,
                        const std::function<bool(const EnvelopePoint&)>& unwanted);

/// Drops points that a straight move between their neighbours passes within `tolerance` (mm), as long as the
/// axis turns at most `max_axis_step` (rad) in one move. Keeps the first and the last.
Pass thinned(const Pass& pass, double tolerance, double max_axis_step);

}  // namespace tiltfeed
