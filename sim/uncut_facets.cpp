#include "sim/uncut_facets.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tiltfeed::sim {
namespace {

/// A facet counts from this share of it on.
constexpr double kMarked = 0.5;

}  // namespace

Result<std::vector<std::uint32_t>> read_uncut_facets(std::istream& in, const std::string& path) {
  const auto report = nlohmann::json::parse(in, nullptr, false);
  if (!report.is_object() || !report.contains("slice_points"))
    return fail(Code::kInput, path + ": not a report of tiltfeed plan (--report)");
  std::vector<std::uint32_t> facets;
  for (const auto& [section, list] : {std::pair{"uncut", "facets"}, std::pair{"free", "unreached_facets"}}) {
    const auto found = report.find(section);
    if (found == report.end() || !found->is_object() || !found->contains(list)) continue;
    for (const auto& entry : (*found)[list]) {
      if (!entry.is_object() || !entry.contains("facet") || !entry["facet"].is_number_unsigned())
        return fail(Code::kInput, path + ": " + section + "." + list + ": an entry without a facet number");
      if (entry.value("share", 1.0) >= kMarked) facets.push_back(entry["facet"].get<std::uint32_t>());
    }
  }
  std::sort(facets.begin(), facets.end());
  facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
  return facets;
}

}  // namespace tiltfeed::sim
