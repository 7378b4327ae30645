#include "pathgen/surface/row_candidates.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace tiltfeed::pathgen {

namespace {

/// Blocks of hulls are worked on side by side: so many at most, of so many hulls at least.
constexpr std::size_t kMostBlocks = 64, kLeastCells = 2048;
/// More than rounding (mm): what is taken here is looked at again, exactly.
constexpr double kWider = 1e-9;

struct Band {
  double low, high;
};

/// The lines by their distance to the left of the origin: the first one at or beyond a distance, found by
/// slots about as wide as two lines are apart.
class Sorted {
 public:
  explicit Sorted(std::span<const FlatLine> lines) {
    across_.reserve(lines.size());
    for (const FlatLine& line : lines) across_.push_back(line.across());
    const double width = across_.back() - across_.front();
    per_mm_ = width > kWider ? static_cast<double>(lines.size()) / width : 0.0;
    slot_.resize(lines.size() + 1);
    std::uint32_t at = 0;
    for (std::size_t s = 0; s < slot_.size(); ++s) {
      while (at < across_.size() && slot_of(across_[at]) < s) ++at;
      slot_[s] = at;
    }
  }
  /// Is a line at a distance in the range?
  bool any_in(Band range) const {
    std::uint32_t i = slot_[slot_of(range.low)];
    while (i < across_.size() && across_[i] < range.low) ++i;
    return i < across_.size() && across_[i] <= range.high;
  }
  /// Calls visit(line) for each line at a distance in the range.
  template <class Visit>
  void each_in(Band range, Visit visit) const {
    for (std::uint32_t i = slot_[slot_of(range.low)]; i < across_.size() && across_[i] <= range.high; ++i)
      if (across_[i] >= range.low) visit(i);
  }

 private:
  std::size_t slot_of(double across) const {
    const double slot = (across - across_.front()) * per_mm_;
    return static_cast<std::size_t>(std::clamp(slot, 0.0, static_cast<double>(slot_.size() - 1)));
  }
  std::vector<double> across_;
  std::vector<std::uint32_t> slot_;  ///< the first line in it or beyond
  double per_mm_ = 0.0;
};

/// How far to the left of the origin a moved box reaches, as lines in the direction of `line` see it.
Band across(const FlatBox& box, double shift_x, double shift_y, const FlatLine& line) {
  const double y0 = (box.low_y + shift_y) * line.dx, y1 = (box.high_y + shift_y) * line.dx,
               x0 = (box.low_x + shift_x) * line.dy, x1 = (box.high_x + shift_x) * line.dy;
  return {std::min(y0, y1) - std::max(x0, x1) - kWider, std::max(y0, y1) - std::min(x0, x1) + kWider};
}

/// The rectangle round all lines.
FlatBox box_round_all(std::span<const FlatLine> lines) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  FlatBox box{kFar, -kFar, kFar, -kFar};
  for (const FlatLine& line : lines) {
    const FlatBox one = box_round(line);
    box = {std::min(box.low_x, one.low_x), std::max(box.high_x, one.high_x), std::min(box.low_y, one.low_y),
           std::max(box.high_y, one.high_y)};
  }
  return box;
}

struct Meeting {
  std::uint32_t line;
  Candidate candidate;
};

/// By line, each line's in the order they came in; `first` of each line.
void spread(const std::vector<Meeting>& meetings, std::vector<std::uint32_t>& first,
            std::vector<Candidate>& met) {
  for (const Meeting& m : meetings) ++first[m.line + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  met.resize(meetings.size());
  for (const Meeting& m : meetings) met[first[m.line]++] = m.candidate;
  std::copy_backward(first.begin(), first.end() - 1, first.end());
  first.front() = 0;
}

}  // namespace

RowCandidates::RowCandidates(const FlatIndex& index, std::span<const FlatLine> lines) {
  if (lines.empty()) return;
  blocks_.resize(std::clamp<std::size_t>(index.hulls() / kLeastCells, 1, kMostBlocks));
  const Sorted sorted(lines);
  const FlatBox round = box_round_all(lines);
  tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t b) {
    std::vector<Meeting> meetings;
    meetings.reserve(index.hulls() / blocks_.size());
    const auto end = static_cast<std::uint32_t>(index.hulls() * (b + 1) / blocks_.size());
    for (auto c = static_cast<std::uint32_t>(index.hulls() * b / blocks_.size()); c < end; ++c)
      index.each_turn(index.box(c), round, [&](double shift_x, double shift_y) {
        if (!sorted.any_in(across(index.box(c), shift_x, shift_y, lines[0]))) return;
        const auto hull = index.seen_along(c, lines[0].dx, lines[0].dy, shift_x, shift_y);
        sorted.each_in({hull.least_across() - kWider, hull.most_across() + kWider}, [&](std::uint32_t i) {
          Candidate candidate;
          if (hull.meets(lines[i], candidate)) meetings.push_back({i, candidate});
        });
      });
    blocks_[b].first.resize(lines.size() + 1);
    spread(meetings, blocks_[b].first, blocks_[b].met);
  });
}

void RowCandidates::of(std::size_t i, std::vector<Candidate>& met) const {
  met.clear();
  for (const Block& block : blocks_)
    met.insert(met.end(), block.met.begin() + block.first[i], block.met.begin() + block.first[i + 1]);
}

}  // namespace tiltfeed::pathgen
