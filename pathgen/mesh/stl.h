#pragma once
// STL files, binary and ASCII, and meshes as OBJ and PLY, told apart by content, not by name or header.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "kinematics/basics/decimal.h"
#include "kinematics/basics/geometry.h"
#include "kinematics/basics/result.h"
#include "pathgen/mesh/stl_facets.h"

namespace tiltfeed::pathgen {

/// `unit_mm`: length of the file's unit in mm. `name` goes into messages. Facets count from 0, lines from 1.
/// Errors, with place and remedy: kInput: empty, truncated, count that does not fit the size, no facets,
/// decimal commas, malformed numbers or text, not an STL, unit not positive; kMesh: NaN/Inf coordinates
/// (count and first facet) or coordinates beyond kMaxCoordinate; kLimit: over kMaxStlBytes or kMaxFacets.
Result<Stl> parse_stl(std::span<const char> bytes, const std::string& name, double unit_mm);
/// The same from a regular file; kIo when it cannot be read.
Result<Stl> read_stl(const std::string& path, double unit_mm);

/// A binary STL, coordinates rounded to float32; `path` names it in messages. Errors: kInput as below.
Result<std::string> stl_bytes(const std::string& path, const std::vector<std::array<Point<Part>, 3>>& facets);

/// Writes it beside `path` and renames it into place; on any
/// error nothing is left behind and a file that was there stays as it was.
/// Errors: kInput: no facets, over kMaxFacets, or a coordinate that is no float32; kIo.
Result<void> write_stl(const std::string& path, const std::vector<std::array<Point<Part>, 3>>& facets);

}  // namespace tiltfeed::pathgen
