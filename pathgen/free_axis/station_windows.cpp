// Where Stations looks for directions but the wished one: how far from it they have to be sought. (O3)

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "pathgen/free_axis/stations.h"

namespace tiltfeed::pathgen {

namespace {

/// Directions are looked at up to what has to be departed from the wish and this more, rad: nearly three
/// steps of the coarser grid.
constexpr double kSpare = 0.4;
/// And so far (times the length over which a turn costs as much as a departure) past where it has to be.
constexpr double kSpareWay = 2.0;
/// Where the sequence breaks, or comes near to the border of what was looked at, departures of up to this,
/// rad.
constexpr double kWidest = 1.6;
/// A direction chosen so near to the border of what was looked at (rad, a step of the grid) might be better
/// beyond it: looked at is so much more, rad.
constexpr double kNearBorder = 0.14, kMore = 0.3;

constexpr double kNothing = -std::numeric_limits<double>::infinity();

}  // namespace

/// The wish alone, but where it is not admitted or turns too fast, and round about.
void Stations::find_windows() {
  std::vector<Vec3> nearest;  // admissible directions; zero: none
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    open(i, 0.0);
    nearest.push_back(stations_[i].wish_admitted ? stations_[i].wished : nearest_clear(stations_[i]));
  }
  open_about(needed(nearest));
  for (std::size_t i = 0; i < stations_.size(); ++i)
    if (squared_length(nearest[i]) == 0.0) widen(i);
}

/// The departures from the wish (rad) without which the axis cannot follow the nearest directions: where
/// these turn by more than the axis may, half of what is too much lies before the bend and half behind it.
std::vector<double> Stations::needed(const std::vector<Vec3>& nearest) const {
  const std::size_t count = stations_.size();
  const auto none = [&](std::size_t i) { return squared_length(nearest[i]) == 0.0; };
  std::vector<double> over(count, kNothing), needs(count, kNothing), before(count, 0.0);
  for (std::size_t i = 1; i < count; ++i)
    if (!none(i - 1) && !none(i))
      over[i] =
          angle_between(nearest[i], nearest[i - 1]) - max_turn_ * (stations_[i].way - stations_[i - 1].way);
  // By how much any way that ends here is too much at most, and one that begins here.
  for (std::size_t i = 1; i < count; ++i) before[i] = std::max(0.0, before[i - 1] + over[i]);
  double after = 0.0;
  for (std::size_t i = count; i-- > 0;) {
    const double off = none(i) ? 0.0 : angle_between(nearest[i], stations_[i].wished);
    if (off > 0.0 || before[i] + after > 0.0) needs[i] = off + (before[i] + after) / 2.0;
    after = std::max(0.0, after + over[i]);
  }
  return needs;
}

/// The admissible direction of the coarser grid that is nearest to the wish; zero: there is none.
Vec3 Stations::nearest_clear(Station& s) {
  const std::vector<Vec3>& grid = admissible_.grid().directions();
  std::vector<std::pair<double, std::uint32_t>> order;
  for (std::uint32_t k = 0; k < DirectionGrid::count(Admissibility::kAdmissibleLevel); ++k)
    if (admissible_.within_limits(s.point.normal, grid[k])) order.emplace_back(-dot(grid[k], s.wished), k);
  if (s.asked.empty()) s.asked.assign(grid.size(), kUnknown);
  std::make_heap(order.begin(), order.end(), std::greater<>());
  for (auto end = order.end(); end != order.begin(); --end) {
    std::pop_heap(order.begin(), end, std::greater<>());
    const std::uint32_t k = (end - 1)->second;
    if (s.asked[k] == kUnknown) s.asked[k] = admissible_.admits(s.point, k, query_) ? kClear : kStopped;
    if (s.asked[k] == kClear) return grid[k];
  }
  return {};
}

/// Windows about the stations that need them (rad, or kNothing): to both sides the axis turns back to the
/// wish as fast as it may.
void Stations::open_about(std::vector<double> needs) {
  const auto carry = [&](std::size_t from, std::size_t to) {
    const double way = std::abs(stations_[to].way - stations_[from].way);
    needs[to] = std::max(needs[to], needs[from] - max_turn_ * way);
  };
  for (std::size_t i = 1; i < needs.size(); ++i) carry(i - 1, i);
  for (std::size_t i = needs.size(); i-- > 1;) carry(i, i - 1);
  for (std::size_t i = 0; i < needs.size(); ++i)
    if (needs[i] >= -max_turn_ * kSpareWay * scale_) open(i, kSpare + std::max(0.0, needs[i]));
}

/// Looks further where a chosen direction is near the border of what was looked at, or the sequence breaks;
/// false: nowhere.
bool Stations::look_further() {
  std::vector<double> needs(stations_.size(), kNothing);
  bool any = false;
  const auto need = [&](std::size_t i, double departure) {
    if (departure + kSpare > stations_[i].window) needs[i] = std::max(needs[i], departure), any = true;
  };
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    const Station& s = stations_[i];
    if (s.candidates.empty()) continue;
    if (s.window > 0.0 && angle_between(s.chosen, s.wished) > s.window - kNearBorder)
      need(i, std::min(s.window - kSpare + kMore, kWidest));
    if (i == 0 || stations_[i - 1].candidates.empty()) continue;
    const double way = s.way - stations_[i - 1].way;
    if (angle_between(s.chosen, stations_[i - 1].chosen) > max_turn_ * way + kRounding)
      need(i - 1, kWidest), need(i, kWidest);
  }
  if (any) open_about(std::move(needs));
  return any;
}

}  // namespace tiltfeed::pathgen
