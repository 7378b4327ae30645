#pragma once
// Rounds off the concave corners of a pass: the tool rises along its axis. (E6) in
// pathgen/envelope/README.md.

#include "pathgen/envelope/envelope.h"

namespace tiltfeed::pathgen {

struct Smoothing {
  double radius = 0.0;     ///< of the arcs in concave corners, mm; above 0
  double tolerance = 0.0;  ///< of the arcs' chords, mm
};

/// What the rounding left uncut.
struct Smoothed {
  std::uint64_t points = 0;  ///< raised by more than the tolerance
  double most = 0.0;         ///< largest rise, along the axis, mm
  void add(const Smoothed& other);
};

/// The pass rolled over by a disc of `radius`: where the disc does not reach down, its lower side is the
/// pass. Nothing is lowered, so what was clear of the part stays clear. Requires: points of `pass` on the
/// envelope, in the order in which they are cut.
Pass smoothed(const Pass& pass, const Smoothing& smoothing, Envelope& envelope, Smoothed& report);

}  // namespace tiltfeed::pathgen
