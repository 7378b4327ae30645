#include "pathgen/linking/nearest_ends.h"

#include <algorithm>
#include <numeric>

namespace tiltfeed::pathgen {

namespace {

double coordinate(Point<Part> p, std::uint8_t dimension) {
  return dimension == 0 ? p.x : dimension == 1 ? p.y : p.z;
}

}  // namespace

NearestEnds::NearestEnds(std::vector<Point<Part>> points)
    : points_(std::move(points)),
      order_(points_.size()),
      place_(points_.size()),
      left_(points_.size()),
      dimension_(points_.size()),
      gone_(points_.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  build(0, order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) place_[order_[i]] = static_cast<std::uint32_t>(i);
}

void NearestEnds::build(std::size_t from, std::size_t to) {
  if (from >= to) return;
  const auto at = [&](std::size_t i) { return points_[order_[i]]; };
  double widest = -1.0;
  std::uint8_t dimension = 0;
  for (std::uint8_t d = 0; d < 3; ++d) {
    double low = coordinate(at(from), d), high = low;
    for (std::size_t i = from; i < to; ++i)
      low = std::min(low, coordinate(at(i), d)), high = std::max(high, coordinate(at(i), d));
    if (high - low > widest) widest = high - low, dimension = d;
  }
  const std::size_t middle = (from + to) / 2;
  const auto iterator = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(iterator(from), iterator(middle), iterator(to), [&](std::uint32_t a, std::uint32_t b) {
    const double in_a = coordinate(points_[a], dimension), in_b = coordinate(points_[b], dimension);
    return in_a < in_b || (in_a == in_b && a < b);
  });
  dimension_[middle] = dimension;
  left_[middle] = static_cast<std::uint32_t>(to - from);
  build(from, middle);
  build(middle + 1, to);
}

void NearestEnds::remove(std::uint32_t index) {
  const std::size_t place = place_[index];
  gone_[place] = 1;
  for (std::size_t from = 0, to = order_.size();;) {
    const std::size_t middle = (from + to) / 2;
    --left_[middle];
    if (middle == place) return;
    (place < middle ? to : from) = place < middle ? middle : middle + 1;
  }
}

void NearestEnds::search(std::size_t from, std::size_t to, Point<Part> place, Best& best) const {
  if (from >= to) return;
  const std::size_t middle = (from + to) / 2;
  if (left_[middle] == 0) return;
  const std::uint32_t index = order_[middle];
  if (gone_[middle] == 0) {
    const double squared = squared_length(points_[index] - place);
    const bool wins =
        !best.index || squared < best.squared || (squared == best.squared && index < *best.index);
    if (wins) best = {squared, index};
  }
  const double beyond =
      coordinate(place, dimension_[middle]) - coordinate(points_[index], dimension_[middle]);
  const auto lower = [&] { search(from, middle, place, best); };
  const auto upper = [&] { search(middle + 1, to, place, best); };
  if (beyond < 0.0) {
    lower();
    if (!best.index || beyond * beyond <= best.squared) upper();
  } else {
    upper();
    if (!best.index || beyond * beyond <= best.squared) lower();
  }
}

std::optional<std::uint32_t> NearestEnds::nearest(Point<Part> from) const {
  Best best;
  search(0, order_.size(), from, best);
  return best.index;
}

}  // namespace tiltfeed::pathgen
