#pragma once
// CIRCLE/ of an APT file as straight moves.

#include <vector>

#include "kinematics/basics/geometry.h"
#include "kinematics/cl_text/apt_record.h"

namespace tiltfeed {

/// The circle on which the next GOTO/ is reached.
struct AptArc {
  Vec3 centre;  ///< in the frame and unit that CIRCLE/ states it in
  Vec3 axis;    ///< unit; the turn is counter-clockwise seen from its tip
  double radius = 0.0;
  bool radius_stated = false;
  bool goes_on = false;      ///< further points on the circle are reached along it, too
  int points = 0;            ///< reached so far
  double first_sweep = 0.0;  ///< rad, to the first of them
};

/// CIRCLE/x,y,z,i,j,k (CAMWorks), with a radius (points along the arc may follow), or with radius,
/// tolerances, diameter and corner radius (NX, whose axis points the other way).
AptVerdict read_circle(const AptRecord& record, AptArc& arc);

/// The point lies on the circle, within `slack` mm.
bool lies_on(const AptArc& arc, Vec3 centre, Vec3 axis, Point<Part> point, double slack);

/// The corners of chords from `from` (left out) to `to` (the last) that stay within `tolerance` mm of the
/// arc; ends that are not equally high make it a helix. Ends within `same` mm of each other: a whole turn.
/// Errors: the ends are not equally far from the centre, nothing to turn about.
AptVerdict chords(AptArc& arc, Vec3 centre, Vec3 axis, Point<Part> from, Point<Part> to, double tolerance,
                  double same, std::vector<Point<Part>>& corners);

}  // namespace tiltfeed
