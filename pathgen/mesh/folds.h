#pragma once
// Where a closed mesh is folded over itself and turned inside out.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

/// An edge that looks like a narrow notch: concave, and narrower than a right angle.
struct NarrowNotch {
  std::uint32_t low = 0, high = 0;        ///< its ends
  std::array<std::uint32_t, 2> facets{};  ///< beside it
};

/// The first facets, ascending, of those notches that have no material behind them. Of more notches than
/// kMostFoldLooks allows only some are asked, evenly spread. Requires: the mesh is closed and oriented.
std::vector<std::uint32_t> folded_facets(const Mesh& mesh, std::span<const NarrowNotch> notches);

/// Notches that are asked times facets of the mesh, at most; 16 notches are always asked.
inline constexpr std::size_t kMostFoldLooks = 5'000'000;

}  // namespace tiltfeed::pathgen
