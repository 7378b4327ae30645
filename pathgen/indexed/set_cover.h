#pragma once
// Few sets that together hold most elements: greedy, then improved by dropping and exchanging sets.

#include <cstdint>
#include <vector>

namespace tiltfeed::pathgen {

struct SetCover {
  std::vector<std::uint32_t> chosen;  ///< indices of the sets, the largest contribution first
  std::uint32_t held = 0;             ///< elements that they hold
};

/// `sets[s][e]` is 1 where set s holds element e, else 0; all have as many elements.
/// Chooses at most `most` sets that hold `share` of what all together hold, as few as it finds; where `most`
/// do not suffice, those that hold as much as it finds. Of sets that do equally well the first is taken.
/// Properties: 1 no chosen set can be left out; 2 no two chosen sets can be replaced by one, nor (up to eight
/// chosen) three by two; 3 where `most` do not suffice, no chosen set can be replaced by one with which all
/// hold more; 4 each chosen set holds at least `least_gain` of what all sets together hold, and that alone,
/// which may leave less than `share` held, and 3 only as it was before such sets went. Not always the fewest:
/// that is NP-hard; the greedy start alone is within ln(elements) of it [Chvatal 1979].
SetCover cover_by_few(const std::vector<std::vector<std::uint8_t>>& sets, double share, std::uint32_t most,
                      double least_gain = 0.0);

}  // namespace tiltfeed::pathgen
