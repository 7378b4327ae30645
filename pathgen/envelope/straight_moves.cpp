#include "pathgen/envelope/straight_moves.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// An arc leaves its chord by a quarter of what its end leaves the tangent, to first order; a little more for
/// the rest.
constexpr double kArcShare = 0.26;
/// The parts of an arc are not quite alike: so much more error is reckoned with.
constexpr double kSparePart = 1.05;
/// Where two planes meet nearer to an end than this share of the move, half way tells more.
constexpr double kNotAtEnd = 0.02;

/// Breaks closer than this share of the curved step are taken as one: what rises or sinks between two samples
/// so near does so by its square of the tolerance at most. The other: where flat space is the most stretched.
constexpr double kBreakShare = 1.0 / 4.0, kFarBreakShare = 1.0 / 2.0;

/// A straight wall on a flat bottom, with nothing between.
bool is_sharp(const ToolPiece& piece) { return piece.corner == 0.0 && !piece.has_cone(); }

}  // namespace

StraightMoves::StraightMoves(const ClSurface& surface, const EnvelopeOptions& options, double stretch)
    : surface_(surface), options_(options) {
  const ToolPiece& cutter = surface.pieces().front();
  curved_step_ = std::sqrt(8.0 * (cutter.corner > 0.0 ? cutter.corner : cutter.flat) * options.tolerance);
  close_ = curved_step_ * std::min(kBreakShare, kFarBreakShare / stretch);
  sharp_ = std::any_of(surface.pieces().begin(), surface.pieces().end(), is_sharp);
}

StraightMoves::Verdict StraightMoves::judge(const Sample& left, const Sample& right,
                                            std::span<const Candidate> active) const {
  const EnvelopePoint &a = left.point, &b = right.point;
  const Vec3 chord = b.centre - a.centre;
  Verdict verdict;
  const double length2 = squared_length(chord);
  verdict.joined = turns_little(a, b, length2) && !another_curved_sheet(left, right, active);
  if (!verdict.joined) return verdict;
  const double from_a = std::abs(dot(a.normal, chord)) * static_cast<double>(a.lever),
               from_b = std::abs(dot(b.normal, chord)) * static_cast<double>(b.lever);
  const double share = a.patch == b.patch && surface_.piece(a.patch).is_ball() ? kArcShare : 1.0;
  verdict.larger = std::max(from_a, from_b) * share, verdict.smaller = std::min(from_a, from_b) * share;
  verdict.corner_at_end = verdict.smaller <= options_.tolerance;
  const bool same = a.patch == b.patch, is_long = length2 > curved_step_ * curved_step_;
  verdict.over_one_edge = !same && verdict.corner_at_end &&
                          (is_long || verdict.larger > options_.tolerance) && crosses_one_edge(a, b);
  verdict.unbroken = same || !is_long || verdict.over_one_edge;
  return verdict;
}

bool StraightMoves::turns_little(const EnvelopePoint& a, const EnvelopePoint& b, double length2) const {
  const double turn2 = squared_length(cross(a.axis, b.axis));
  return pathgen::turns_little(a, b, turn2, options_) &&
         length2 <= options_.max_distance * options_.max_distance;
}

/// (E3) May a curved sheet that neither end lies on rise over the straight move?
bool StraightMoves::another_curved_sheet(const Sample& left, const Sample& right,
                                         std::span<const Candidate> active) const {
  if (active.empty()) return false;
  const EnvelopePoint &a = left.point, &b = right.point;
  const double chord = distance(a.centre, b.centre), turn = length(cross(a.axis, b.axis));
  // A straight move dips under the lower of its ends by what the axis turns.
  const double low = std::min(a.flat.z, b.flat.z) - chord * options_.max_axis_step;
  // What stands further up is passed on a longer way: the tool's side turns with the axis.
  const auto short_at = [&](float top) {
    const double up = turn > 0.0 ? turn * std::max(0.0, static_cast<double>(top) - low) : 0.0;
    return chord + up <= curved_step_;
  };
  if (!sharp_ && short_at(active.front().top)) return false;
  const double enough = std::min(close_, right.run - left.run);  // of a sheet, on the line
  const auto may_rise = [&](const Candidate& c) {
    const double over = std::min(c.to, right.run) - std::max(c.from, left.run);
    if (over < 0.0 || surface_.is_face(c.patch)) return false;
    if (sharp_ && is_sharp(surface_.piece(c.patch)) && !core_keeps_off(c.patch, a, b)) return true;
    if (c.patch == a.patch || c.patch == b.patch) return false;
    return over >= enough && !short_at(c.top) && !keeps_off(c.patch, a, b);
  };
  const auto is_below = [&](const Candidate& c) { return static_cast<double>(c.top) <= low; };
  // On moves side by side it is mostly the same one.
  if (rose_ < active.size() && !is_below(active[rose_]) && may_rise(active[rose_])) return true;
  for (std::size_t i = 0; i < active.size() && !is_below(active[i]); ++i)  // from the highest down
    if (may_rise(active[i])) return rose_ = i, true;
  return false;
}

