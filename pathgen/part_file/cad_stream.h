#pragma once
// How tiltfeed-cad hands a part over: a stream of bytes that ends with its own check sum. Not a file format:
// both programs are of one build.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/part_file/part_model.h"

namespace tiltfeed::pathgen {

/// The facets of one face. Normals are the surface's own at the corners, unit, out of the material.
struct FaceFacets {
  std::vector<Point<Part>> corners;
  std::vector<Vec3> normals;
  std::vector<std::array<std::uint32_t, 3>> facets;  ///< counter-clockwise from outside
};

/// `model` without facets, and for each of its faces its facets.
/// Requires: facets.size() == model.faces.size().
std::string cad_stream(const PartModel& model, const std::vector<FaceFacets>& facets);

/// Properties: 1 what cad_stream() wrote, with faces in order and facets by face. 2 Every truncation and
/// every changed byte is an error. Errors: kInput: cut short, check sum, an index out of range; kMesh: a
/// corner that is not finite or beyond kMaxCoordinate, with its face; kLimit over kMaxFacets. Warns of faces
/// whose facets are turned against their normals.
Result<PartModel> read_cad_stream(std::span<const char> bytes, const std::string& name);

}  // namespace tiltfeed::pathgen
