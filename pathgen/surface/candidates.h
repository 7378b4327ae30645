#pragma once
// Where along a line each patch may be the highest.

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "pathgen/surface/cl_surface.h"

namespace tiltfeed::pathgen {

/// Patch `patch` can be the highest only for run coordinates in [from, to].
struct Candidate {
  double from = 0.0, to = 0.0;
  PatchId patch = 0;
  float top = std::numeric_limits<float>::infinity();  ///< as FlatHull::top
  bool operator==(const Candidate&) const = default;
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

/// Goes along a line from break to break: the places where candidates begin or end, those less than `close`
/// (mm) beyond the last break left out, and the last of all.
class CandidateSweep {
 public:
  /// Requires: candidates by rising start, which outlive it.
  CandidateSweep(std::span<const Candidate> all, double close) : all_(all), close_(close) {}

  /// On to the next stretch; false where there is none. The first is the first break alone.
  bool next();
  double from() const { return from_; }
  double to() const { return to_; }
  /// All that overlap the stretch, those that may be highest first.
  const std::vector<Candidate>& active() {
    if (settled_ < active_.size()) settle();
    return active_;
  }

 private:
  void drop_ended();
  void take_next();
  double next_end();
  void settle();

  std::span<const Candidate> all_;
  double close_, from_ = 0.0, to_ = 0.0;
  std::size_t next_ = 0;  ///< those before it have been taken
  std::vector<Candidate> active_;
  std::size_t settled_ = 0;   ///< so many of them are in order, those behind were just taken
  std::vector<double> ends_;  ///< of them, a heap with the first in front; without those below
  bool some_end_ = false;     ///< too near to the last break for a break of their own
};

}  // namespace tiltfeed::pathgen
