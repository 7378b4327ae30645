#include "pathgen/tool/swept_tool.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tiltfeed::pathgen {

namespace {

struct Corner {
  double x, y, z;
};
/// A triangle of which two planes cut a corner off each.
struct Polygon {
  std::array<Corner, 6> at;
  int count = 0;
};

/// Two unit vectors square to `axis` and to each other [Duff et al. 2017].
std::array<Vec3, 2> across(Vec3 axis) {
  const double sign = std::copysign(1.0, axis.z);
  const double a = -1.0 / (sign + axis.z), b = axis.x * axis.y * a;
  return {Vec3{1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x},
          Vec3{b, sign + axis.y * axis.y * a, -axis.y}};
}

/// What of the polygon is above (sign 1) or below (sign -1) the height.
void clip(Polygon& polygon, double height, double sign) {
  Polygon kept;
  for (int i = 0; i < polygon.count; ++i) {
    const Corner& p = polygon.at[i];
    const Corner& q = polygon.at[i + 1 == polygon.count ? 0 : i + 1];
    const double a = (p.z - height) * sign, b = (q.z - height) * sign;
    if (a >= 0.0) kept.at[kept.count++] = p;
    if ((a < 0.0) == (b < 0.0)) continue;
    const double f = a / (a - b);
    kept.at[kept.count++] = {p.x + (q.x - p.x) * f, p.y + (q.y - p.y) * f, height};
  }
  polygon = kept;
}

bool axis_pierces(const Polygon& polygon) {
  bool left = false, right = false;
  for (int i = 0; i < polygon.count; ++i) {
    const Corner& p = polygon.at[i];
    const Corner& q = polygon.at[i + 1 == polygon.count ? 0 : i + 1];
    const double turn = p.x * q.y - p.y * q.x;
    (turn > 0.0 ? left : right) = true;
    if (left && right) return false;
  }
  return true;
}

/// (A2) The least of hypot(x, y) - slope z over the side from p to q. It is convex there, and on the side's
/// line hypot = sqrt(d^2 + h^2 t^2) about the foot of the perpendicular: least where its derivative is the
/// slope's.
double least_on_side(const Corner& p, const Corner& q, double slope) {
  const double dx = q.x - p.x, dy = q.y - p.y, dz = q.z - p.z;
  const double hh = dx * dx + dy * dy;
  if (hh <= 0.0) return std::hypot(p.x, p.y) - slope * std::max(p.z, q.z);
  const double foot = -(p.x * dx + p.y * dy) / hh;
  const double cross = p.x * dy - p.y * dx, dd = cross * cross / hh;
  double t = foot;
  if (slope != 0.0) {
    const double h = std::sqrt(hh), rise = slope * dz / h;
    if (std::abs(rise) >= 1.0) {
      t = rise > 0.0 ? 1.0 : 0.0;
    } else {
      t = foot + std::sqrt(dd) * rise / std::sqrt(1.0 - rise * rise) / h;
    }
  }
  t = std::clamp(t, 0.0, 1.0);
  const double x = p.x + dx * t, y = p.y + dy * t;
  return std::sqrt(x * x + y * y) - slope * (p.z + dz * t);
}

Box box_about(Point<Part> p, double r) { return {p - Vec3{r, r, r}, p + Vec3{r, r, r}}; }

}  // namespace

namespace {

/// (A3) Is the ball about the facet clear of the cylinder about the frustum?
bool away_from_ball(const SweptTool::Frustum& frustum, Point<Part> centre, Vec3 axis,
                    const PlacedFacet& facet) {
  const Vec3 d = facet.centre - centre;
  const double h = dot(d, axis), reach = frustum.widest + facet.radius;
  return h + facet.radius < frustum.from || h - facet.radius > frustum.to ||
         squared_length(d) - h * h > reach * reach;
}

/// (A3) Is all of the frustum on one side of the facet's plane?
bool beside_plane(const SweptTool::Frustum& frustum, Point<Part> centre, Vec3 axis,
                  const PlacedFacet& facet) {
  double height = dot(facet.normal, from_origin(centre)) - facet.offset, rise = dot(facet.normal, axis);
  if (height < 0.0) height = -height, rise = -rise;
  const double across = std::sqrt(std::max(0.0, 1.0 - rise * rise));
  if (height + frustum.from * rise - frustum.radius * across <= 0.0) return false;
  if (frustum.to == kForEver) return rise >= 0.0;
  return height + frustum.to * rise - frustum.widest * across > 0.0;
}

}  // namespace

