#pragma once
// Cutting passes to what is wanted of them: by a condition on their points, or to a polygon.

#include <array>
#include <functional>
#include <vector>

#include "kinematics/basics/units.h"
#include "pathgen/envelope/envelope.h"

namespace tiltfeed::pathgen {

/// Corners (x', y'), mm; either way round.
using FlatPolygon = std::vector<std::array<double, 2>>;

/// Always true for an empty polygon.
bool in_polygon(const FlatPolygon& polygon, double x, double y);

/// The passes where `wanted` holds, each piece longer by `overlap` (mm of the CL reference) at both ends as
/// far as the pass goes. Ends between two points lie on the straight move, within kTrimStep of where `wanted`
/// changes; a closed pass that is cut becomes open pieces, none of which ends at its old start for that
/// reason alone.
std::vector<Pass> keep_where(const std::vector<Pass>& passes, const Deformation& map,
                             const std::function<bool(const EnvelopePoint&)>& wanted, double overlap);
inline constexpr double kTrimStep = 1e-4;  ///< mm

/// The same for a polygon of the flat plane, where moves are straight. Nothing is cut by an empty one.
std::vector<Pass> inside_polygon(const std::vector<Pass>& passes, const Deformation& map,
                                 const FlatPolygon& polygon);

/// Angle of the surface against the plane across the axis, rad.
double slope(const EnvelopePoint& point);

/// Both sides of a split by slope: each place of the surface is in one, and within `overlap` of the border
/// along a pass in both.
std::vector<Pass> steep_of(const std::vector<Pass>& passes, const Deformation& map, Angle split_slope,
                           double overlap);
std::vector<Pass> shallow_of(const std::vector<Pass>& passes, const Deformation& map, Angle split_slope,
                             double overlap);

bool is_closed(const Pass& pass);
/// Turns a closed pass round so that it starts at its point nearest to `to`.
void start_near(Pass& pass, Point<Part> to);

}  // namespace tiltfeed::pathgen
