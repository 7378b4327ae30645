#pragma once
// The tool path that a program really makes, as a viewer draws it.

#include <iosfwd>

#include "kinematics/cl_text/apt_file.h"

namespace tiltfeed::daemon {

/// Numbers of a point, float32 in this order: tip x, y, z (part, mm), axis i, j, k, kind, line. The axis is
/// unit, from the tip to the shank. The kind is 0 for a rapid, 2 for a cut. The program's line leads to the
/// point, exact up to 16 million.
inline constexpr std::size_t kTextNumbers = 8;

/// One record of kTextNumbers for each point of all operations, little-endian. Requires: of unpost(), which
/// knows the lines.
void write_text_drawing(const AptProgram& program, std::ostream& out);

}  // namespace tiltfeed::daemon