bool meets(const SweptTool::Frustum& frustum, Point<Part> centre, Vec3 axis, const PlacedFacet& facet) {
  if (away_from_ball(frustum, centre, axis, facet) || beside_plane(frustum, centre, axis, facet))
    return false;
  const Corners& triangle = facet.corners;
  const Vec3 v[3] = {triangle[0] - centre, triangle[1] - centre, triangle[2] - centre};
  const double z[3] = {dot(v[0], axis), dot(v[1], axis), dot(v[2], axis)};
  const double low = std::min({z[0], z[1], z[2]}), high = std::max({z[0], z[1], z[2]});
  if (high <= frustum.from || low >= frustum.to) return false;
  const auto [e, f] = across(axis);
  Polygon polygon;
  for (int i = 0; i < 3; ++i) polygon.at[i] = {dot(v[i], e), dot(v[i], f), z[i]};
  polygon.count = 3;
  if (low < frustum.from) clip(polygon, frustum.from, 1.0);
  if (high > frustum.to) clip(polygon, frustum.to, -1.0);
  if (polygon.count == 0) return false;
  const double limit = frustum.radius - frustum.slope * frustum.from;
  for (int i = 0; i < polygon.count; ++i)
    if (least_on_side(polygon.at[i], polygon.at[i + 1 == polygon.count ? 0 : i + 1], frustum.slope) < limit)
      return true;
  // No side is met: the triangle may still be all round the frustum.
  return axis_pierces(polygon);
}

/// By the region of the triangle's plane that p lies over [Ericson 2005, 5.1.5].
Point<Part> nearest_point(Point<Part> p, const Corners& t) {
  const Vec3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return t[0];
  const Vec3 bp = p - t[1];
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return t[1];
  const Vec3 cp = p - t[2];
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return t[2];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return t[0] + ab * (d1 / (d1 - d3));
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return t[0] + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return t[1] + (t[2] - t[1]) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double whole = va + vb + vc;
  return t[0] + ab * (vb / whole) + ac * (vc / whole);
}

SweptTool::SweptTool(const FacetBvh& tree, const PlanOptions& options, double slack, HeldPieces held)
    : tree_(tree), held_(held), ball_(options.cutter.radius() + options.allowance), slack_(slack) {
  const auto add = [](std::vector<Frustum>& list, const ToolPiece& piece, double give, bool swept) {
    const double base = piece.above_reference, top = base + piece.length, end = swept ? kForEver : top;
    double from = base, radius = piece.outer - give;
    if (piece.has_cone()) {
      // (T1), (T2): the cone starts where it leaves the rounding.
      const double start = base - piece.corner * piece.taper_sin, slope = piece.taper_sin / piece.taper_cos;
      const double lower = piece.flat + piece.corner * piece.taper_cos - give;
      const double reach = std::min(start + (piece.outer - give - lower) / slope, end);
      list.push_back({piece.part, start, reach, lower, slope, piece.outer - give, top});
      from = reach;
    }
    if (from < end) list.push_back({piece.part, from, end, radius, 0.0, radius, top});
  };
  const std::vector<ToolPiece> pieces = all_pieces(options);
  const std::vector<bool> hidden = in_shadow(options);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const ToolPiece& piece = pieces[i];
    widest_ = std::max(widest_, piece.outer);
    if (hidden[i] && held != HeldPieces::kAll) continue;
    if (held == HeldPieces::kBesidesCutter && piece.part == ToolPart::kCutter) continue;
    // What is as wide as the cutting part below it touches where that does.
    add(swept_, piece, piece.part == ToolPart::kCutter || hidden[i] ? slack : 0.0, true);
    top_ = std::max(top_, piece.above_reference + piece.length);
  }
  for (Frustum& f : swept_) {
    double below = ball_;
    for (const Frustum& g : swept_)
      if (g.from < f.from) below = std::max(below, g.radius + g.slope * (std::min(f.from, g.to) - g.from));
    f.sharp = f.part != ToolPart::kCutter && f.radius > below;
  }
  for (const ToolPiece& piece : all_pieces(options))
    add(still_, piece, piece.part == ToolPart::kCutter ? slack : 0.0, false);
  if (!options.fixtures) return;
  fixture_tree_ = std::make_shared<const FacetBvh>(options.fixtures->mesh);
  fixtures_ = std::make_shared<const SweptTool>(*fixture_tree_, as_of_fixtures(options), 0.0, held);
}