namespace {

/// Does a place that goes straight from p to q stay out of the wall of that radius about the axis through the
/// origin, or below that height where it is within?
bool passes_by(double radius, double height, Vec3 axis, Vec3 p, Vec3 q) {
  const double low = dot(p, axis), high = dot(q, axis);
  if (std::max(low, high) <= height || radius <= 0.0) return true;
  const Vec3 start = p - axis * low, way = q - axis * high - start;
  const double aa = squared_length(way), ab = dot(start, way), c = squared_length(start) - radius * radius;
  double first = 0.0, last = 1.0;
  if (aa > 0.0) {
    const double disc = ab * ab - aa * c;
    if (disc <= 0.0) return true;
    const double root = std::sqrt(disc);
    first = std::max(first, (-ab - root) / aa), last = std::min(last, (-ab + root) / aa);
  } else if (c >= 0.0) {
    return true;
  }
  if (first >= last) return true;
  const auto at = [&](double share) { return low + (high - low) * share; };
  return std::max(at(first), at(last)) <= height;
}

/// The same of a segment that goes from one place to another: its corners, in order round what it passes.
bool passes_by(double radius, double height, Vec3 axis, const std::array<Vec3, 4>& corners) {
  std::array<Point<Part>, 8> over;  // what is over the height, as seen along the axis
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 p = corners[i], q = corners[(i + 1) % 4];
    const double up = dot(p, axis) - height, next = dot(q, axis) - height;
    if (up > 0.0) over[count++] = Point<Part>{} + (p - axis * (up + height));
    if ((up > 0.0) != (next > 0.0)) {
      const Vec3 at = p + (q - p) * (up / (up - next));
      over[count++] = Point<Part>{} + (at - axis * height);
    }
  }
  if (count == 0 || radius <= 0.0) return true;
  int left = 0, right = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Point<Part> p = over[i], q = over[(i + 1) % count];
    if (distance_to_segment(Point<Part>{}, p, q) < radius) return false;
    const double side = dot(axis, cross(from_origin(p), from_origin(q)));
    left += side >= 0.0 ? 1 : 0, right += side <= 0.0 ? 1 : 0;
  }
  return left < static_cast<int>(count) && right < static_cast<int>(count);
}

/// The distance of two segments as seen along the unit `axis`.
double distance_along(Vec3 axis, std::span<const Point<Part>> core, Point<Part> a, Point<Part> b) {
  const auto seen = [&](Point<Part> p) { return p - axis * dot(p - a, axis); };
  const Point<Part> p = seen(core.front()), q = seen(core.back()), end = seen(b);
  if (core.size() > 1) {
    const auto side = [&](Point<Part> from, Point<Part> to, Point<Part> of) {
      return dot(axis, cross(to - from, of - from));
    };
    if (side(a, end, p) * side(a, end, q) < 0.0 && side(p, q, a) * side(p, q, end) < 0.0) return 0.0;
  }
  return std::min({distance_to_segment(p, a, end), distance_to_segment(q, a, end),
                   distance_to_segment(a, p, q), distance_to_segment(end, p, q)});
}

