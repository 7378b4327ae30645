#include "pathgen/options/cutter.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

double Cutter::cutting_top_radius() const {
  if (type != CutterType::kTaperBall) return radius();
  // The cone touches the ball where the normal leans `taper` above the horizontal.
  const double sine = std::sin(taper.radians()), cosine = std::cos(taper.radians());
  const double touch_height = radius() * (1.0 - sine);
  return radius() * cosine + std::max(0.0, cutting_end() - touch_height) * sine / cosine;
}

}  // namespace tiltfeed::pathgen
