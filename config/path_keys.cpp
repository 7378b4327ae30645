#include "config/description.h"
#include "config/enum_words.h"
#include "config/job_keys.h"
#include "config/key_ranges.h"
#include "pathgen/options/side_step.h"

namespace tiltfeed::config {
namespace {

constexpr Range kTolerance{
    1e-4, 1.0, false, false,
    "the corners in an STL are 32-bit numbers, up to 0.00003 mm off at a metre from its "
    "zero, and programs print 4 decimals: anything finer would follow that noise"};
constexpr Range kStock{0.0, 50.0};                     // mm
constexpr Range kRest{0.01, 50.0};                     // mm
constexpr Range kHeightOverPart = above(0.0, 1000.0);  // mm
constexpr Range kGuard{0.0, 100.0};                    // mm
constexpr Range kLinkLength{0.0, 1000.0};              // mm
constexpr Range kLeadRadius{0.0, 100.0};               // mm
constexpr int kMostRounds = 1000;
constexpr double kMaxPointDistance = 1000.0;  // mm
constexpr double kMaxPointTurn = 90.0;        // degrees
constexpr Range kAxisTolerance{0.0, 10.0};    // degrees
constexpr Range kCalm{0.0, 30.0};             // degrees
/// Closer points than these, mm and degrees, are more than a control can read and a drive can follow.
constexpr double kLeastPointStep = 0.001;

void read_stock(const Section& root, pathgen::PlanOptions& plan) {
  plan.allowance = root.number("allowance_mm", kStock, plan.allowance);
  const Section stock = root.optional_section("stock", {"radial_mm", "axial_mm"});
  plan.radial_stock = stock.number("radial_mm", kStock, plan.radial_stock);
  plan.axial_stock = stock.number("axial_mm", kStock, plan.axial_stock);
  if (plan.axis.mode == pathgen::AxisMode::kFree && (plan.radial_stock > 0.0 || plan.axial_stock > 0.0))
    stock.complain(
        plan.radial_stock > 0.0 ? "radial_mm" : "axial_mm",
        "is not used in the axis mode free, where the axis has no one direction; use allowance_mm");
}

void read_rest(const Section& root, pathgen::PlanOptions& plan) {
  if (!root.has("rest")) return;
  const Section rest = root.section("rest", {"more_than_mm"});
  plan.rest_more_than = rest.number("more_than_mm", kRest);
  if (plan.axis.mode == pathgen::AxisMode::kFree)
    rest.complain("more_than_mm", "is not made in the axis mode free; use another mode for this operation");
}

/// 0: no limit.
double read_point_step(const Section& points, const char* key, double max, double fallback) {
  const double step = points.number(key, {0.0, max}, fallback);
  if (step > 0.0 && step < kLeastPointStep)
    points.complain(key, exact_text(step) + " is too fine; expected 0 (no limit) or at least " +
                             exact_text(kLeastPointStep));
  return step;
}

Section points_of(const Section& root) {
  return root.optional_section(
      "points", {"max_distance_mm", "max_angle_deg", "smoothing_mm", "axis_tolerance_deg", "calm_deg"});
}

void read_points(const Section& root, pathgen::PlanOptions& plan) {
  const Section points = points_of(root);
  plan.max_point_distance =
      read_point_step(points, "max_distance_mm", kMaxPointDistance, plan.max_point_distance);
  plan.max_angle_step = Angle::from_degrees(
      read_point_step(points, "max_angle_deg", kMaxPointTurn, plan.max_angle_step.degrees()));
  plan.smoothing = points.number("smoothing_mm", kSmoothing, plan.smoothing);
  if (plan.axis.mode == pathgen::AxisMode::kFree && plan.smoothing > 0.0)
    points.complain("smoothing_mm",
                    "is not used in the axis mode free; expected 0 (axis.smoothing_mm is another)");
}

pathgen::StandOff read_guard(const Section& guards, const char* key, pathgen::StandOff guard) {
  const Section section = guards.optional_section(key, {"clearance_mm", "reaction"});
  guard.clearance = section.number("clearance_mm", kGuard, guard.clearance);
  guard.reaction = section.choice<pathgen::Reaction>("reaction", kReactionWords, guard.reaction);
  return guard;
}

/// With the axis free, directions are chosen so that shank and holder are clear.
void refuse_reaction(const Section& guards, const char* key, const pathgen::StandOff& guard) {
  if (guard.reaction != pathgen::Reaction::kTrim)
    guards.complain(key,
                    "the reaction " + std::string(word(kReactionWords, guard.reaction)) +
                        " is not used in the axis mode free, which leaves out what has no clear direction; "
                        "expected trim");
}

/// What the reaction tilt needs.
void check_tilt(const Section& guards, const pathgen::PlanOptions& plan) {
  const bool shank = plan.shank.reaction == pathgen::Reaction::kTilt,
             holder = plan.holder.reaction == pathgen::Reaction::kTilt;
  if (!shank && !holder) return;
  const char* key = shank ? "shank" : "holder";
  if (plan.axis.mode == pathgen::AxisMode::kIndexed)
    return guards.complain(key,
                           "the reaction tilt is not used in the axis mode indexed, whose directions are "
                           "fixed; expected trim, retract or report");
  if (plan.lean.limit.radians() <= 0.0)
    guards.complain(key, "the reaction tilt needs axis.lean_limit_deg above 0: how far the tool may lean");
  const pathgen::Reaction other = shank ? plan.holder.reaction : plan.shank.reaction;
  if (!plan.cutter.holder.empty() && other != pathgen::Reaction::kTilt && other != pathgen::Reaction::kTrim)
    guards.complain(shank ? "holder" : "shank",
                    "the reaction " + std::string(word(kReactionWords, other)) +
                        " does not go with tilt, which keeps the whole tool clear; expected tilt or trim");
  if (plan.radial_stock > 0.0 || plan.axial_stock > 0.0)
    guards.complain(key,
                    "the stock of stock.radial_mm and stock.axial_mm lies along and square to the tool axis, "
                    "and a tool that leans cuts into it; expected trim, or the stock as allowance_mm");
}

void read_guards(const Section& root, pathgen::PlanOptions& plan) {
  const Section guards = root.optional_section("guards", {"shank", "holder"});
  plan.shank = read_guard(guards, "shank", plan.shank);
  plan.holder = read_guard(guards, "holder", plan.holder);
  if (plan.axis.mode == pathgen::AxisMode::kFree) {
    refuse_reaction(guards, "shank", plan.shank);
    refuse_reaction(guards, "holder", plan.holder);
  }
  if (plan.axis.mode != pathgen::AxisMode::kFree) check_tilt(guards, plan);
  if (guards.has("holder") && plan.cutter.holder.empty())
    guards.complain("holder", "there is no holder to guard; give its steps in cutter.holder");
}

/// Ends of passes this near to each other are those of neighbours, also where the surface leans by up to 60
/// degrees across them; with the axis indexed, also those of two pieces of passes between which a few more
/// belong to another direction.
double near_passes(const pathgen::PlanOptions& plan) {
  const pathgen::Pattern& pattern = plan.pattern;
  if (pattern.kind == pathgen::PatternKind::kRough) return 0.0;
  const bool wide =
      plan.axis.mode == pathgen::AxisMode::kIndexed || pattern.measure == pathgen::StepMeasure::kRidge;
  const double steps = wide ? 4.0 : 2.0;
  return std::min(steps * asked_step(plan), kLinkLength.max);
}

void read_links(const Section& root, pathgen::PlanOptions& plan) {
  pathgen::LinkingOptions& links = plan.links;
  links.clearance = root.number("clearance_mm", kHeightOverPart);
  links.approach = root.number("approach_mm", kHeightOverPart);
  if (links.approach > links.clearance)
    root.complain("approach_mm", exact_text(links.approach) + " mm is over clearance_mm, " +
                                     exact_text(links.clearance) +
                                     " mm; the approach is the last part of the way down from there");
  const Section section = root.optional_section("links", {"join_distance_mm", "lead_radius_mm", "rounds"});
  links.join_distance = section.number("join_distance_mm", kLinkLength, near_passes(plan));
  if (plan.pattern.kind == pathgen::PatternKind::kRough && links.join_distance > 0.0)
    section.complain("join_distance_mm",
                     "is not used by the kind rough, whose layers lie above the surface; expected 0");
  links.lead_radius = section.number("lead_radius_mm", kLeadRadius, links.lead_radius);
  if (plan.axis.mode == pathgen::AxisMode::kFree && links.lead_radius > 0.0)
    section.complain(
        "lead_radius_mm",
        "is not used in the axis mode free, which goes straight down the tool axis to every pass; "
        "expected 0");
  links.rounds = static_cast<std::uint32_t>(section.integer("rounds", 0, kMostRounds, 0));
  if (plan.axis.mode == pathgen::AxisMode::kFree && links.rounds > 0)
    section.complain("rounds", "is not used in the axis mode free, which has no rows; expected 0");
}

}  // namespace

Angle read_axis_tolerance(const Section& root, const pathgen::PlanOptions& plan) {
  const Section points = points_of(root);
  const double degrees = points.number("axis_tolerance_deg", kAxisTolerance, 0.0);
  if (degrees <= 0.0) return {};
  if (plan.axis.mode == pathgen::AxisMode::kFixed || plan.axis.mode == pathgen::AxisMode::kIndexed)
    points.complain("axis_tolerance_deg", "is not used where the axis stands while cutting; expected 0");
  if (plan.cutter.type != pathgen::CutterType::kBall && plan.cutter.type != pathgen::CutterType::kTaperBall)
    points.complain(
        "axis_tolerance_deg",
        "a cutter that leans touches elsewhere unless it ends in a ball; expected 0, or the cutter "
        "type ball or taper_ball");
  if (plan.radial_stock > 0.0 || plan.axial_stock > 0.0)
    points.complain(
        "axis_tolerance_deg",
        "the stock of stock.radial_mm and stock.axial_mm lies along and square to the tool axis, and "
        "a tool that leans cuts into it; expected 0, or the stock as allowance_mm");
  return Angle::from_degrees(degrees);
}

Angle read_calm(const Section& root, const pathgen::PlanOptions& plan) {
  const Section points = points_of(root);
  const double degrees = points.number("calm_deg", kCalm, 0.0);
  if (degrees <= 0.0) return {};
  if (plan.axis.mode == pathgen::AxisMode::kFixed || plan.axis.mode == pathgen::AxisMode::kIndexed)
    points.complain("calm_deg", "is not used where the axis stands while cutting; expected 0");
  if (plan.cutter.type != pathgen::CutterType::kBall)
    points.complain("calm_deg",
                    "a cutter that leans touches elsewhere unless it is a ball; expected 0, or the cutter "
                    "type ball");
  if (plan.radial_stock > 0.0 || plan.axial_stock > 0.0)
    points.complain("calm_deg",
                    "the stock of stock.radial_mm and stock.axial_mm lies along and square to the tool axis, "
                    "and a tool that leans cuts into it; expected 0, or the stock as allowance_mm");
  if (points.number("axis_tolerance_deg", kAxisTolerance, 0.0) > 0.0)
    points.complain(
        "calm_deg",
        "axis_tolerance_deg lets the axis lean near the pole already; expected 0 for one of them");
  if (pathgen::may_lean(plan))
    points.complain(
        "calm_deg",
        "a guard with the reaction tilt says how the tool leans; expected 0, or another reaction");
  return Angle::from_degrees(degrees);
}

void read_path(const Section& root, pathgen::PlanOptions& plan) {
  plan.tolerance = root.number("tolerance_mm", kTolerance, plan.tolerance);
  const double radius = smallest_radius(plan.cutter);
  if (plan.tolerance >= radius)
    root.complain("tolerance_mm", exact_text(plan.tolerance) +
                                      " mm is not below the cutter's smallest radius, " + exact_text(radius) +
                                      " mm");
  read_rest(root, plan);
  read_stock(root, plan);
  read_points(root, plan);
  read_guards(root, plan);
  read_links(root, plan);
}

}  // namespace tiltfeed::config
