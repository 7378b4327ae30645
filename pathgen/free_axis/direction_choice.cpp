#include "pathgen/free_axis/direction_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kinematics/basics/units.h"

namespace tiltfeed::pathgen {

namespace {

/// With more candidates than this off the grid, or fewer in all, the search by height is the faster one.
constexpr std::size_t kMostOthers = 16, kFewCandidates = 24;

std::uint32_t least_of(const std::vector<double>& costs) {
  return static_cast<std::uint32_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
}

}  // namespace

/// From the candidates of one station to those of the next.
struct CheapestSequence::Turns {
  const AxisCandidates& last;
  const std::vector<double>& before;
  double least_cosine, chord, per_square, jump;
  std::uint32_t cheapest;

  struct Best {
    double cost;
    std::uint32_t from;
  };
  /// A turn costs in proportion to the square of its chord: those over a longer one than this are no cheaper.
  bool too_far(double square, const Best& best) const {
    return square > chord * chord || per_square * square >= best.cost - before[cheapest];
  }
  void look(std::uint32_t j, Vec3 axis, Best& best) const {
    if (before[j] >= best.cost) return;
    const double cosine = dot(last[j].axis, axis);
    if (cosine < least_cosine) return;
    const double cost = before[j] + per_square * std::max(0.0, 2.0 - 2.0 * cosine);
    if (cost < best.cost) best = {cost, j};
  }
};

CheapestSequence::CheapestSequence(std::vector<const AxisCandidates*> stations, std::vector<double> ways,
                                   const TurnPrices& prices, const DirectionNeighbours* near)
    : stations_(std::move(stations)),
      ways_(std::move(ways)),
      prices_(prices),
      near_(near),
      cost_(stations_.size()),
      from_(stations_.size()) {}

void CheapestSequence::reach(std::size_t i) {
  const std::vector<double>& before = cost_[i - 1];
  const double widest = std::min(prices_.max_turn * ways_[i - 1] + prices_.spare, kPi);
  const Turns turns{*stations_[i - 1],           before,       std::cos(widest), 2.0 * std::sin(widest / 2.0),
                    prices_.turn / ways_[i - 1], prices_.jump, least_of(before)};
  cost_[i].resize(stations_[i]->size()), from_[i].resize(stations_[i]->size());
  if (!reach_by_neighbours(i, turns)) reach_by_height(i, turns);
}

/// The directions of the grid by its neighbours; the few others each with each.
bool CheapestSequence::reach_by_neighbours(std::size_t i, const Turns& turns) {
  const AxisCandidates &last = turns.last, &here = *stations_[i];
  if (near_ == nullptr || last.size() < kFewCandidates || turns.chord > near_->chord()) return false;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  cost_at_.assign(near_->count(), kNone), place_.resize(near_->count());
  others_.clear();
  for (std::uint32_t j = 0; j < last.size(); ++j) {
    if (const std::uint32_t direction = last[j].direction; direction < near_->count())
      cost_at_[direction] = turns.before[j], place_[direction] = j;
    else
      others_.push_back(j);
  }
  if (others_.size() > kMostOthers) return false;
  const double square = turns.chord * turns.chord, least = turns.before[turns.cheapest];
  for (std::size_t k = 0; k < here.size(); ++k) {
    Turns::Best best{least + turns.jump, turns.cheapest};
    if (here[k].direction < near_->count()) {
      for (const DirectionNeighbours::Neighbour& near : near_->of(here[k].direction)) {
        const double turn = turns.per_square * near.square;
        if (near.square > square || turn >= best.cost - least) break;
        const double cost = cost_at_[near.direction] + turn;
        if (cost < best.cost) best = {cost, place_[near.direction]};
      }
      for (const std::uint32_t j : others_) turns.look(j, here[k].axis, best);
    } else {
      for (std::uint32_t j = 0; j < last.size(); ++j) turns.look(j, here[k].axis, best);
    }
    cost_[i][k] = best.cost + here[k].cost, from_[i][k] = best.from;
  }
  return true;
}

/// Two directions differ by no more in z than by their chord.
void CheapestSequence::reach_by_height(std::size_t i, const Turns& turns) {
  const AxisCandidates &last = turns.last, &here = *stations_[i];
  const auto count = static_cast<std::uint32_t>(last.size());
  std::uint32_t same = 0;
  for (std::size_t k = 0; k < here.size(); ++k) {
    const Vec3 axis = here[k].axis;
    Turns::Best best{turns.before[turns.cheapest] + turns.jump, turns.cheapest};
    const auto too_far = [&](std::uint32_t j) {
      const double rise = last[j].axis.z - axis.z;
      return turns.too_far(rise * rise, best);
    };
    while (same < count && last[same].axis.z < axis.z) ++same;
    for (std::uint32_t j = same; j < count && last[j].axis.z == axis.z; ++j)
      if (last[j].axis == axis) turns.look(j, axis, best);
    for (std::uint32_t j = same; j < count && !too_far(j); ++j) turns.look(j, axis, best);
    for (std::uint32_t j = same; j-- > 0 && !too_far(j);) turns.look(j, axis, best);
    cost_[i][k] = best.cost + here[k].cost, from_[i][k] = best.from;
  }
}

std::vector<std::uint32_t> CheapestSequence::find(std::size_t changed) {
  if (stations_.empty()) return {};
  if (changed == 0) {
    cost_[0].clear();
    for (const AxisCandidate& c : *stations_[0]) cost_[0].push_back(c.cost);
  }
  for (std::size_t i = std::max<std::size_t>(changed, 1); i < stations_.size(); ++i) reach(i);
  std::vector<std::uint32_t> chosen(stations_.size());
  chosen.back() = least_of(cost_.back());
  for (std::size_t i = stations_.size(); i-- > 1;) chosen[i - 1] = from_[i][chosen[i]];
  return chosen;
}

}  // namespace tiltfeed::pathgen
