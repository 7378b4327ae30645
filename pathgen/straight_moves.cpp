#include "pathgen/straight_moves.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {

namespace {

/// An arc leaves its chord by a quarter of what its end leaves the tangent, to first order; a little more for
/// the rest.
constexpr double kArcShare = 0.26;
/// The parts of an arc are not quite alike: so much more error is reckoned with.
constexpr double kSparePart = 1.05;
/// Where two planes meet nearer to an end than this share of the move, half way tells more.
constexpr double kNotAtEnd = 0.02;

}  // namespace

StraightMoves::StraightMoves(const ClSurface& surface, const EnvelopeOptions& options)
    : surface_(surface), options_(options) {
  const ToolPiece& cutter = surface.pieces().front();
  curved_step_ = std::sqrt(8.0 * (cutter.corner > 0.0 ? cutter.corner : cutter.flat) * options.tolerance);
}

StraightMoves::Verdict StraightMoves::judge(const Sample& left, const Sample& right,
                                            std::span<const Candidate> active) const {
  const EnvelopePoint &a = left.point, &b = right.point;
  const Vec3 chord = b.centre - a.centre;
  Verdict verdict;
  verdict.length2 = squared_length(chord);
  verdict.joined = turns_little(a, b, verdict.length2) &&
                   (verdict.length2 <= curved_step_ * curved_step_ ||
                    !another_curved_sheet(left, right, std::sqrt(verdict.length2), active));
  if (!verdict.joined) return verdict;
  const double from_a = std::abs(dot(a.normal, chord)) * static_cast<double>(a.lever),
               from_b = std::abs(dot(b.normal, chord)) * static_cast<double>(b.lever);
  const double share = a.patch == b.patch && surface_.piece(a.patch).is_ball() ? kArcShare : 1.0;
  verdict.larger = std::max(from_a, from_b) * share, verdict.smaller = std::min(from_a, from_b) * share;
  verdict.corner_at_end = verdict.smaller <= options_.tolerance;
  return verdict;
}

bool StraightMoves::turns_little(const EnvelopePoint& a, const EnvelopePoint& b, double length2) const {
  const double turn2 = squared_length(cross(a.axis, b.axis));
  return turn2 <= options_.max_axis_step * options_.max_axis_step &&
         turns_evenly(a, b, turn2, options_.tolerance, options_) &&
         length2 <= options_.max_distance * options_.max_distance;
}

/// May a curved sheet that neither end lies on rise over the straight move?
bool StraightMoves::another_curved_sheet(const Sample& left, const Sample& right, double chord,
                                         std::span<const Candidate> active) const {
  // A straight move dips under the lower of its ends by what the axis turns.
  const double low = std::min(left.point.flat.z, right.point.flat.z) - chord * options_.max_axis_step;
  return std::any_of(active.begin(), active.end(), [&](const Candidate& c) {
    return static_cast<double>(c.top) > low && c.from <= left.run && c.to >= right.run &&
           c.patch != left.point.patch && c.patch != right.point.patch && !surface_.is_face(c.patch) &&
           !keeps_off(c.patch, left.point.centre, right.point.centre);
  });
}

/// (E3) Does a ball that moves straight from a to b keep off the patch's edge or vertex, but for the
/// tolerance?
bool StraightMoves::keeps_off(PatchId patch, Point<Part> a, Point<Part> b) const {
  const ToolPiece& piece = surface_.piece(patch);
  if (!piece.is_ball_at_reference()) return false;
  const ClSurface::Core core = surface_.core(patch);
  if (core.count == 2) {  // as seen along it
    const Vec3 edge = core.corner[1] - core.corner[0];
    const double share = 1.0 / squared_length(edge);
    a = a - edge * (dot(a - core.corner[0], edge) * share);
    b = b - edge * (dot(b - core.corner[0], edge) * share);
  }
  return distance_to_segment(core.corner[0], a, b) >= piece.corner - options_.tolerance;
}

bool StraightMoves::on_move(const Sample& sample, const Sample& left, const Sample& right) const {
  return sample.hit && distance_to_segment(sample.point.centre, left.point.centre, right.point.centre) *
                               static_cast<double>(sample.point.lever) <=
                           options_.tolerance;
}

bool StraightMoves::one_corner(const Sample& left, const Sample& middle, const Sample& right,
                               double length2) const {
  const bool planes = surface_.is_face(left.point.patch) && surface_.is_face(right.point.patch);
  return (planes || length2 <= curved_step_ * curved_step_) &&
         (middle.point.patch == left.point.patch || middle.point.patch == right.point.patch);
}

bool StraightMoves::crosses_one_edge(const Sample& left, const Sample& right) const {
  const PatchId a = left.point.patch, b = right.point.patch;
  const ToolPiece& piece = surface_.piece(a);
  if (!surface_.is_face(a) || !surface_.is_face(b) || &surface_.piece(b) != &piece) return false;
  if (!piece.is_ball_at_reference()) return false;
  const ClSurface::Core one = surface_.core(a), other = surface_.core(b);
  int shared = 0;
  for (const Point<Part>& v : one.points())
    for (const Point<Part>& w : other.points()) shared += v == w ? 1 : 0;
  return shared >= 2;
}

double StraightMoves::next_share(const Sample& left, const Sample& right, const Verdict& move) const {
  constexpr double kHalf = 0.5;
  const EnvelopePoint &a = left.point, &b = right.point;
  if (!move.joined || move.corner_at_end) return kHalf;
  if (a.patch == b.patch) {
    const double parts = std::ceil(std::sqrt(kSparePart * move.larger / options_.tolerance));
    return 1.0 / std::max(parts, 2.0);
  }
  if (!surface_.is_face(a.patch) || !surface_.is_face(b.patch)) return kHalf;
  // How steeply, along the chord, each plane leaves its end.
  const Vec3 chord = b.centre - a.centre;
  const double rise = -dot(a.normal, chord) / dot(a.normal, a.axis),
               fall = dot(b.normal, chord) / dot(b.normal, a.axis);
  const double share = fall / (rise + fall);
  return share > kNotAtEnd && share < 1.0 - kNotAtEnd ? share : kHalf;
}

bool StraightMoves::stands_level_on_two(const Sample& left, const Sample& right) const {
  const auto level = [](const EnvelopePoint& p) { return p.normal == p.axis; };
  return left.point.patch != right.point.patch && level(left.point) && level(right.point);
}

}  // namespace tiltfeed
