#pragma once
// Patterns of closed curves in the flat plane: contours at constant z', and a region's border moved inwards.
// (Z1)..(Z7) in pathgen/pattern/README.md.

#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/envelope/envelope.h"
#include "pathgen/envelope/pass_trim.h"
#include "pathgen/progress/stages.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

struct ContourOptions {
  EnvelopeOptions envelope;
  Pattern pattern;
  FlatPolygon boundary;  ///< closed; in mm of the flat plane, within one turn; empty: none
  Interval height;       ///< z', mm
  /// Where z_level's contours are wanted: what lies further off than some cells of the grid is not looked
  /// for; nothing: everywhere.
  std::optional<FlatBounds> window = {};
};

struct Contours {
  /// In the order of machining; what is in one group is best linked without going far away. A closed pass
  /// ends with its first point, and no pass may be run backwards. x', y' of points lie within half a turn of
  /// 0.
  std::vector<std::vector<Pass>> groups;
  std::vector<std::string> warnings;
  /// Roughing: z' of the stock's top and of each layer, downwards.
  std::vector<double> floors;
};

inline constexpr double kMaxLevels = 10e3;
/// Nodes of the grid times levels: some 1 GB.
inline constexpr double kMaxLevelNodes = 200e6;

/// The CL reference on the border of where the envelope is higher than the level, at z' = level, for levels
/// evenly and at most step_down apart: from the highest place on a grid line (or height.high), where there is
/// none, to the lowest (or height.low, which may lie below: walls down from where the surface ends).
/// Properties, t = envelope.tolerance: on every move the envelope is at most level + t, or a move grazes a
/// wall less than t deep; at every point it is higher than the level at most 2 t aside; each comes after the
/// loops above it (order_of) as far as their pocket or island lies within the window. Features narrower than
/// grid_spacing that no grid line meets are missed: their contours are left out, never cut into. Errors:
/// kLimit for too many levels or too fine a grid, kUnreachable when there is nothing, kCancelled.
Result<Contours> z_level(const ClField& field, const ContourOptions& options, const Progress& progress);

/// Distance of the grid lines on which contours are found: the smaller of side_step and step_down, at least
/// 16 tolerances.
double grid_spacing(const Pattern& pattern, double tolerance);

/// From below `top` down to `bottom`, evenly and at most `step_down` apart. Errors: kLimit, kInput.
Result<std::vector<double>> levels_between(double top, double bottom, double step_down);

}  // namespace tiltfeed::pathgen
