#pragma once
// STEP files (AP203, AP214, AP242), by OpenCASCADE.

#include <string>

#include "cad/shape/loaded_part.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::cad {

/// Lengths become mm, whatever the file's unit. Errors: kIo; kInput, with "#12 ADVANCED_FACE": as
/// check_step_text(); an entity that OpenCASCADE cannot read; a face without a shape; no bodies; a
/// product whose shape is in another file. No other file is opened.
Result<LoadedPart> load_step(const std::string& path);

}  // namespace tiltfeed::cad
