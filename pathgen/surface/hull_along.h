#pragma once
// A hull as lines of one direction see it. (S1) in pathgen/surface/README.md.

#include <cstdint>

#include "pathgen/surface/candidates.h"
#include "pathgen/surface/flat_bins.h"
#include "pathgen/surface/flat_hulls.h"

namespace tiltfeed::pathgen {

class HullAlong {
 public:
  /// The hull moved by (shift_x, shift_y), its corners from `corner` on; (dx, dy): the direction, unit.
  HullAlong(const FlatHull& hull, const FlatCorner* corner, double dx, double dy, double shift_x,
            double shift_y);

  /// It lies between two lines at these distances to the left of the origin, mm.
  double least_across() const { return least_ - cross_pad_; }
  double most_across() const { return most_ + cross_pad_; }

  /// Where the line, which has that direction, runs in the hull within the band of the cross pad; false if
  /// nowhere.
  bool meets(const FlatLine& line, Candidate& candidate) const;

 private:
  struct Place {
    double across, run;  ///< to the left of the origin, along the direction
  };
  Place place_[8];
  std::uint32_t count_;
  double cross_pad_, run_pad_, least_, most_;
  PatchId patch_;
  float top_;
};

}  // namespace tiltfeed::pathgen
