#include "pathgen/fit/fitted_shape.h"

#include <array>
#include <cmath>

namespace tiltfeed::pathgen {

const char* word_of(FitKind kind) {
  constexpr std::array<const char*, 5> kWords{"plane", "circle", "sphere", "cylinder", "torus"};
  return kWords[static_cast<std::size_t>(kind)];
}

double distance_to(const Fit& shape, Point<Part> place) {
  const Vec3 from = place - shape.centre;
  const double along = dot(from, shape.axis);
  const double off_axis = length(from - shape.axis * along);
  switch (shape.kind) {
    case FitKind::kPlane:
      return along;
    case FitKind::kCircle:
      return std::hypot(off_axis - shape.radius, along);
    case FitKind::kSphere:
      return length(from) - shape.radius;
    case FitKind::kCylinder:
      return off_axis - shape.radius;
    case FitKind::kTorus:
      break;
  }
  return std::hypot(off_axis - shape.radius, along) - shape.tube;
}

}  // namespace tiltfeed::pathgen
