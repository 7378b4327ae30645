#pragma once
// The lines of an IGES file before OpenCASCADE sees them: five sections of 80 columns, whose counts the last
// line states.

#include <string>
#include <string_view>

#include "kinematics/basics/result.h"

namespace tiltfeed::cad {

/// Errors, kInput, with the line: shorter than 80 columns, sections out of order or miscounted, a number out
/// of its sequence, no last section (cut short), a directory entry without parameters or with an odd line
/// count.
Result<void> check_iges_text(std::string_view text, const std::string& file);

}  // namespace tiltfeed::cad
