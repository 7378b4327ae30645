#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pathgen/free_slices/cl_chains.h"
#include "pathgen/tool/swept_tool.h"

namespace tiltfeed::pathgen {

namespace {

/// Steps of the search for the least distance on a move; each at least halves what is unknown.
constexpr int kMostSteps = 64;
/// More obstacles of a patch than this are looked up near each move.
constexpr std::size_t kFewObstacles = 64;

/// Distance of a facet from the place s of a move, and its derivative.
struct Near {
  double s, distance, slope;
};

class Move1 {
 public:
  Move1(Point<Part> from, Point<Part> to)
      : from_(from), length_(distance(from, to)), along_((to - from) / length_) {}
  double length() const { return length_; }
  Vec3 along() const { return along_; }
  Near at(double s, const Corners& c) const {
    const Point<Part> p = from_ + along_ * s;
    const Vec3 off = p - nearest_point(p, c);
    const double d = tiltfeed::length(off);
    return {s, d, d > 0.0 ? dot(off, along_) / d : 0.0};
  }

 private:
  Point<Part> from_;
  double length_;
  Vec3 along_;
};

/// A place of the move between two that are not nearer than `limit` to the facet, but is itself, if there is
/// one: the distance is convex along the move, so between two places it is nowhere less than where their
/// tangents meet.
bool find_inside(const Move1& move, const Corners& c, double limit, Near a, Near b, Near& inside) {
  for (int i = 0; i < kMostSteps; ++i) {
    if (a.slope >= 0.0 || b.slope <= 0.0) return false;
    const double meet = (b.distance - b.slope * b.s - a.distance + a.slope * a.s) / (a.slope - b.slope);
    if (a.distance + a.slope * (meet - a.s) >= limit) return false;
    const Near middle = move.at(std::clamp(meet, a.s, b.s), c);
    if (middle.distance < limit) return inside = middle, true;
    (middle.slope < 0.0 ? a : b) = middle;
    if (b.s - a.s < kSamePoint) return false;
  }
  return false;
}

/// Where the move comes out of the limit on the way from `inside` to `outside`.
double border(const Move1& move, const Corners& c, double limit, double inside, double outside) {
  for (int i = 0; i < kMostSteps && std::abs(outside - inside) > 1e-10; ++i) {
    const double middle = 0.5 * (inside + outside);
    (move.at(middle, c).distance < limit ? inside : outside) = middle;
  }
  return outside;
}

using Span = std::array<double, 2>;

/// Are plane or ball of the facet no nearer than the limit? Asks for no distance of the facet itself.
bool clearly_off(const Move1& move, Point<Part> from, Point<Part> to, const PlacedFacet& facet,
                 double limit) {
  const double low = dot(facet.normal, from_origin(from)) - facet.offset;
  const double high = dot(facet.normal, from_origin(to)) - facet.offset;
  if ((low >= limit && high >= limit) || (low <= -limit && high <= -limit)) return true;
  const double beside = std::clamp(dot(facet.centre - from, move.along()), 0.0, move.length());
  const double reach = limit + facet.radius;
  return squared_length(facet.centre - (from + move.along() * beside)) >= reach * reach;
}

/// Appends the part of the move that is too near to the facet, if there is one; true: all of it.
bool add_span_inside(const Move1& move, Point<Part> from, Point<Part> to, const PlacedFacet& facet,
                     double limit, std::vector<Span>& spans) {
  if (clearly_off(move, from, to, facet, limit)) return false;
  const Corners& c = facet.corners;
  const double end = move.length();
  // No place is further from the middle than half the move.
  const Near middle = move.at(end / 2.0, c);
  if (middle.distance - end / 2.0 >= limit) return false;
  const Near first = move.at(0.0, c), last = move.at(end, c);
  const bool starts = first.distance < limit, ends = last.distance < limit;
  if (starts && ends) return spans.push_back({0.0, end}), true;
  Near inside = starts ? first : last;
  if (!starts && !ends && !find_inside(move, c, limit, first, last, inside)) return false;
  spans.push_back({starts ? 0.0 : border(move, c, limit, inside.s, 0.0),
                   ends ? end : border(move, c, limit, inside.s, end)});
  return false;
}

/// In rising order, overlaps united.
void unite(std::vector<Span>& spans) {
  if (spans.empty()) return;
  std::sort(spans.begin(), spans.end());
  std::size_t last = 0;
  for (std::size_t i = 1; i < spans.size(); ++i) {
    if (spans[i][0] <= spans[last][1])
      spans[last][1] = std::max(spans[last][1], spans[i][1]);
    else
      spans[++last] = spans[i];
  }
  spans.resize(last + 1);
}

/// Is some part of the move too near to a facet?
bool any_inside(Point<Part> from, Point<Part> to, const FacetBvh& tree, double limit) {
  const Move1 move(from, to);
  std::vector<Span> spans;
  return tree.any_along(from, move.along(), 0.0, move.length(), limit,
                        [&](std::uint32_t, const PlacedFacet& facet) {
                          add_span_inside(move, from, to, facet, limit, spans);
                          return !spans.empty();
                        });
}

}  // namespace

void trim_strand(const ClStrand& strand, const FacetBvh& tree, std::span<const std::uint32_t> obstacles,
                 double radius, std::vector<ClStrand>& kept) {
  if (obstacles.empty()) return kept.push_back(strand);
  ClStrand run;
  std::vector<Span> spans;
  const auto end_run = [&] {
    if (run.size() > 1) kept.push_back(std::move(run));
    run.clear();
  };
  for (std::size_t i = 0; i + 1 < strand.size(); ++i) {
    const ClPoint &a = strand[i], &b = strand[i + 1];
    const double whole = distance(a.centre, b.centre);
    if (whole < kSamePoint) continue;
    spans.clear();
    const Move1 move(a.centre, b.centre);
    const double limit = radius - kInside;
    if (obstacles.size() <= kFewObstacles) {
      for (const std::uint32_t facet : obstacles)
        if (add_span_inside(move, a.centre, b.centre, tree.facet(facet), limit, spans)) break;
    } else {
      tree.any_along(a.centre, move.along(), 0.0, whole, limit,
                     [&](std::uint32_t index, const PlacedFacet& facet) {
                       return std::binary_search(obstacles.begin(), obstacles.end(), index) &&
                              add_span_inside(move, a.centre, b.centre, facet, limit, spans);
                     });
    }
    unite(spans);
    if (run.empty()) run.push_back(a);
    for (const Span& span : spans) {
      if (span[0] > kSamePoint)
        run.push_back(between(a, b, span[0] / whole));
      else if (run.size() == 1)
        run.clear();
      end_run();
      if (span[1] < whole - kSamePoint) run.push_back(between(a, b, span[1] / whole));
    }
    if (spans.empty() || spans.back()[1] < whole - kSamePoint) run.push_back(b);
  }
  end_run();
}

namespace {

/// The facet that is nearest to the place, if any is in reach.
std::optional<Corners> nearest(Point<Part> place, const FacetBvh& tree, double reach) {
  std::optional<Corners> found;
  tree.nearest(place, reach, [&](std::uint32_t, const PlacedFacet& f) {
    const double off = distance(place, nearest_point(place, f.corners));
    if (off <= reach) reach = off, found = f.corners;
    return off;
  });
  return found;
}

/// Is some facet in reach all along the move, if these two are of its ends? The distance to one facet is
/// convex along it.
bool stays_near(Point<Part> from, const Corners& of_from, Point<Part> to, const Corners& of_to,
                const FacetBvh& tree, double reach) {
  if (distance(to, nearest_point(to, of_from)) <= reach ||
      distance(from, nearest_point(from, of_to)) <= reach)
    return true;
  const Point<Part> middle = lerp(from, to, 0.5);
  const auto between = nearest(middle, tree, reach);
  if (!between || distance(from, to) < kSamePoint) return between.has_value();
  return stays_near(from, of_from, middle, *between, tree, reach) &&
         stays_near(middle, *between, to, of_to, tree, reach);
}

}  // namespace

bool in_contact(Point<Part> from, Point<Part> to, const FacetBvh& tree, double radius, double tolerance) {
  if (any_inside(from, to, tree, radius - tolerance)) return false;
  const double reach = radius + tolerance;
  const auto of_from = nearest(from, tree, reach), of_to = nearest(to, tree, reach);
  return of_from && of_to && stays_near(from, *of_from, to, *of_to, tree, reach);
}

}  // namespace tiltfeed::pathgen
