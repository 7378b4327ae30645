#include "pathgen/mesh/facet_winding.h"

#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>

#include <exception>

#include "kinematics/basics/tool_path.h"

namespace tiltfeed::pathgen {
namespace {

struct ReversalNotes : CGAL::Polygon_mesh_processing::Default_orientation_visitor {
  std::vector<bool>* reversed = nullptr;  // CGAL copies the visitor
  void polygon_orientation_reversed(std::size_t facet) { reversed->at(facet) = !reversed->at(facet); }
};

bool agrees(const Mesh& mesh, const VertexFans& fans) {
  bool all = true;
  fans.each_edge(
      [&](std::span<const HalfEdge> edge) { all = all && state(edge) != EdgeState::kMisoriented; });
  return all && !mesh.facets.empty();
}

/// In each shell, turns the smaller part instead of the larger.
void keep_majority(std::vector<bool>& reversed, const Shells& shells) {
  std::vector<std::int64_t> surplus(shells.count, 0);  // turned minus kept
  std::vector<std::uint32_t> first(shells.count, kNoFacet);
  for (std::uint32_t i = 0; i < reversed.size(); ++i) {
    const std::uint32_t shell = shells.of_facet[i];
    surplus[shell] += reversed[i] ? 1 : -1;
    if (first[shell] == kNoFacet) first[shell] = i;
  }
  std::vector<bool> swap(shells.count);
  for (std::uint32_t s = 0; s < shells.count; ++s)
    swap[s] = surplus[s] > 0 || (surplus[s] == 0 && reversed[first[s]]);
  for (std::uint32_t i = 0; i < reversed.size(); ++i)
    if (swap[shells.of_facet[i]]) reversed[i] = !reversed[i];
}

}  // namespace

std::optional<std::vector<std::uint32_t>> orient_facets(Mesh& mesh) {
  namespace pmp = CGAL::Polygon_mesh_processing;
  std::vector<bool> reversed(mesh.facets.size(), false);
  try {
    // CGAL works on copies: where it cannot orient it duplicates vertices, and ours must stay.
    std::vector<Point<Part>> points = mesh.vertices;
    std::vector<Facet> facets = mesh.facets;
    ReversalNotes notes;
    notes.reversed = &reversed;
    pmp::orient_polygon_soup(points, facets, CGAL::parameters::visitor(notes));
  } catch (const std::exception&) {
    return std::nullopt;
  }
  Mesh turned = mesh;
  for (std::uint32_t i = 0; i < reversed.size(); ++i)
    if (reversed[i]) turn_over(turned.facets[i]);
  const VertexFans fans(turned.facets, turned.vertices.size());
  if (!agrees(turned, fans)) return std::nullopt;

  keep_majority(reversed, survey(fans).shells);
  std::vector<std::uint32_t> list;
  for (std::uint32_t i = 0; i < reversed.size(); ++i) {
    if (!reversed[i]) continue;
    turn_over(mesh.facets[i]);
    list.push_back(i);
  }
  return list;
}

}  // namespace tiltfeed::pathgen
