#include "cad/shape/face_mesh.h"

#include <BRepAdaptor_Curve.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "cad/shape/surface_gap.h"

namespace tiltfeed::cad {
namespace {

using Key = std::uint64_t;

// Barycentric: the middle, of each side, and half way from the middle to each corner.
constexpr std::array<std::array<double, 3>, 7> kInside = {{{1.0 / 3, 1.0 / 3, 1.0 / 3},
                                                           {0.5, 0.5, 0.0},
                                                           {0.0, 0.5, 0.5},
                                                           {0.5, 0.0, 0.5},
                                                           {2.0 / 3, 1.0 / 6, 1.0 / 6},
                                                           {1.0 / 6, 2.0 / 3, 1.0 / 6},
                                                           {1.0 / 6, 1.0 / 6, 2.0 / 3}}};
constexpr std::array<double, 3> kAlongEdge = {0.25, 0.5, 0.75};
/// A side is halved where its middle has this share of its facet's distance: those along which the surface
/// is straight are left.
constexpr double kBentSide = 0.3;

Point<Part> point_of(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

double to_segment(Point<Part> p, Point<Part> a, Point<Part> b) {
  const Vec3 along = b - a;
  const double square = dot(along, along);
  const double t = square > 0.0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0.0;
  return length(p - (a + along * t));
}

struct Corner {
  Point<Part> at;
  gp_Pnt2d uv;
};
struct Facet {
  std::array<std::uint32_t, 3> corners{};
  double off = 0.0;   ///< from the surface, mm, when measured
  bool done = false;  ///< measured, and within what is allowed
};
struct EdgeCurve {
  BRepAdaptor_Curve curve;
  Handle(Geom2d_Curve) flat;
};
/// A facet's side that stands for a piece of an edge, from corner `from` to `to` along it.
struct EdgeSide {
  EdgePiece piece;
  std::size_t curve = 0;
  std::uint32_t from = 0, to = 0;
  double t_from = 0.0, t_to = 0.0;
  double off = 0.0;  ///< from the edge's curve, mm, when measured
};

Key key_of(std::uint32_t a, std::uint32_t b) {
  return (static_cast<Key>(std::min(a, b)) << 32) | std::max(a, b);
}

/// The value beside `near` that is `u` on a surface that comes back to itself after `period`.
double unwound(double u, double near, double period) { return u - period * std::round((u - near) / period); }

}  // namespace

struct FaceMesh::State {
  explicit State(const TopoDS_Face& of)
      : face(of), surface(of, true), gap(of), turned(of.Orientation() == TopAbs_REVERSED) {}

  TopoDS_Face face;
  BRepAdaptor_Surface surface;
  SurfaceGap gap;
  bool turned;
  std::vector<Corner> corners;
  std::vector<Facet> facets;
  std::vector<EdgeCurve> curves;
  std::unordered_map<Key, EdgeSide> sides;         ///< on edges
  std::vector<Key> new_sides;                      ///< of them those to be measured, in order
  std::unordered_set<Key> alone;                   ///< sides of one facet on no known edge: never halved
  std::unordered_set<Key> marked;                  ///< to be halved, but for those on edges
  std::unordered_map<Key, std::uint32_t> middles;  ///< of this round
  double at_corners = 0.0;

