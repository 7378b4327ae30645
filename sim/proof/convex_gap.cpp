#include "sim/proof/convex_gap.h"

#include <limits>

namespace tiltfeed::sim {

Vec3 NearestHull::add(Vec3 point) {
  points_[count_++] = point;
  switch (count_) {
    case 1:
      return point;
    case 2:
      return on_edge(0, 1);
    case 3:
      return on_face(0, 1, 2);
    default:
      return in_solid();
  }
}

/// Nearest point of the edge; the simplex becomes what it lies on.
Vec3 NearestHull::on_edge(int a, int b) {
  const Vec3 from = points_[a], to = points_[b], way = to - from;
  const double square = squared_length(way), along = -dot(from, way);
  if (!(along > 0.0)) {
    points_[0] = from, count_ = 1;
    return from;
  }
  if (along >= square) {
    points_[0] = to, count_ = 1;
    return to;
  }
  points_[0] = from, points_[1] = to, count_ = 2;
  return from + way * (along / square);
}

Vec3 NearestHull::on_face(int ia, int ib, int ic) {
  const Vec3 a = points_[ia], b = points_[ib], c = points_[ic];
  const Vec3 ab = b - a, ac = c - a;
  const double d1 = -dot(ab, a), d2 = -dot(ac, a), d3 = -dot(ab, b), d4 = -dot(ac, b), d5 = -dot(ab, c),
               d6 = -dot(ac, c);
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return on_edge(ia, ib);
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return on_edge(ia, ic);
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) return on_edge(ib, ic);
  if (d1 <= 0.0 && d2 <= 0.0) return on_edge(ia, ib);
  if (d3 >= 0.0 && d4 <= d3) return on_edge(ib, ia);
  if (d6 >= 0.0 && d5 <= d6) return on_edge(ic, ia);
  points_[0] = a, points_[1] = b, points_[2] = c, count_ = 3;
  const double sum = va + vb + vc;
  if (!(sum > 0.0)) return on_edge(0, 1);
  return a + ab * (vb / sum) + ac * (vc / sum);
}

Vec3 NearestHull::in_solid() {
  const std::array<Vec3, 4> all = points_;
  constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};
  double least = std::numeric_limits<double>::infinity();
  std::array<Vec3, 4> kept{};
  int count = 0;
  Vec3 nearest;
  bool outside = false;
  for (const auto& [a, b, c, d] : kFaces) {
    const Vec3 normal = cross(all[b] - all[a], all[c] - all[a]);
    const double origin = -dot(normal, all[a]), other = dot(normal, all[d] - all[a]);
    // On the other side of this face than the fourth corner, or the four lie in a plane.
    if (origin * other > 0.0) continue;
    outside = true;
    points_ = all;
    const Vec3 p = on_face(a, b, c);
    const double square = squared_length(p);
    if (square >= least) continue;
    least = square, nearest = p, kept = points_, count = count_;
  }
  if (!outside) return {};
  points_ = kept, count_ = count;
  return nearest;
}

}  // namespace tiltfeed::sim
