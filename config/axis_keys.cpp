#include <cmath>

#include "config/description.h"
#include "config/enum_words.h"
#include "config/job.h"
#include "config/job_keys.h"
#include "config/key_ranges.h"

namespace tiltfeed::config {
namespace {

constexpr Range kCircleRadius = above(0.0, 10'000.0);  // mm

/// t unit; n made perpendicular to it when it is so within kPerpendicularTolerance, else an error.
void read_directions(const Section& axis, pathgen::AxisFrame& frame) {
  frame.t = axis.direction("t", frame.t);
  const Vec3 n = axis.direction("n", frame.n);
  const double angle = angle_between(frame.t, n);
  if (std::abs(angle - kPi / 2.0) > kPerpendicularTolerance) {
    axis.complain(axis.has("n") ? "n" : "t",
                  "t and n are " + exact_text(Angle::from_radians(angle).degrees()) +
                      " degrees apart; expected 90 within " + exact_text(kPerpendicularTolerance) + " rad");
    return;
  }
  // Once leaves an error of the order of the rounding of n; twice is exact to the last digit.
  const Vec3 once = normalized(n - dot(n, frame.t) * frame.t);
  frame.n = normalized(once - dot(once, frame.t) * frame.t);
}

constexpr Range kLeanLimit{0.0, 60.0};  // degrees

void read_lean(const Section& axis, pathgen::PlanOptions& plan) {
  plan.lean.limit = Angle::from_degrees(axis.number("lean_limit_deg", kLeanLimit, 0.0));
  if (plan.lean.limit.radians() <= 0.0) {
    axis.unused("max_turn_deg_per_mm", "without lean_limit_deg, which lets the tool lean from the axis");
    return;
  }
  plan.lean.max_turn = Angle::from_degrees(axis.number("max_turn_deg_per_mm", kMaxTurn, 0.0));
  if (plan.cutter.type != pathgen::CutterType::kBall && plan.cutter.type != pathgen::CutterType::kTaperBall)
    axis.complain("lean_limit_deg",
                  "a cutter that leans touches elsewhere unless it ends in a ball; expected 0, or the cutter "
                  "type ball or taper_ball");
}

}  // namespace

void read_axis(const Section& root, pathgen::PlanOptions& plan) {
  const Section axis =
      root.section("axis", {"mode", "sense", "origin_mm", "t", "n", "circle_radius_mm", "plane_normals",
                            "lead_deg", "lean_deg", "lean_limit_deg", "smoothing_mm", "max_turn_deg_per_mm",
                            "most_directions", "coverage_percent", "least_gain_percent", "steepest_deg"});
  pathgen::AxisFrame& frame = plan.axis;
  frame.mode = axis.choice<pathgen::AxisMode>("mode", kModeWords);
  const std::string mode = word(kModeWords, frame.mode);
  if (frame.mode != pathgen::AxisMode::kIndexed)
    for (const char* key : {"most_directions", "coverage_percent", "least_gain_percent", "steepest_deg"})
      axis.unused(key, "in the mode " + mode + ", only in indexed");
  if (frame.mode == pathgen::AxisMode::kIndexed) {
    for (const char* key : {"sense", "origin_mm", "t", "n", "circle_radius_mm", "plane_normals", "lead_deg",
                            "lean_deg", "lean_limit_deg", "smoothing_mm", "max_turn_deg_per_mm"})
      axis.unused(key, "in the mode indexed, where a few fixed directions are chosen");
    read_indexed_axis(root, axis, plan.indexed, plan.cutter);
    return;
  }
  if (frame.mode == pathgen::AxisMode::kFree) {
    for (const char* key : {"sense", "origin_mm", "t", "n", "circle_radius_mm", "lean_limit_deg"})
      axis.unused(key, "in the mode free, where the tool axis is chosen at every point");
    read_free_axis(root, axis, plan.free, plan.cutter);
    return;
  }
  for (const char* key : {"plane_normals", "lead_deg", "lean_deg", "smoothing_mm"})
    axis.unused(key, "in the mode " + mode + ", only in free");
  read_lean(axis, plan);
  if (frame.mode != pathgen::AxisMode::kFixed)
    frame.sense = axis.choice<pathgen::Sense>("sense", kSenseWords);
  else
    axis.unused("sense", "in the mode fixed, where the shank points along n");
  const Vec3 origin = axis.vector("origin_mm", kPartPlace, Vec3{});
  frame.origin = {origin.x, origin.y, origin.z};
  read_directions(axis, frame);
  if (frame.mode == pathgen::AxisMode::kCircle)
    frame.circle_radius = axis.number("circle_radius_mm", kCircleRadius);
  else
    axis.unused("circle_radius_mm", "in the mode " + mode + ", only in circle");
}

}  // namespace tiltfeed::config
