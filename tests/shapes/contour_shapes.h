#pragma once
// Shapes whose contours are known in closed form, and the ball let down on them by search: no patches, no
// cells, no closed forms in common with the planner.

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "kinematics/basics/units.h"
#include "pathgen/envelope/heights.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed {
using namespace pathgen;

inline constexpr double kBallRadius = 2.0;  ///< of the ball, mm

struct Shapes {
  Mesh mesh;

  void facet(Point<Part> a, Point<Part> b, Point<Part> c) {
    mesh.source.push_back(static_cast<std::uint32_t>(mesh.facets.size()));
    mesh.facets.push_back({vertex(a), vertex(b), vertex(c)});
  }
  /// Places that differ by rounding only are one.
  std::uint32_t vertex(Point<Part> p) {
    const auto whole = [](double v) { return std::llround(v * 1e6); };
    const auto [known, fresh] = known_.try_emplace({whole(p.x), whole(p.y), whole(p.z)},
                                                   static_cast<std::uint32_t>(mesh.vertices.size()));
    if (fresh) mesh.vertices.push_back(p);
    return known->second;
  }
  void quad(Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) { facet(a, b, c), facet(a, c, d); }

  void floor(double x0, double y0, double x1, double y1, double z) {
    quad({x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z});
  }
  /// Closed, but for its bottom.
  void box(double x0, double y0, double x1, double y1, double z0, double z1) {
    floor(x0, y0, x1, y1, z1);
    const auto wall = [&](double ax, double ay, double bx, double by) {
      quad({ax, ay, z0}, {bx, by, z0}, {bx, by, z1}, {ax, ay, z1});
    };
    wall(x0, y0, x1, y0), wall(x1, y0, x1, y1), wall(x1, y1, x0, y1), wall(x0, y1, x0, y0);
  }
  /// The profile (r, z) turned round the axis through (x, y); outside is on the left of the profile.
  void revolve(double x, double y, const std::vector<std::array<double, 2>>& profile, int count) {
    const auto at = [&](std::size_t k, int i) {
      const double turn = 2.0 * kPi * i / count;
      return Point<Part>{x + profile[k][0] * std::cos(turn), y + profile[k][0] * std::sin(turn),
                         profile[k][1]};
    };
    for (std::size_t k = 0; k + 1 < profile.size(); ++k)
      for (int i = 0; i < count; ++i) {
        if (profile[k][0] > 0.0) facet(at(k, i), at(k, i + 1), at(k + 1, i));
        if (profile[k + 1][0] > 0.0) facet(at(k, i + 1), at(k + 1, i + 1), at(k + 1, i));
      }
  }
  /// From (r + radius, z) over the top: a dome (r = 0) or, with `whole`, a bead of radius `radius` on a ring
  /// r.
  void bead(double x, double y, double r, double radius, double z, bool whole, int count) {
    std::vector<std::array<double, 2>> profile;
    const int steps = whole ? 48 : 32;
    for (int k = 0; k <= steps; ++k) {
      const double turn = (whole ? kPi : kPi / 2.0) * k / steps;
      profile.push_back({r + radius * std::cos(turn), z + radius * std::sin(turn)});
    }
    if (!whole) profile.back()[0] = r;
    revolve(x, y, profile, count);
  }

 private:
  std::map<std::array<long long, 3>, std::uint32_t> known_;
};

inline PlanOptions ball(double diameter) {
  PlanOptions options;
  options.cutter.diameter = diameter, options.cutter.length = 60.0, options.cutter.shank_length = 40.0;
  return options;
}

/// `scale`: R of the maths. The mesh must outlive it.
inline std::unique_ptr<const ClField> field_over(const Mesh& mesh, const AxisFrame& frame, double diameter,
                                                 double scale = 1.0) {
  ClSurface surface(mesh, Sides::kOutward, tool_pieces(ball(diameter)));
  const Deformation map(frame, scale);
  FlatIndex index(make_flat_hulls(surface, map, 0.5), map);
  const FlatBounds bounds = index.bounds();
  return std::make_unique<const ClField>(ClField{std::move(surface), map, std::move(index), bounds});
}

/// Largest value of a concave function on [0, 1].
template <class Function>
double largest(Function f) {
  const double golden = 0.6180339887498949;
  double low = 0.0, high = 1.0, a = 1.0 - golden, b = golden, fa = f(a), fb = f(b);
  for (int i = 0; i < 32; ++i) {
    if (fa < fb) {
      low = a, a = b, fa = fb, b = low + golden * (high - low), fb = f(b);
    } else {
      high = b, b = a, fb = fa, a = high - golden * (high - low), fa = f(a);
    }
  }
  return std::max(fa, fb);
}

/// z' of the centre of a ball let down on the axis line until it meets the mesh; kNoSurface if it comes to
/// `least` without meeting it.
inline double let_down(const Mesh& mesh, const AxisLine& line, double radius, double least) {
  // No point of a facet holds the ball higher than `bound`.
  struct Near {
    double bound;
    Vec3 a, b, c;
  };
  std::vector<Near> near;
  for (const auto& f : mesh.facets) {
    const Vec3 a = mesh.vertices[f[0]] - line.base, b = mesh.vertices[f[1]] - line.base,
               c = mesh.vertices[f[2]] - line.base;
    const Vec3 middle = (a + b + c) / 3.0;
    const double size = std::max({length(a - middle), length(b - middle), length(c - middle)});
    const double height = dot(middle, line.axis);
    const double beside = std::max(0.0, length(middle - line.axis * height) - size);
    if (height < 0.0 || beside > radius) continue;
    const double bound = std::max({dot(a, line.axis), dot(b, line.axis), dot(c, line.axis)}) +
                         std::sqrt(radius * radius - beside * beside);
    if (bound >= least) near.push_back({bound, a, b, c});
  }
  std::sort(near.begin(), near.end(), [](const Near& p, const Near& q) { return p.bound > q.bound; });
  double top = kNoSurface;
  for (const Near& facet : near) {
    if (facet.bound <= top) break;
    const Vec3 &a = facet.a, &b = facet.b, &c = facet.c;
    // Beyond the ball the height falls steeply, which keeps the function concave.
    const auto over = [&](double s, double t) {
      const Vec3 p = a + ((b + (c - b) * t) - a) * s;
      const double h = dot(p, line.axis), d = length(p - line.axis * h);
      return d <= radius ? h + std::sqrt(radius * radius - d * d) : h - 1e8 * (d - radius);
    };
    top = std::max(top, largest([&](double s) { return largest([&](double t) { return over(s, t); }); }));
  }
  return top < least ? kNoSurface : top;
}

}  // namespace tiltfeed
