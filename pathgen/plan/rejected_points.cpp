#include "pathgen/plan/rejected_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace tiltfeed::pathgen {

namespace {

constexpr Reason kRefusals[] = {
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

void warn_fixtures(const char* of_what, PlanReport& report) {
  for (const KeptByFixture& kept : report.fixtures) {
    const auto mm = [](double value) { return number_text(std::round(1e3 * value) / 1e3); };
    std::string what = kept.points > 0 ? std::to_string(kept.points) + " " + of_what : "";
    if (kept.area > 0.0) what += (what.empty() ? "" : " and ") + mm(kept.area) + " mm2 of the part";
    report.warnings.push_back("the fixture " + kept.name + " keeps the tool from " + what + ", first near (" +
                              mm(kept.place.x) + ", " + mm(kept.place.y) + ", " + mm(kept.place.z) + "); " +
                              remedy(RestReason::kFixture));
  }
}

KeptByFixture& note_fixture(const PlanOptions& options, const SweptTool& tool, Point<Part> place, Vec3 normal,
                            PlanReport& report) {
  const Point<Part> centre = place + normal * tool.ball();
  std::uint32_t hint = kNoFacet, facet = 0;
  const Mesh& mesh = options.fixtures->mesh;
  const auto met = tool.stop(centre, normal, hint, kWithFixtures);
  if (met && met->of_fixtures) {
    facet = met->facet;
  } else {
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) {
      const auto& [a, b, c] = mesh.facets[i];
      const double off =
          distance(place, nearest_point(place, {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]}));
      if (off < least) least = off, facet = i;
    }
  }
  const std::string& name = options.fixtures->names[mesh.source[facet]];
  for (KeptByFixture& kept : report.fixtures)
    if (kept.name == name) return kept;
  report.fixtures.push_back({name, 0, place});
  return report.fixtures.back();
}

Result<void> report_refusals(const ClSurface& surface, const Passes& passes, const PlanOptions& options,
                             PlanReport& report) {
  std::uint64_t left_out = 0;
  const std::uint64_t asked = passes.traced - passes.refusals.beside;
  if (options.only_faces && asked == 0) return fail(Code::kUnreachable, kNoFaceReached);
  const std::string all = std::to_string(asked);
  std::string names;
  for (const auto& [body, kept] : passes.refusals.fixtures) {
    const std::string& name = options.fixtures->names[body];
    report.fixtures.push_back({name, kept.points, kept.first});
    left_out += kept.points, names += (names.empty() ? "" : ", ") + name;
  }
  if (left_out > 0 && left_out == asked)
    return fail(Code::kUnreachable,
                "nothing is left to cut: at every point of the path the tool would come "
                "nearer to a fixture than its clearance (" +
                    names + "); " + remedy(RestReason::kFixture));
  for (const Reason& reason : kRefusals) {
    const auto index = static_cast<std::size_t>(reason.why);
    const std::uint64_t count = passes.refusals.count[index], raised = passes.refusals.raised[index];
    left_out += count;
    if (count == asked)
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
  if (left_out == asked)
    return fail(Code::kUnreachable,
                "nothing is left to cut: every point is left out; see guards, containment and "
                "setup.tilt_max_deg" +
                    (names.empty() ? "" : ", and the fixtures " + names));
  if (passes.steep > 0)
    report.warnings.push_back(
        "at " + std::to_string(passes.steep) + " of " + all +
        " points the wall is steeper than 75 degrees across the passes, and the side step "
        "wider there than asked; cut it with z-level contours");
  report.slice_points = asked - left_out;
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

void warn_taper_edge(const PlanOptions& options, PlanReport& report) {
  const double left = left_at_taper_edge(options);
  if (left <= options.tolerance) return;
  report.warnings.push_back(
      "up to " + number_text(std::ceil(1e4 * left) / 1e4) +
      " mm more than the allowance stay where the upper edge of the cutter's taper touches");
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
