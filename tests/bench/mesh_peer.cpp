// The check of the part beside CGAL's polygon mesh processing: processor time and whether the mesh is closed.
//
//   mesh_peer FILE.stl ...

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Surface_mesh.h>

#include <cstdio>
#include <ctime>
#include <filesystem>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Corner = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
using Surface = CGAL::Surface_mesh<Corner>;

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Duplicates merged, facets turned to agree, borders stitched; closed meshes turned outwards. The open
/// edges.
std::size_t open_edges_by_cgal(const tiltfeed::pathgen::Stl& stl) {
  std::vector<Corner> points;
  std::vector<std::vector<std::size_t>> facets;
  points.reserve(3 * stl.facets.size());
  for (const auto& facet : stl.facets) {
    facets.push_back({points.size(), points.size() + 1, points.size() + 2});
    for (const auto& p : facet) points.emplace_back(p.x, p.y, p.z);
  }
  pmp::repair_polygon_soup(points, facets);
  pmp::orient_polygon_soup(points, facets);
  Surface mesh;
  pmp::polygon_soup_to_polygon_mesh(points, facets, mesh);
  pmp::stitch_borders(mesh);
  if (CGAL::is_closed(mesh)) pmp::orient_to_bound_a_volume(mesh);
  std::size_t open = 0;
  for (const auto edge : mesh.halfedges()) open += mesh.is_border(edge) ? 1 : 0;
  return open;
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const auto stl = tiltfeed::pathgen::read_stl(argv[i], 1.0);
    if (!stl) continue;
    const double begun = processor_s();
    const auto checked = tiltfeed::pathgen::check_mesh(*stl);
    const double ours = processor_s() - begun;
    const std::size_t open = open_edges_by_cgal(*stl);
    const double theirs = processor_s() - begun - ours;
    const bool closed = checked && checked->sides == tiltfeed::Sides::kOutward;
    std::printf("%-32s %8zu facets; check_mesh %.3f s, %s; CGAL %.3f s, %zu open edges\n",
                std::filesystem::path(argv[i]).filename().c_str(), stl->facets.size(), ours,
                closed ? "closed" : "open", theirs, open);
  }
}
