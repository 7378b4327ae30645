#include "pathgen/direction_choice.h"

#include <algorithm>
#include <cmath>

#include "kinematics/units.h"

namespace tiltfeed {

std::vector<std::uint32_t> cheapest_sequence(const std::vector<const AxisCandidates*>& stations,
                                             const std::vector<double>& ways, const TurnPrices& prices) {
  std::vector<std::vector<std::uint32_t>> from(stations.size());
  std::vector<double> before, now;
  if (stations.empty()) return {};
  for (const AxisCandidate& c : *stations.front()) before.push_back(c.cost);
  for (std::size_t i = 1; i < stations.size(); ++i) {
    const AxisCandidates &last = *stations[i - 1], &here = *stations[i];
    const double widest = std::min(prices.max_turn * ways[i - 1] + prices.spare, kPi);
    // Directions no further apart than `widest` differ by no more than its chord in z.
    const double least_cosine = std::cos(widest), chord = 2.0 * std::sin(widest / 2.0);
    const double per_square = prices.turn / ways[i - 1];
    const auto cheapest =
        static_cast<std::uint32_t>(std::min_element(before.begin(), before.end()) - before.begin());
    now.assign(here.size(), 0.0);
    from[i].assign(here.size(), cheapest);
    std::uint32_t first = 0;
    for (std::size_t k = 0; k < here.size(); ++k) {
      const Vec3 axis = here[k].axis;
      double best = before[cheapest] + prices.jump;
      while (first < last.size() && last[first].axis.z < axis.z - chord) ++first;
      for (std::uint32_t j = first; j < last.size() && last[j].axis.z <= axis.z + chord; ++j) {
        if (before[j] >= best) continue;
        const double cosine = dot(last[j].axis, axis);
        if (cosine < least_cosine) continue;
        const double cost = before[j] + per_square * (2.0 - 2.0 * cosine);
        if (cost < best) best = cost, from[i][k] = j;
      }
      now[k] = best + here[k].cost;
    }
    std::swap(before, now);
  }
  std::vector<std::uint32_t> chosen(stations.size());
  chosen.back() = static_cast<std::uint32_t>(std::min_element(before.begin(), before.end()) - before.begin());
  for (std::size_t i = stations.size(); i-- > 1;) chosen[i - 1] = from[i][chosen[i]];
  return chosen;
}

}  // namespace tiltfeed
