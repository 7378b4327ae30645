#include "pathgen/cl_surface.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace tiltfeed {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
/// A facet steeper than this against the axis (cosine) has no height of its own: its edges carry it.
constexpr double kSteepest = 1e-9;
/// Beyond this angle between its two normals (cosine of 120 degrees) an edge's patch is bounded by its ball
/// only.
constexpr double kWideWedge = -0.5;
/// The same for the normals round a vertex against their mean (cosine of 60 degrees).
constexpr double kNarrowFan = 0.5;

struct HalfEdge {
  std::uint32_t low, high;    ///< its vertices, ordered
  std::uint32_t facet, apex;  ///< the facet it bounds, and that facet's third corner
  bool rising;                ///< the facet runs along it from low to high
};

std::vector<HalfEdge> sorted_half_edges(const Mesh& mesh) {
  std::vector<HalfEdge> all;
  all.reserve(mesh.facets.size() * 3);
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f)
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = mesh.facets[f][i], b = mesh.facets[f][(i + 1) % 3],
                          c = mesh.facets[f][(i + 2) % 3];
      all.push_back({std::min(a, b), std::max(a, b), f, c, a < b});
    }
  std::sort(all.begin(), all.end(), [](const HalfEdge& l, const HalfEdge& r) {
    if (l.low != r.low) return l.low < r.low;
    if (l.high != r.high) return l.high < r.high;
    return l.facet < r.facet;
  });
  return all;
}

}  // namespace

ClSurface::ClSurface(const Mesh& mesh, Sides sides, double radius)
    : mesh_(mesh), sides_(sides), radius_(radius) {
  assert(radius > 0.0);
  normals_.reserve(mesh.facets.size());
  for (const auto& f : mesh.facets)
    normals_.push_back(normalized(
        cross(mesh.vertices[f[1]] - mesh.vertices[f[0]], mesh.vertices[f[2]] - mesh.vertices[f[0]])));
  find_vertices(find_edges());
}

/// An edge gets a patch when it is convex by more than the seam, or when it has not two facets, or when sides
/// are not known and it is bent at all.
std::vector<std::uint8_t> ClSurface::find_edges() {
  std::vector<std::uint8_t> disagree(mesh_.vertices.size(), 0);
  const std::vector<HalfEdge> all = sorted_half_edges(mesh_);
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    while (end < all.size() && all[end].low == all[i].low && all[end].high == all[i].high) ++end;
    EdgePatch edge{all[i].low, all[i].high, all[i].apex, kNone, all[i].facet, all[i].facet};
    bool bent = true;
    if (end - i != 2 || all[i].rising == all[i + 1].rising) disagree[edge.v0] = disagree[edge.v1] = 1;
    if (end - i == 2) {
      edge.w1 = all[i + 1].apex;
      edge.f1 = all[i + 1].facet;
      const Vec3 away = mesh_.vertices[edge.w1] - mesh_.vertices[edge.v0];
      const Vec3 along = normalized(mesh_.vertices[edge.v1] - mesh_.vertices[edge.v0]);
      const double rise =
          dot(normals_[edge.f0], away) / length(away - along * dot(away, along));  // sine of the bend
      const bool folded = dot(normals_[edge.f0], normals_[edge.f1]) < kWideWedge;
      bent = sides_ == Sides::kBoth ? folded || std::abs(rise) > kSeam
                                    : rise < -kSeam || (folded && rise <= kSeam);
    } else if (end - i > 2) {
      edge.w0 = kNone;  // several facets: the whole cylinder, which never reaches outside the offset body
    }
    if (bent) edges_.push_back(edge);
    i = end;
  }
  return disagree;
}

void ClSurface::find_vertices(const std::vector<std::uint8_t>& disagree) {
  std::vector<std::uint8_t> sticks_out(mesh_.vertices.size(), 0);
  for (const EdgePatch& e : edges_) sticks_out[e.v0] = sticks_out[e.v1] = 1;
  std::vector<std::uint32_t> start(mesh_.vertices.size() + 1, 0);
  for (const auto& f : mesh_.facets)
    for (std::uint32_t v : f) ++start[v + 1];
  for (std::size_t v = 0; v < mesh_.vertices.size(); ++v) start[v + 1] += start[v];
  fans_.resize(start.back());
  std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
  for (std::uint32_t f = 0; f < mesh_.facets.size(); ++f)
    for (std::uint32_t v : mesh_.facets[f]) fans_[next[v]++] = f;
  std::vector<std::uint32_t> ring;
  for (std::uint32_t v = 0; v < mesh_.vertices.size(); ++v) {
    if (!sticks_out[v]) continue;
    ring.clear();
    for (std::uint32_t k = start[v]; k < start[v + 1]; ++k)
      for (std::uint32_t w : mesh_.facets[fans_[k]])
        if (w != v) ring.push_back(w);
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    const auto first = static_cast<std::uint32_t>(neighbours_.size());
    neighbours_.insert(neighbours_.end(), ring.begin(), ring.end());
    vertices_.push_back(
        {v, first, static_cast<std::uint32_t>(neighbours_.size()), start[v], start[v + 1], disagree[v] == 0});
  }
}

