#pragma once
// Holds a finished surface against its path by brute force: no reachable point of the part keeps more
// material than the two passes beside it must leave. Ball end mills, passes side by side in flat space.

#include <algorithm>
#include <cmath>
#include <vector>

#include "pathgen/options/plan_options.h"
#include "sim/solid/distance.h"
#include "tests/judges/ball_track.h"
#include "tests/judges/path_proof.h"
#include "tests/judges/surface_sample.h"

namespace tiltfeed {
using namespace pathgen;

struct Coverage {
  std::size_t points = 0;  ///< reachable, between two passes
  std::size_t steep = 0;   ///< of these: where passes are further apart along the wall than the radius
  std::size_t tight = 0;   ///< of the others: within the scallop of the nearer pass, on a plane
  std::size_t unreachable = 0, outside = 0;
  std::size_t uncut = 0;  ///< more left than the two passes beside it must leave, by over the tolerance
  double worst_excess = -sim::kInfinity;
  Point<Part> worst_at;
};

class CoverProof {
 public:
  /// All must outlive the proof. Requires: a ball end mill, PatternKind::kRaster, no allowance.
  CoverProof(const PlanOptions& options, const CheckedMesh& checked, const ToolPath& path,
             const PathProof& proof)
      : options_(options),
        mesh_(checked.mesh),
        path_(path),
        proof_(proof),
        radius_(options.cutter.radius()) {}

  /// At random points, spread evenly over the part.
  Coverage cover(int surface_points) const {
    const sim::PartDistance swept(ball_track(path_, radius_));
    const std::vector<double> places = pass_places();
    SurfaceSample surface(mesh_);
    Coverage c;
    for (int i = 0; i < surface_points; ++i) {
      const SurfaceSample::At at = surface.next();
      cover_point(at.point, at.normal, places, swept, c);
    }
    return c;
  }

 private:
  /// A ball placed on a facet's normal is off by the rounding of its coordinates, mm.
  static constexpr double kRounding = 1e-6;
  /// Rounding of a flat coordinate, of the proof's own scale.
  static constexpr double kGraze = 1e-7;
  /// Walls steeper than 85 degrees against the axis are counted as steep.
  static constexpr double kLeastFacing = 0.0872;

  const sim::PartDistance& part() const { return proof_.part(); }
  const Deformation& map() const { return proof_.map(); }
  bool along_x() const { return options_.pattern.along == Along::kX; }
  double across(Point<Flat> f) const { return along_x() ? f.y : f.x; }

  /// Where the passes lie, in flat coordinates of this proof's own scale, ascending. Moves from one pass to
  /// the next are none: they change their place across.
  std::vector<double> pass_places() const {
    std::vector<double> places, distinct;
    double last = sim::kInfinity;
    for (const Move& move : path_.moves) {
      const double place = across(map().flatten(move.pose.tip + move.pose.axis * radius_));
      if (move.kind == MoveKind::kCut && std::abs(place - last) <= kGraze) places.push_back(place);
      last = place;
    }
    std::sort(places.begin(), places.end());
    for (const double p : places)
      if (distinct.empty() || p > distinct.back() + 1e-7) distinct.push_back(p);
    return distinct;
  }

  /// A pass ends at its last point within the limit; between two points the axis turns by (E5) at most.
  bool tilts(Vec3 axis) const {
    const double turn = std::sqrt(8.0 * options_.tolerance / options_.cutter.shank_length);
    const double limit = options_.tilt_max.radians();
    return limit >= kPi || angle_between(axis, options_.up) <= limit - turn;
  }

  /// The tool can stand there: nothing in the way of ball and shank, up to the axis feature or out of the
  /// part, and the head tilts that far.
  bool reachable(Point<Part> centre, Vec3 axis) const {
    if (!tilts(axis)) return false;
    const sim::Hit hit =
        part().nearest({centre, centre + axis * proof_.way_out(centre)}, radius_ - kRounding);
    return hit.facet == kNoFacet;
  }

  /// What a ball leaves at p when it stands on the true envelope (let down from beyond the part) beside it,
  /// where a pass lies at `place` across; infinite if there is nothing to stand on. Where the ball grazes a
  /// wall, rounding alone says on which side of the wall's edge it stands: the worse one counts.
  double left_by_pass(Point<Part> p, Point<Flat> flat, double place) const {
    double most = 0.0;
    for (const double shift : {0.0, kGraze, -kGraze}) {
      const AxisLine line =
          along_x() ? map().axis_line(flat.x + shift, place) : map().axis_line(place, flat.y + shift);
      if (!tilts(line.axis)) return sim::kInfinity;
      const Point<Part> level = line.base + line.axis * flat.z;
      const Point<Part> start = level + line.axis * proof_.way_out(level);
      const sim::Hit drop = part().first_touch(start, -line.axis, radius_);
      if (drop.value == sim::kInfinity) return sim::kInfinity;
      most = std::max(most, distance(p, start - line.axis * drop.value) - radius_);
    }
    return most;
  }

  void cover_point(Point<Part> p, Vec3 normal, const std::vector<double>& places,
                   const sim::PartDistance& swept, Coverage& c) const {
    const Point<Part> centre = p + normal * radius_;
    const Vec3 axis = map().axis_at(centre);
    if (!reachable(centre, axis)) return void(++c.unreachable);
    const Point<Flat> flat = map().flatten(centre);
    const auto above = std::lower_bound(places.begin(), places.end(), across(flat));
    if (above == places.begin() || above == places.end()) return void(++c.outside);
    // A small step across the passes shows their direction and true distance there.
    constexpr double kStep = 1e-5;
    const Point<Flat> beside =
        along_x() ? Point<Flat>{flat.x, flat.y + kStep, flat.z} : Point<Flat>{flat.x + kStep, flat.y, flat.z};
    const Vec3 sideways = map().unflatten(beside) - map().unflatten(flat);
    const double true_length = length(sideways) / kStep;
    const double facing = std::abs(dot(axis, normal));
    const double slope_cosine = facing / std::hypot(facing, dot(normalized(sideways), normal));
    const double must_leave = std::min(left_by_pass(p, flat, above[-1]), left_by_pass(p, flat, *above));
    if (must_leave == sim::kInfinity) return void(++c.outside);
    ++c.points;
    const double left = swept.nearest(p).value - radius_;
    const double near = std::min(across(flat) - above[-1], *above - across(flat)) * true_length;
    if (facing < kLeastFacing || near / slope_cosine > radius_) {
      ++c.steep;
    } else if (left <= std::hypot(radius_, near / slope_cosine) - radius_ + options_.tolerance) {
      ++c.tight;
    }
    const double excess = left - must_leave - options_.tolerance;
    if (excess > c.worst_excess) c.worst_excess = excess, c.worst_at = p;
    if (excess > 0.0) ++c.uncut;
  }

  const PlanOptions& options_;
  const Mesh& mesh_;
  const ToolPath& path_;
  const PathProof& proof_;
  double radius_;
};

}  // namespace tiltfeed
