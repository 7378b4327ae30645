#pragma once
// How far two convex bodies are from each other, from below: by the points of both that lie furthest along a
// direction [Gilbert, Johnson, Keerthi 1988]. Formula (P1) is in sim/proof/README.md.

#include <array>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::sim {

/// A direction, unit, along which a plane between the bodies is known, and how wide the gap is there, mm: no
/// more than their distance. 0: none is known.
struct Gap {
  double width = 0.0;
  Vec3 along;
};

/// Some points of the difference of two bodies, and that of their hull which is nearest to the origin.
class NearestHull {
 public:
  /// Adds a point; keeps of the others what the nearest one hangs on. Returns the nearest; zero: the hull
  /// holds the origin.
  Vec3 add(Vec3 point);

 private:
  Vec3 on_edge(int a, int b);
  Vec3 on_face(int a, int b, int c);
  Vec3 in_solid();

  std::array<Vec3, 4> points_;
  int count_ = 0;
};

/// (P1) difference(u): of all p - q, p of one body and q of the other, that with the least u . (p - q).
/// `along`: a first guess, unit. Ends as soon as the gap is `enough`, or within `error` of the distance, or
/// where the distance is known to be less than `hopeless`, mm.
template <class Difference>
Gap gap_between(const Difference& difference, Vec3 along, double enough, double error,
                double hopeless = 0.0) {
  constexpr int kMostLooks = 64;
  Gap best;
  NearestHull hull;
  for (int look = 0; look < kMostLooks; ++look) {
    const Vec3 point = difference(along);
    const double width = dot(along, point);
    if (width > best.width) best = {width, along};
    if (best.width >= enough) return best;
    const Vec3 nearest = hull.add(point);
    const double distance = length(nearest);
    if (distance <= best.width + error || distance < error || distance < hopeless) return best;
    along = nearest / distance;
  }
  return best;
}

}  // namespace tiltfeed::sim
