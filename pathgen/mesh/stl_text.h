#pragma once
// The ASCII form of STL; used by stl.cpp only.

#include <string>
#include <string_view>

#include "kinematics/basics/result.h"
#include "pathgen/mesh/stl_facets.h"

namespace tiltfeed::pathgen {

/// True when the bytes begin like ASCII STL: "solid" in any case, after white space, and no NUL where a
/// binary file has its header and count.
bool looks_like_text_stl(std::string_view bytes);

/// Facets in the file's own unit, unchecked: NaN and infinity come through.
/// Grammar: white space separates words, case does not matter; the rest of the line after solid and
/// endsolid is a name; words that are no keyword are skipped after normal, loop, endloop and endfacet.
/// Errors: kInput with the line; kLimit over kMaxFacets.
Result<Stl> parse_text_stl(std::string_view bytes, const std::string& name);

}  // namespace tiltfeed::pathgen
