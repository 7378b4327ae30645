#include "pathgen/options/fixtures.h"

namespace tiltfeed::pathgen {

Mesh joined(const Mesh& part, const Mesh& fixtures) {
  Mesh all = part;
  const auto before = static_cast<std::uint32_t>(part.vertices.size());
  all.vertices.insert(all.vertices.end(), fixtures.vertices.begin(), fixtures.vertices.end());
  for (const auto& [a, b, c] : fixtures.facets) all.facets.push_back({a + before, b + before, c + before});
  all.source.insert(all.source.end(), fixtures.source.begin(), fixtures.source.end());
  return all;
}

}  // namespace tiltfeed::pathgen
