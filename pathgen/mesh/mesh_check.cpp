#include "pathgen/mesh/mesh_check.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <optional>

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/facet_winding.h"
#include "pathgen/mesh/repair.h"
#include "pathgen/mesh/tasks.h"
#include "pathgen/mesh/topology.h"
#include "pathgen/mesh/weld.h"

namespace tiltfeed::pathgen {
namespace {

using Range = tbb::blocked_range<std::size_t>;

/// A part shorter than this was most likely drawn in metres or inches, mm.
constexpr double kSmallestPart = 1.0;

const char* const kBothSides =
    "; outside and inside cannot be told, so both sides of every facet count as surface, and the tool keeps "
    "off both; repair the part to plan its outside only";

/// Edges in one state; the first is the one whose lowest facet is lowest.
struct EdgeCount {
  std::uint64_t count = 0;
  std::uint32_t facet = kNoFacet;  ///< of the mesh
  Point<Part> middle;
};

/// Indexed by EdgeState.
using EdgeCounts = std::array<EdgeCount, 4>;

/// Of the check, what is done after each of its steps.
constexpr double kFinite = 0.05, kJoined = 0.5, kCounted = 0.6, kRepaired = 0.9;

tl::unexpected<Error> cancelled() {
  return fail(Code::kCancelled, "the check of the part was cancelled; nothing was written");
}

EdgeCounts count_edges(const Welded& welded, const Mesh& mesh) {
  EdgeCounts counts;
  if (welded.survey.all_sound) return counts;
  welded.fans.each_edge([&](std::span<const HalfEdge> edge) {
    const EdgeState what = state(edge);
    if (what == EdgeState::kSound) return;
    EdgeCount& c = counts[static_cast<std::size_t>(what)];
    ++c.count;
    if (c.facet <= edge[0].facet) return;
    c.facet = edge[0].facet;
    c.middle = lerp(mesh.vertices[edge[0].low], mesh.vertices[edge[0].high], 0.5);
  });
  return counts;
}

const EdgeCount& of(const EdgeCounts& counts, EdgeState state) {
  return counts[static_cast<std::size_t>(state)];
}

std::string place(std::uint32_t facet, Point<Part> at) {
  return "facet " + std::to_string(facet) + " at " + to_string(at);
}

/// "1 facet has", "2 facets have": `one` and `many` include the verb.
std::string counted(std::uint64_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// Fills in the defects, in the order of DefectKind, and their warnings.
class Findings {
 public:
  Findings(const Stl& stl, CheckedMesh& out) : stl_(stl), out_(out) {}

  void facets(DefectKind kind, const Found& found, const std::string& what) {
    if (found.count > 0) add(kind, found.count, place(found.first, stl_.facets[found.first][0]), what);
  }
  void edges(DefectKind kind, const EdgeCount& found, const std::string& what) {
    if (found.count > 0) add(kind, found.count, place(out_.mesh.source[found.facet], found.middle), what);
  }

 private:
  void add(DefectKind kind, std::uint64_t count, const std::string& first, const std::string& what) {
    out_.defects.push_back({kind, count, first});
    const std::size_t consequence = std::min(what.find(';'), what.size());
    out_.warnings.push_back(what.substr(0, consequence) + ", first " + first + what.substr(consequence));
  }

  const Stl& stl_;
  CheckedMesh& out_;
};

Result<void> check_coordinates(const Stl& stl) {
  // Written so that NaN fails too.
  const auto good = [](Point<Part> p) {
    return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
           std::abs(p.z) <= kMaxCoordinate;
  };
  const std::size_t bad = tbb::parallel_reduce(
      Range(0, stl.facets.size(), kGrain), stl.facets.size(),
      [&](const Range& range, std::size_t first) {
        for (std::size_t i = range.begin(); i < std::min(range.end(), first); ++i)
          if (!std::all_of(stl.facets[i].begin(), stl.facets[i].end(), good)) first = i;
        return first;
      },
      [](std::size_t x, std::size_t y) { return std::min(x, y); });
  if (bad == stl.facets.size()) return {};
  const Point<Part> at = *std::find_if_not(stl.facets[bad].begin(), stl.facets[bad].end(), good);
  return fail(Code::kMesh, "facet " + std::to_string(bad) + " has a corner at " + to_string(at) +
                               " mm, beyond the limit of " + std::to_string(std::lround(kMaxCoordinate)) +
                               " mm; check the unit of the file, or move the part to its origin");
}

void measure(CheckedMesh& out) {
  const std::vector<Point<Part>>& v = out.mesh.vertices;
  // Fixed blocks, added up in their order: the same sum for any number of threads.
  const Box box = tbb::parallel_deterministic_reduce(
      Range(0, v.size(), kGrain), Box{v[0], v[0]},
      [&v](const Range& range, Box b) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) b = grown(b, v[i]);
        return b;
      },
      [](const Box& a, const Box& b) { return grown(grown(a, b.min), b.max); });
  out.bounds = box;
  const Point<Part> centre = lerp(box.min, box.max, 0.5);  // near the part: a far origin costs digits
  const double six_volumes = tbb::parallel_deterministic_reduce(
      Range(0, out.mesh.facets.size(), kGrain), 0.0,
      [&](const Range& range, double sum) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          const Facet& f = out.mesh.facets[i];
          sum += dot(v[f[0]] - centre, cross(v[f[1]] - centre, v[f[2]] - centre));
        }
        return sum;
      },
      std::plus<>{});
  out.volume = six_volumes / 6.0;

  const Vec3 size = box.max - box.min;
  if (std::max({size.x, size.y, size.z}) >= kSmallestPart) return;
  out.warnings.push_back("the part is only " + to_string(Point<Part>{size.x, size.y, size.z}) +
                         " mm large: check the unit of the file (metres, inches)");
}

