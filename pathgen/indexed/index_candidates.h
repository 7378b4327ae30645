#pragma once
// Directions from which a part may be machined with a fixed axis. (I1) in pathgen/indexed/README.md.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "pathgen/indexed/indexed_cells.h"

namespace tiltfeed::pathgen {

/// Directions within the tilt limit, unit, and what of the samples each reaches.
struct IndexCandidates {
  std::vector<Vec3> directions;
  std::vector<std::vector<std::uint8_t>> sets;  ///< of reach_sets()
  bool reach(std::size_t sample) const {
    return std::any_of(sets.begin(), sets.end(), [sample](const auto& s) { return s[sample] != 0; });
  }
};

/// Those that a machinist would set first come first; then an even grid, finer where it reaches samples that
/// the rest does not. When the user stops it, not all is asked.
IndexCandidates index_candidates(const CheckedMesh& part, const PlanOptions& options, const CellReach& reach,
                                 const std::vector<SurfaceCell>& samples, const ReportShare& report = {});

}  // namespace tiltfeed::pathgen
