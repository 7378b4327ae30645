#pragma once
// What an STL file holds, and how much of it is taken.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::pathgen {

/// The facets in file order, scaled to mm, unwelded. Normals of the file are ignored: corners decide.
/// Coordinates are the file's float32 values (text is rounded to float32 too), scaled in double.
struct Stl {
  std::vector<std::array<Point<Part>, 3>> facets;
  bool binary = false;
  std::vector<std::string> warnings;  ///< oddities that do no harm: trailing bytes, several solids
};

inline constexpr std::uint64_t kMaxStlBytes = 512ull << 20;
inline constexpr std::uint32_t kMaxFacets = 5'000'000;
/// Largest coordinate in any direction, mm: beyond it the unit is wrong, and float32 is coarser than 1 um.
inline constexpr double kMaxCoordinate = 10'000.0;

}  // namespace tiltfeed::pathgen
