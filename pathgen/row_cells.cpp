#include "pathgen/row_cells.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tiltfeed {

namespace {

/// Blocks of cells worked on side by side; what they find is joined in their order.
constexpr std::size_t kBlocks = 64;
/// More than rounding (mm): what is taken here is looked at again, exactly.
constexpr double kSpare = 1e-9;

struct Range {
  double low, high;
};

/// The lines by their distance to the left of the origin: the first one at or beyond a distance, found by
/// slots about as wide as two lines are apart.
class Sorted {
 public:
  explicit Sorted(std::span<const FlatLine> lines) {
    across_.reserve(lines.size());
    for (const FlatLine& line : lines) across_.push_back(line.y * line.dx - line.x * line.dy);
    const double width = across_.back() - across_.front();
    per_mm_ = width > kSpare ? static_cast<double>(lines.size()) / width : 0.0;
    slot_.resize(lines.size() + 1);
    std::uint32_t at = 0;
    for (std::size_t s = 0; s < slot_.size(); ++s) {
      while (at < across_.size() && slot_of(across_[at]) < s) ++at;
      slot_[s] = at;
    }
  }
  /// Calls visit(line) for each line at a distance in the range.
  template <class Visit>
  void each_in(Range range, Visit visit) const {
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
  std::uint32_t line, cell;
};
/// What one block of cells meets, and on each line how much.
struct Block {
  std::vector<Meeting> meetings;
  std::vector<std::uint32_t> count;
};

}  // namespace

RowCells::RowCells(const FlatIndex& index, std::span<const FlatLine> lines) : first_(lines.size() + 1) {
  if (lines.empty()) return;
  const Sorted sorted(lines);
  const FlatBox round = box_round_all(lines);
  const double dx = lines[0].dx, dy = lines[0].dy, ax = std::abs(dx), ay = std::abs(dy);
  std::vector<Block> blocks(kBlocks);
  tbb::parallel_for(std::size_t{0}, kBlocks, [&](std::size_t b) {
    Block& block = blocks[b];
    block.count.resize(lines.size());
    block.meetings.reserve(index.cells() / kBlocks);
    const auto end = static_cast<std::uint32_t>(index.cells() * (b + 1) / kBlocks);
    for (auto c = static_cast<std::uint32_t>(index.cells() * b / kBlocks); c < end; ++c) {
      const std::size_t before = block.meetings.size();
      const FlatBox box = index.box(c);
      index.each_turn(box, round, [&](double shift_x, double shift_y) {
        const double x = (box.low_x + box.high_x) / 2.0 + shift_x,
                     y = (box.low_y + box.high_y) / 2.0 + shift_y;
        const double wide = (box.high_x - box.low_x) / 2.0, high = (box.high_y - box.low_y) / 2.0;
        const double across = y * dx - x * dy, half = ax * high + ay * wide + kSpare;
        const double reach = ax * wide + ay * high + kSpare;
        sorted.each_in({across - half, across + half}, [&](std::uint32_t i) {
          const double run = lines[i].run_of(x, y);
          if (run < -reach || run > lines[i].length + reach) return;
          for (std::size_t k = before; k < block.meetings.size(); ++k)  // on another turn
            if (block.meetings[k].line == i) return;
          block.meetings.push_back({i, c}), ++block.count[i];
        });
      });
    }
  });
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    first_[i] = sum;
    for (Block& block : blocks) sum += std::exchange(block.count[i], sum);
  }
  first_.back() = sum;
  cells_.resize(sum);
  tbb::parallel_for(std::size_t{0}, kBlocks, [&](std::size_t b) {
    for (const Meeting& m : blocks[b].meetings) cells_[blocks[b].count[m.line]++] = m.cell;
    blocks[b] = {};
  });
}

}  // namespace tiltfeed
