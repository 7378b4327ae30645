#include "pathgen/mesh/winding_number.h"

#include <cmath>

#include "kinematics/basics/units.h"

namespace tiltfeed::pathgen {

namespace {

/// The sum of many angles, each of the place (x, y) from the x axis: the places are multiplied as complex
/// numbers, and turns counted where the product comes past the negative x axis.
class AngleSum {
 public:
  void add(double x, double y) {
    if (y == 0.0 && x >= 0.0) return;
    const double re = re_ * x - im_ * y, im = re_ * y + im_ * x;
    const bool was_below = std::signbit(im_), is_below = std::signbit(im);
    if (y >= 0.0 && !was_below && is_below) ++turns_;
    if (y < 0.0 && was_below && !is_below) --turns_;
    re_ = re, im_ = im;
    // Neither too large nor too small for the next.
    if (const double size = std::abs(re) + std::abs(im); size > kLarge || size < 1.0 / kLarge)
      re_ /= size, im_ /= size;
  }
  double sum() const { return std::atan2(im_, re_) + 2.0 * kPi * turns_; }

 private:
  static constexpr double kLarge = 1e100;
  double re_ = 1.0, im_ = 0.0, turns_ = 0.0;
};

}  // namespace

double winding_number(const Mesh& mesh, Point<Part> p) {
  AngleSum halves;
  for (const auto& f : mesh.facets) {
    const Vec3 a = mesh.vertices[f[0]] - p, b = mesh.vertices[f[1]] - p, c = mesh.vertices[f[2]] - p;
    const double la = length(a), lb = length(b), lc = length(c);
    halves.add(la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb, dot(a, cross(b, c)));
  }
  return halves.sum() / (2.0 * kPi);
}

}  // namespace tiltfeed::pathgen
