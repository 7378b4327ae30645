#pragma once
// The map of what is left on the part, as a picture.

#include <array>
#include <string>
#include <vector>

#include "sim/raster.h"
#include "sim/removal_report.h"

namespace tiltfeed::sim {

/// A place of the colour scale: what is left, mm, and its colour (linear).
struct ColourStop {
  double left = 0.0;
  Colour colour;
};

/// From a gouge over nothing left to all that is told apart. Surface that the tool never reached is grey.
std::vector<ColourStop> colour_scale(const Removal& removal, const RemovalVerdict& verdict);
/// "#rrggbb" of a linear colour.
std::string html_colour(Colour colour);
inline constexpr Colour kUnreachedColour{0.33, 0.35, 0.38};

/// Draws the part in the scale's colours with the worst places ringed. Errors: kIo.
Result<void> draw_deviation(const Mesh& part, const ToolPath& path, const Probes& probes,
                            const Removal& removal, const std::vector<ColourStop>& scale,
                            const std::string& png_path);

}  // namespace tiltfeed::sim
