#include "pathgen/surface/normal_cone.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// Wider cones (cosine of 60 degrees to their mean) are not cut: the plane square to the mean shows them too
/// stretched.
constexpr double kWidest = 0.5;
/// Rounding of the plane's coordinates, widened: what is cut off is that far outside.
constexpr double kPlaneRounding = 1e-7;

struct Place {
  double x, y;
};

/// A plane square to the mean of some directions; each is where it meets that plane.
struct View {
  Vec3 mean, right, up;
  Place of(Vec3 n) const {
    const double along = dot(n, mean);
    return {dot(n, right) / along, dot(n, up) / along};
  }
  Vec3 at(Place p) const { return normalized(mean + right * p.x + up * p.y); }
};

/// A convex polygon of the plane; a cut adds one corner at most.
struct Polygon {
  std::array<Place, kMostSpokes + 4> corner;
  std::size_t count = 0;
  void add(Place p) { corner[count++] = p; }
};

/// Leaves what of the polygon has a x + b y <= c.
void clip(Polygon& polygon, double a, double b, double c) {
  const auto over = [&](Place p) { return a * p.x + b * p.y - c; };
  const auto last = polygon.corner.begin() + polygon.count;
  if (std::none_of(polygon.corner.begin(), last, [&](Place p) { return over(p) > 0.0; })) return;
  const Polygon from = polygon;
  polygon.count = 0;
  Place p = from.corner[from.count - 1];
  double over_p = over(p);
  for (std::size_t i = 0; i < from.count; ++i) {
    const Place q = from.corner[i];
    const double over_q = over(q);
    if ((over_p < 0.0 && over_q > 0.0) || (over_p > 0.0 && over_q < 0.0)) {
      const double t = over_p / (over_p - over_q);
      polygon.add({p.x + (q.x - p.x) * t, p.y + (q.y - p.y) * t});
    }
    if (over_q <= 0.0) polygon.add(q);
    p = q, over_p = over_q;
  }
}

}  // namespace

bool cut_cone(std::vector<Vec3>& normals, std::span<const Vec3> spokes, double slack) {
  Vec3 sum;
  for (Vec3 n : normals) sum = sum + n;
  if (length(sum) <= 0.0 || spokes.empty() || spokes.size() > kMostSpokes) return true;
  View view{normalized(sum), {}, {}};
  if (std::any_of(normals.begin(), normals.end(), [&](Vec3 n) { return !(dot(n, view.mean) >= kWidest); }))
    return true;
  view.up = cross(view.mean, spokes[0]);  // so that a turned part gives the turned cone
  if (length(view.up) <= kPlaneRounding * length(spokes[0])) return true;
  view.up = normalized(view.up), view.right = cross(view.up, view.mean);
  Place low{1e9, 1e9}, high{-1e9, -1e9};
  for (Vec3 n : normals) {
    const Place p = view.of(n);
    low = {std::min(low.x, p.x), std::min(low.y, p.y)}, high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  const double spare =
      slack / kWidest + kPlaneRounding;  // a direction in the plane is up to 1 / kWidest long
  Polygon polygon;
  polygon.add({low.x - spare, low.y - spare}), polygon.add({high.x + spare, low.y - spare});
  polygon.add({high.x + spare, high.y + spare}), polygon.add({low.x - spare, high.y + spare});
  for (Vec3 e : spokes) {
    clip(polygon, dot(e, view.right), dot(e, view.up), spare * length(e) - dot(e, view.mean));
    if (polygon.count == 0) return false;
  }
  normals.clear();
  for (std::size_t i = 0; i < polygon.count; ++i) normals.push_back(view.at(polygon.corner[i]));
  return true;
}

NormalArc widest_arc(std::span<const Vec3> normals) {
  NormalArc arc{normals[0], normals[0]};
  double least = 1.0;
  for (std::size_t i = 0; i < normals.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (const double cosine = dot(normals[i], normals[j]); cosine < least)
        least = cosine, arc.from = normals[i], arc.to = normals[j];
  const Vec3 side = cross(arc.from, arc.to);
  const double sine = length(side);
  double aside = 0.0;
  for (Vec3 n : normals)
    aside =
        std::max(aside, sine > kPlaneRounding ? std::abs(dot(n, side)) / sine : length(cross(n, arc.from)));
  // Between two places on one side of the great circle a straight way may lie further off than both; past an
  // end nothing lies further than by the square of it.
  const double half = std::sqrt((1.0 + std::clamp(least, -1.0, 1.0)) / 2.0);
  arc.aside = std::asin(std::min(1.0, aside / half)) * (1.0 + aside);
  return arc;
}

Vec3 arc_apex(const NormalArc& arc) { return (arc.from + arc.to) / (1.0 + dot(arc.from, arc.to)); }

}  // namespace tiltfeed::pathgen
