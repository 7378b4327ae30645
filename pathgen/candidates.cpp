#include "pathgen/candidates.h"

#include <algorithm>
#include <numeric>

namespace tiltfeed {

namespace {

/// On a shorter line (mm) all candidates start in one bin.
constexpr double kShort = 1e-9;

}  // namespace

void join_pieces(std::vector<Candidate>& pieces, std::vector<Candidate>& candidates) {
  std::sort(pieces.begin(), pieces.end(), [](const Candidate& a, const Candidate& b) {
    if (a.patch != b.patch) return a.patch < b.patch;
    if (a.from != b.from) return a.from < b.from;
    return a.to < b.to;
  });
  const std::size_t first = candidates.size();
  for (const Candidate& piece : pieces) {
    if (candidates.size() > first && candidates.back().patch == piece.patch &&
        piece.from <= candidates.back().to) {
      candidates.back().to = std::max(candidates.back().to, piece.to);
      candidates.back().top = std::max(candidates.back().top, piece.top);
    } else {
      candidates.push_back(piece);
    }
  }
}

/// They are spread over as many bins as there are, then each bin is sorted.
void sort_by_start(std::vector<Candidate>& candidates, double length, CandidateSorting& room) {
  const std::size_t count = candidates.size();
  if (count == 0) return;
  const double per_mm = length > kShort ? static_cast<double>(count) / length : 0.0;
  const auto bin = [&](const Candidate& c) {
    return std::min(static_cast<std::size_t>(c.from * per_mm), count - 1);
  };
  std::vector<std::uint32_t>& start = room.start;
  start.assign(count + 1, 0);
  for (const Candidate& c : candidates) ++start[bin(c) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  room.candidates.resize(count);
  for (const Candidate& c : candidates) room.candidates[start[bin(c)]++] = c;
  candidates.swap(room.candidates);
  std::uint32_t from = 0;  // each start has moved on to the end of its bin
  for (std::size_t b = 0; b < count; from = start[b++]) {
    if (start[b] - from < 2) continue;
    std::sort(candidates.begin() + from, candidates.begin() + start[b],
              [](const Candidate& p, const Candidate& q) {
                if (p.from != q.from) return p.from < q.from;
                if (p.patch != q.patch) return p.patch < q.patch;
                return p.to < q.to;
              });
  }
}

}  // namespace tiltfeed
