// Where the patches of ClSections may be.

#include <algorithm>
#include <cmath>

#include "pathgen/free_slices/cl_sections.h"

namespace tiltfeed::pathgen {

std::array<double, 2> ClSections::extent(std::uint32_t patch, Vec3 normal) const {
  if (patch < faces_.size()) {
    const auto& c = faces_[patch].corner;
    const double a = dot(from_origin(c[0]), normal), b = dot(from_origin(c[1]), normal),
                 d = dot(from_origin(c[2]), normal);
    return {std::min({a, b, d}), std::max({a, b, d})};
  }
  const auto [low, high] = caps_[patch].along(normal);
  patch -= static_cast<std::uint32_t>(faces_.size());
  if (patch < edges_.size()) {
    const Edge& e = edges_[patch];
    const double a = dot(from_origin(e.start), normal), b = a + e.length * dot(e.along, normal);
    return {std::min(a, b) + low * radius_, std::max(a, b) + high * radius_};
  }
  const double at = dot(from_origin(vertices_[patch - edges_.size()].at), normal);
  return {at + low * radius_, at + high * radius_};
}

PatchHull ClSections::hull(std::uint32_t patch) const {
  PatchHull h;
  h.normals = caps_[patch], h.near = h.far = radius_;
  const auto own = patch;
  double spread = 0.0;  // of the feet from their middle
  if (patch < faces_.size()) {
    const Face& f = faces_[patch];
    for (const Point<Part> c : f.corner) h.foot[h.feet++] = c - f.normal * radius_;
    h.support[h.supports++] = f.normal;
    h.middle = h.foot[0] + ((h.foot[1] - h.foot[0]) + (h.foot[2] - h.foot[0])) / 3.0;
    for (const Point<Part> p : h.foot) spread = std::max(spread, distance(p, h.middle));
  } else if ((patch -= static_cast<std::uint32_t>(faces_.size())) < edges_.size()) {
    const Edge& e = edges_[patch];
    h.foot[h.feet++] = e.start, h.foot[h.feet++] = e.start + e.along * e.length;
    // The ends of half a turn, as on a rim, do not tell what lies between them.
    for (const double q : {e.from, 0.5 * (e.from + e.to), e.to})
      h.support[h.supports++] = e.p * std::cos(q) + e.w * std::sin(q);
    h.far = radius_ + sagitta_, h.middle = lerp(h.foot[0], h.foot[1], 0.5), spread = e.length / 2.0;
  } else {
    h.foot[h.feet++] = h.middle = vertices_[patch - edges_.size()].at;
    h.far = radius_ + sagitta_, h.is_vertex = true;
  }
  const NormalCap& cap = caps_[own];
  if (cap.cosine <= -1.0) {
    h.reach = spread + h.far;
  } else {
    // Of two normals within the cap's angle of the axis the ends are no further apart than its chord.
    h.middle = h.middle + cap.axis * h.near;
    h.reach = spread + 2.0 * h.near * std::sqrt(std::max(0.0, (1.0 - cap.cosine) / 2.0)) + (h.far - h.near);
  }
  return h;
}

}  // namespace tiltfeed::pathgen
