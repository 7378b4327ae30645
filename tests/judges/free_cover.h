#pragma once
// How much of what a tool can reach a path has machined, by brute force: random points of the part, each
// judged by tests/judges/reach.h, and by what the ball's true track leaves there against what passes one step
// apart must leave. Ball end mills.

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/judges/ball_track.h"
#include "tests/judges/reach.h"
#include "tests/judges/surface_sample.h"

namespace tiltfeed {
using namespace pathgen;

/// The nearest point of a facet [Ericson 2005, 5.1.5], by its three regions of edges when it is not inside.
inline Point<Part> nearest_on_facet(const Mesh& mesh, std::uint32_t facet, Point<Part> p) {
  const auto& [i, j, k] = mesh.facets[facet];
  const Point<Part> corner[3] = {mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]};
  const Vec3 n = normalized(cross(corner[1] - corner[0], corner[2] - corner[0]));
  const Point<Part> foot = p - n * dot(p - corner[0], n);
  bool inside = true;
  Point<Part> best = corner[0];
  for (int e = 0; e < 3; ++e) {
    const Point<Part> a = corner[e], b = corner[(e + 1) % 3];
    inside = inside && dot(cross(b - a, foot - a), n) >= 0.0;
    const Point<Part> at = lerp(a, b, std::clamp(dot(p - a, b - a) / squared_length(b - a), 0.0, 1.0));
    if (distance(p, at) < distance(p, best)) best = at;
  }
  return inside ? foot : best;
}

/// How the distance of neighbouring passes is measured.
enum class PassStep {
  kPlanes,  ///< between the planes they lie in
  kSurface  ///< along the surface of ball centres
};

struct FreeCoverage {
  std::size_t reachable = 0, machined = 0;  ///< points; what is machined counts only where it is reachable
  std::size_t border = 0;   ///< of those not machined: no pass can lie beside them within a step
  std::size_t shallow = 0;  ///< of those not machined: planes that far apart cannot step there
  std::size_t no_seat = 0, no_direction = 0;  ///< not reachable: the ball does not fit, or no direction does
  double worst_excess = 0.0;
  Point<Part> worst_at;
  double share() const {
    const std::size_t asked = reachable - border - shallow;
    return asked > 0 ? static_cast<double>(machined) / static_cast<double>(asked) : 0.0;
  }
};

class FreeCover {
 public:
  /// All must outlive the object. `across`: the normals of the stacks of planes, unit: each place is cut by
  /// the stack whose normal is the furthest from the surface's; empty: passes run anyhow. `step`: between two
  /// passes, mm.
  FreeCover(const Mesh& mesh, const sim::PartDistance& part, const Reach& reach, std::vector<Vec3> across,
            PassStep kind, double step, double tolerance)
      : mesh_(mesh),
        part_(part),
        reach_(reach),
        across_(std::move(across)),
        kind_(kind),
        step_(step),
        tolerance_(tolerance) {}

  FreeCoverage cover(const ToolPath& path, int surface_points) const {
    const sim::PartDistance track(ball_track(path, reach_.radius()));
    SurfaceSample surface(mesh_);
    FreeCoverage c;
    for (int i = 0; i < surface_points; ++i) {
      const SurfaceSample::At at = surface.next();
      cover_point(at, track, c);
    }
    return c;
  }

 private:
  static constexpr int kPhases = 8;  ///< where in a step the passes beside a point may lie
  /// Flatter against the planes than this (sine), a ball does not roll on to the next of them.
  static constexpr double kShallow = 0.1;
  static constexpr double kSettled = 1e-6;  ///< of a centre on the surface of centres, mm

  struct Place {
    Point<Part> centre;
    Vec3 normal;
  };

