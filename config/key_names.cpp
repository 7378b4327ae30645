#include "config/key_names.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <numeric>
#include <string_view>
#include <utility>

namespace tiltfeed::config {
namespace {

using Ending = std::pair<std::string_view, std::string_view>;

/// Endings of keys and the units that they state, longer ones before those that they end in.
constexpr std::array<Ending, 14> kEndings{{
    {"_mm_per_min", "mm/min"},
    {"_mm_per_s2", "mm/s^2"},
    {"_mm_per_s3", "mm/s^3"},
    {"_deg_per_min", "degrees/min"},
    {"_deg_per_s2", "degrees/s^2"},
    {"_deg_per_s3", "degrees/s^3"},
    {"_m_per_min", "m/min"},
    {"_per_min", "1/min"},
    {"_blocks", "blocks"},
    {"_bytes", "bytes"},
    {"_deg", "degrees"},
    {"_rpm", "1/min"},
    {"_mm", "mm"},
    {"_ms", "ms"},
}};

Ending ending_of(const std::string& key) {
  const auto unit = std::find_if(kEndings.begin(), kEndings.end(),
                                 [&](const Ending& candidate) { return key.ends_with(candidate.first); });
  return unit != kEndings.end() ? *unit : Ending{};
}

/// Insertions, deletions and replacements from one to the other [Levenshtein]; at or over the limit: any
/// number that is at or over it.
std::size_t edit_distance(const std::string& from, const std::string& to, std::size_t limit) {
  const std::size_t lengths = from.size() > to.size() ? from.size() - to.size() : to.size() - from.size();
  if (lengths >= limit) return lengths;
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= from.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    std::size_t least = i;
    for (std::size_t j = 1; j <= to.size(); ++j) {
      const std::size_t replaced = diagonal + (from[i - 1] == to[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
      least = std::min(least, row[j]);
    }
    if (least >= limit) return least;
  }
  return row.back();
}

}  // namespace

std::string unit_of(const std::string& key) { return std::string(ending_of(key).second); }

std::string stem_of(const std::string& key) {
  return key.substr(0, key.size() - ending_of(key).first.size());
}

const std::string& nearest_key(const std::string& key, const std::vector<std::string>& known) {
  assert(!known.empty());
  const auto same_words = std::find_if(known.begin(), known.end(), [&](const std::string& candidate) {
    const std::string stem = stem_of(candidate);
    return stem != candidate && (key == stem || key.starts_with(stem + "_"));
  });
  if (same_words != known.end()) return *same_words;
  const std::string* nearest = &known.front();
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(key, candidate, least);
    if (distance < least) least = distance, nearest = &candidate;
  }
  return *nearest;
}

}  // namespace tiltfeed::config
