#include "sim/picture/facet_marks.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/solid/distance.h"

namespace tiltfeed::sim {
namespace {

/// A facet that the report calls uncut in part counts from this share on.
constexpr double kMarked = 0.5;

/// The ball's centres on cuts, as facets without area.
pathgen::Mesh centres_of(const ToolPath& path, double over_tip) {
  pathgen::Mesh track;
  for (const Move& move : path.moves) {
    const auto v = static_cast<std::uint32_t>(track.vertices.size());
    track.vertices.push_back(move.pose.tip + move.pose.axis * over_tip);
    if (move.kind == MoveKind::kCut && v > 0) track.facets.push_back({v - 1, v, v});
  }
  return track;
}

/// How high a ridge passes leave at most where each plane cuts the surface at 45 degrees.
double ridge(const pathgen::PlanOptions& plan) {
  const double r = plan.cutter.nose_radius() + plan.allowance,
               half = std::min(r, plan.pattern.side_step * std::sqrt(0.5));
  const double scallop = std::max(plan.pattern.scallop, r - std::sqrt(r * r - half * half));
  return plan.allowance + scallop + plan.tolerance;
}

void mark_uncut(const pathgen::Mesh& part, const config::Job& job, const ToolPath& path,
                std::vector<FacetMark>& marks) {
  const double over_tip = job.plan.cutter.nose_radius();
  const pathgen::Mesh track = centres_of(path, over_tip);
  if (track.facets.empty()) return;
  const PartDistance distances(track);
  const double within = over_tip + ridge(job.plan);
  for (std::size_t f = 0; f < part.facets.size(); ++f) {
    const auto& [i, j, k] = part.facets[f];
    const Point<Part> middle =
        part.vertices[i] +
        ((part.vertices[j] - part.vertices[i]) + (part.vertices[k] - part.vertices[i])) / 3.0;
    if (distances.nearest(middle, within).facet == kNoFacet) marks[f] = FacetMark::kUncut;
  }
}

/// Marks the facets of a list of the report whose `share`, if it has one, is at least half.
void mark_listed(const nlohmann::json& report, const char* section, const char* list,
                 const pathgen::Mesh& part, FacetMark mark, std::vector<FacetMark>& marks) {
  const auto found = report.find(section);
  if (found == report.end() || !found->is_object() || !found->contains(list)) return;
  std::vector<std::uint32_t> facets;
  for (const auto& entry : (*found)[list])
    if (entry.is_object() && entry.contains("facet") && entry["facet"].is_number_unsigned() &&
        entry.value("share", 1.0) >= kMarked)
      facets.push_back(entry["facet"].get<std::uint32_t>());
  std::sort(facets.begin(), facets.end());
  for (std::size_t f = 0; f < part.facets.size(); ++f)
    if (std::binary_search(facets.begin(), facets.end(), part.source[f])) marks[f] = mark;
}

}  // namespace

Result<std::vector<FacetMark>> facet_marks(const pathgen::Mesh& part, const config::Job& job,
                                           const ToolPath& path, const std::string& report) {
  std::vector<FacetMark> marks(part.facets.size(), FacetMark::kNone);
  const pathgen::CutterType type = job.plan.cutter.type;
  if (job.plan.axis.mode == pathgen::AxisMode::kFree &&
      (type == pathgen::CutterType::kBall || type == pathgen::CutterType::kTaperBall))
    mark_uncut(part, job, path, marks);
  if (report.empty()) return marks;
  const auto json = nlohmann::json::parse(report, nullptr, false);
  if (!json.is_object()) return fail(Code::kInput, "the report is not the planner's: no JSON object");
  mark_listed(json, "uncut", "facets", part, FacetMark::kUncut, marks);
  mark_listed(json, "free", "unreached_facets", part, FacetMark::kUnreached, marks);
  return marks;
}

}  // namespace tiltfeed::sim