void name_flipped(const Found& flipped, Findings& findings) {
  findings.facets(DefectKind::kFlipped, flipped,
                  counted(flipped.count, "facet faces", "facets face") +
                      " the other way than the neighbours; turned over");
}

void name_inside_out(const Found& shells, Findings& findings) {
  findings.facets(DefectKind::kInsideOut, shells,
                  counted(shells.count, "closed shell is", "closed shells are") +
                      " inside out; turned over, so that normals point out of the material");
}

/// Turns closed shells that are inside out. Requires: every edge is sound.
void turn_shells(CheckedMesh& out, const Shells& shells, Findings& findings) {
  const InsideOut found = turn_outward(out.mesh, shells);
  if (!found.certain) {
    out.sides = Sides::kBoth;
    out.warnings.push_back(std::to_string(shells.count) +
                           " closed shells, some inside out, are too many to tell which contains which" +
                           kBothSides);
  }
  if (found.shells.empty()) return;
  const auto first = std::find(shells.of_facet.begin(), shells.of_facet.end(), found.shells[0]);
  name_inside_out({found.shells.size(), out.mesh.source[first - shells.of_facet.begin()]}, findings);
}

bool is_closed(const EdgeCounts& counts) {
  return of(counts, EdgeState::kOpen).count == 0 && of(counts, EdgeState::kNonManifold).count == 0;
}

/// `broken`, `turned`: what becomes of edges that have not two facets; whose two facets disagree.
void name_edges(const EdgeCounts& counts, const std::string& broken, const std::string& turned,
                Findings& findings) {
  const EdgeCount& open = of(counts, EdgeState::kOpen);
  const EdgeCount& non_manifold = of(counts, EdgeState::kNonManifold);
  const EdgeCount& misoriented = of(counts, EdgeState::kMisoriented);
  findings.edges(DefectKind::kOpenEdge, open,
                 counted(open.count, "edge has", "edges have") + " one facet only: holes or cracks" + broken);
  findings.edges(DefectKind::kNonManifold, non_manifold,
                 counted(non_manifold.count, "edge has", "edges have") + " more than two facets" + broken);
  findings.edges(
      DefectKind::kMisoriented, misoriented,
      counted(misoriented.count, "edge joins", "edges join") + " facets that face opposite ways" + turned);
}

