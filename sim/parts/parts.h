#pragma once
// The four parts of the paper, made by formula: exact face counts, no files.

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::sim {

using Triangles = std::vector<std::array<Point<Part>, 3>>;

inline constexpr std::size_t kTyreFacets = 236'748;

/// Tyre-mould segment: closed, exactly `facets` facets: with more of them the same surface, its longest edges
/// split. Requires: facets even and at least kTyreFacets.
Triangles tyre_segment(std::size_t facets = kTyreFacets);
/// Cooling pin with 6 rings of 12 wings: closed, exactly 55,818 facets.
Triangles cooling_pin();
/// Hollow sphere with three through holes: closed, 4,446 facets.
Triangles hollow_sphere();
/// Pull handle with finger grooves: closed, 23,780 facets.
Triangles handle();

/// By name: "tyre", "pin", "sphere", "handle". Errors: kUsage with the names.
Result<Triangles> part_by_name(const std::string& name);

}  // namespace tiltfeed::sim
