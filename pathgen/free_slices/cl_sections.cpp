#include "pathgen/free_slices/cl_sections.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "kinematics/basics/units.h"
#include "pathgen/mesh/topology.h"
#include "pathgen/surface/normal_cone.h"

namespace tiltfeed::pathgen {

namespace {

/// Edges bent by less than this (rad) have no patch of their own: the gap between the facets' strands is less
/// than what chains are closed over.
constexpr double kFlat = 1e-6;
/// An edge whose ends differ by less than this (mm) in height lies in the plane.
constexpr double kLevel = 1e-9;
/// Slack of the vertex's cone (cosine).
constexpr double kCone = 1e-9;
/// Arcs shorter than this (rad) are points, than that straight: their chords are inside by less than kInside.
constexpr double kShortest = 1e-9, kStraight = 1e-5;

/// The angles 0..2 pi where cos(q - at) = value, appended.
void add_crossings(double at, double value, std::vector<double>& angles) {
  if (!(std::abs(value) <= 1.0)) return;
  const double half = std::acos(value);
  for (const double q : {at + half, at - half}) angles.push_back(q - 2.0 * kPi * std::floor(q / (2.0 * kPi)));
}

/// The steps into which an arc of `span` is cut so that chords outside it stand off by at most the sagitta.
int steps_of(double span, double radius, double sagitta) {
  const double half = std::acos(radius / (radius + sagitta));
  return std::max(1, static_cast<int>(std::ceil(span / (2.0 * half))));
}

std::uint32_t apex(const Facet& facet, const HalfEdge& half) {
  for (const std::uint32_t v : facet)
    if (v != half.low && v != half.high) return v;
  return half.low;
}

}  // namespace

ClSections::ClSections(const CheckedMesh& part, double radius, double sagitta)
    : part_(part), radius_(radius), sagitta_(sagitta) {
  add_faces();
  add_vertices(add_edges());
}

void ClSections::add_faces() {
  const Mesh& mesh = part_.mesh;
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) {
    const auto& f = mesh.facets[i];
    const Point<Part> a = mesh.vertices[f[0]], b = mesh.vertices[f[1]], c = mesh.vertices[f[2]];
    const Vec3 n = normalized(cross(b - a, c - a));
    for (const double side : {1.0, -1.0}) {
      if (side < 0.0 && part_.sides == Sides::kOutward) continue;
      const Vec3 out = n * side;
      faces_.push_back({{a + out * radius_, b + out * radius_, c + out * radius_}, out, i});
      caps_.push_back({out, 1.0, 0.0});
    }
  }
}

/// (N2) The normals n of an edge's patch are square to it and point away from each of its facets: n.d <= 0.
std::vector<std::uint8_t> ClSections::add_edges() {
  const Mesh& mesh = part_.mesh;
  std::vector<std::uint8_t> sticks_out(mesh.vertices.size(), 0);
  VertexFans(mesh.facets, mesh.vertices.size()).each_edge([&](std::span<const HalfEdge> halves) {
    const Point<Part> start = mesh.vertices[halves[0].low], end = mesh.vertices[halves[0].high];
    const Vec3 along = normalized(end - start);
    std::vector<Vec3> into;  // unit, square to the edge, into each facet
    for (const HalfEdge& h : halves) {
      const Vec3 d = mesh.vertices[apex(mesh.facets[h.facet], h)] - start;
      into.push_back(normalized(d - along * dot(d, along)));
    }
    if (part_.sides == Sides::kOutward) {
      const auto& f = mesh.facets[halves[0].facet];
      const Vec3 n = normalized(
          cross(mesh.vertices[f[1]] - mesh.vertices[f[0]], mesh.vertices[f[2]] - mesh.vertices[f[0]]));
      if (halves.size() != 2 || dot(n, into[1]) > -kFlat) return;  // concave or flat
    } else if (halves.size() == 2 && length(into[0] + into[1]) < kFlat) {
      return;
    }
    const Vec3 p = -into[0], w = cross(along, p);
    double from = -kPi / 2.0, to = kPi / 2.0;
    for (std::size_t i = 1; i < into.size(); ++i) {
      // The middle of the half circle that points away from the facet, nearest to what is left.
      double middle = std::atan2(-dot(into[i], w), -dot(into[i], p));
      const double mean = (from + to) / 2.0;
      middle += 2.0 * kPi * std::round((mean - middle) / (2.0 * kPi));
      from = std::max(from, middle - kPi / 2.0), to = std::min(to, middle + kPi / 2.0);
    }
    if (to - from < kFlat) return;
    edges_.push_back({start, along, distance(start, end), p, w, from, to, halves[0].facet});
    const double middle = (from + to) / 2.0;
    caps_.push_back(cap_of(p * std::cos(middle) + w * std::sin(middle), (to - from) / 2.0));
    sticks_out[halves[0].low] = sticks_out[halves[0].high] = 1;
  });
  return sticks_out;
}

