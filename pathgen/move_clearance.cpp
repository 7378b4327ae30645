#include "pathgen/move_clearance.h"

#include <algorithm>
#include <cmath>

#include "pathgen/facet_tree.h"
#include "pathgen/swept_tool.h"
#include "pathgen/tool_pieces.h"

namespace tiltfeed {
namespace {

/// Share of the tolerance by which the cutting part may seem to cut in where it touches.
constexpr double kSlackShare = 0.25;
/// A cylinder of radius r that steps by s leaves s^2 / (8 r) of a corner: a fifth of the tolerance at most.
constexpr double kStepShare = 8.0 * 0.2;

}  // namespace

MoveClearance::MoveClearance(const Mesh& mesh, const PlanOptions& options)
    : tree_(std::make_unique<FacetTree>(mesh)),
      tool_(std::make_unique<SweptTool>(*tree_, options, kSlackShare * options.tolerance)),
      up_(options.up),
      reference_height_(reference_height(options.cutter)),
      tilt_cosine_(std::cos(options.tilt_max.radians())),
      lever_(std::min(tool_->top(), distance(tree_->bounds().min, tree_->bounds().max))),
      step_(std::sqrt(kStepShare * tool_->ball() * options.tolerance)) {}

MoveClearance::~MoveClearance() = default;

bool MoveClearance::clear(const Pose& from, const Pose& to) const {
  std::uint32_t hint = kNoFacet;
  const double turn = angle_between(from.axis, to.axis), way = distance(from.tip, to.tip);
  const int steps = std::max(1, static_cast<int>(std::ceil((way + lever_ * turn) / step_)));
  for (int k = 0; k <= steps; ++k) {
    const double f = static_cast<double>(k) / steps;
    const Vec3 axis = slerp(from.axis, to.axis, f);
    if (dot(axis, up_) < tilt_cosine_) return false;
    const Point<Part> centre = lerp(from.tip, to.tip, f) + axis * reference_height_;
    if (tool_->stop(centre, axis, hint)) return false;
  }
  return true;
}

}  // namespace tiltfeed
