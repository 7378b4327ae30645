// Bytes of a 3MF file, and of the model within one: every facet that comes out is finite and on a face of a
// body.

#include <algorithm>
#include <cmath>

#include "pathgen/part_file/three_mf.h"
#include "tests/fuzz/fuzz.h"
#include "tests/texts/zip_text.h"

namespace {

void holds(const tiltfeed::Result<tiltfeed::pathgen::PartModel>& read) {
  if (!read) return HOLDS(!read.error().message.empty());
  HOLDS(!read->mesh.facets.empty() && read->face_of.size() == read->mesh.facets.size());
  for (const auto& facet : read->mesh.facets)
    for (const auto& corner : facet)
      HOLDS(std::isfinite(corner.x) && std::isfinite(corner.y) && std::isfinite(corner.z));
  for (const auto face : read->face_of) HOLDS(face < read->faces.size());
  for (const auto& face : read->faces) HOLDS(face.body < read->bodies.size());
}

}  // namespace

FUZZ_TARGET(threemf) {
  using namespace tiltfeed;
  if (bytes.starts_with("<"))
    holds(pathgen::parse_three_mf(three_mf_of(std::string(bytes)), "fuzz.3mf"));
  else
    holds(pathgen::parse_three_mf(std::span(bytes.data(), bytes.size()), "fuzz.3mf"));
}
