// Bytes of an STL, OBJ or PLY file: every facet that comes out is finite, and there are no more of them than
// the bytes can hold.

#include <cmath>
#include <span>

#include "pathgen/mesh/stl.h"
#include "tests/fuzz/fuzz.h"

FUZZ_TARGET(stl) {
  const auto stl = tiltfeed::pathgen::parse_stl(std::span(bytes.data(), bytes.size()), "fuzz.stl", 1.0);
  if (!stl) return HOLDS(!stl.error().message.empty());
  // A corner more of a face is a facet more: one byte of a binary PLY.
  const std::size_t least = stl->binary ? 50 : bytes.starts_with("solid") ? 25 : 1;
  HOLDS(!stl->facets.empty() && stl->facets.size() <= bytes.size() / least + 1);
  for (const auto& facet : stl->facets)
    for (const auto& corner : facet)
      HOLDS(std::isfinite(corner.x) && std::isfinite(corner.y) && std::isfinite(corner.z));
}