void ClSections::add_vertices(const std::vector<std::uint8_t>& sticks_out) {
  const Mesh& mesh = part_.mesh;
  std::vector<std::vector<std::uint32_t>> around(mesh.vertices.size());
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f)
    for (const std::uint32_t v : mesh.facets[f])
      if (sticks_out[v]) around[v].push_back(f);
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (around[v].empty()) continue;
    Vertex vertex{mesh.vertices[v], static_cast<std::uint32_t>(spokes_.size()), 0, {}, around[v].front()};
    std::vector<std::uint32_t> ring;
    std::vector<Vec3> normals;
    for (const std::uint32_t f : around[v]) {
      const auto& corner = mesh.facets[f];
      for (const std::uint32_t u : corner)
        if (u != v) ring.push_back(u);
      if (part_.sides != Sides::kOutward) continue;
      // The normals weighted by angle tell the sides of a vertex [Baerentzen, Aanaes 2005].
      const std::size_t k = corner[0] == v ? 0 : corner[1] == v ? 1 : 2;
      const Vec3 a = mesh.vertices[corner[(k + 1) % 3]] - vertex.at,
                 b = mesh.vertices[corner[(k + 2) % 3]] - vertex.at;
      normals.push_back(normalized(cross(a, b)));
      vertex.outward = vertex.outward + normals.back() * angle_between(a, b);
    }
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    for (const std::uint32_t u : ring) spokes_.push_back(normalized(mesh.vertices[u] - vertex.at));
    vertex.last = static_cast<std::uint32_t>(spokes_.size());
    const std::span<const Vec3> spokes(spokes_.data() + vertex.first, vertex.last - vertex.first);
    if (part_.sides == Sides::kOutward && !cut_cone(normals, spokes, kCone)) continue;
    vertices_.push_back(vertex);
    caps_.push_back(cap_about(normals));
  }
}

void ClSections::cut(std::uint32_t patch, Vec3 normal, double height, std::vector<ClStrand>& strands) const {
  if (patch < faces_.size()) return cut_face(faces_[patch], normal, height, strands);
  patch -= static_cast<std::uint32_t>(faces_.size());
  if (patch < edges_.size()) return cut_edge(edges_[patch], normal, height, strands);
  cut_vertex(vertices_[patch - edges_.size()], normal, height, strands);
}

namespace {

/// Turns the strand so that it runs along plane normal x surface normal.
void add_directed(ClStrand strand, Vec3 plane, std::vector<ClStrand>& strands) {
  const std::size_t middle = strand.size() / 2;
  const Vec3 step = strand.size() > 2 ? strand[middle].centre - strand[middle - 1].centre
                                      : strand.back().centre - strand.front().centre;
  const Vec3 n = strand[middle].normal + strand[middle - 1].normal;
  if (dot(step, cross(plane, n)) < 0.0) std::reverse(strand.begin(), strand.end());
  strands.push_back(std::move(strand));
}

}  // namespace

void ClSections::cut_face(const Face& face, Vec3 normal, double height,
                          std::vector<ClStrand>& strands) const {
  std::array<double, 3> h;
  for (std::size_t i = 0; i < 3; ++i) h[i] = dot(from_origin(face.corner[i]), normal) - height;
  ClStrand strand;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    if ((h[i] >= 0.0) == (h[j] >= 0.0)) continue;
    strand.push_back({lerp(face.corner[i], face.corner[j], h[i] / (h[i] - h[j])), face.normal, face.facet});
  }
  if (strand.size() == 2) add_directed(std::move(strand), normal, strands);
}