  void add_corner(Point<Part> at, gp_Pnt2d uv) {
    corners.push_back({at, uv});
    at_corners = std::max(at_corners, gap(at, uv.X(), uv.Y()));
  }
  void add_side(EdgeSide side) {
    const Key key = key_of(side.from, side.to);
    if (sides.emplace(key, side).second) new_sides.push_back(key);
  }
  void read_edge(const TopoDS_Edge& edge, std::size_t number, const Handle(Poly_Triangulation) & mesh,
                 const TopLoc_Location& at);
  void find_alone();
  bool is_flat(const Facet& facet) const;
  void measure_side(EdgeSide& side) const;
  bool mark(const Facet& facet, const std::array<double, 3>& bent, double most, EdgeHalves& halves);
  std::uint32_t middle(std::uint32_t a, std::uint32_t b, EdgeHalves& halves);
  bool halved(std::uint32_t a, std::uint32_t b, const EdgeHalves& halves) const;
  double flat_area(const std::array<std::uint32_t, 3>& c) const;
};

void FaceMesh::State::read_edge(const TopoDS_Edge& edge, std::size_t number,
                                const Handle(Poly_Triangulation) & mesh, const TopLoc_Location& at) {
  if (BRep_Tool::Degenerated(edge)) return;
  const Handle(Poly_PolygonOnTriangulation) chain = BRep_Tool::PolygonOnTriangulation(edge, mesh, at);
  if (chain.IsNull() || !chain->HasParameters()) return;
  double first = 0.0, last = 0.0;
  const Handle(Geom2d_Curve) flat = BRep_Tool::CurveOnSurface(edge, face, first, last);
  if (flat.IsNull()) return;
  curves.push_back({BRepAdaptor_Curve(edge), flat});
  const int count = chain->NbNodes();
  const bool backward = chain->Parameter(1) > chain->Parameter(count);
  for (int i = 0; i + 1 < count; ++i) {
    const int a = backward ? count - i : i + 1, b = backward ? a - 1 : a + 1;
    EdgeSide side{{number, double(i), double(i + 1)},
                  curves.size() - 1,
                  static_cast<std::uint32_t>(chain->Node(a) - 1),
                  static_cast<std::uint32_t>(chain->Node(b) - 1),
                  chain->Parameter(a),
                  chain->Parameter(b)};
    add_side(side);
  }
}

void FaceMesh::State::find_alone() {
  std::unordered_map<Key, int> count;
  for (const Facet& facet : facets)
    for (std::size_t k = 0; k < 3; ++k) ++count[key_of(facet.corners[k], facet.corners[(k + 1) % 3])];
  for (const auto& [key, times] : count)
    if (times == 1 && !sides.contains(key)) alone.insert(key);
}

std::unique_ptr<FaceMesh> FaceMesh::read(const TopoDS_Face& face,
                                         const std::function<std::size_t(const TopoDS_Edge&)>& number) {
  TopLoc_Location at;
  const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, at);
  if (mesh.IsNull() || mesh->NbTriangles() == 0 || !mesh->HasUVNodes()) return nullptr;
  auto state = std::make_unique<State>(face);
  for (int i = 1; i <= mesh->NbNodes(); ++i)
    state->add_corner(point_of(mesh->Node(i).Transformed(at.Transformation())), mesh->UVNode(i));
  for (int i = 1; i <= mesh->NbTriangles(); ++i) {
    std::array<int, 3> node{};
    mesh->Triangle(i).Get(node[0], node[1], node[2]);
    Facet facet;
    for (std::size_t k = 0; k < 3; ++k) facet.corners[k] = static_cast<std::uint32_t>(node[k] - 1);
    state->facets.push_back(facet);
  }
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
    const TopoDS_Edge& edge = TopoDS::Edge(e.Current());
    state->read_edge(edge, number(edge), mesh, at);
  }
  state->find_alone();
  return std::unique_ptr<FaceMesh>(new FaceMesh(std::move(state)));
}

FaceMesh::FaceMesh(std::unique_ptr<State> state) : state_(std::move(state)) {}
FaceMesh::~FaceMesh() = default;

/// At a pole corners are one place.
bool FaceMesh::State::is_flat(const Facet& facet) const {
  const Point<Part> a = corners[facet.corners[0]].at;
  const Vec3 b = corners[facet.corners[1]].at - a, c = corners[facet.corners[2]].at - a;
  return dot(b, b) == 0.0 || dot(c, c) == 0.0 || dot(b - c, b - c) == 0.0;
}

void FaceMesh::State::measure_side(EdgeSide& side) const {
  side.off = 0.0;
  for (const double share : kAlongEdge) {
    const double t = side.t_from + share * (side.t_to - side.t_from);
    side.off = std::max(side.off, to_segment(point_of(curves[side.curve].curve.Value(t)),
                                             corners[side.from].at, corners[side.to].at));
  }
}

