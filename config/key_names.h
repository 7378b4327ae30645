#pragma once
// The names of settings: the unit is the key's ending, and a wrong name has a nearest right one.

#include <string>
#include <vector>

namespace tiltfeed::config {

/// The unit that a key's ending states ("mm/min" for cut_mm_per_min), or "".
std::string unit_of(const std::string& key);
/// The key without that ending.
std::string stem_of(const std::string& key);

/// The known key that `key` most likely means: the same words with another unit or none (side_step_in and
/// side_step mean side_step_mm), else the least edit distance, the first of equals.
/// Requires: known is not empty.
const std::string& nearest_key(const std::string& key, const std::vector<std::string>& known);

}  // namespace tiltfeed::config
