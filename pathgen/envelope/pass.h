#pragma once
// Points of the envelope and rows of them.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/surface/cl_surface.h"

namespace tiltfeed::pathgen {

/// A point of the envelope, exactly on the CL surface.
struct EnvelopePoint {
  Point<Flat> flat;
  Point<Part> centre;  ///< the CL reference: centre of the ball or of the rounded edge
  Vec3 axis;           ///< unit, from tip to shank
  Vec3 normal;         ///< unit, of the CL surface, away from the part
  PatchId patch = 0;
  float lever = 1.0f;  ///< (C5) what the reference strays from the surface the contact does times this, >= 1
};

/// A pass: an unbroken row of envelope points in rising run coordinate.
using Pass = std::vector<EnvelopePoint>;

struct EnvelopeOptions {
  double tolerance =
      0.003;  ///< largest distance of the envelope from the straight move between two points, mm
  double max_axis_step = 0.02;  ///< largest turn of the axis between two points, rad
  double max_distance = std::numeric_limits<double>::infinity();  ///< between two points, mm
  double reach = 0.0;  ///< how far up the tool its side must keep to the path, over the CL reference, mm
  double turn_tolerance = 0.002;  ///< what the side so far up may stray where the axis turns in a move, mm
};

/// (E5) From a to b the axis turns by an angle whose square is `turn2` (rad^2), evenly; the true one faster
/// the nearer it is to the point, line or circle. Does the side at options.reach stay within
/// options.turn_tolerance of its place, bow included?
inline bool turns_little(const EnvelopePoint& a, const EnvelopePoint& b, double turn2,
                         const EnvelopeOptions& options) {
  if (turn2 > options.max_axis_step * options.max_axis_step) return false;
  const double near = std::min(std::abs(a.flat.z), std::abs(b.flat.z));
  const double left = (8.0 * options.turn_tolerance - options.reach * turn2) * near;  // of the bow
  const double uneven = 2.0 * options.reach * (a.flat.z - b.flat.z);
  return left >= 0.0 && uneven * uneven * turn2 <= left * left;
}

/// Nearer than this to the point, line or circle (mm) the axis turns too fast to be of use: nothing is
/// machined there.
inline constexpr double kLeastAxisDistance = 0.1;

}  // namespace tiltfeed::pathgen
