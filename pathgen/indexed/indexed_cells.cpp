#include "pathgen/indexed/indexed_cells.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// A facet is cut into at most this many cells along an edge.
constexpr int kMostAlong = 128;
/// A ball placed on a facet's normal is off by the rounding of its coordinates and, on a concave surface of
/// small facets, by what their edges stand out; this share of the tolerance.
constexpr double kSeatShare = 1.0;

/// Where the ball stands when it touches the cell: lifted by as much as its cutting part may cut in.
Point<Part> seat_of(const SurfaceCell& cell, double ball, const PlanOptions& options) {
  return cell.place + cell.normal * (ball + kSeatShare * options.tolerance);
}

}  // namespace

std::vector<SurfaceCell> make_cells(const Mesh& mesh, double size) {
  std::vector<SurfaceCell> cells;
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) {
    const auto& [i, j, k] = mesh.facets[f];
    const Point<Part> a = mesh.vertices[i];
    const Vec3 ab = mesh.vertices[j] - a, ac = mesh.vertices[k] - a, twice = cross(ab, ac);
    const double longest = std::max({length(ab), length(ac), length(ac - ab)});
    const int along = std::clamp(static_cast<int>(std::ceil(longest / size)), 1, kMostAlong);
    const SurfaceCell whole{a, normalized(twice), 0.5 * length(twice) / (along * along), f, mesh.source[f]};
    // Rows of upright triangles, and turned ones between them; thirds to their middles.
    for (int u = 0; u < along; ++u)
      for (int v = 0; u + v < along; ++v)
        for (int turned = 0; turned < (u + v + 1 < along ? 2 : 1); ++turned) {
          const double third = (1.0 + turned) / 3.0;
          SurfaceCell cell = whole;
          cell.place = a + ab * ((u + third) / along) + ac * ((v + third) / along);
          cells.push_back(cell);
        }
  }
  return cells;
}

std::vector<SurfaceCell> only_chosen(std::vector<SurfaceCell> cells, const PlanOptions& options) {
  if (options.only_faces)
    std::erase_if(cells, [&](const SurfaceCell& cell) { return !options.only_faces->chosen[cell.facet]; });
  return cells;
}

std::vector<SurfaceCell> sample_cells(const std::vector<SurfaceCell>& cells, std::uint32_t count) {
  double whole = 0.0;
  for (const SurfaceCell& cell : cells) whole += cell.area;
  std::vector<SurfaceCell> samples;
  double sum = 0.0;
  for (const SurfaceCell& cell : cells) {
    sum += cell.area;
    // A cell larger than a share stands for several.
    for (; (static_cast<double>(samples.size()) + 0.5) * whole / count <= sum && samples.size() < count;) {
      samples.push_back(cell);
      samples.back().area = whole / count;
    }
  }
  return samples;
}

std::optional<Contact> CellReach::contact(Point<Part> centre, double gap) const {
  double least = tool_.ball() + gap;
  std::optional<Contact> found;
  tool_.tree().nearest(centre, least, [&](std::uint32_t facet, const PlacedFacet& f) {
    const Point<Part> near = nearest_point(centre, f.corners);
    const double away = distance(centre, near);
    if (away < least || (found && away == least && facet < found->facet)) least = away, found = {near, facet};
    return away;
  });
  return found;
}

bool CellReach::seats(const SurfaceCell& cell) const {
  return !contact(seat_of(cell, tool_.ball(), options_), 0.0).has_value();
}

bool CellReach::clears(const SurfaceCell& cell, Vec3 direction, std::uint32_t& hint, int parts) const {
  if (dot(direction, cell.normal) < std::cos(options_.indexed.steepest.radians())) return false;
  return !tool_.stop(seat_of(cell, tool_.ball(), options_), direction, hint, parts).has_value();
}

bool CellReach::reaches(const SurfaceCell& cell, Vec3 direction, std::uint32_t& hint) const {
  if (angle_between(direction, options_.up) > options_.tilt_max.radians()) return false;
  return clears(cell, direction, hint, kWithFixtures);
}

std::vector<std::vector<std::uint8_t>> reach_sets(const CellReach& reach,
                                                  const std::vector<SurfaceCell>& cells,
                                                  const std::vector<Vec3>& directions,
                                                  const ReportShare& report) {
  std::vector<std::uint8_t> seated(cells.size());
  Watch watch(report, cells.size() * (directions.size() + 1));
  tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t c) {
    if (watch.next()) seated[c] = reach.seats(cells[c]);
  });
  std::vector<std::vector<std::uint8_t>> sets(directions.size(), std::vector<std::uint8_t>(cells.size(), 0));
  tbb::parallel_for(std::size_t{0}, directions.size(), [&](std::size_t d) {
    std::uint32_t hint = kNoFacet;
    for (std::size_t c = 0; c < cells.size(); ++c)
      if (watch.next() && seated[c] != 0) sets[d][c] = reach.reaches(cells[c], directions[d], hint) ? 1 : 0;
  });
  return sets;
}

}  // namespace tiltfeed::pathgen
