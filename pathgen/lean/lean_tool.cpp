#include "pathgen/lean/lean_tool.h"

#include <algorithm>
#include <cmath>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/options/axis_step.h"

namespace tiltfeed::pathgen {

namespace {

/// The normal where the cone touches leans from the side by its half-angle: to this sine.
constexpr double kOnCone = 1e-6;
/// Of the tolerance: moves are looked at in steps that leave this of a corner. A tool that leans no further
/// than it must has no room for more.
constexpr double kStepShare = 1.0 / 9.0;
/// So far (mm) the end of a rapid is found.
constexpr double kRapidStep = 0.01;
/// A move on the mode's axis is asked in pieces as long as so many radii: bounds tell of those.
constexpr double kPiece = 1.0;
/// The lean is below 90 degrees; the way back grows with it by this much at most.
constexpr double kLeastCosine = 0.1;

PlanOptions grown_by_approach(PlanOptions options) {
  options.allowance += options.links.approach;
  return options;
}

double flank(const PlanOptions& options) { return ToleranceBudget(options.tolerance).flank(); }

}  // namespace

LeanTool::LeanTool(const Mesh& part, const PlanOptions& options, const Deformation& map, double clearance_z)
    : options_(options),
      map_(map),
      clearance_z_(clearance_z),
      largest_turn_(largest_axis_step(options)),
      reference_height_(reference_height(options.cutter)),
      tolerance_(kStepShare * options.tolerance),
      step_(std::sqrt(8.0 * (options.cutter.radius() + options.allowance) *
                      ToleranceBudget(tolerance_).corner())),
      tree_(part),
      tool_(tree_, options, flank(options), HeldPieces::kAll),
      guards_(tree_, options, 0.0, HeldPieces::kBesidesCutter),
      grown_(tree_, grown_by_approach(options), flank(options), HeldPieces::kAll),
      tilt_(options.up, options.tilt_max) {}

double LeanTool::way_back(const EnvelopePoint& p, Vec3 axis) const {
  return std::max(0.0, clearance_z_ - p.flat.z) / std::max(kLeastCosine, dot(axis, map_.axis_at(p.centre)));
}

std::optional<Blocker> LeanTool::held(const EnvelopePoint& p, std::uint32_t& hint) const {
  return guards_.stop(p.centre, p.axis, hint, kWithFixtures, way_back(p, p.axis));
}

bool LeanTool::clear_upright(const EnvelopePoint& p, Vec3 before, Vec3 ahead, std::uint32_t& hint) const {
  const double fall = step_ * std::max(std::abs(dot(before, p.axis)), std::abs(dot(ahead, p.axis)));
  return !guards_.stopped_below(p.centre, p.axis, kForEver, fall, 0.0, hint, way_back(p, p.axis));
}

bool LeanTool::clear_upright(const EnvelopePoint& a, const EnvelopePoint& b, std::uint32_t& hint) const {
  const double back = std::max(way_back(a, a.axis), way_back(b, b.axis));
  const double pieces =
      std::max(1.0, std::ceil(distance(a.centre, b.centre) / (kPiece * options_.cutter.radius())));
  std::uint64_t tested = 0;
  ToolStand from{a.centre, a.axis};
  for (double k = 1.0; k <= pieces; ++k) {
    const ToolStand to{lerp(a.centre, b.centre, k / pieces), slerp(a.axis, b.axis, k / pieces)};
    // The limit of the tilt is that of the passes, not asked again.
    if (!clear_along(guards_, TiltLimit(options_.up, Angle::from_degrees(180.0)), from, to, reference_height_,
                     tolerance_, hint, tested, back))
      return false;
    from = to;
  }
  return true;
}

bool LeanTool::touches_with_ball(const EnvelopePoint& p) const {
  return options_.cutter.type != CutterType::kTaperBall ||
         dot(p.normal, p.axis) > std::sin(options_.cutter.taper.radians()) + kOnCone;
}

bool LeanTool::clear(const EnvelopePoint& p, Vec3 axis, Vec3 before, Vec3 ahead, std::uint32_t& hint) const {
  if (!tilt_.allows(axis)) return false;
  const double back = way_back(p, axis);
  // A join may go on from there any way over the surface.
  const double aslant = length(cross(axis, p.axis));
  const double fall = step_ * std::max({std::abs(dot(before, axis)), std::abs(dot(ahead, axis)), aslant});
  return !tool_.stopped_below(p.centre, axis, kForEver, fall, step_ / (tool_.top() + back), hint, back);
}

bool LeanTool::clear(const EnvelopePoint& a, Vec3 from, const EnvelopePoint& b, Vec3 to,
                     std::uint32_t& hint) const {
  std::uint64_t tested = 0;
  return clear_along(tool_, tilt_, {a.centre, from}, {b.centre, to}, reference_height_, tolerance_, hint,
                     tested, std::max(way_back(a, from), way_back(b, to)));
}

bool LeanTool::clear_off_part(const ToolStand& from, const ToolStand& to) const {
  if (!tilt_.allows(from.axis, to.axis)) return false;
  const double way =
      distance(from.centre, to.centre) + (tool_.top() + tool_.widest()) * angle_between(from.axis, to.axis);
  const double steps = std::max(1.0, std::ceil(way / step_));
  const Point<Part> tip_a = from.centre - from.axis * reference_height_,
                    tip_b = to.centre - to.axis * reference_height_;
  for (double k = 0.0; k <= steps; ++k) {
    const Vec3 axis = slerp(from.axis, to.axis, k / steps);
    if (tool_.hit(lerp(tip_a, tip_b, k / steps) + axis * reference_height_, axis)) return false;
  }
  return true;
}

double LeanTool::rapid_end(const EnvelopePoint& p, Vec3 axis) const {
  const double back = way_back(p, axis);
  const auto clear_over = [&](double over) {
    const Point<Part> centre = p.centre + axis * over;
    std::uint32_t hint = kNoFacet;
    return !grown_.hit(centre, axis) && !grown_.stop(centre, axis, hint, kWithFixtures, back - over);
  };
  double low = std::min(options_.links.approach, back), high = back;
  if (clear_over(low)) return low;
  while (high - low > kRapidStep) (clear_over((low + high) / 2.0) ? high : low) = (low + high) / 2.0;
  return high;
}

}  // namespace tiltfeed::pathgen
