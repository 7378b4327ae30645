#pragma once
// Wavefront OBJ: corners and faces as text; used by stl.cpp only.

#include <string>
#include <string_view>

#include "kinematics/basics/result.h"
#include "pathgen/mesh/polygons.h"

namespace tiltfeed::pathgen {

/// True when the first word that is no remark begins a statement of OBJ.
bool looks_like_obj(std::string_view bytes);

/// Corners and faces; groups, names, normals, textures and materials are skipped. Coordinates are doubles.
/// Errors: kInput with the line: malformed numbers, free-form curves and surfaces, which no face stands for.
Result<Polygons> parse_obj(std::string_view bytes, const std::string& name);

}  // namespace tiltfeed::pathgen
