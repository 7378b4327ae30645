#pragma once
// Regions of the flat plane and what is left of them at a distance from their borders (Clipper).

#include <vector>

#include "pathgen/envelope/heights.h"
#include "pathgen/envelope/pass_trim.h"

namespace tiltfeed::pathgen {

/// Closed where the last place is the first.
using FlatCurve = std::vector<Place>;

/// One connected region: its border counter-clockwise, its holes clockwise.
struct FlatRegion {
  FlatPolygon border;
  std::vector<FlatPolygon> holes;
};

/// Coordinates are rounded to this (mm).
inline constexpr double kFlatGrain = 1e-5;

/// The regions of which the polygons, either way round, are the borders: a place is inside if it is inside an
/// odd number of them.
std::vector<FlatRegion> regions_of(const std::vector<FlatPolygon>& polygons);

/// What of the regions is further than `distance` (mm) from their borders: round what sticks in, the new
/// border is an arc, within `tolerance` (mm).
std::vector<FlatRegion> moved_inwards(const std::vector<FlatRegion>& regions, double distance,
                                      double tolerance);

bool in_region(const FlatRegion& region, double x, double y);

}  // namespace tiltfeed::pathgen
