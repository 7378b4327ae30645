#pragma once
// Which patches of the CL surface each slice can meet, and where along it. (S1)..(S3) in pathgen/README.md.

#include <cstdint>
#include <span>
#include <vector>

#include "kinematics/result.h"
#include "pathgen/cells.h"
#include "pathgen/cl_surface.h"
#include "pathgen/deformation.h"

namespace tiltfeed {

/// Patch `patch` can be the highest only for run coordinates in [from, to].
struct Candidate {
  double from = 0.0, to = 0.0;
  PatchId patch = 0;
};

/// Slice k is the surface `cross coordinate = first + k * step`; its run coordinate lies in [run_min,
/// run_max].
struct Slices {
  Along along = Along::kX;
  double first = 0.0, step = 0.0;
  double run_min = 0.0, run_max = 0.0;
  std::vector<std::size_t> start;  ///< count() + 1 offsets into `candidates`
  std::vector<Candidate> candidates;
  std::vector<PatchId> near;  ///< patches that may cover the end of a column (Deformation::column_end)

  std::size_t count() const { return start.size() - 1; }
  double level(std::size_t k) const { return first + static_cast<double>(k) * step; }
  std::span<const Candidate> of(std::size_t k) const {
    return {candidates.data() + start[k], start[k + 1] - start[k]};
  }
};

inline constexpr std::size_t kMaxSlices = 1'000'000;
/// Candidates of all slices together; they take about 60 bytes each while they are sorted.
inline constexpr double kMaxCandidates = 100e6;

/// Lays slices over the whole CL surface that faces the tool, evenly and at most `side_step` apart, the
/// outermost half a step inside its borders. Properties: a patch that is the highest anywhere on a slice is
/// among that slice's candidates there; candidates of a slice are sorted by `from`, then patch. Errors:
/// kUnreachable when nothing faces the tool; kLimit when the side step asks for more than kMaxSlices
/// or kMaxCandidates.
Result<Slices> slice(const ClSurface& surface, const Deformation& deformation, Along along, double side_step);

}  // namespace tiltfeed
