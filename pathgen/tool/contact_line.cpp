#include "pathgen/tool/contact_line.h"

namespace tiltfeed::pathgen {

namespace {

/// The axis at the reference depends on the reference: so often it is asked again.
constexpr int kAxisSteps = 4;

}  // namespace

Point<Part> contact_reference(const ToolPiece& piece, Vec3 axis, Point<Part> place, Vec3 n) {
  const double along = dot(n, axis);
  const Vec3 lateral = n - axis * along;
  const double across = length(lateral);
  const Vec3 out = across > 0.0 ? lateral / across : Vec3{};
  Point<Part> ring = place + n * piece.corner + out * piece.flat;
  if (piece.has_cone() && along < piece.taper_sin)
    ring = place - axis * piece.cone_height(piece.outer) + out * piece.outer;
  return ring - axis * piece.above_reference;
}

AxisLine contact_line(const ToolPiece& piece, const Deformation& deformation, Point<Part> place, Vec3 n) {
  AxisLine line{place, deformation.axis_at(place)};
  for (int k = 0; k < kAxisSteps; ++k) {
    const Point<Part> last = line.base;
    const Point<Part> reference = contact_reference(piece, line.axis, place, n);
    line = {reference, deformation.axis_at(reference)};
    if (line.base == last) break;  // a ball's centre does not ask for the axis
  }
  return line;
}

}  // namespace tiltfeed::pathgen
