#include "pathgen/mesh.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kinematics/tool_path.h"
#include "pathgen/orient.h"
#include "pathgen/topology.h"
#include "pathgen/weld.h"

namespace tiltfeed {
namespace {

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

EdgeCounts count_edges(const EdgeTable& edges, const Mesh& mesh) {
  EdgeCounts counts;
  edges.each_edge([&](std::span<const HalfEdge> edge) {
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

  void facets(DefectKind kind, std::uint64_t count, std::uint32_t first, const std::string& what) {
    if (count > 0) add(kind, count, place(first, stl_.facets[first][0]), what);
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
  for (std::size_t i = 0; i < stl.facets.size(); ++i) {
    for (const Point<Part>& p : stl.facets[i]) {
      // Written so that NaN fails too.
      const bool good = std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
                        std::abs(p.z) <= kMaxCoordinate;
      if (good) continue;
      return fail(Code::kMesh, "facet " + std::to_string(i) + " has a corner at " + to_string(p) +
                                   " mm, beyond the limit of " + std::to_string(std::lround(kMaxCoordinate)) +
                                   " mm; check the unit of the file, or move the part to its origin");
    }
  }
  return {};
}

void measure(CheckedMesh& out) {
  const std::vector<Point<Part>>& v = out.mesh.vertices;
  Box box{v[0], v[0]};
  for (const Point<Part>& p : v) {
    box.min = {std::min(box.min.x, p.x), std::min(box.min.y, p.y), std::min(box.min.z, p.z)};
    box.max = {std::max(box.max.x, p.x), std::max(box.max.y, p.y), std::max(box.max.z, p.z)};
  }
  out.bounds = box;
  const Point<Part> centre = lerp(box.min, box.max, 0.5);  // near the part: a far origin costs digits
  double six_volumes = 0.0;
  for (const Facet& f : out.mesh.facets)
    six_volumes += dot(v[f[0]] - centre, cross(v[f[1]] - centre, v[f[2]] - centre));
  out.volume = six_volumes / 6.0;

  const Vec3 size = box.max - box.min;
  const double longest = std::max({size.x, size.y, size.z});
  if (longest < kSmallestPart) {
    out.warnings.push_back("the part is only " + to_string(Point<Part>{size.x, size.y, size.z}) +
                           " mm large: check the unit of the file (metres, inches)");
  }
}

/// Turns closed shells that are inside out. Requires: every edge is sound.
void repair_shells(CheckedMesh& out, const EdgeTable& edges, Findings& findings) {
  const Shells shells = find_shells(edges, out.mesh.facets.size());
  const InsideOut found = turn_outward(out.mesh, shells);
  if (!found.certain) {
    out.sides = Sides::kBoth;
    out.warnings.push_back(std::to_string(shells.count) +
                           " closed shells, some inside out, are too many to tell which contains which" +
                           kBothSides);
  }
  if (found.shells.empty()) return;
  const auto first = std::find(shells.of_facet.begin(), shells.of_facet.end(), found.shells[0]);
  findings.facets(DefectKind::kInsideOut, found.shells.size(),
                  out.mesh.source[first - shells.of_facet.begin()],
                  counted(found.shells.size(), "closed shell is", "closed shells are") +
                      " inside out; turned over, so that normals point out of the material");
}

}  // namespace

std::string to_string(DefectKind kind) {
  switch (kind) {
    case DefectKind::kDegenerate:
      return "facets without area";
    case DefectKind::kDuplicate:
      return "duplicate facets";
    case DefectKind::kOpenEdge:
      return "open edges";
    case DefectKind::kNonManifold:
      return "edges with more than two facets";
    case DefectKind::kMisoriented:
      return "edges between facets that face opposite ways";
    case DefectKind::kFlipped:
      return "facets turned over";
    case DefectKind::kInsideOut:
      return "shells inside out";
  }
  return "unknown defect";
}

Result<CheckedMesh> check_mesh(const Stl& stl) {
  if (auto good = check_coordinates(stl); !good) return tl::unexpected(good.error());
  Welded welded = weld(stl);
  if (welded.mesh.facets.size() == welded.seams.size()) {
    return fail(Code::kMesh, "nothing is left to plan: all " + std::to_string(stl.facets.size()) +
                                 " facets are without area; check the unit of the file and export it again");
  }
  CheckedMesh out;
  out.mesh = std::move(welded.mesh);
  Findings findings(stl, out);
  findings.facets(DefectKind::kDegenerate, welded.degenerate.count, welded.degenerate.first,
                  counted(welded.degenerate.count, "facet has", "facets have") +
                      " no area; left out, which changes no surface");
  findings.facets(DefectKind::kDuplicate, welded.duplicate.count, welded.duplicate.first,
                  counted(welded.duplicate.count, "facet lies", "facets lie") +
                      " on the corners of an earlier one; left out, which changes no surface");

  const EdgeTable edges(out.mesh.facets, out.mesh.vertices.size());
  const EdgeCounts counts = count_edges(edges, out.mesh);
  const EdgeCount& open = of(counts, EdgeState::kOpen);
  const EdgeCount& non_manifold = of(counts, EdgeState::kNonManifold);
  const EdgeCount& misoriented = of(counts, EdgeState::kMisoriented);
  std::optional<std::vector<std::uint32_t>> flipped{std::in_place};
  if (misoriented.count > 0) flipped = orient_facets(out.mesh);
  if (open.count > 0 || non_manifold.count > 0 || !flipped) out.sides = Sides::kBoth;

  findings.edges(
      DefectKind::kOpenEdge, open,
      counted(open.count, "edge has", "edges have") + " one facet only: holes or cracks" + kBothSides);
  findings.edges(
      DefectKind::kNonManifold, non_manifold,
      counted(non_manifold.count, "edge has", "edges have") + " more than two facets" + kBothSides);
  findings.edges(DefectKind::kMisoriented, misoriented,
                 counted(misoriented.count, "edge joins", "edges join") + " facets that face opposite ways" +
                     (flipped ? "; repaired" : kBothSides));
  if (flipped && !flipped->empty()) {
    findings.facets(DefectKind::kFlipped, flipped->size(), out.mesh.source[flipped->front()],
                    counted(flipped->size(), "facet faces", "facets face") +
                        " the other way than the neighbours; turned over");
  }
  // Turning facets over changes no neighbourhood, so the edges found before still serve.
  if (out.sides == Sides::kOutward) repair_shells(out, edges, findings);

  remove_facets(out.mesh, welded.seams);
  measure(out);
  return out;
}

}  // namespace tiltfeed
