#pragma once
// In which order and direction the passes are travelled. (L3) in pathgen/linking/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/linking/link_options.h"

namespace tiltfeed::pathgen {

/// A pass, and whether it is travelled from back to front.
struct Travelled {
  std::uint32_t slice = 0, pass = 0;
  bool reversed = false;
  bool operator==(const Travelled&) const = default;
};
using Order = std::vector<Travelled>;

/// Slice by slice; in zigzag every second slice that has passes is travelled backwards.
Order plain_order(const std::vector<std::vector<Pass>>& slices, Direction direction);

/// Region by region: a region is a row of passes on neighbouring slices, each of which overlaps the next and
/// no other. In zigzag they are travelled to and fro, from either end of the row; else all forwards and in
/// rising slices, so that the stock stays on one side. From the end of a region to the nearest start.
/// Properties: holds each pass once; the work is n log n. Requires: no pass is empty.
Order region_order(const std::vector<std::vector<Pass>>& slices, const Deformation& deformation,
                   const Linking& options);

/// Regions, or stretches of them whose ends are at most Linking::join_distance apart, in the order and
/// direction in which the ways between them over the clearance surface take the least time, about: as
/// order_runs(), by Linking::rapid. Empty where there are more than kMostOrderedRuns, or fewer than three.
/// Properties: holds each pass once; one way none is reversed; the same for the same passes. Requires: as
/// region_order().
Order timed_order(const std::vector<std::vector<Pass>>& slices, const Deformation& deformation,
                  const Linking& options);

}  // namespace tiltfeed::pathgen