Box SweptTool::bounds() const {
  if (!fixtures_) return tree_.bounds();
  const Box& of = fixture_tree_->bounds();
  return grown(grown(tree_.bounds(), of.min), of.max);
}

bool SweptTool::ball_meets(Point<Part> centre, double radius, std::uint32_t* facet) const {
  bool met = false;
  tree_.each_in(box_about(centre, radius), [&](std::uint32_t i, const PlacedFacet& c) {
    if (met || squared_length(centre - nearest_point(centre, c.corners)) >= radius * radius) return;
    met = true;
    if (facet != nullptr) *facet = i;
  });
  return met;
}

std::optional<Blocker> SweptTool::stop_at_fixtures(Point<Part> centre, Vec3 axis, double back) const {
  std::uint32_t facet = kNoFacet;
  if (held_ != HeldPieces::kBesidesCutter && fixtures_->ball_meets(centre, fixtures_->ball_, &facet))
    return Blocker{ToolPart::kCutter, facet, true};
  const std::optional<Blocker> found = fixtures_->stop(centre, axis, facet, kWithFixtures, back);
  return found ? std::optional(Blocker{found->part, found->facet, true}) : std::nullopt;
}

std::optional<Blocker> SweptTool::stop(Point<Part> centre, Vec3 axis, std::uint32_t& hint) const {
  return stop(centre, axis, hint, kWithFixtures);
}

std::optional<Blocker> SweptTool::stop(Point<Part> centre, Vec3 axis, std::uint32_t& hint, int parts,
                                       double back) const {
  const auto drawn = [back](Frustum f) {
    f.to = std::min(f.to, f.top + back);
    return f;
  };
  if (hint != kNoFacet)
    for (const Frustum& f : swept_)
      if (static_cast<int>(f.part) < parts && meets(drawn(f), centre, axis, tree_.facet(hint)))
        return Blocker{f.part, hint};
  for (const Frustum& swept : swept_) {
    const Frustum f = drawn(swept);
    if (static_cast<int>(f.part) >= parts || f.from >= f.to) continue;
    const bool found = tree_.any_in_cylinder(centre, axis, f.from, f.to, f.widest,
                                             [&](std::uint32_t facet, const PlacedFacet& c) {
                                               if (!meets(f, centre, axis, c)) return false;
                                               hint = facet;
                                               return true;
                                             });
    if (found) return Blocker{f.part, hint};
  }
  return fixtures_ && parts >= kWithFixtures ? stop_at_fixtures(centre, axis, back) : std::nullopt;
}

bool SweptTool::stopped_by(std::uint32_t facet, Point<Part> centre, Vec3 axis, int parts) const {
  return std::any_of(swept_.begin(), swept_.end(), [&](const Frustum& f) {
    return static_cast<int>(f.part) < parts && meets(f, centre, axis, tree_.facet(facet));
  });
}

