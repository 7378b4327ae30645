#pragma once
// Where in flat space the job lets the tool go: limits of the coordinates and a boundary polygon.

#include <array>
#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/surface/flat_index.h"

namespace tiltfeed::pathgen {

class Region {
 public:
  Region(const Containment& containment, const Deformation& deformation);

  /// The part of the rectangle within the limits; empty (max < min) where they do not meet.
  FlatBounds within(const FlatBounds& bounds) const;
  /// The pieces of the line inside the boundary, from its start to its end; the line itself where there is
  /// no boundary.
  std::vector<FlatLine> inside(const FlatLine& line) const;
  /// Is the height of a CL point (z') within the limits?
  bool reaches(double z) const { return height_.contains(z * sign_); }
  /// Is (x', y') within limits and boundary?
  bool over(Point<Flat> f) const;
  /// Is there any limit to x' and y'?
  bool limited() const { return first_.bounded() || second_.bounded() || !boundary_.empty(); }
  /// The limits of z'.
  Interval levels() const;
  /// All of it: limits, boundary and height.
  bool contains(Point<Flat> f) const;
  /// Corners of the boundary, mm; empty: none.
  const std::vector<std::array<double, 2>>& boundary() const { return boundary_; }

 private:
  Interval first_, second_, height_;  ///< mm of x', y'; height as in Containment
  double sign_ = 1.0;                 ///< from z' to the height
  std::vector<std::array<double, 2>> boundary_;
};

}  // namespace tiltfeed::pathgen
