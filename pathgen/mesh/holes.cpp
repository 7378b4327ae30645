#include "pathgen/mesh/holes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "kinematics/basics/units.h"
#include "pathgen/mesh/weld.h"

namespace tiltfeed::pathgen {
namespace {

/// A rim's edge, run the way a fill runs along it.
struct Step {
  std::uint32_t to, facet;
};

/// By their first corner; in the order of the edges, so the choice at a corner with several is fixed.
using Steps = std::multimap<std::uint32_t, Step>;

/// Walks until no step leads on; each time a corner comes again, what lies between is a hole.
void walk(Steps& steps, std::uint32_t start, std::vector<Hole>& holes) {
  Hole path;  // beside has one element less than corners
  std::unordered_map<std::uint32_t, std::size_t> place;
  path.corners.push_back(start);
  place[start] = 0;
  for (auto step = steps.find(start); step != steps.end(); step = steps.find(path.corners.back())) {
    const auto [to, facet] = step->second;
    steps.erase(step);
    path.beside.push_back(facet);
    const auto seen = place.find(to);
    if (seen == place.end()) {
      place[to] = path.corners.size();
      path.corners.push_back(to);
      continue;
    }
    const auto from = static_cast<std::ptrdiff_t>(seen->second);
    holes.push_back(
        {{path.corners.begin() + from, path.corners.end()}, {path.beside.begin() + from, path.beside.end()}});
    for (std::size_t i = seen->second + 1; i < path.corners.size(); ++i) place.erase(path.corners[i]);
    path.corners.resize(seen->second + 1);
    path.beside.resize(seen->second);
  }
}

Vec3 normal_of(const Mesh& mesh, const Facet& f) {
  return cross(mesh.vertices[f[1]] - mesh.vertices[f[0]], mesh.vertices[f[2]] - mesh.vertices[f[0]]);
}

/// 0 where one of them has no area: it lies in any plane.
double turn(const Mesh& mesh, const Facet& a, const Facet& b) {
  if (!has_area(mesh, a) || !has_area(mesh, b)) return 0.0;
  return angle_between(normal_of(mesh, a), normal_of(mesh, b));
}

/// Corners of the hole by their place in it, in the hole's order.
using Piece = std::array<std::size_t, 3>;
using Pieces = std::vector<Piece>;

/// All ways to cut a polygon of three or four corners into triangles.
std::vector<Pieces> triangulations(std::size_t corners) {
  if (corners == 3) return {{{0, 1, 2}}};
  return {{{0, 1, 2}, {2, 3, 0}}, {{1, 2, 3}, {3, 0, 1}}};
}

/// How a triangulation turns at its edges, rad.
struct Turns {
  double largest = 0.0;       ///< at any edge, the rim's included
  double least_at_rim = 0.0;  ///< each facet's least at its edges on the rim; the largest of those
};

Turns turns_of(const Mesh& mesh, const Hole& hole, const Pieces& pieces) {
  const auto facet = [&](const Piece& p) {
    return Facet{hole.corners[p[0]], hole.corners[p[1]], hole.corners[p[2]]};
  };
  Turns turns;
  if (pieces.size() == 2) turns.largest = turn(mesh, facet(pieces[0]), facet(pieces[1]));
  for (const Piece& p : pieces) {
    double least = kPi;
    for (int k = 0; k < 3; ++k) {
      if (p[(k + 1) % 3] != (p[k] + 1) % hole.corners.size()) continue;  // the diagonal
      const double here = turn(mesh, facet(p), mesh.facets[hole.beside[p[k]]]);
      least = std::min(least, here);
      turns.largest = std::max(turns.largest, here);
    }
    turns.least_at_rim = std::max(turns.least_at_rim, least);
  }
  return turns;
}

}  // namespace

std::vector<Hole> find_holes(const VertexFans& fans) {
  Steps steps;
  fans.each_edge([&](std::span<const HalfEdge> edge) {
    if (edge.size() != 1) return;
    const HalfEdge& e = edge[0];
    steps.insert({e.forward ? e.high : e.low, {e.forward ? e.low : e.high, e.facet}});
  });
  std::vector<Hole> holes;
  while (!steps.empty()) walk(steps, steps.begin()->first, holes);
  return holes;
}

double width(const Mesh& mesh, const Hole& hole) {
  double squared = 0.0;
  for (std::uint32_t a : hole.corners)
    for (std::uint32_t b : hole.corners)
      squared = std::max(squared, squared_length(mesh.vertices[a] - mesh.vertices[b]));
  return std::sqrt(squared);
}

Fill fill(const Mesh& mesh, const Hole& hole) {
  const std::size_t n = hole.corners.size();
  const std::string where = " at " + to_string(mesh.vertices[hole.corners[0]]);
  const std::string only = ", and only holes of at most ", missing = " are taken for missing facets";
  if (n > kMaxHoleEdges)
    return {{},
            "the rim" + where + " has " + std::to_string(n) + " edges" + only +
                std::to_string(kMaxHoleEdges) + missing};
  const double most = Angle::from_degrees(kMaxHoleTurnDegrees).radians();
  const auto better = [most](const Turns& a, const Turns& b) {
    const bool a_goes_on = a.least_at_rim <= most, b_goes_on = b.least_at_rim <= most;
    return a_goes_on != b_goes_on ? a_goes_on : a.largest < b.largest;
  };
  Pieces best;
  Turns least;
  for (const Pieces& pieces : triangulations(n)) {
    const Turns turns = turns_of(mesh, hole, pieces);
    if (!best.empty() && !better(turns, least)) continue;
    best = pieces;
    least = turns;
  }
  if (least.least_at_rim > most)
    return {{},
            "a fill of the hole" + where + " would turn by " +
                number_text(Angle::from_radians(least.least_at_rim).degrees()) +
                " degrees from the facets beside it" + only + number_text(kMaxHoleTurnDegrees) + missing};
  Fill out;
  for (const Piece& p : best)
    out.facets.push_back({hole.corners[p[0]], hole.corners[p[1]], hole.corners[p[2]]});
  return out;
}

}  // namespace tiltfeed::pathgen
