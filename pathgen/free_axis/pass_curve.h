#pragma once
// A pass by its length: where it is, and which direction the tool is wished to have there.

#include <vector>

#include "pathgen/free_slices/cl_chains.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

class PassCurve {
 public:
  /// `chain` must outlive the curve. Requires: at least two points, no two neighbours the same.
  PassCurve(const ClChain& chain, const FreeAxis& wish);

  double length() const { return way_.back(); }
  /// The chain's points' places along it, mm.
  const std::vector<double>& ways() const { return way_; }
  const ClStrand& points() const { return chain_.points; }
  ClPoint at(double way) const;
  /// (O1) The surface normal, turned by lead forwards and by lean to the left of the feed; normal and feed
  /// are means over the smoothing length. Unit.
  Vec3 wished(double way) const;

 private:
  std::size_t index(double way) const;
  /// Of the normal from the start to `way`, and the centre there; beyond the ends of a closed pass it goes on
  /// round, else it stops.
  Vec3 normals_up_to(double way) const;

  const ClChain& chain_;
  FreeAxis wish_;
  std::vector<double> way_;
  std::vector<Vec3> sum_;  ///< integrals of the normal up to each point
};

}  // namespace tiltfeed::pathgen
