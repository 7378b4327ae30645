#pragma once
// Random points of a surface, spread evenly over its area; the same ones every time.

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "pathgen/mesh/mesh.h"

namespace tiltfeed {
using namespace pathgen;

class SurfaceSample {
 public:
  struct At {
    Point<Part> point;
    Vec3 normal;  ///< unit, of its facet
  };

  /// `mesh` must outlive the sample.
  explicit SurfaceSample(const Mesh& mesh) : mesh_(mesh) {
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.facets) {
      const Point<Part> p = mesh.vertices[a];
      areas_.push_back(sum += 0.5 * length(cross(mesh.vertices[b] - p, mesh.vertices[c] - p)));
    }
  }

  At next() {
    const auto found = std::lower_bound(areas_.begin(), areas_.end(), unit() * areas_.back());
    const auto facet = std::min(static_cast<std::size_t>(found - areas_.begin()), areas_.size() - 1);
    const auto& [a, b, c] = mesh_.facets[facet];
    const Point<Part> p = mesh_.vertices[a];
    const Vec3 ab = mesh_.vertices[b] - p, ac = mesh_.vertices[c] - p;
    double v = unit(), w = unit();
    if (v + w > 1.0) v = 1.0 - v, w = 1.0 - w;
    return {p + ab * v + ac * w, normalized(cross(ab, ac))};
  }

 private:
  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  const Mesh& mesh_;
  std::vector<double> areas_;  ///< of the facets up to and with this one
  std::mt19937_64 random_{20050101};
};

}  // namespace tiltfeed