bool SweptTool::may_stop(Point<Part> centre, Vec3 axis, double off, double turn, double from,
                         double back) const {
  const Box& box = tree_.bounds();
  const Point<Part> middle = lerp(box.min, box.max, 0.5);
  const double highest = distance(middle, centre) + distance(middle, box.max);
  for (const Frustum& f : swept_) {
    // A point of the tool at height h and distance r from the axis moves by at most off + (h + r) turn.
    const double moved = off + f.widest * turn,
                 low = std::max(f.from - moved - std::abs(f.from) * turn, from);
    const double to = std::min({f.to, f.top + back, highest}), high = to + moved + to * turn;
    if (low >= high) continue;
    Frustum grown{
        f.part,         low,
        high,           f.radius + f.slope * std::max(0.0, low - f.from) + moved + std::max(0.0, low) * turn,
        f.slope + turn, 0.0};
    // In pieces that get no more than twice as wide: the tree is asked for what is near to the widest.
    while (grown.from < high) {
      const double twice = grown.slope > 0.0 ? grown.from + grown.radius / grown.slope : high;
      grown.to = std::min(high, twice), grown.widest = grown.radius + grown.slope * (grown.to - grown.from);
      const auto met = [&](std::uint32_t, const PlacedFacet& c) { return meets(grown, centre, axis, c); };
      if (tree_.any_in_cylinder(centre, axis, grown.from, grown.to, grown.widest, met)) return true;
      grown.from = grown.to, grown.radius = grown.widest;
    }
  }
  const bool asks_ball = held_ != HeldPieces::kBesidesCutter;
  return fixtures_ && ((asks_ball && fixtures_->ball_meets(centre, fixtures_->ball_ + off)) ||
                       fixtures_->may_stop(centre, axis, off, turn, from, back));
}

bool SweptTool::stopped_below(Point<Part> centre, Vec3 axis, double to, double fall, double turn,
                              std::uint32_t& hint, double back) const {
  for (Frustum f : swept_) {
    f.to = std::min(f.to, f.top + back);
    if (f.sharp) f.from -= fall + f.radius * turn;
    if (f.from >= std::min(to, f.to)) continue;
    if (f.to > to) f.widest = f.radius + f.slope * (to - f.from), f.to = to;
    if (hint != kNoFacet && meets(f, centre, axis, tree_.facet(hint))) return true;
    const bool found = tree_.any_in_cylinder(centre, axis, f.from, f.to, f.widest,
                                             [&](std::uint32_t facet, const PlacedFacet& c) {
                                               if (!meets(f, centre, axis, c)) return false;
                                               hint = facet;
                                               return true;
                                             });
    if (found) return true;
  }
  std::uint32_t facet = kNoFacet;
  const bool asks_ball = held_ != HeldPieces::kBesidesCutter;
  return fixtures_ && ((asks_ball && fixtures_->ball_meets(centre, fixtures_->ball_)) ||
                       fixtures_->stopped_below(centre, axis, to, fall, turn, facet, back));
}

std::optional<Blocker> SweptTool::hit(Point<Part> centre, Vec3 axis) const {
  const double radius = ball_ - slack_;
  std::optional<Blocker> found;
  tree_.each_in(box_about(centre, radius), [&](std::uint32_t facet, const PlacedFacet& c) {
    if (!found && squared_length(centre - nearest_point(centre, c.corners)) < radius * radius)
      found = {ToolPart::kCutter, facet};
  });
  for (const Frustum& f : still_) {
    if (found) break;
    tree_.any_in_cylinder(centre, axis, f.from, f.to, f.widest,
                          [&](std::uint32_t facet, const PlacedFacet& c) {
                            if (meets(f, centre, axis, c)) found = {f.part, facet};
                            return found.has_value();
                          });
  }
  if (!found && fixtures_)
    if (found = fixtures_->hit(centre, axis); found) found->of_fixtures = true;
  return found;
}

}  // namespace tiltfeed::pathgen
