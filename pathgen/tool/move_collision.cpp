#include "pathgen/tool/move_collision.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/mesh/facet_bvh.h"
#include "pathgen/tool/swept_tool.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {
namespace {

/// Up to so many radii of the ball over the reference moves are checked pose by pose, further up by a bound.
constexpr double kBoundedFrom = 3.0;

/// How far up the tool, drawn back by `back`, anything of the part can be, mm.
double lever(const SweptTool& tool, double back) {
  const Box b = tool.bounds();
  return std::min(tool.top() + (std::isfinite(back) ? back : 0.0), distance(b.min, b.max));
}

}  // namespace

double least_cosine(Vec3 a, Vec3 b, Vec3 up) {
  const double ends = std::min(dot(a, up), dot(b, up));
  const Vec3 normal = cross(a, b);
  const Vec3 in_plane = up * squared_length(normal) - normal * dot(up, normal);
  const double away = length(in_plane);
  if (away == 0.0) return ends;
  const Vec3 lowest = in_plane * (-1.0 / away);
  const bool between = dot(cross(a, lowest), normal) > 0.0 && dot(cross(lowest, b), normal) > 0.0;
  return between ? std::min(ends, dot(lowest, up)) : ends;
}

bool clear_along(const SweptTool& tool, const TiltLimit& tilt, const ToolStand& a, const ToolStand& b,
                 double reference_height, double tolerance, std::uint32_t& hint, std::uint64_t& tested,
                 double back) {
  if (!tilt.allows(a.axis, b.axis)) return false;
  const double turn = angle_between(a.axis, b.axis), way = distance(a.centre, b.centre);
  const double from = kBoundedFrom * tool.ball();
  ++tested;
  const bool bounded = !tool.may_stop(lerp(a.centre, b.centre, 0.5), slerp(a.axis, b.axis, 0.5), way / 2.0,
                                      turn / 2.0, from, back);
  // A cylinder of radius r that steps by s leaves s^2 / (8 r) of a corner. But what comes in at the side of a
  // sharp lower end may leave through the bottom before the next pose: the end reaches down by what it moves
  // along the axis from one pose to the next.
  const double step = std::sqrt(8.0 * tool.ball() * ToleranceBudget(tolerance).corner());
  const int steps =
      std::max(1, static_cast<int>(std::ceil((way + (bounded ? from : lever(tool, back)) * turn) / step)));
  const double h = reference_height;
  const Vec3 moved = (b.centre - a.centre) / steps;
  const double fall = std::max(std::abs(dot(moved, a.axis)), std::abs(dot(moved, b.axis)));
  // The bound tells of what is higher than `from` where the tool stands half way; at the ends that may be
  // higher.
  const double to =
      bounded ? from + way / 2.0 + (from + tool.widest()) * turn : std::numeric_limits<double>::infinity();
  const Point<Part> tip_a = a.centre - a.axis * h, tip_b = b.centre - b.axis * h;
  for (int k = 0; k <= steps; ++k) {
    const double f = static_cast<double>(k) / steps;
    const Vec3 axis = slerp(a.axis, b.axis, f);
    const Point<Part> centre = lerp(tip_a, tip_b, f) + axis * h;
    ++tested;
    if (tool.stopped_below(centre, axis, to, fall, turn / steps, hint, back)) return false;
  }
  return true;
}

MoveCollision::MoveCollision(const Mesh& mesh, const PlanOptions& options)
    : tree_(std::make_unique<FacetBvh>(mesh)),
      tool_(std::make_unique<SweptTool>(*tree_, options, ToleranceBudget(options.tolerance).touch())),
      tilt_(options.up, options.tilt_max),
      reference_height_(reference_height(options.cutter)),
      tolerance_(options.tolerance) {}

MoveCollision::~MoveCollision() = default;

bool MoveCollision::clear(const Pose& from, const Pose& to) const {
  std::uint32_t hint = kNoFacet;
  std::uint64_t tested = 0;
  const auto stand = [this](const Pose& p) { return ToolStand{p.tip + p.axis * reference_height_, p.axis}; };
  return clear_along(*tool_, tilt_, stand(from), stand(to), reference_height_, tolerance_, hint, tested);
}

}  // namespace tiltfeed::pathgen