void name_repair(const Repair& fixed, double distance, Findings& findings) {
  const std::string half = number_text(distance / 2) + " mm";
  name_flipped(fixed.flipped, findings);
  name_inside_out(fixed.inside_out, findings);
  findings.facets(DefectKind::kWelded, fixed.welded,
                  counted(fixed.welded.count, "corner lies", "corners lie") +
                      " beside another of an open edge; moved onto it, by at most " + half);
  findings.facets(
      DefectKind::kSplit, fixed.split,
      counted(fixed.split.count, "facet has", "facets have") +
          " a neighbour's corner on an open edge; cut up there, which moves the edge by at most " + half);
  findings.facets(DefectKind::kFlap, fixed.flaps,
                  counted(fixed.flaps.count, "facet hangs", "facets hang") +
                      " on an edge that has its two facets, within " + half + " of it; left out");
  findings.facets(DefectKind::kSeparated, fixed.separated,
                  counted(fixed.separated.count, "edge is", "edges are") +
                      " where solids touch; each solid has corners of its own there, which moves no surface");
  findings.facets(DefectKind::kFilled, fixed.filled,
                  counted(fixed.filled.count, "hole is", "holes are") +
                      " taken for one or two missing facets, " + number_text(fixed.widest_hole) +
                      " mm wide at most; filled, though the file has no surface there");
}

/// What is done without a repair: `obstacle` is what stands against one, if it was tried.
void orient_as_found(CheckedMesh& out, const Shells& shells, const EdgeCounts& counts,
                     const std::string& obstacle, Findings& findings) {
  std::optional<std::vector<std::uint32_t>> flipped{std::in_place};
  if (of(counts, EdgeState::kMisoriented).count > 0) flipped = orient_facets(out.mesh);
  if (!is_closed(counts) || !flipped) out.sides = Sides::kBoth;
  const std::string why = obstacle.empty() ? "" : "; not repaired: " + obstacle;
  name_edges(counts, why + kBothSides, flipped ? "; repaired" : kBothSides, findings);
  if (flipped && !flipped->empty())
    name_flipped({flipped->size(), out.mesh.source[flipped->front()]}, findings);
  // Turning facets over changes no neighbourhood, so the shells found before still serve.
  if (out.sides == Sides::kOutward) turn_shells(out, shells, findings);
}

}  // namespace

Result<CheckedMesh> check_mesh(const Stl& stl, const RepairOptions& options) {
  return check_mesh(stl, options, {});
}

Result<CheckedMesh> check_mesh(const Stl& stl, const RepairOptions& options, const ReportShare& report) {
  if (auto good = check_coordinates(stl); !good) return tl::unexpected(good.error());
  const auto stopped = [&](double share) { return report && !report(share); };
  if (stopped(kFinite)) return cancelled();
  Welded welded = weld(stl, part_of(report, kFinite, kJoined));
  if (welded.mesh.facets.size() == welded.seams.size()) {
    return fail(Code::kMesh, "nothing is left to plan: all " + std::to_string(stl.facets.size()) +
                                 " facets are without area; check the unit of the file and export it again");
  }
  CheckedMesh out;
  out.mesh = std::move(welded.mesh);
  Findings findings(stl, out);
  findings.facets(DefectKind::kDegenerate, welded.degenerate,
                  counted(welded.degenerate.count, "facet has", "facets have") +
                      " no area; left out, which changes no surface");
  findings.facets(DefectKind::kDuplicate, welded.duplicate,
                  counted(welded.duplicate.count, "facet lies", "facets lie") +
                      " on the corners of an earlier one; left out, which changes no surface");

  if (stopped(kJoined)) return cancelled();
  const EdgeCounts counts = count_edges(welded, out.mesh);
  if (stopped(kCounted)) return cancelled();
  Repair fixed;
  if (!is_closed(counts) && options.distance > 0.0)
    fixed = repair(out.mesh, welded.fans, options.distance, part_of(report, kCounted, kRepaired));
  if (stopped(kRepaired)) return cancelled();
  if (fixed.mesh) {
    name_edges(counts, "; repaired", "; repaired", findings);
    name_repair(fixed, options.distance, findings);
    out.mesh = std::move(*fixed.mesh);
    remove_facets(out.mesh, without_area(out.mesh));
  } else {
    orient_as_found(out, welded.survey.shells, counts, fixed.obstacle, findings);
    if (!welded.seams.empty()) remove_facets(out.mesh, welded.seams);
  }
  measure(out);
  return out;
}

}  // namespace tiltfeed::pathgen
