#pragma once
// One function for each picture: it has the product compute what it shows, and writes the SVG to `file`.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::pictures {

Result<void> draw_cl_surface(const std::string& file);
Result<void> draw_deformation(const std::string& file);
Result<void> draw_envelope(const std::string& file);
Result<void> draw_directions(const std::string& file);
Result<void> draw_pole_bend(const std::string& file);
Result<void> draw_window(const std::string& file);

}  // namespace tiltfeed::pictures
