#pragma once
// PLY [Turk 1994], as text and binary in either byte order; used by stl.cpp only.

#include <span>
#include <string>

#include "kinematics/basics/result.h"
#include "pathgen/mesh/polygons.h"

namespace tiltfeed::pathgen {

/// True when the bytes begin with the line "ply".
bool looks_like_ply(std::span<const char> bytes);

/// Corners (x, y, z of the element vertex) and faces (its list vertex_indices or vertex_index); other
/// elements and properties are skipped. Errors: kInput, with the line of the header or the element's number:
/// a malformed header, a file that is cut short, malformed numbers, triangle strips.
Result<Polygons> parse_ply(std::span<const char> bytes, const std::string& name);

}  // namespace tiltfeed::pathgen
