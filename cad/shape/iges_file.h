#pragma once
// IGES files, by OpenCASCADE: their faces, which stand loose as a rule, are sewn.

#include <string>

#include "cad/shape/loaded_part.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::cad {

/// Faces whose edges are at most this far apart are sewn, mm.
inline constexpr double kSewn = 0.01;

/// Lengths become mm. Loose faces are sewn; what closes is a solid, turned outward, and open edges are warned
/// of. Errors: kIo; kInput, with "D12 (type 144)": as check_iges_text(); an entity that OpenCASCADE cannot
/// read; a trimmed surface without a shape; no surfaces.
Result<LoadedPart> load_iges(const std::string& path);

}  // namespace tiltfeed::cad