/// `bent`: distances of the middles of the facet's sides. True: noted one at least.
bool FaceMesh::State::mark(const Facet& facet, const std::array<double, 3>& bent, double most,
                           EdgeHalves& halves) {
  const auto note = [&](std::size_t k) {
    const Key key = key_of(facet.corners[k], facet.corners[(k + 1) % 3]);
    if (const auto side = sides.find(key); side != sides.end())
      halves.wanted.insert(side->second.piece);
    else
      marked.insert(key);
  };
  bool any = false;
  std::size_t longest = 3;
  double reach = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t a = facet.corners[k], b = facet.corners[(k + 1) % 3];
    if (alone.contains(key_of(a, b))) continue;
    const double length = distance(corners[a].at, corners[b].at);
    if (length > reach) reach = length, longest = k;
    if (bent[k] < kBentSide * most) continue;
    note(k), any = true;
  }
  if (any || longest == 3) return any;
  note(longest);
  return true;
}

bool FaceMesh::measure(double allowed, EdgeHalves& halves) {
  State& s = *state_;
  bool any = false;
  std::vector<Key> still;
  for (const Key key : s.new_sides) {
    EdgeSide& side = s.sides.at(key);
    s.measure_side(side);
    if (side.off <= allowed) continue;
    still.push_back(key), halves.wanted.insert(side.piece), any = true;
  }
  s.new_sides = std::move(still);
  for (Facet& facet : s.facets) {
    if (facet.done) continue;
    if (s.is_flat(facet)) {
      facet.done = true;
      continue;
    }
    const Corner &a = s.corners[facet.corners[0]], &b = s.corners[facet.corners[1]],
                 &c = s.corners[facet.corners[2]];
    const Vec3 ab = b.at - a.at, ac = c.at - a.at;
    std::array<double, kInside.size()> off{};
    for (std::size_t i = 0; i < kInside.size(); ++i) {
      const auto& [p, q, r] = kInside[i];
      off[i] = s.gap(a.at + ab * q + ac * r, p * a.uv.X() + q * b.uv.X() + r * c.uv.X(),
                     p * a.uv.Y() + q * b.uv.Y() + r * c.uv.Y());
    }
    const double most = *std::max_element(off.begin(), off.end());
    facet.off = most, facet.done = most <= allowed;
    if (!facet.done) any = s.mark(facet, {off[1], off[2], off[3]}, most, halves) || any;
  }
  return any;
}

bool FaceMesh::State::halved(std::uint32_t a, std::uint32_t b, const EdgeHalves& halves) const {
  const Key key = key_of(a, b);
  const auto side = sides.find(key);
  return side != sides.end() ? halves.wanted.contains(side->second.piece) : marked.contains(key);
}

std::uint32_t FaceMesh::State::middle(std::uint32_t a, std::uint32_t b, EdgeHalves& halves) {
  const Key key = key_of(a, b);
  const auto [known, is_new] = middles.try_emplace(key, static_cast<std::uint32_t>(corners.size()));
  if (!is_new) return known->second;
  const std::uint32_t m = known->second;
  const gp_Pnt2d &ua = corners[a].uv, &ub = corners[b].uv;
  const gp_Pnt2d half((ua.X() + ub.X()) / 2.0, (ua.Y() + ub.Y()) / 2.0);
  const auto found = sides.find(key);
  if (found == sides.end()) {
    add_corner(point_of(surface.Value(half.X(), half.Y())), half);
    return m;
  }
  const EdgeSide side = found->second;
  const double t = (side.t_from + side.t_to) / 2.0, at = (side.piece.from + side.piece.to) / 2.0;
  gp_Pnt2d uv = curves[side.curve].flat->Value(t);
  if (surface.IsUPeriodic()) uv.SetX(unwound(uv.X(), half.X(), surface.UPeriod()));
  if (surface.IsVPeriodic()) uv.SetY(unwound(uv.Y(), half.Y(), surface.VPeriod()));
  const auto [place, first] =
      halves.middles.try_emplace(side.piece, point_of(curves[side.curve].curve.Value(t)));
  add_corner(place->second, uv);
  add_side({{side.piece.edge, side.piece.from, at}, side.curve, side.from, m, side.t_from, t});
  add_side({{side.piece.edge, at, side.piece.to}, side.curve, m, side.to, t, side.t_to});
  return m;
}