/// Does the tool's side, over the ball's centre on a straight move from a to b, keep `near` off that part of
/// the core that reaches up from its first corner to where it is below the centre?
bool side_keeps_off(std::span<const Point<Part>> core, const EnvelopePoint& a, const EnvelopePoint& b,
                    double near) {
  double up = 0.0, share = 0.0;
  // Where the axis turns evenly nothing is further up than along either end's axis over either end.
  for (const EnvelopePoint* end : {&a, &b})
    for (const Vec3 axis : {a.axis, b.axis}) {
      const double first = dot(core.front() - end->centre, axis), last = dot(core.back() - end->centre, axis);
      if (first <= 0.0) continue;
      up = std::max({up, first, last});
      share = std::max(share, last < 0.0 ? first / (first - last) : 1.0);
    }
  if (up == 0.0) return true;
  const std::array part{core.front(), lerp(core.front(), core.back(), share)};
  const double turn = length(cross(a.axis, b.axis));
  return distance_along(a.axis, std::span(part).first(core.size()), a.centre, b.centre) - turn * up >=
         (1.0 + turn) * near;
}

}  // namespace

/// (E3) Does a ball with its side, on a straight move from a to b, keep off the patch's edge or vertex, but
/// for the tolerance?
bool StraightMoves::keeps_off(PatchId patch, const EnvelopePoint& a, const EnvelopePoint& b) const {
  const ToolPiece& piece = surface_.piece(patch);
  if (!piece.is_ball_at_reference()) return false;
  const ClSurface::Core core = surface_.core(patch);
  const double near = piece.corner - options_.tolerance;
  Point<Part> from = a.centre, to = b.centre;
  if (core.count == 2) {  // as seen along it
    const Vec3 edge = core.corner[1] - core.corner[0];
    const double share = 1.0 / squared_length(edge);
    from = from - edge * (dot(from - core.corner[0], edge) * share);
    to = to - edge * (dot(to - core.corner[0], edge) * share);
  }
  if (distance_to_segment(core.corner[0], from, to) < near) return false;
  return side_keeps_off(core.points(), a, b, near) &&
         (core.count == 1 || side_keeps_off(std::array{core.corner[1], core.corner[0]}, a, b, near));
}

namespace {

/// Is the core so far beside the piece's wall or below its bottom that it stays there, however it turns on a
/// straight move from a to b? Costs less than core_keeps_off().
bool is_far(const ToolPiece& piece, const ClSurface::Core& core, const EnvelopePoint& a,
            const EnvelopePoint& b, double bend, double chord) {
  const Vec3 first = core.corner[0] - a.centre, last = core.corner[core.count - 1] - a.centre;
  const double up = dot(first, a.axis), next = dot(last, a.axis);
  const double reach = std::sqrt(std::max(squared_length(first), squared_length(last))) + chord;
  // A rotation by q moves a place by 2 sin(q / 2) of its distance, at most sqrt(2) sin(q) up to 90 degrees.
  const double moves = chord + 1.5 * bend * reach;
  const double off = moves + bend * (bend * reach + 2.0 * chord) / 8.0;
  if (dot(a.axis, b.axis) <= 0.0) return false;
  if (std::max(up, next) + off <= piece.above_reference) return true;
  const Vec3 aside = first + last - a.axis * (up + next);
  const double nearest = std::min(dot(first, aside), dot(last, aside)), wall = piece.flat + off;
  return nearest > 0.0 && nearest * nearest >= wall * wall * squared_length(aside);
}

}  // namespace

