#include "pathgen/mesh/repair.h"

#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <exception>
#include <numeric>

#include "pathgen/mesh/cracks.h"
#include "pathgen/mesh/facet_winding.h"
#include "pathgen/mesh/holes.h"
#include "pathgen/mesh/pinches.h"

namespace tiltfeed::pathgen {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using ExactCorners = std::array<Kernel::Point_3, 3>;
using FacetBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;

/// Welds and cuts each may take half of the distance; narrow cracks are closed by a small reach, which
/// spares small facets.
constexpr double kReaches[] = {1.0 / 32, 1.0 / 8, 1.0 / 2};

/// What is measured in double may exceed the distance by this factor.
constexpr double kExcess = 1.0 + 1e-9;

Kernel::Point_3 exact(Point<Part> p) { return {p.x, p.y, p.z}; }

ExactCorners corners_of(const Mesh& mesh, std::uint32_t facet) {
  const Facet& f = mesh.facets[facet];
  return {exact(mesh.vertices[f[0]]), exact(mesh.vertices[f[1]]), exact(mesh.vertices[f[2]])};
}

bool is_flat(const ExactCorners& c) { return CGAL::collinear(c[0], c[1], c[2]); }

/// The facets share more than the corners and edges they have in common. Decided exactly.
bool cross(ExactCorners a, ExactCorners b) {
  if (is_flat(a) || is_flat(b)) return false;  // seams: their neighbours stand for them
  std::size_t shared = 0;                      // moved to the front of both
  for (std::size_t i = 0; i < 3; ++i) {
    const auto same = std::find(b.begin() + shared, b.end(), a[i]);
    if (same == b.end()) continue;
    std::iter_swap(a.begin() + i, a.begin() + shared);
    std::iter_swap(same, b.begin() + shared);
    ++shared;
  }
  const Kernel::Triangle_3 ta(a[0], a[1], a[2]), tb(b[0], b[1], b[2]);
  switch (shared) {
    case 0:
      return CGAL::do_intersect(ta, tb);
    case 1:
      return CGAL::do_intersect(Kernel::Segment_3(a[1], a[2]), tb) ||
             CGAL::do_intersect(Kernel::Segment_3(b[1], b[2]), ta);
    case 2:
      return CGAL::coplanar(a[0], a[1], a[2], b[2]) &&
             CGAL::coplanar_orientation(a[0], a[1], a[2], b[2]) == CGAL::POSITIVE;
    default:
      return true;
  }
}

/// A facet without area is its three edges.
double squared_distance(const Kernel::Point_3& p, const ExactCorners& c) {
  if (!is_flat(c)) return CGAL::squared_distance(p, Kernel::Triangle_3(c[0], c[1], c[2]));
  return std::min({CGAL::squared_distance(p, Kernel::Segment_3(c[0], c[1])),
                   CGAL::squared_distance(p, Kernel::Segment_3(c[1], c[2])),
                   CGAL::squared_distance(p, Kernel::Segment_3(c[2], c[0]))});
}

/// Counts at the least source of the facets listed.
Found found_at(const Mesh& mesh, std::uint64_t count, const std::vector<std::uint32_t>& facets) {
  Found found{count, 0};
  if (facets.empty()) return found;
  found.first = mesh.source[facets[0]];
  for (std::uint32_t i : facets) found.first = std::min(found.first, mesh.source[i]);
  return found;
}

/// A mesh whose corners are welded within a reach.
struct Weld {
  double reach = 0.0;
  Mesh mesh;
  Found moved;
  std::uint64_t open = 0;  ///< edges left open
};

Weld weld_within(const Mesh& broken, const VertexFans& fans, double reach) {
  Weld weld{reach, broken, {}, 0};
  weld.moved = weld_corners(weld.mesh, fans, reach);
  VertexFans(weld.mesh.facets, weld.mesh.vertices.size()).each_edge([&](std::span<const HalfEdge> edge) {
    weld.open += edge.size() == 1;
  });
  return weld;
}

/// One try with one reach.
class Attempt {
 public:
  Attempt(const Mesh& broken, Weld start, double distance)
      : broken_(broken), reach_(start.reach), distance_(distance), mesh_(std::move(start.mesh)) {
    out_.welded = start.moved;
  }

