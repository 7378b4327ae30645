#include <sstream>

#include "config/body_keys.h"
#include "config/description.h"
#include "config/enum_words.h"
#include "config/job.h"
#include "config/job_keys.h"
#include "config/program_keys.h"

namespace tiltfeed::config {
namespace {

void describe_cutter(Description& out, const pathgen::Cutter& cutter) {
  out.add("cutter.type", word(kCutterWords, cutter.type));
  out.add("cutter.diameter_mm", cutter.diameter);
  if (cutter.type == pathgen::CutterType::kBullNose) out.add("cutter.corner_radius_mm", cutter.corner_radius);
  if (cutter.type == pathgen::CutterType::kTaperBall) out.add("cutter.taper_deg", cutter.taper);
  out.add("cutter.length_mm", cutter.length);
  out.add("cutter.cutting_length_mm", cutter.cutting_end());
  out.add("cutter.shank_diameter_mm", tidy(2.0 * cutter.shank_radius()));
  out.add("cutter.shank_length_mm", cutter.shank_length);
  if (cutter.holder.empty()) out.add("cutter.holder", "none");
  double top = cutter.shank_length;
  for (std::size_t i = 0; i < cutter.holder.size(); ++i) {
    const pathgen::HolderStep& step = cutter.holder[i];
    const std::string name = "cutter.holder[" + std::to_string(i + 1) + "].";
    out.add(name + "diameter_mm", step.lower_diameter);
    out.add(name + "upper_diameter_mm", step.upper_diameter);
    out.add(name + "length_mm", step.length);
    top += step.length;
  }
  if (!cutter.holder.empty()) out.add("cutter.holder_top_mm", tidy(top));
}

void describe_free_axis(Description& out, const pathgen::FreeAxis& free) {
  for (std::size_t i = 0; i < free.plane_normals.size(); ++i)
    out.add("axis.plane_normals[" + std::to_string(i + 1) + "]", free.plane_normals[i]);
  out.add("axis.lead_deg", free.lead);
  out.add("axis.lean_deg", free.lean);
  out.add("axis.smoothing_mm", free.smoothing);
  out.add("axis.max_turn_deg_per_mm", free.max_turn);
}

void describe_indexed_axis(Description& out, const pathgen::IndexedAxis& indexed) {
  out.add("axis.most_directions", static_cast<double>(indexed.most_directions));
  out.add("axis.coverage_percent", tidy(100.0 * indexed.coverage));
  out.add("axis.least_gain_percent", tidy(100.0 * indexed.least_gain));
  out.add("axis.steepest_deg", indexed.steepest);
}

void describe_axis(Description& out, const pathgen::PlanOptions& plan) {
  const pathgen::AxisFrame& axis = plan.axis;
  out.add("axis.mode", word(kModeWords, axis.mode));
  if (axis.mode == pathgen::AxisMode::kFree) return describe_free_axis(out, plan.free);
  if (axis.mode == pathgen::AxisMode::kIndexed) return describe_indexed_axis(out, plan.indexed);
  if (axis.mode != pathgen::AxisMode::kFixed) out.add("axis.sense", word(kSenseWords, axis.sense));
  out.add("axis.origin_mm", from_origin(axis.origin));
  out.add("axis.t", axis.t);
  out.add("axis.n", axis.n);
  if (axis.mode == pathgen::AxisMode::kCircle) out.add("axis.circle_radius_mm", axis.circle_radius);
  out.add("axis.lean_limit_deg", plan.lean.limit);
  if (plan.lean.limit.radians() > 0.0) out.add("axis.max_turn_deg_per_mm", plan.lean.max_turn);
}

void describe_pattern(Description& out, const pathgen::Pattern& pattern, pathgen::AxisMode mode) {
  const auto uses = [&](const std::string& key) {
    const bool row = key == "along" || key == "angle_deg";
    return uses_key(pattern.kind, key) && !(mode == pathgen::AxisMode::kFree && row);
  };
  const bool scallop = pattern.scallop > 0.0;
  out.add("pattern.kind", word(kKindWords, pattern.kind));
  if (uses("along")) out.add("pattern.along", word(kAlongWords, pattern.along));
  if (uses("angle_deg")) out.add("pattern.angle_deg", pattern.angle);
  if (uses("direction")) out.add("pattern.direction", word(kDirectionWords, pattern.direction));
  if (uses("measure")) out.add("pattern.measure", word(kMeasureWords, pattern.measure));
  if (uses("scallop_mm") && scallop) out.add("pattern.scallop_mm", pattern.scallop);
  if (pattern.optimise_scallop > 0.0) out.add("pattern.optimise_scallop_mm", pattern.optimise_scallop);
  if (uses("side_step_mm") && pattern.side_step > 0.0) out.add("pattern.side_step_mm", pattern.side_step);
  if (uses("side_step_mm") && pattern.side_step <= 0.0) out.add("pattern.side_step_mm", "no limit");
  if (uses("step_down_mm")) out.add("pattern.step_down_mm", pattern.step_down);
  if (uses("milling")) out.add("pattern.milling", word(kMillingWords, pattern.climb));
  if (uses("split_slope_deg")) out.add("pattern.split_slope_deg", pattern.split_slope);
  if (uses("crease_angle_deg")) out.add("pattern.crease_angle_deg", pattern.crease_angle);
}

/// A coordinate of the axis line as the job file has it.
std::string typed(const std::string& key, double value) {
  return exact_text(key.ends_with("_deg") ? tidy(Angle::from_radians(value).degrees()) : value);
}

void describe_containment(Description& out, const Job& job) {
  const pathgen::Containment& containment = job.plan.containment;
  const CoordinateKeys keys = coordinate_keys(job.plan.axis.mode);
  bool any = !containment.boundary.empty() || !job.only_faces.empty();
  const auto limits = [&](const std::string& key, const pathgen::Interval& interval) {
    if (!interval.bounded()) return;
    any = true;
    out.add("containment." + key, "[" + typed(key, interval.low) + ", " + typed(key, interval.high) + "]");
  };
  limits(keys.first, containment.first);
  limits(keys.second, containment.second);
  limits(keys.height, containment.height);
  for (std::size_t i = 0; i < containment.boundary.size(); ++i)
    out.add("containment.boundary[" + std::to_string(i + 1) + "]",
            "[" + typed(keys.first, containment.boundary[i][0]) + ", " +
                typed(keys.second, containment.boundary[i][1]) + "]");
  for (std::size_t i = 0; i < job.only_faces.size(); ++i)
    out.add("containment.faces[" + std::to_string(i + 1) + "]", job.only_faces[i]);
  if (!job.only_faces.empty()) out.add("containment.beyond_faces_mm", job.beyond_faces);
  if (!any) out.add("containment", "none");
}

/// `left`: of the tolerance, what the plan leaves to the control and to the facets of the part.
void describe_path(Description& out, const pathgen::PlanOptions& plan, Angle axis_tolerance, Angle calm,
                   double left) {
  out.add("tolerance_mm", tidy(plan.tolerance + left));
  if (plan.rest_more_than > 0.0) out.add("rest.more_than_mm", plan.rest_more_than);
  out.add("allowance_mm", plan.allowance);
  out.add("stock.radial_mm", plan.radial_stock);
  out.add("stock.axial_mm", plan.axial_stock);
  out.add("points.max_distance_mm", plan.max_point_distance);
  out.add("points.max_angle_deg", plan.max_angle_step);
  out.add("points.smoothing_mm", plan.smoothing);
  out.add("points.axis_tolerance_deg", axis_tolerance);
  out.add("points.calm_deg", calm);
  out.add("guards.shank.clearance_mm", plan.shank.clearance);
  out.add("guards.shank.reaction", word(kReactionWords, plan.shank.reaction));
  if (!plan.cutter.holder.empty()) {
    out.add("guards.holder.clearance_mm", plan.holder.clearance);
    out.add("guards.holder.reaction", word(kReactionWords, plan.holder.reaction));
  }
  out.add("links.join_distance_mm", plan.links.join_distance);
  out.add("links.lead_radius_mm", plan.links.lead_radius);
  out.add("links.rounds", static_cast<int>(plan.links.rounds));
  out.add("clearance_mm", plan.links.clearance);
  out.add("approach_mm", plan.links.approach);
}

}  // namespace

std::string describe(const Job& job) {
  const pathgen::PlanOptions& plan = job.plan;
  Description out;
  out.add("job", job.path);
  if (!job.operation.name.empty())
    out.add("operation", std::to_string(job.operation.number) + " of " + std::to_string(job.operation.count) +
                             ", " + job.operation.name);
  out.add("part.name", plan.name);
  out.add("part.stl", job.stl_path);
  out.add("part.unit_mm", job.stl_unit_mm);
  for (std::size_t i = 0; i < job.bodies.size(); ++i)
    out.add("part.bodies[" + std::to_string(i + 1) + "]", job.bodies[i]);
  for (std::size_t i = 0; i < job.avoid_faces.size(); ++i)
    out.add("part.avoid_faces[" + std::to_string(i + 1) + "]", job.avoid_faces[i]);
  if (!job.avoid_faces.empty()) out.add("part.avoid_mm", job.avoid);
  if (!job.tools_path.empty()) out.add("cutter.library", job.tools_path);
  if (!job.tool_id.empty()) out.add("cutter.id", job.tool_id);
  if (!job.material.empty()) out.add("cutter.material", job.material);
  describe_cutter(out, plan.cutter);
  describe_axis(out, plan);
  describe_pattern(out, plan.pattern, plan.axis.mode);
  describe_containment(out, job);
  describe_path(out, plan, job.axis_tolerance, job.calm, left_to_control(job) + job.tessellation);
  out.add("feeds.cut_mm_per_min", plan.cut_feed.mm_per_min());
  out.add("feeds.plunge_mm_per_min", plan.plunge_feed.mm_per_min());
  out.add("feeds.spindle_rpm", job.spindle_rpm);
  out.add("feeds.highest_mm_per_min", job.feeds.highest.mm_per_min());
  out.add("feeds.lowest_mm_per_min", job.feeds.lowest.mm_per_min());
  out.add("feeds.load_percent", 100.0 * job.feeds.load);
  out.add("feeds.change_percent_per_mm", 100.0 * job.feeds.change);
  if (job.feeds.largest_chip > 0.0) out.add("cutter.largest_chip_mm_per_min", tidy(job.feeds.largest_chip));
  describe_program_data(out, job.program);
  out.add("setup.part_zero_mm", job.setup.part_zero);
  for (std::size_t row = 0; row < 3; ++row)
    out.add("setup.fixture_row_" + std::to_string(row + 1), job.setup.fixture.rows[row]);
  out.add("setup.tilt_max_deg", plan.tilt_max);
  out.add("setup.tool_length_mm", job.setup.tool_length);
  describe_fixtures(out, job.fixtures);
  describe_blank(out, job.blank);
  std::istringstream machine(describe(job.machine));
  std::string text = out.text();
  for (std::string line; std::getline(machine, line);) text += "machine." + line + "\n";
  return text;
}

}  // namespace tiltfeed::config
