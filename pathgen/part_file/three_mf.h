#pragma once
// 3MF core [3MF Core Specification 1.3]: an archive with a model of objects, components and build items.

#include <span>
#include <string>

#include "kinematics/basics/result.h"
#include "pathgen/part_file/part_model.h"

namespace tiltfeed::pathgen {

/// What is built: each mesh of it a body where its item and components put it, in mm. A body has its object's
/// name, a face the facets of one colour. Supports are left out, with a note. Errors: kInput, with line and
/// object: as ZipArchive and walk_xml(); a unit, number or transform that is none, an object that is named
/// and not there before, a triangle's corner that is not there, nothing built, an extension that is required
/// and not read, a component of another file; kMesh beyond kMaxCoordinate; kLimit over kMaxFacets or 100,000
/// components.
Result<PartModel> parse_three_mf(std::span<const char> bytes, const std::string& file);
/// The same of a file; kIo when it cannot be read, kLimit over kMaxStlBytes.
Result<PartModel> read_three_mf(const std::string& path);

}  // namespace tiltfeed::pathgen