std::uint32_t ClSurface::facet_of(PatchId patch) const {
  const std::size_t faces = mesh_.facets.size();
  if (patch < faces) return mesh_.source[patch];
  if (patch < faces + edges_.size()) return mesh_.source[edges_[patch - faces].f0];
  return mesh_.source[fans_[vertices_[patch - faces - edges_.size()].first_facet]];
}

bool ClSurface::top(PatchId patch, const AxisLine& line, ClHit& hit) const {
  const std::size_t faces = mesh_.facets.size();
  if (patch < faces) return face_top(patch, line, hit);
  if (patch < faces + edges_.size()) return edge_top(edges_[patch - faces], line, hit);
  return vertex_top(vertices_[patch - faces - edges_.size()], line, hit);
}

/// (C1) The plane of the facet, raised by R along its normal on the tool's side.
bool ClSurface::face_top(std::uint32_t facet, const AxisLine& line, ClHit& hit) const {
  Vec3 n = normals_[facet];
  double facing = dot(n, line.axis);
  if (sides_ == Sides::kBoth && facing < 0.0) n = -n, facing = -facing;
  if (facing < kSteepest) return false;
  const auto& f = mesh_.facets[facet];
  const Point<Part> a = mesh_.vertices[f[0]], b = mesh_.vertices[f[1]], c = mesh_.vertices[f[2]];
  hit.z = (radius_ - dot(n, line.base - a)) / facing;
  hit.normal = n;
  const Point<Part> q = line.base + line.axis * hit.z - n * radius_;
  const double slack = kSeam * radius_;
  const Vec3 m = normals_[facet];
  for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
    const Vec3 inward = cross(m, to - from);
    const double d = dot(inward, q - from);
    if (d < 0.0 && d * d > slack * slack * squared_length(to - from)) return false;
  }
  return true;
}

/// (C2) The cylinder of radius R round the edge, where the edge's facets lie behind the contact normal.
bool ClSurface::edge_top(const EdgePatch& edge, const AxisLine& line, ClHit& hit) const {
  const Point<Part> p = mesh_.vertices[edge.v0];
  const Vec3 e = mesh_.vertices[edge.v1] - p, w = line.base - p;
  const double ee = squared_length(e);
  const Vec3 a = line.axis - e * (dot(line.axis, e) / ee);
  const Vec3 o = w - e * (dot(w, e) / ee);
  const double aa = squared_length(a), ao = dot(a, o);
  const double disc = ao * ao - aa * (squared_length(o) - radius_ * radius_);
  if (disc < 0.0 || aa < kSteepest) return false;
  hit.z = (-ao + std::sqrt(disc)) / aa;
  const double along = dot(w + line.axis * hit.z, e);
  const double slack = kSeam * radius_ * std::sqrt(ee);
  if (along < -slack || along > ee + slack) return false;
  hit.normal = (o + a * hit.z) / radius_;
  for (std::uint32_t apex : {edge.w0, edge.w1}) {
    if (apex == kNone) continue;
    const Vec3 d = mesh_.vertices[apex] - p;
    const double ahead = dot(hit.normal, d);
    if (ahead > 0.0 && ahead * ahead > kSeam * kSeam * squared_length(d - e * (dot(d, e) / ee))) return false;
  }
  return true;
}

/// (C3) The sphere of radius R round the vertex, where all its edges lie behind the contact normal.
bool ClSurface::vertex_top(const VertexPatch& patch, const AxisLine& line, ClHit& hit) const {
  const Point<Part> v = mesh_.vertices[patch.vertex];
  const Vec3 w = line.base - v;
  const double aw = dot(line.axis, w);
  const Vec3 off = w - line.axis * aw;
  const double disc = radius_ * radius_ - squared_length(off);
  if (disc < 0.0) return false;
  hit.z = -aw + std::sqrt(disc);
  hit.normal = (w + line.axis * hit.z) / radius_;
  for (std::uint32_t k = patch.first; k < patch.last; ++k) {
    const Vec3 e = mesh_.vertices[neighbours_[k]] - v;
    const double ahead = dot(hit.normal, e);
    if (ahead > 0.0 && ahead * ahead > kSeam * kSeam * squared_length(e)) return false;
  }
  return true;
}

bool ClSurface::covers(PatchId patch, Point<Part> p) const {
  if (!is_face(patch)) {
    const Core c = core(patch);
    return distance_to_segment(p, c.p, c.q) < radius_;
  }
  const auto& f = mesh_.facets[patch];
  const Point<Part> a = mesh_.vertices[f[0]], b = mesh_.vertices[f[1]], c = mesh_.vertices[f[2]];
  const Vec3 n = normals_[patch];
  const bool over = dot(cross(n, b - a), p - a) >= 0.0 && dot(cross(n, c - b), p - b) >= 0.0 &&
                    dot(cross(n, a - c), p - c) >= 0.0;
  if (over) return std::abs(dot(n, p - a)) < radius_;
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c),
                   distance_to_segment(p, c, a)}) < radius_;
}

