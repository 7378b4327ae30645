#include "pathgen/surface/flat_bins.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>

namespace tiltfeed::pathgen {

namespace {

/// The finest bins, against the side of a square of the area that a box has on average.
constexpr double kFinest = 0.5;
constexpr double kMostBins = 16e6;
/// A box is of a size whose measure is at least this much of its longer side.
constexpr double kBinShare = 0.7;
/// The bins of a size, against its measure: a box lies in two or three bins.
constexpr double kBinsPerMeasure = 2.0;
/// Each grid's bins are twice those of the one before.
constexpr int kMostGrids = 24;

template <class Work>
void each(std::size_t count, const Work& work) {
  constexpr std::size_t kBoxesPerTask = 8192;  // some hundred microseconds of work
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kBoxesPerTask), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) work(i);
  });
}

}  // namespace

LooseBox loosened(const FlatBox& box) {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  const auto down = [](double v) {
    const auto f = static_cast<float>(v);
    return f > v ? std::nextafter(f, -kFar) : f;
  };
  const auto up = [](double v) {
    const auto f = static_cast<float>(v);
    return f < v ? std::nextafter(f, kFar) : f;
  };
  return {down(box.low_x), up(box.high_x), down(box.low_y), up(box.high_y)};
}

std::int64_t FlatBins::Axis::from_outside(std::int64_t b) const {
  if (!wraps) return std::clamp<std::int64_t>(b, 0, count - 1);
  const std::int64_t rest = b % count;
  return rest < 0 ? rest + count : rest;
}

void FlatBins::Axis::span(double from, double to, std::int64_t& first, std::int64_t& last) const {
  first = bin(from), last = bin(to);
  if (wraps) {
    last = std::min(last, first + count - 1);
  } else {
    first = wrapped(first), last = wrapped(last);
  }
}

FlatBins::FlatBins(std::span<const LooseBox> boxes, const FlatBounds& bounds, double period_x,
                   double period_y)
    : grid_of_(boxes.size()) {
  lay_grids(boxes, bounds, period_x, period_y);
  fill(boxes);
}

/// Grids that hold no box are left out.
void FlatBins::lay_grids(std::span<const LooseBox> boxes, const FlatBounds& bounds, double period_x,
                         double period_y) {
  const double width = std::max(bounds.max_x - bounds.min_x, 1e-9);
  const double height = std::max(bounds.max_y - bounds.min_y, 1e-9);
  double finest = kFinest * std::sqrt(width * height / static_cast<double>(boxes.size()));
  while (std::ceil(width / finest) * std::ceil(height / finest) >
         std::min(kMostBins, 8.0 * static_cast<double>(boxes.size()) + 64.0))
    finest *= 1.25;
  const auto grid_of = [&](const LooseBox& box) {
    const double side = std::max(std::min<double>(box.high_x - box.low_x, width),
                                 std::min<double>(box.high_y - box.low_y, height));
    std::uint8_t doublings = 0;
    for (double size = finest; size < kBinShare * side && doublings < kMostGrids - 1; size *= 2.0)
      ++doublings;
    return doublings;
  };
  std::array<std::uint8_t, kMostGrids> used{};
  each(boxes.size(), [&](std::size_t i) {
    grid_of_[i] = grid_of(boxes[i]);
    const std::atomic_ref<std::uint8_t> mark(used[grid_of_[i]]);
    if (mark.load(std::memory_order_relaxed) == 0) mark.store(1, std::memory_order_relaxed);
  });
  const auto axis = [](double low, double extent, double size, double period) {
    Axis a;
    a.low = low, a.wraps = period > 0.0;
    a.count = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(extent / size)));
    a.size = extent / static_cast<double>(a.count), a.per_size = 1.0 / a.size;
    return a;
  };
  std::array<std::uint8_t, kMostGrids> place{};
  std::size_t bins = 0;
  for (int k = 0; k < kMostGrids; ++k) {
    if (used[static_cast<std::size_t>(k)] == 0) continue;
    place[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(grids_.size());
    const double measure = std::ldexp(finest, k), size = kBinsPerMeasure * measure;
    if (grids_.empty())
      spacing_ = std::min(axis(0.0, width, measure, 0.0).size, axis(0.0, height, measure, 0.0).size);
    grids_.push_back(
        {axis(bounds.min_x, width, size, period_x), axis(bounds.min_y, height, size, period_y), bins});
    bins += static_cast<std::size_t>(grids_.back().x.count * grids_.back().y.count);
  }
  each(boxes.size(), [&](std::size_t i) { grid_of_[i] = place[grid_of_[i]]; });
  start_.assign(bins + 1, 0);
}

/// A counting sort; each bin lists its boxes in rising order.
void FlatBins::fill(std::span<const LooseBox> boxes) {
  const auto each_bin_of = [&](std::size_t box, const auto& visit) {
    each_bin(grids_[grid_of_[box]], boxes[box], visit);
  };
  const auto count_on = [&](std::size_t bin) {
    return std::atomic_ref<std::uint32_t>(start_[bin]).fetch_add(1, std::memory_order_relaxed);
  };
  each(boxes.size(), [&](std::size_t i) { each_bin_of(i, count_on); });
  std::exclusive_scan(start_.begin(), start_.end(), start_.begin(), 0U);
  entries_.resize(start_.back());
  each(boxes.size(), [&](std::size_t i) {
    each_bin_of(i, [&](std::size_t bin) { entries_[count_on(bin)] = static_cast<std::uint32_t>(i); });
  });
  // Each start has been counted on to the next one.
  std::move_backward(start_.begin(), start_.end() - 1, start_.end());
  start_.front() = 0;
  each(start_.size() - 1, [&](std::size_t bin) {
    std::sort(entries_.begin() + start_[bin], entries_.begin() + start_[bin + 1]);
  });
}

bool run_in_box(const FlatBox& box, const FlatLine& line, double& from, double& to) {
  from = 0.0, to = line.length;
  const auto cut = [&](double at, double d, double low, double high) {
    if (d == 0.0) {
      if (at < low || at > high) to = -1.0;
      return;
    }
    from = std::max(from, std::min((low - at) / d, (high - at) / d));
    to = std::min(to, std::max((low - at) / d, (high - at) / d));
  };
  cut(line.x, line.dx, box.low_x, box.high_x);
  cut(line.y, line.dy, box.low_y, box.high_y);
  return from <= to;
}

/// A slanted line goes piece by piece, so that it does not sweep the whole rectangle.
std::int64_t FlatBins::pieces_of(const Grid& grid, const FlatLine& line) {
  if (line.dx == 0.0 || line.dy == 0.0) return 1;
  return std::max<std::int64_t>(
      1, static_cast<std::int64_t>(std::ceil(line.length / std::min(grid.x.size, grid.y.size))));
}

FlatBox FlatBins::piece_box(const FlatLine& line, std::int64_t k, std::int64_t pieces) {
  const double n = static_cast<double>(pieces);
  const double a = line.length * static_cast<double>(k) / n, b = line.length * static_cast<double>(k + 1) / n;
  const double xa = line.x_at(a), xb = line.x_at(b), ya = line.y_at(a), yb = line.y_at(b);
  return {std::min(xa, xb), std::max(xa, xb), std::min(ya, yb), std::max(ya, yb)};
}

}  // namespace tiltfeed::pathgen