  /// The ball rolls from `seat` over the part towards `along`: where it is at each phase of a step; shorter
  /// where it does not get that far.
  std::vector<Place> roll(Place at, Vec3 along) const {
    constexpr int kFine = 4;  // places for each phase
    std::vector<Place> places;
    const double stride = step_ / kPhases / kFine;
    double gone = 0.0;
    for (int k = 0; k < kPhases * kFine * 12 && places.size() < kPhases; ++k) {
      const Vec3 tangent = along - at.normal * dot(along, at.normal);
      const double sine = length(tangent);
      if (sine < kShallow) break;
      const Point<Part> before = at.centre;
      at.centre = at.centre + tangent * (stride / sine);
      for (int pull = 0; pull < 6; ++pull) {
        const sim::Hit hit = part_.nearest(at.centre);
        if (std::abs(hit.value - reach_.radius()) < kSettled) break;
        at.normal = normalized(at.centre - nearest_on_facet(mesh_, hit.facet, at.centre));
        at.centre = at.centre + at.normal * (reach_.radius() - hit.value);
      }
      const Vec3 moved = at.centre - before;
      gone += kind_ == PassStep::kPlanes ? dot(moved, along) : length(moved);
      while (places.size() < kPhases &&
             gone >= step_ * static_cast<double>(places.size() + 1) / kPhases - kSettled)
        places.push_back(at);
    }
    return places;
  }

  double left(Point<Part> p, const Place& ball) const { return distance(p, ball.centre) - reach_.radius(); }

  /// The directions across the passes that may lie at a place: those of the stack that cuts it, and of others
  /// that may cut the surface beside it; or every 45 degrees.
  std::vector<Vec3> crossings(Vec3 normal) const {
    constexpr double kNearlyAsSteep = 0.1;
    std::vector<Vec3> found;
    if (across_.empty()) {
      const Vec3 u = normalized(cross(std::abs(normal.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0}, normal));
      for (int k = 0; k < 4; ++k) found.push_back(rotation_about(normal, kPi / 4 * k) * u);
      return found;
    }
    double least = 1.0;
    for (const Vec3 n : across_) least = std::min(least, std::abs(dot(n, normal)));
    for (const Vec3 n : across_)
      if (std::abs(dot(n, normal)) <= least + kNearlyAsSteep) found.push_back(n);
    return found;
  }

  /// The most that passes one step apart must leave at p, wherever they lie; infinite where none can lie
  /// beside p. `only_reachable`: passes lie only where the tool can stand.
  double must_leave(Point<Part> p, const Place& seat, bool only_reachable) const {
    const auto cost = [&](const std::vector<Place>& places) {
      std::vector<double> leaves(kPhases + 1, sim::kInfinity);
      leaves[0] = left(p, seat);
      for (std::size_t i = 0; i < places.size(); ++i)
        if (!only_reachable || reach_.direction_at(places[i].centre, places[i].normal))
          leaves[i + 1] = left(p, places[i]);
      return leaves;
    };
    double most = 0.0;
    for (const Vec3 across : crossings(seat.normal)) {
      const std::vector<double> up = cost(roll(seat, across)), down = cost(roll(seat, -across));
      for (int k = 0; k <= kPhases; ++k) most = std::max(most, std::min(up[k], down[kPhases - k]));
    }
    return most;
  }

  void cover_point(const SurfaceSample::At& at, const sim::PartDistance& track, FreeCoverage& c) const {
    const auto centre = reach_.seat(at.point, at.normal);
    if (!centre) return void(++c.no_seat);
    if (!reach_.direction_at(*centre, at.normal)) return void(++c.no_direction);
    ++c.reachable;
    const Place seat{*centre, at.normal};
    const double is_left = track.nearest(at.point).value - reach_.radius();
    const double most = must_leave(at.point, seat, false);
    if (is_left <= most + tolerance_ && most < sim::kInfinity) return void(++c.machined);
    if (is_left <= 2.0 * tolerance_) return void(++c.machined);
    if (most == sim::kInfinity) return void(++c.shallow);
    if (is_left <= must_leave(at.point, seat, true) + tolerance_) return void(++c.border);
    const double excess = is_left - most - tolerance_;
    if (excess > c.worst_excess) c.worst_excess = excess, c.worst_at = at.point;
  }

  const Mesh& mesh_;
  const sim::PartDistance& part_;
  const Reach& reach_;
  std::vector<Vec3> across_;
  PassStep kind_;
  double step_, tolerance_;
};

}  // namespace tiltfeed
