#pragma once
// Where along a line each patch may be the highest.

#include <cstdint>
#include <limits>
#include <vector>

#include "pathgen/cl_surface.h"

namespace tiltfeed {

/// Patch `patch` can be the highest only for run coordinates in [from, to].
struct Candidate {
  double from = 0.0, to = 0.0;
  PatchId patch = 0;
  float top = std::numeric_limits<float>::infinity();  ///< as Cell::top
};

/// Adds the pieces to the candidates, those of one patch joined where they overlap. Leaves `pieces` sorted.
void join_pieces(std::vector<Candidate>& pieces, std::vector<Candidate>& candidates);

/// Room to sort in.
struct CandidateSorting {
  std::vector<Candidate> candidates;
  std::vector<std::uint32_t> start;  ///< of each bin
};
/// Sorts candidates that start within [0, length] by (from, patch, to).
void sort_by_start(std::vector<Candidate>& candidates, double length, CandidateSorting& room);

}  // namespace tiltfeed
