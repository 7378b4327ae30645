#include "pathgen/plan/exact_reach.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "pathgen/plan/plan.h"
#include "pathgen/plan/rest_material.h"
#include "pathgen/tool/contact_line.h"

namespace tiltfeed::pathgen {

namespace {

/// A facet of which this share or more stays uncut is called by the reason.
constexpr double kMostly = 0.5;

/// Calls visit(mesh facet) for those that came from this facet of the STL file, which ascend.
template <class Visit>
void each_from(const Mesh& mesh, std::uint32_t source, const Visit& visit) {
  for (auto at = std::lower_bound(mesh.source.begin(), mesh.source.end(), source);
       at != mesh.source.end() && *at == source; ++at)
    visit(static_cast<std::size_t>(at - mesh.source.begin()));
}

double& area_of(ReachMap& map, Reach reach) { return map.area[static_cast<std::size_t>(reach)]; }

/// Classes by facet, areas by the shares of which the report knows.
void take_report(const RestReport& report, std::span<const double> facing, std::span<const ReachPlace> facets,
                 ReachMap& map) {
  for (std::size_t i = 0; i < facets.size(); ++i) {
    if (facing[i] == 0.0) map.places[i] = Reach::kAway;
    area_of(map, Reach::kAway) += facets[i].area * (1.0 - facing[i]);
    area_of(map, Reach::kCut) += facets[i].area * facing[i];
  }
  for (const RestFacet& uncut : report.facets) {
    const ReachPlace& facet = facets[uncut.mesh_facet];
    const Reach why = reach_of(uncut.why, facet.fits);
    if (uncut.share >= kMostly) map.places[uncut.mesh_facet] = why;
    area_of(map, Reach::kCut) -= facet.area * uncut.share;
    area_of(map, why) += facet.area * uncut.share;
  }
}

/// What is cut of the facets where the machine does not go.
void take_machine(const MachineReach& machine, const PlanOptions& options, std::span<const double> cut,
                  std::span<const ReachPlace> facets, ReachMap& map) {
  const Deformation field(options.axis, 1.0);
  const double tip = reference_height(options.cutter);
  const std::vector<ToolPiece> pieces = tool_pieces(options);
  std::vector<std::optional<Reach>> refused(facets.size());
  tbb::parallel_for(std::size_t{0}, facets.size(), [&](std::size_t i) {
    if (map.places[i] != Reach::kCut) return;
    const AxisLine line = contact_line(pieces.front(), field, facets[i].place, facets[i].normal);
    refused[i] = machine.refusal({line.base - line.axis * tip, line.axis});
  });
  for (std::size_t i = 0; i < facets.size(); ++i) {
    if (!refused[i]) continue;
    map.places[i] = *refused[i];
    area_of(map, Reach::kCut) -= facets[i].area * cut[i];
    area_of(map, *refused[i]) += facets[i].area * cut[i];
  }
}

}  // namespace

Result<ReachMap> exact_reach(const CheckedMesh& part, const PlanOptions& options, const ReachScene& scene,
                             std::span<const ReachPlace> facets, const ReachQuestion& question,
                             const Progress& progress) {
  PlanOptions asked = options;
  asked.find_rest_material = true;
  const Result<Plan> planned = plan(part, asked, progress);
  if (!planned) return tl::unexpected(planned.error());
  ReachQuestion own = question;
  own.axis = options.axis, own.up = options.up, own.tilt_max = options.tilt_max;
  if (const auto& indexed = planned->report.indexed) {
    own.directions.clear();
    for (const IndexedReport::Direction& d : indexed->directions) own.directions.push_back(d.axis);
    return scene.ask(own, facets, Rays::kRim);
  }
  ReachMap map;
  map.places.assign(facets.size(), Reach::kCut);
  if (const auto& free = planned->report.free) {
    for (const FreeReport::Facet& f : free->unreached)
      each_from(part.mesh, f.facet, [&](std::size_t i) { map.places[i] = reach_of(f.why, facets[i].fits); });
    for (std::size_t i = 0; i < facets.size(); ++i) area_of(map, map.places[i]) += facets[i].area;
    return map;
  }
  std::vector<double> cut = facing_shares(part.mesh, options);
  take_report(*planned->report.uncut, cut, facets, map);
  for (const RestFacet& uncut : planned->report.uncut->facets) cut[uncut.mesh_facet] -= uncut.share;
  if (own.machine != nullptr) take_machine(*own.machine, options, cut, facets, map);
  return map;
}

}  // namespace tiltfeed::pathgen
