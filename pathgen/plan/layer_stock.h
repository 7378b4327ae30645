#pragma once
// What stock the layers of roughing leave for those below them: how far a rapid may go down. (U7) in
// pathgen/plan/README.md.

#include <vector>

#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

class LayerStock {
 public:
  /// All must outlive it. `floors`: z' of the CL reference on the stock's top and on each layer, downwards;
  /// empty: no layers, and no stock. `clearance_z`: z' that rapids come down from.
  LayerStock(const Box& part, const PlanOptions& options, const Deformation& map,
             const std::vector<double>& floors, double clearance_z);

  /// The z' over (x', y') down to which a rapid meets no stock on its way to `place`, a place of a layer: the
  /// floor above it and the approach, at least `to`, at most clearance_z. Where no containment says how far
  /// the stock goes, that is the part's box; beside it: `to`.
  double free_from(Point<Flat> place, double to) const;

 private:
  bool beside_box(Point<Flat> place, double to) const;

  const Box& part_;
  const PlanOptions& options_;
  const Deformation& map_;
  const std::vector<double>& floors_;
  double clearance_z_;
  bool box_known_;  ///< does the stock end with the part's box? A blank is asked elsewhere
  double radius_;   ///< of the cutting part, mm
};

}  // namespace tiltfeed::pathgen
