#include "pathgen/plan/rejected_points.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace tiltfeed::pathgen {

namespace {

struct Reason {
  RestReason why;
  const char* text;
};
constexpr Reason kReasons[] = {
    {RestReason::kTilt, "the tool axis would tilt further than setup.tilt_max_deg"},
    {RestReason::kContainment, "the tool would leave the containment's height"},
    {RestReason::kShank, "the shank would come nearer to the part than guards.shank.clearance_mm"},
    {RestReason::kHolder, "the holder would come nearer to the part than guards.holder.clearance_mm"}};

/// The facets that stop shank or holder.
std::string stopped_by(const ClSurface& surface, const Passes& passes, RestReason why) {
  if (why != RestReason::kShank && why != RestReason::kHolder) return "";
  std::vector<std::uint32_t> found;
  for (PatchId patch : passes.refusals.patches)
    if (rest_reason_of(surface.piece(patch).part) == why) found.push_back(surface.facet_of(patch));
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  if (found.empty()) return "";
  return ", stopped by facet " + std::to_string(found.front()) + " (" + std::to_string(found.size()) +
         " facets in all)";
}

}  // namespace

Result<void> report_refusals(const ClSurface& surface, const Passes& passes, PlanReport& report) {
  std::uint64_t left_out = 0;
  const std::string all = std::to_string(passes.traced);
  for (const Reason& reason : kReasons) {
    const auto index = static_cast<std::size_t>(reason.why);
    const std::uint64_t count = passes.refusals.count[index], raised = passes.refusals.raised[index];
    left_out += count;
    if (count == passes.traced)
      return fail(reason.why == RestReason::kTilt ? Code::kLimit : Code::kUnreachable,
                  std::string("nothing is left to cut: at every point of the path ") + reason.text + "; " +
                      remedy(reason.why));
    const std::string facets = stopped_by(surface, passes, reason.why);
    if (count > 0)
      report.warnings.push_back(std::to_string(count) + " of " + all + " points left out: " + reason.text +
                                facets);
    if (raised > 0)
      report.warnings.push_back(std::to_string(raised) + " of " + all + " points raised off the part: else " +
                                reason.text + facets);
  }
  if (left_out == passes.traced)
    return fail(Code::kUnreachable,
                "nothing is left to cut: every point is left out; see guards, containment and "
                "setup.tilt_max_deg");
  if (passes.steep > 0)
    report.warnings.push_back(
        "at " + std::to_string(passes.steep) + " of " + all +
        " points the wall is steeper than 75 degrees across the passes, and the side step "
        "wider there than asked; cut it with z-level contours");
  report.slice_points -= left_out;
  return {};
}

void warn_too_near(const ClSurface& surface, const std::vector<PatchId>& too_near, PlanReport& report) {
  std::vector<std::uint32_t> facets;
  for (PatchId patch : too_near) facets.push_back(surface.facet_of(patch));
  std::sort(facets.begin(), facets.end());
  facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
  if (facets.empty()) return;
  report.warnings.push_back(
      "near facet " + std::to_string(facets.front()) + " (" + std::to_string(facets.size()) +
      " facets in all) the CL surface touches the axis point, line or circle, where no tool axis is "
      "defined: what is nearer to it than 0.1 mm is not machined");
}

void warn_smoothed(const Smoothed& smoothed, PlanReport& report) {
  if (smoothed.points == 0) return;
  report.warnings.push_back("points.smoothing_mm leaves up to " + std::to_string(smoothed.most) +
                            " mm along the tool axis in concave corners, at " +
                            std::to_string(smoothed.points) + " points of the envelope");
}

void warn_between(const BetweenPasses& between, const char* remedy, PlanReport& report) {
  if (between.area == 0.0) return;
  const auto mm = [](double value) { return number_text(std::round(1e4 * value) / 1e4); };
  const Point<Part> p = between.place;
  report.warnings.push_back(
      "between passes more is left than the " + mm(between.limit) +
      " mm that the job asks for, tolerance included, on " + mm(between.area) +
      " mm2: " + (between.never ? "no pass comes near (" : mm(between.most) + " mm at (") + mm(p.x) + ", " +
      mm(p.y) + ", " + mm(p.z) + ") on facet " + std::to_string(between.facet) + "; " + remedy);
}

void warn_touches(const Touches& touches, PlanReport& report) {
  if (touches.points == 0) return;
  report.warnings.push_back("at " + std::to_string(touches.points) +
                            " points shank or holder come nearer to the part than their clearance, first "
                            "facet " +
                            std::to_string(touches.facets.front()) + " (" +
                            std::to_string(touches.facets.size()) +
                            " facets in all); guards ask for a report only: nothing was changed");
}

}  // namespace tiltfeed::pathgen
