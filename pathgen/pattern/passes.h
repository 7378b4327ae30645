#pragma once
// The passes of a raster: rows of the envelope, as near to each other as the side step asks on the part, with
// what may not be cut left out. (R1)..(R3) in pathgen/pattern/README.md.

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/envelope/envelope.h"
#include "pathgen/envelope/smoothing.h"
#include "pathgen/pattern/point_rules.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

struct Passes {
  std::vector<std::vector<Pass>> rows;  ///< from right to left of the pass direction; thinned
  std::uint64_t traced = 0;             ///< points of the envelope before anything was left out
  double top = -std::numeric_limits<double>::infinity();  ///< highest z' of the envelope
  std::vector<PatchId> too_near;                          ///< patches left out for kLeastAxisDistance
  RejectedPoints refusals;
  bool as_given = false;    ///< rows are groups in the order to be cut, and no pass may be run backwards
  std::uint64_t steep = 0;  ///< points on walls too steep for the side step to be kept
  Smoothed smoothed;
  double ridge = 0.0;          ///< with StepMeasure::kRidge what is allowed between rows, mm
  std::vector<double> floors;  ///< as Contours::floors; empty: no roughing

  /// Adds all of it but the rows.
  void add(const Passes& other);
};

/// Rounds off the concave corners of passes that may be cut as they are; what rises out of the region is left
/// out.
void smooth(std::vector<Pass>& passes, double radius, const PointRules& rules, Envelope& envelope,
            Smoothed& report);

/// Most times a row is halved for the side step on the part.
inline constexpr int kMostHalvings = 7;

/// Properties: 1 with StepMeasure::kFlat rows are evenly spaced. 2 With kSurface and kScallop neighbouring
/// passes are at most the side step apart on the part, as a rule not less than half of it, where the surface
/// leans at most kSteepestAcross across them. Errors: as lay_rows; kCancelled when `progress` returns false.
Result<Passes> trace_raster(const ClField& field, const PlanOptions& options, const EnvelopeOptions& envelope,
                            double thinning, const std::function<bool(double)>& progress);

}  // namespace tiltfeed::pathgen
