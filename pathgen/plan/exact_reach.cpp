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

void take_uncut(const RestReport& report, const Mesh& mesh, std::span<const ReachPlace> facets,
                std::vector<Reach>& places) {
  for (const RestFacet& uncut : report.facets)
    if (uncut.share >= kMostly)
      each_from(mesh, uncut.facet, [&](std::size_t i) {
        if (places[i] != Reach::kAway) places[i] = reach_of(uncut.why, facets[i].fits);
      });
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
  const std::vector<ToolPiece> pieces = tool_pieces(options);
  if (const auto& free = planned->report.free) {
    for (const FreeReport::Facet& f : free->unreached)
      each_from(part.mesh, f.facet, [&](std::size_t i) { map.places[i] = reach_of(f.why, facets[i].fits); });
  } else {
    const std::vector<bool> facing = facing_facets(part.mesh, options);
    for (std::size_t i = 0; i < facets.size(); ++i)
      if (!facing[i]) map.places[i] = Reach::kAway;
    take_uncut(*planned->report.uncut, part.mesh, facets, map.places);
    if (own.machine != nullptr) {
      const Deformation field(options.axis, 1.0);
      const double tip = reference_height(options.cutter);
      tbb::parallel_for(std::size_t{0}, facets.size(), [&](std::size_t i) {
        if (map.places[i] != Reach::kCut) return;
        const AxisLine line = contact_line(pieces.front(), field, facets[i].place, facets[i].normal);
        if (const auto refused = own.machine->refusal({line.base - line.axis * tip, line.axis}))
          map.places[i] = *refused;
      });
    }
  }
  for (std::size_t i = 0; i < facets.size(); ++i)
    map.area[static_cast<std::size_t>(map.places[i])] += facets[i].area;
  return map;
}

}  // namespace tiltfeed::pathgen
