#include "sim/removal/stock_film.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::sim {
namespace {

constexpr double kHeights = 65534.0;

std::array<double, 3> of(Point<Part> p) { return {p.x, p.y, p.z}; }

/// The two coordinates that are not the axis.
std::array<std::size_t, 2> others(int axis) {
  return {axis == 0 ? std::size_t{1} : std::size_t{0}, axis == 2 ? std::size_t{1} : std::size_t{2}};
}

}  // namespace

double StockFilm::cell_for(const pathgen::Box& box, int axis, double cell) {
  const std::array<double, 3> low = of(box.min), high = of(box.max);
  const auto [u, v] = others(axis);
  return std::max(cell, std::max(high[u] - low[u], high[v] - low[v]) / kMostLines);
}

StockFilm::StockFilm(Dexels lines, double cell, double begin, double end)
    : lines_(std::move(lines)), cell_(cell), begin_(begin), end_(end) {
  std::array<double, 2> low{kInfinity, kInfinity}, high{-kInfinity, -kInfinity};
  span_ = {kInfinity, -kInfinity};
  const std::array<std::size_t, 2> across = others(axis());
  for (int stripe = 0; stripe < Dexels::kStripes; ++stripe)
    lines_.each(stripe, [&](Point<Part> origin, double from, double to) {
      const std::array<double, 3> at = of(origin);
      low = {std::min(low[0], at[across[0]]), std::min(low[1], at[across[1]])};
      high = {std::max(high[0], at[across[0]]), std::max(high[1], at[across[1]])};
      span_ = {std::min(span_[0], from), std::max(span_[1], to)};
    });
  if (low[0] <= high[0]) {
    first_ = low;
    for (std::size_t k = 0; k < 2; ++k)
      size_[k] = static_cast<std::uint32_t>(std::lround((high[k] - low[k]) / cell_)) + 1;
  }
  snap();
}

std::uint16_t StockFilm::height(double mm) const {
  const double share = (mm - span_[0]) / std::max(span_[1] - span_[0], Dexels::kUnit);
  return static_cast<std::uint16_t>(1 + std::lround(std::clamp(share, 0.0, 1.0) * kHeights));
}

void StockFilm::snap() {
  const std::size_t count = std::size_t{size_[0]} * size_[1];
  std::vector<std::uint16_t> frame(2 * count, kNothing);
  const std::array<std::size_t, 2> across = others(axis());
  for (int stripe = 0; stripe < Dexels::kStripes; ++stripe)
    lines_.each(stripe, [&](Point<Part> origin, double from, double to) {
      const std::array<double, 3> at = of(origin);
      const auto column = static_cast<std::size_t>(std::lround((at[across[0]] - first_[0]) / cell_)),
                 row = static_cast<std::size_t>(std::lround((at[across[1]] - first_[1]) / cell_));
      std::uint16_t &top = frame[row * size_[0] + column], &bottom = frame[count + row * size_[0] + column];
      top = std::max(top, height(to));
      bottom = bottom == kNothing ? height(from) : std::min(bottom, height(from));
    });
  frames_.push_back(std::move(frame));
}

/// When the next frame shows the stock.
double StockFilm::due() const {
  return begin_ + (end_ - begin_) * static_cast<double>(frames_.size()) / static_cast<double>(kFrames - 1);
}

void StockFilm::take(const SweptBody& body, double time) {
  while (frames_.size() + 1 < kFrames && time >= due()) snap();
  const auto [first, end] = lines_.stripes(body);
  for (int stripe = first; stripe < end; ++stripe) lines_.cut(stripe, body, false);
}

void StockFilm::finish() {
  while (frames_.size() < kFrames) snap();
}

}  // namespace tiltfeed::sim
