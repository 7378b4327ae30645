#include "pathgen/pattern/pass_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pathgen/options/side_step.h"

namespace tiltfeed::pathgen {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Places of the grid in one direction, at most.
constexpr double kMostPlaces = 512.0;
/// Of the cutter's radius: so much lower than the passes ways between them may be.
constexpr double kSlack = 0.25;

}  // namespace

/// No square lies between two passes. Leads and joins reach a little beyond them.
PassDepth::PassDepth(const Passes& passes, const ClField& field, const PlanOptions& options)
    : bounds_(field.bounds),
      slack_(kSlack * options.cutter.radius()),
      period_x_(field.deformation.period_x()),
      period_y_(field.deformation.period_y()),
      of_all_(kInfinity) {
  const double spacing = 2.0 * std::max(asked_step(options), options.pattern.step_down) +
                         options.links.lead_radius + options.links.join_distance;
  const double width = std::max(bounds_.max_x - bounds_.min_x, 1e-9);
  const double height = std::max(bounds_.max_y - bounds_.min_y, 1e-9);
  size_ = std::max(spacing, std::max(width, height) / kMostPlaces);
  columns_ = static_cast<std::int64_t>(std::ceil(width / size_));
  rows_ = static_cast<std::int64_t>(std::ceil(height / size_));
  lowest_.assign(static_cast<std::size_t>(columns_ * rows_), kInfinity);
  // Contours run elsewhere, and on other levels, once shank and holder are heeded.
  if (passes.as_given) lowest_.assign(lowest_.size(), -kInfinity);
  for (const auto& row : passes.rows)
    for (const Pass& pass : row)
      for (std::size_t i = 0; i + 1 < pass.size(); ++i) add(pass[i].flat, pass[i + 1].flat);
  sum_up();
}

double PassDepth::in(double low_x, double high_x, double low_y, double high_y) const {
  // What lies past a seam may be anywhere.
  if ((period_x_ > 0.0 && (low_x < bounds_.min_x || high_x > bounds_.max_x)) ||
      (period_y_ > 0.0 && (low_y < bounds_.min_y || high_y > bounds_.max_y)))
    return -kInfinity;
  double lowest = kInfinity;
  const std::int64_t x0 = column(low_x), x1 = column(high_x), y0 = row(low_y), y1 = row(high_y);
  for (std::int64_t j = y0; j <= y1;) {
    const bool high = j % kBlock == 0 && j + kBlock - 1 <= y1;
    for (std::int64_t i = x0; i <= x1;) {
      const bool whole = high && i % kBlock == 0 && i + kBlock - 1 <= x1;
      if (whole) {
        lowest = std::min(lowest, of_block_[static_cast<std::size_t>(j / kBlock * blocks_ + i / kBlock)]);
      } else {
        for (std::int64_t k = j; k < (high ? j + kBlock : j + 1); ++k)
          lowest = std::min(lowest, lowest_[static_cast<std::size_t>(k * columns_ + i)]);
      }
      i += whole ? kBlock : 1;
    }
    j += high ? kBlock : 1;
  }
  return lowest;
}

bool PassDepth::knows(Point<Flat> place) const {
  const std::int64_t i = column(short_way(0.5 * (bounds_.min_x + bounds_.max_x), place.x, period_x_)),
                     j = row(short_way(0.5 * (bounds_.min_y + bounds_.max_y), place.y, period_y_));
  return place.z >= lowest_[static_cast<std::size_t>(j * columns_ + i)];
}

void PassDepth::sum_up() {
  blocks_ = columns_ / kBlock + 1;
  of_block_.assign(static_cast<std::size_t>(blocks_ * (rows_ / kBlock + 1)), kInfinity);
  for (std::int64_t j = 0; j < rows_; ++j)
    for (std::int64_t i = 0; i < columns_; ++i) {
      double& block = of_block_[static_cast<std::size_t>(j / kBlock * blocks_ + i / kBlock)];
      block = std::min(block, lowest_[static_cast<std::size_t>(j * columns_ + i)]);
    }
  of_all_ = *std::min_element(of_block_.begin(), of_block_.end());
}

std::int64_t PassDepth::column(double x) const {
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor((x - bounds_.min_x) / size_)), 0,
                                  columns_ - 1);
}

std::int64_t PassDepth::row(double y) const {
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor((y - bounds_.min_y) / size_)), 0,
                                  rows_ - 1);
}

/// A straight move, with the squares beside it, since its flat image is bent.
void PassDepth::add(Point<Flat> a, Point<Flat> b) {
  const double z = std::min(a.z, b.z) - slack_;
  for (std::int64_t j = row(std::min(a.y, b.y) - size_); j <= row(std::max(a.y, b.y) + size_); ++j)
    for (std::int64_t i = column(std::min(a.x, b.x) - size_); i <= column(std::max(a.x, b.x) + size_); ++i) {
      double& lowest = lowest_[static_cast<std::size_t>(j * columns_ + i)];
      lowest = std::min(lowest, z);
    }
}

}  // namespace tiltfeed::pathgen