ClSurface::Core ClSurface::core(PatchId patch) const {
  const std::size_t index = patch - mesh_.facets.size();
  if (index < edges_.size()) return {mesh_.vertices[edges_[index].v0], mesh_.vertices[edges_[index].v1]};
  const Point<Part> v = mesh_.vertices[vertices_[index - edges_.size()].vertex];
  return {v, v};
}

void ClSurface::hull(PatchId patch, int side, std::vector<Point<Part>>& points) const {
  points.clear();
  const std::size_t index = patch - mesh_.facets.size();
  if (index < edges_.size()) {
    edge_hull(edges_[index], points);
  } else {
    vertex_hull(vertices_[index - edges_.size()], side, points);
  }
}

bool ClSurface::faces_away(PatchId patch, int side, Vec3 axis, double spread) const {
  const std::size_t faces = mesh_.facets.size();
  const auto away = [&](Vec3 normal) { return dot(normal, axis) < -spread; };
  if (patch < faces) return away(normals_[patch] * side);
  if (patch < faces + edges_.size()) {
    const EdgePatch& edge = edges_[patch - faces];
    if (!narrow(edge)) return false;
    const auto [n0, n1] = convex_normals(edge);
    return away(n0) && away(n1);
  }
  const VertexPatch& vertex = vertices_[patch - faces - edges_.size()];
  if (!vertex.oriented) return false;
  for (std::uint32_t k = vertex.first_facet; k < vertex.last_facet; ++k)
    if (!away(normals_[fans_[k]] * side)) return false;
  return true;
}

/// Two facets, and the material between them no sharper than 60 degrees (the patch no wider than 120).
bool ClSurface::narrow(const EdgePatch& edge) const {
  if (edge.w0 == kNone || edge.w1 == kNone) return false;
  const Point<Part> p = mesh_.vertices[edge.v0];
  const Vec3 e = normalized(mesh_.vertices[edge.v1] - p);
  const Vec3 a = mesh_.vertices[edge.w0] - p, b = mesh_.vertices[edge.w1] - p;
  return dot(normalized(a - e * dot(a, e)), normalized(b - e * dot(b, e))) <= -kWideWedge;
}

/// The normals of the two facets on the edge's convex side. Requires: narrow(edge).
std::array<Vec3, 2> ClSurface::convex_normals(const EdgePatch& edge) const {
  const Point<Part> p = mesh_.vertices[edge.v0];
  const auto turned = [&](std::uint32_t facet, std::uint32_t apex) {
    const Vec3 n = normals_[facet];
    return dot(n, mesh_.vertices[apex] - p) > 0.0 ? -n : n;
  };
  if (sides_ == Sides::kOutward) return {normals_[edge.f0], normals_[edge.f1]};
  return {turned(edge.f0, edge.w1), turned(edge.f1, edge.w0)};
}

/// (C4) An arc between two normals lies in the triangle of its ends and the point where its tangents meet.
void ClSurface::edge_hull(const EdgePatch& edge, std::vector<Point<Part>>& points) const {
  if (!narrow(edge)) return;
  const auto [n0, n1] = convex_normals(edge);
  for (std::uint32_t v : {edge.v0, edge.v1}) {
    const Point<Part> p = mesh_.vertices[v];
    points.push_back(p + n0 * radius_);
    points.push_back(p + n1 * radius_);
    points.push_back(p + (n0 + n1) * (radius_ / (1.0 + dot(n0, n1))));
  }
}

/// (C4) A direction in the cone of the normals n_i is c * sum(l_i n_i) with 1 <= c <= 1 / cos(widest angle to
/// their mean): it lies in the hull of the n_i and the n_i so stretched.
void ClSurface::vertex_hull(const VertexPatch& patch, int side, std::vector<Point<Part>>& points) const {
  if (!patch.oriented) return;
  const Point<Part> v = mesh_.vertices[patch.vertex];
  Vec3 sum;
  for (std::uint32_t k = patch.first_facet; k < patch.last_facet; ++k) sum = sum + normals_[fans_[k]];
  if (length(sum) < kSteepest) return;
  const Vec3 mean = normalized(sum);
  double narrowest = 1.0;  // cosine
  for (std::uint32_t k = patch.first_facet; k < patch.last_facet; ++k)
    narrowest = std::min(narrowest, dot(mean, normals_[fans_[k]]));
  if (narrowest < kNarrowFan) return;
  for (std::uint32_t k = patch.first_facet; k < patch.last_facet; ++k)
    for (double stretch : {1.0, 1.0 / narrowest})
      points.push_back(v + normals_[fans_[k]] * (side * radius_ * stretch));
}

}  // namespace tiltfeed
