#pragma once
// Tilted planes in program text: G68.2, CYCLE800, PLANE SPATIAL, as daemon/post/dialect.cpp has them.

#include <optional>
#include <string>

#include "daemon/post/dialect_words.h"
#include "kinematics/basics/geometry.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// A tilted plane in the part's frame with the table at home.
struct TextPlane {
  std::optional<Rotation> frame;  ///< directions of the plane to the part's; none: it follows the table
  Vec3 origin;                    ///< mm
};

/// Each: the plane, or why it is not understood. `swivel_data`: the name that CYCLE800 has to call; empty:
/// any.
Result<TextPlane> plane_of_words(const DialectWords& words);
Result<TextPlane> plane_of_line(const std::string& line, const std::string& swivel_data);

}  // namespace tiltfeed::daemon
