#pragma once
// Few sets that together hold most of a weight: greedy, then improved by dropping and exchanging sets.

#include <cstdint>
#include <vector>

namespace tiltfeed {

struct SetCover {
  std::vector<std::uint32_t> chosen;  ///< indices of the sets, the heaviest contribution first
  double weight = 0.0;                ///< of what they hold
};

/// `sets[s][e]` is 1 where set s holds element e, else 0; all have as many elements as `weights`.
/// Chooses at most `most` sets that hold `share` of what all together hold, as few as it finds; where `most` do
/// not suffice, those that hold as much as it finds. Of sets that do equally well the first is taken.
/// Properties: 1 no chosen set can be left out; 2 no two chosen sets can be replaced by one; 3 no chosen set can
/// be replaced by one with which all hold more, where `most` do not suffice. Not always the fewest: that is
/// NP-hard; the greedy start alone is within ln(weight) of it [Chvatal 1979].
SetCover cover_by_few(const std::vector<std::vector<std::uint8_t>>& sets, const std::vector<double>& weights,
                      double share, std::uint32_t most);

}  // namespace tiltfeed