/// (E3) Does the patch's edge or vertex keep out of a piece with a sharp lower edge on a straight move from a
/// to b, but for the tolerance to the side or from below? What is inside at an end, where the tool may be, is
/// beyond the column's end or turned away: it does not count.
bool StraightMoves::core_keeps_off(PatchId patch, const EnvelopePoint& a, const EnvelopePoint& b) const {
  const ToolPiece& piece = surface_.piece(patch);
  const Vec3 turn = cross(b.axis, a.axis);
  const double bend = length(turn), chord = distance(a.centre, b.centre), towards = 1.0 + dot(a.axis, b.axis);
  const ClSurface::Core core = surface_.core(patch);
  if (is_far(piece, core, a, b, bend, chord)) return true;
  std::array<Vec3, 2> from, to;  // as the tool sees the corners, which turns from a's axis to b's
  double most = 0.0;
  for (std::size_t i = 0; i < core.count; ++i) {
    const Vec3 off = core.corner[i] - b.centre, aside = cross(turn, off);
    from[i] = core.corner[i] - a.centre, to[i] = off + aside + cross(turn, aside) / towards;
    const double strays = bend * (bend * std::max(length(from[i]), length(to[i])) + 2.0 * chord) / 8.0;
    const double spare = options_.tolerance - strays;
    const auto by = [&](Vec3 p, Vec3 q) {
      return passes_by(piece.flat - spare, piece.above_reference + spare, a.axis, p, q);
    };
    if (!by(from[i], to[i]) && by(from[i], from[i]) && by(to[i], to[i])) return false;
    most = std::max(most, strays);
  }
  if (core.count < 2) return true;
  // Where the axis turns the edge does, too; of a long one then only the corners are known to keep off.
  const double spare = options_.tolerance - most - 0.5 * length((to[1] - from[1]) - (to[0] - from[0]));
  const auto by = [&](const std::array<Vec3, 2>& p, const std::array<Vec3, 2>& q) {
    return passes_by(piece.flat - spare, piece.above_reference + spare, a.axis, {p[0], p[1], q[1], q[0]});
  };
  return spare <= 0.0 || by(from, to) || !by(from, from) || !by(to, to);
}

bool StraightMoves::on_move(const Sample& sample, const Sample& left, const Sample& right) const {
  return sample.hit && distance_to_segment(sample.point.centre, left.point.centre, right.point.centre) *
                               static_cast<double>(sample.point.lever) <=
                           options_.tolerance;
}

bool StraightMoves::one_corner(const Sample& left, const Sample& middle, const Sample& right) {
  return middle.point.patch == left.point.patch || middle.point.patch == right.point.patch;
}

/// (E2) Does a ball go from one facet over an edge that both share to the other, and not past that edge's
/// end?
bool StraightMoves::crosses_one_edge(const EnvelopePoint& a, const EnvelopePoint& b) const {
  const ToolPiece& piece = surface_.piece(a.patch);
  if (!surface_.is_face(a.patch) || !surface_.is_face(b.patch) || &surface_.piece(b.patch) != &piece)
    return false;
  if (!piece.is_ball_at_reference()) return false;
  const ClSurface::Core one = surface_.core(a.patch), other = surface_.core(b.patch);
  std::array<Point<Part>, 3> shared{};
  std::size_t count = 0;
  for (const Point<Part>& v : one.points())
    if (std::find(other.points().begin(), other.points().end(), v) != other.points().end())
      shared[count++] = v;
  if (count < 2) return false;
  const Vec3 chord = b.centre - a.centre, edge = shared[1] - shared[0];
  // The contact runs in its plane straight to the edge.
  const auto meets = [&](const EnvelopePoint& end) {
    const Point<Part> contact = end.centre - end.normal * piece.corner;
    const Vec3 way = chord - end.axis * (dot(end.normal, chord) / dot(end.normal, end.axis));
    const double turn = dot(end.normal, cross(way, edge));
    if (turn == 0.0) return false;
    const double share = dot(end.normal, cross(shared[0] - contact, edge)) / turn;
    const double run = dot(contact + way * share - shared[0], edge);
    return run >= 0.0 && run <= squared_length(edge);
  };
  return meets(a) && meets(b);
}

/// (E3)
bool StraightMoves::may_sink(const EnvelopePoint& a, const EnvelopePoint& b) const {
  const ToolPiece& piece = surface_.piece(a.patch);
  if (a.patch == b.patch || piece.part != ToolPart::kCutter || !is_sharp(piece)) return false;
  const Vec3 chord = b.centre - a.centre;
  // What it sinks down a slope, square to it.
  const double up = dot(chord, a.axis), length2 = squared_length(chord);
  if (up * up * (length2 - up * up) <= options_.tolerance * options_.tolerance * length2) return false;
  const ClSurface::Core one = surface_.core(a.patch), other = surface_.core(b.patch);
  const auto shared = std::count_if(one.points().begin(), one.points().end(), [&](const Point<Part>& v) {
    return std::find(other.points().begin(), other.points().end(), v) != other.points().end();
  });
  return shared < std::min({2, static_cast<int>(one.count), static_cast<int>(other.count)});
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

}  // namespace tiltfeed::pathgen
