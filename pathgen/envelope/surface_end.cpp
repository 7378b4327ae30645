#include "pathgen/envelope/surface_end.h"

namespace tiltfeed::pathgen {

namespace {

/// The end is as far as foreseen but for this times the square of that over the ball's radius.
constexpr double kBend = 2.0;
/// Of so many looks one is half way.
constexpr int kHalving = 4;

/// How far the run goes on from a hit to where the surface ends, if it does where the ball's side touches an
/// edge or a vertex: to first order in the square of the cosine of the contact, which falls to 0 there. Else
/// 0 or anything.
double run_to_end(const ClSurface& surface, const EnvelopePoint& hit, Vec3 step) {
  const ToolPiece& piece = surface.piece(hit.patch);
  if (!piece.is_ball() || surface.is_face(hit.patch)) return 0.0;
  const ClSurface::Core core = surface.core(hit.patch);
  double level = 1.0;  // of the edge: squared sine against the axis
  if (core.count == 2) {
    const Vec3 edge = core.corner[1] - core.corner[0];
    const double climb = dot(edge, hit.axis);
    level -= climb * climb / squared_length(edge);
  }
  const double along = dot(hit.normal, hit.axis);
  return piece.corner * along * along / (2.0 * level * dot(hit.normal, step));
}

}  // namespace

double next_look(const ClSurface& surface, const Deformation& map, const FlatLine& line, const Sample& left,
                 const Sample& right, int looks) {
  const double middle = (left.run + right.run) / 2.0, gap = right.run - left.run;
  if (looks % kHalving == kHalving - 1) return middle;
  const Sample& hit = left.hit ? left : right;
  const double direction = left.hit ? 1.0 : -1.0;
  const Deformation::Steps steps = map.steps(hit.point.flat);
  const Vec3 step = (steps.x * line.dx + steps.y * line.dy) * direction;
  const double to_end = run_to_end(surface, hit.point, step);
  const double unsure = kBend * to_end * to_end / surface.piece(hit.point.patch).corner + kEndStep / 4.0;
  if (!(to_end > unsure && to_end < gap + unsure)) return middle;
  return hit.run + direction * (gap > to_end + 2.0 * unsure ? to_end + unsure : to_end - unsure);
}

}  // namespace tiltfeed::pathgen
