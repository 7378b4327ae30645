#include "sim/removal/tool_sweep.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::sim {
namespace {

// Length of a piece of a round cutter, in its radii.
constexpr double kPieceRadii = 2.0;

}  // namespace

Vec3 mean_axis(const Pose& a, const Pose& b) {
  const Vec3 sum = a.axis + b.axis;
  return squared_length(sum) > 0.0 ? normalized(sum) : a.axis;
}

Cube cube_at(Point<Part> p, double side) {
  const double per_mm = 1.0 / side;
  const auto whole = [&](double mm) { return static_cast<std::int64_t>(std::floor(mm * per_mm)); };
  return {whole(p.x), whole(p.y), whole(p.z)};
}

ToolSweep::ToolSweep(const pathgen::Cutter& cutter)
    : solid_(cutter), round_(cutter.type == pathgen::CutterType::kBall) {
  reach_ = solid_.cutting().widest();
  // The capsule is rounded at its upper end, too, and ends where the cutting part does.
  const double top = cutter.cutting_end();
  core_low_ = round_ ? reach_ : 0.0;
  core_high_ = std::max(core_low_, round_ ? top - reach_ : top);
  step_ = kPieceRadii * reach_;
  longest_ = round_ ? 2.0 * step_ : core_high_;
  for (const ToolPart part : {ToolPart::kShank, ToolPart::kHolder})
    for (const Revolved& solid : solid_.pieces(part))
      longest_ = std::max(longest_, solid.corners().back().h - solid.corners().front().h);
}

SweptBody ToolSweep::piece(const Pose& from, const Pose& to, double low, double high) const {
  const Vec3 axis = mean_axis(from, to);
  const double middle = 0.5 * (low + high);
  const Point<Part> start = from.tip + from.axis * middle, end = to.tip + to.axis * middle;
  return SweptBody::round(start + axis * (low - middle), axis * (high - low), end - start, reach_,
                          ToolPart::kCutter);
}

void ToolSweep::rest_bodies(const Pose& from, const Pose& to, std::vector<SweptBody>& out) const {
  for (const ToolPart part : {ToolPart::kShank, ToolPart::kHolder}) solid_bodies(part, from, to, out);
}

void ToolSweep::solid_bodies(ToolPart part, const Pose& from, const Pose& to,
                             std::vector<SweptBody>& out) const {
  const Vec3 axis = mean_axis(from, to);
  for (const Revolved& solid : solid_.pieces(part)) {
    const double middle =
        part == ToolPart::kCutter ? 0.0 : 0.5 * (solid.corners().front().h + solid.corners().back().h);
    const Point<Part> start = from.tip + from.axis * middle, end = to.tip + to.axis * middle;
    out.push_back(SweptBody::revolved(solid, {start - axis * middle, axis}, end - start, part));
  }
}

SweptBody ToolSweep::cutter_near(const Pose& from, const Pose& to, Point<Part> p) const {
  const Vec3 axis = mean_axis(from, to);
  const double h = dot(p - lerp(from.tip, to.tip, 0.5), axis);
  if (!round_) {
    const double middle = std::clamp(h, 0.0, core_high_);
    const Point<Part> start = from.tip + from.axis * middle, end = to.tip + to.axis * middle;
    return SweptBody::revolved(solid_.pieces(ToolPart::kCutter).front(), {start - axis * middle, axis},
                               end - start, ToolPart::kCutter);
  }
  const double low = std::clamp(h - step_, core_low_, core_high_);
  const double high = std::clamp(h + step_, core_low_, core_high_);
  const SweptBody body = piece(from, to, low, high);
  // The ball is passed by itself, along its exact way.
  return low == core_low_ ? body.without_ball() : body;
}

}  // namespace tiltfeed::sim
