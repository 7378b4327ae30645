#pragma once
// How deep a rapid may go down an axis line. (L1) in pathgen/linking/README.md.

#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

class Approaches {
 public:
  /// `approach`: thickness of what may still stand on the part, mm, above 0. `from`: the z' that rapids come
  /// down from.
  Approaches(const ClField& field, double approach, double from);

  /// z' at which the tool, grown by the approach all round, first touches the part on its way from `from`
  /// down the axis line of `place`: above, it is clear of a layer as thick. At least place.z + approach. The
  /// tool: those of its pieces that the CL surface is made for.
  double rapid_end(Point<Flat> place);

 private:
  const ClField& field_;
  double approach_, from_;
  std::vector<ToolPiece> grown_;  ///< by the approach
  FlatIndex::Scratch scratch_;
  std::vector<FlatIndex::Nearby> nearby_;
};

}  // namespace tiltfeed::pathgen