double FaceMesh::State::flat_area(const std::array<std::uint32_t, 3>& c) const {
  const gp_Pnt2d &p = corners[c[0]].uv, &q = corners[c[1]].uv, &r = corners[c[2]].uv;
  return (q.X() - p.X()) * (r.Y() - p.Y()) - (q.Y() - p.Y()) * (r.X() - p.X());
}

bool FaceMesh::split(EdgeHalves& halves) {
  State& s = *state_;
  s.middles.clear();
  std::vector<Facet> after;
  bool folds = false;
  for (const Facet& facet : s.facets) {
    const std::array<std::uint32_t, 3>& c = facet.corners;
    const std::array<bool, 3> cut{s.halved(c[0], c[1], halves), s.halved(c[1], c[2], halves),
                                  s.halved(c[2], c[0], halves)};
    const auto count = std::count(cut.begin(), cut.end(), true);
    if (count == 0) {
      after.push_back(facet);
      continue;
    }
    const double before = s.flat_area(c);
    const auto add = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
      after.push_back({{i, j, k}});
      folds = folds || s.flat_area({i, j, k}) * before < 0.0;
    };
    // Turned so that the first side is halved, and with two the last is not.
    std::size_t k = 0;
    while (!cut[k] || (count == 2 && cut[(k + 2) % 3])) ++k;
    const std::uint32_t i = c[k], j = c[(k + 1) % 3], l = c[(k + 2) % 3];
    const std::uint32_t ij = s.middle(i, j, halves);
    if (count == 1) {
      add(i, ij, l), add(ij, j, l);
      continue;
    }
    const std::uint32_t jl = s.middle(j, l, halves);
    add(ij, j, jl);
    if (count == 3) {
      const std::uint32_t li = s.middle(l, i, halves);
      add(i, ij, li), add(li, jl, l), add(ij, jl, li);
    } else if (distance(s.corners[i].at, s.corners[jl].at) <= distance(s.corners[ij].at, s.corners[l].at)) {
      add(i, ij, jl), add(i, jl, l);
    } else {
      add(i, ij, l), add(ij, jl, l);
    }
  }
  // The halves stand for these now.
  for (const auto& [key, m] : s.middles) s.sides.erase(key);
  std::erase_if(s.new_sides, [&](Key key) { return !s.sides.contains(key); });
  s.facets = std::move(after);
  s.marked.clear();
  return !folds;
}

std::size_t FaceMesh::facets() const { return state_->facets.size(); }
double FaceMesh::deviation() const {
  double most = state_->at_corners;
  for (const Facet& facet : state_->facets) most = std::max(most, facet.off);
  for (const auto& [key, side] : state_->sides) most = std::max(most, side.off);
  return most;
}
double FaceMesh::at_corners() const { return state_->at_corners; }
std::string FaceMesh::surface() const { return state_->gap.kind(); }

pathgen::FaceFacets FaceMesh::oriented() const {
  const State& s = *state_;
  pathgen::FaceFacets out;
  for (const Corner& corner : s.corners) {
    out.corners.push_back(corner.at);
    const Vec3 n = s.gap.normal(corner.uv.X(), corner.uv.Y());
    out.normals.push_back(s.turned ? -n : n);
  }
  for (const Facet& facet : s.facets) {
    if (s.is_flat(facet)) continue;
    const auto& [a, b, c] = facet.corners;
    out.facets.push_back(s.turned ? std::array{a, c, b} : std::array{a, b, c});
  }
  return out;
}

}  // namespace tiltfeed::cad