/// (N2) On the edge's cylinder the plane is at t(q) = -(h + R (a cos q + b sin q)) / m along the edge, m the
/// edge's rise; the strand is where 0 <= t <= length.
void ClSections::cut_edge(const Edge& edge, Vec3 normal, double height,
                          std::vector<ClStrand>& strands) const {
  const double h = dot(from_origin(edge.start), normal) - height, m = dot(edge.along, normal);
  const double a = radius_ * dot(edge.p, normal), b = radius_ * dot(edge.w, normal);
  const double c = std::hypot(a, b), at = std::atan2(b, a), rise = m * edge.length;
  const auto normal_at = [&](double q) { return edge.p * std::cos(q) + edge.w * std::sin(q); };
  const auto point = [&](double q, double t, double r) {
    const Vec3 n = normal_at(q);
    return ClPoint{edge.start + edge.along * t + n * r, n, edge.facet};
  };
  std::vector<double> angles;
  add_crossings(at, -h / c, angles);
  const bool level = std::abs(rise) < kLevel;
  if (!level) add_crossings(at, -(h + rise) / c, angles);
  for (double& q : angles) q += 2.0 * kPi * std::ceil((edge.from - q) / (2.0 * kPi));
  std::erase_if(angles, [&](double q) { return q > edge.to; });
  std::sort(angles.begin(), angles.end());
  if (level) {
    for (const double q : angles)
      add_directed({point(q, 0.0, radius_), point(q, edge.length, radius_)}, normal, strands);
    return;
  }
  angles.insert(angles.begin(), edge.from);
  angles.push_back(edge.to);
  const auto t_at = [&](double q) { return -(h + a * std::cos(q) + b * std::sin(q)) / m; };
  for (std::size_t i = 0; i + 1 < angles.size(); ++i) {
    const double from = angles[i], to = angles[i + 1], middle = t_at((from + to) / 2.0);
    if (to - from < kShortest || middle < 0.0 || middle > edge.length) continue;
    const int steps = steps_of(to - from, radius_, sagitta_);
    const double step = (to - from) / steps, outside = radius_ / std::cos(step / 2.0);
    const auto on_edge = [&](double q) { return std::clamp(t_at(q), 0.0, edge.length); };
    ClStrand strand{point(from, on_edge(from), radius_)};
    for (int k = 0; k < steps && to - from > kStraight; ++k) {
      const double q = from + (k + 0.5) * step;
      strand.push_back(point(q, on_edge(q), outside));
    }
    strand.push_back(point(to, on_edge(to), radius_));
    add_directed(std::move(strand), normal, strands);
  }
}

/// (N3) The plane cuts the vertex's ball in a circle; of it count the places whose normal points away from
/// every edge at the vertex, and out of the material.
void ClSections::cut_vertex(const Vertex& vertex, Vec3 normal, double height,
                            std::vector<ClStrand>& strands) const {
  const double up = height - dot(from_origin(vertex.at), normal);
  if (std::abs(up) >= radius_) return;
  const double r = std::sqrt(radius_ * radius_ - up * up);
  const Vec3 e =
      normalized(std::abs(normal.x) < 0.6 ? cross(normal, Vec3{1, 0, 0}) : cross(normal, Vec3{0, 1, 0}));
  const Vec3 f = cross(normal, e);
  const std::span<const Vec3> spokes(spokes_.data() + vertex.first, vertex.last - vertex.first);
  std::vector<double> angles;
  for (const Vec3 s : spokes) {
    const double a = dot(s, e), b = dot(s, f), c = std::hypot(a, b);
    if (c > 0.0) add_crossings(std::atan2(b, a), -up * dot(s, normal) / (r * c), angles);
  }
  const auto normal_at = [&](double q) {
    return (normal * up + (e * std::cos(q) + f * std::sin(q)) * r) / radius_;
  };
  const auto counts = [&](double q) {
    const Vec3 n = normal_at(q);
    for (const Vec3 s : spokes)
      if (dot(n, s) > kCone) return false;
    return squared_length(vertex.outward) == 0.0 || dot(n, vertex.outward) > 0.0;
  };
  std::sort(angles.begin(), angles.end());
  if (angles.empty()) angles.push_back(0.0);
  angles.push_back(angles.front() + 2.0 * kPi);
  const Point<Part> middle = vertex.at + normal * up;
  const auto point = [&](double q, double distance) {
    return ClPoint{middle + (e * std::cos(q) + f * std::sin(q)) * distance, normal_at(q), vertex.facet};
  };
  for (std::size_t i = 0; i + 1 < angles.size(); ++i) {
    const double from = angles[i], to = angles[i + 1];
    if (to - from < kShortest || !counts((from + to) / 2.0)) continue;
    const int steps = steps_of(to - from, r, sagitta_);
    const double step = (to - from) / steps;
    ClStrand strand{point(from, r)};
    for (int k = 0; k < steps && to - from > kStraight; ++k)
      strand.push_back(point(from + (k + 0.5) * step, r / std::cos(step / 2.0)));
    strand.push_back(point(to, r));
    add_directed(std::move(strand), normal, strands);
  }
}

}  // namespace tiltfeed::pathgen