  Repair run() {
    out_.split = split_at_corners(mesh_, reach_);
    out_.flaps = drop_flaps(mesh_, reach_);
    if (orient() && fill_holes() && turn_shells() && stays_near() && crosses_nothing_new()) finish();
    return std::move(out_);
  }

 private:
  bool give_up(const std::string& why) {
    out_.obstacle = why;
    return false;
  }
  VertexFans fans_now() const { return {mesh_.facets, mesh_.vertices.size()}; }
  std::string at(const HalfEdge& edge) const {
    return "at " + to_string(lerp(mesh_.vertices[edge.low], mesh_.vertices[edge.high], 0.5));
  }
  /// The facet of the broken mesh that a facet comes from.
  std::uint32_t origin(std::uint32_t facet) const {
    const auto found = std::lower_bound(broken_.source.begin(), broken_.source.end(), mesh_.source[facet]);
    return static_cast<std::uint32_t>(found - broken_.source.begin());
  }
  bool is_fill(std::uint32_t facet) const { return facet >= first_fill_; }

  bool orient();
  bool fill_holes();
  bool turn_shells();
  void find_touched();
  bool stays_near();
  bool crosses_nothing_new();
  void finish();

  const Mesh& broken_;
  const double reach_, distance_;
  Mesh mesh_;
  std::uint32_t first_fill_ = 0;        ///< facets from here on are fills
  std::vector<std::uint32_t> touched_;  ///< facets that are not as they were, fills included
  Repair out_;
};

bool Attempt::orient() {
  if (mesh_.facets.empty()) return give_up("all facets are smaller than the distance");
  bool agree = true;
  fans_now().each_edge(
      [&](std::span<const HalfEdge> edge) { agree = agree && state(edge) != EdgeState::kMisoriented; });
  if (!agree) {
    const auto flipped = orient_facets(mesh_);
    if (!flipped) return give_up("no choice of facets turned over makes all neighbours agree");
    out_.flipped = found_at(mesh_, flipped->size(), *flipped);
  }
  out_.separated = separate_pinches(mesh_);
  return true;
}

bool Attempt::fill_holes() {
  first_fill_ = static_cast<std::uint32_t>(mesh_.facets.size());
  const VertexFans fans = fans_now();
  std::vector<std::uint32_t> beside;
  for (const Hole& hole : find_holes(fans)) {
    const Fill patch = fill(mesh_, hole);
    if (!patch.obstacle.empty()) return give_up(patch.obstacle);
    const std::uint32_t neighbour = *std::min_element(hole.beside.begin(), hole.beside.end());
    beside.push_back(neighbour);
    out_.widest_hole = std::max(out_.widest_hole, width(mesh_, hole));
    mesh_.facets.insert(mesh_.facets.end(), patch.facets.begin(), patch.facets.end());
    mesh_.source.resize(mesh_.facets.size(), mesh_.source[neighbour]);
  }
  out_.filled = found_at(mesh_, beside.size(), beside);
  return true;
}

bool Attempt::turn_shells() {
  const VertexFans fans = fans_now();
  std::optional<HalfEdge> unsound;
  std::size_t facets = 0;
  fans.each_edge([&](std::span<const HalfEdge> edge) {
    if (unsound || state(edge) == EdgeState::kSound) return;
    unsound = edge[0];
    facets = edge.size();
  });
  if (unsound)
    return give_up("the edge " + at(*unsound) + " would still have " + std::to_string(facets) +
                   (facets == 1 ? " facet" : " facets") + (facets == 2 ? " that face opposite ways" : ""));
  const Shells shells = survey(fans).shells;
  const InsideOut turned = turn_outward(mesh_, shells);
  if (!turned.certain) return give_up("its shells are too many to tell which contains which");
  std::vector<std::uint32_t> facets_turned;
  for (std::uint32_t i = 0; i < shells.of_facet.size(); ++i)
    if (std::binary_search(turned.shells.begin(), turned.shells.end(), shells.of_facet[i]))
      facets_turned.push_back(i);
  out_.inside_out = found_at(mesh_, turned.shells.size(), facets_turned);
  return true;
}

void Attempt::find_touched() {
  const auto sorted = [](const Mesh& mesh, std::uint32_t facet) {
    ExactCorners c = corners_of(mesh, facet);
    std::sort(c.begin(), c.end());
    return c;
  };
  for (std::uint32_t i = 0; i < mesh_.facets.size(); ++i)
    if (is_fill(i) || sorted(mesh_, i) != sorted(broken_, origin(i))) touched_.push_back(i);
}

/// A facet's points are no further from a facet, which is convex, than its corners.
bool Attempt::stays_near() {
  find_touched();
  const double limit = distance_ * distance_ * kExcess;
  for (std::uint32_t i : touched_) {
    if (is_fill(i)) continue;
    const ExactCorners from = corners_of(broken_, origin(i));
    for (const Kernel::Point_3& p : corners_of(mesh_, i)) {
      if (squared_distance(p, from) <= limit) continue;
      return give_up("facet " + std::to_string(mesh_.source[i]) + " would move by more than the distance");
    }
  }
  return true;
}

bool Attempt::crosses_nothing_new() {
  CGAL::Bbox_3 region;
  const auto box = [&](std::uint32_t i) {
    const ExactCorners c = corners_of(mesh_, i);
    return c[0].bbox() + c[1].bbox() + c[2].bbox();
  };
  std::vector<FacetBox> changed, all;
  for (std::uint32_t i : touched_) {
    changed.emplace_back(box(i), i);
    region += changed.back().bbox();
  }
  std::vector<bool> is_touched(mesh_.facets.size(), false);
  for (std::uint32_t i : touched_) is_touched[i] = true;
  for (std::uint32_t i = 0; i < mesh_.facets.size(); ++i)
    if (const CGAL::Bbox_3 b = box(i); CGAL::do_overlap(b, region)) all.emplace_back(b, i);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> crossed;
  CGAL::box_intersection_d(
      changed.begin(), changed.end(), all.begin(), all.end(), [&](const FacetBox& x, const FacetBox& y) {
        const std::uint32_t a = x.info(), b = y.info();
        if (a == b || (is_touched[b] && b < a)) return;  // a pair of changed facets comes twice
        if (!cross(corners_of(mesh_, a), corners_of(mesh_, b))) return;
        const bool before = !is_fill(a) && !is_fill(b) && origin(a) != origin(b) &&
                            cross(corners_of(broken_, origin(a)), corners_of(broken_, origin(b)));
        if (!before) crossed.push_back({a, b});
      });
  if (crossed.empty()) return true;
  const auto [a, b] = *std::min_element(crossed.begin(), crossed.end());
  return give_up(std::to_string(crossed.size()) +
                 " pairs of facets would cross that do not in the file, among "
                 "them those from facets " +
                 std::to_string(mesh_.source[a]) + " and " + std::to_string(mesh_.source[b]));
}

/// Back to the file's order, fills after the facet beside them.
void Attempt::finish() {
  std::vector<std::uint32_t> order(mesh_.facets.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [this](std::uint32_t a, std::uint32_t b) { return mesh_.source[a] < mesh_.source[b]; });
  Mesh sorted;
  sorted.vertices = std::move(mesh_.vertices);
  for (std::uint32_t i : order) {
    sorted.facets.push_back(mesh_.facets[i]);
    sorted.source.push_back(mesh_.source[i]);
  }
  remove_facets(sorted, {});  // numbers the vertices by their first use
  out_.mesh = std::move(sorted);
}

}  // namespace

Repair repair(const Mesh& mesh, const VertexFans& fans, double distance, const ReportShare& report) {
  std::vector<Weld> welds;
  for (double share : kReaches) {
    welds.push_back(weld_within(mesh, fans, distance * share));
    if (report) report(static_cast<double>(welds.size()) / (std::size(kReaches) + 1));
  }
  const auto fewest = std::min_element(welds.begin(), welds.end(),
                                       [](const Weld& a, const Weld& b) { return a.open < b.open; });
  Repair last;
  for (auto weld = fewest; weld != welds.end(); ++weld) {
    try {
      last = Attempt(mesh, std::move(*weld), distance).run();
    } catch (const std::exception& e) {
      last = {};
      last.obstacle = std::string("CGAL: ") + e.what();
    }
    if (last.mesh) break;
  }
  return last;
}

}  // namespace tiltfeed::pathgen
