#pragma once
// The map of what is left on the part, as a picture.

#include <array>
#include <string>
#include <vector>

#include "sim/picture/camera.h"
#include "sim/picture/rasteriser.h"
#include "sim/report/verdict.h"

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

/// The part as the picture shows it, but for the colours: they are only known when all is cut.
class DeviationPicture {
 public:
  /// Draws the patches where the camera sees them. `path` is only what the camera must have in view.
  DeviationPicture(const pathgen::Mesh& part, const ToolPath& path, const Patches& patches);

  /// Puts on the scale's colours, and rings round the worst places: the bytes of a PNG file. Errors: kIo.
  Result<std::string> png(const Removal& removal, const std::vector<ColourStop>& scale, int threads);

 private:
  Camera camera_;
  Rasteriser raster_;
};

}  // namespace tiltfeed::sim
