#include "pathgen/surface/cl_surface.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>

#include "pathgen/surface/normal_cone.h"

namespace tiltfeed::pathgen {

namespace {
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
/// Beyond this angle between its two normals (cosine of 120 degrees) an edge's patch is bounded by its ball
/// only.
constexpr double kWideWedge = -0.5;

/// (C4) Facets and edges ahead of a contact normal by no more than this (sine) are taken to lie behind it.
constexpr double kAhead = 1e-4;

std::uint32_t apex(const Facet& facet, const HalfEdge& half) {
  for (std::uint32_t v : facet)
    if (v != half.low && v != half.high) return v;
  return kNone;
}

/// Vertices worked on together: some hundred microseconds of work. What blocks find is joined in their order,
/// so that it is the same for any number of threads.
constexpr std::size_t kBlock = 4096;
std::size_t blocks_of(std::size_t vertices) { return (vertices + kBlock - 1) / kBlock; }

/// For flags that several threads may set.
void mark(std::uint8_t& flag) { std::atomic_ref<std::uint8_t>(flag).store(1, std::memory_order_relaxed); }

template <class T>
void join(std::vector<std::vector<T>>& blocks, std::vector<T>& all) {
  std::size_t size = 0;
  for (const std::vector<T>& block : blocks) size += block.size();
  all.reserve(size);
  for (std::vector<T>& block : blocks) {
    all.insert(all.end(), block.begin(), block.end());
    block = std::vector<T>();
  }
}

}  // namespace

ClSurface::ClSurface(const Mesh& mesh, Sides sides, std::vector<ToolPiece> pieces, std::size_t part_facets)
    : mesh_(mesh),
      sides_(sides),
      pieces_(std::move(pieces)),
      part_facets_(std::min(part_facets, mesh.facets.size())),
      normals_(mesh.facets.size()) {
  assert(!pieces_.empty());
  const bool balls =
      std::all_of(pieces_.begin(), pieces_.end(), [](const ToolPiece& p) { return p.is_ball(); });
  least_bend_ = balls ? kSeam : kSeam * kLevel;
  tbb::parallel_for(std::size_t{0}, mesh.facets.size(), [&](std::size_t i) {
    const Facet& f = mesh.facets[i];
    normals_[i] = normalized(
        cross(mesh.vertices[f[1]] - mesh.vertices[f[0]], mesh.vertices[f[2]] - mesh.vertices[f[0]]));
  });
  find_vertices(find_edges());
  features_ = static_cast<PatchId>(mesh.facets.size() + edges_.size() + vertices_.size());
}

std::vector<ClSurface::VertexNotes> ClSurface::find_edges() {
  const std::size_t vertices = mesh_.vertices.size();
  fans_ = VertexFans(mesh_.facets, vertices);
  std::vector<VertexNotes> notes(vertices);
  std::vector<std::vector<EdgePatch>> blocks(blocks_of(vertices));
  std::vector<std::vector<NarrowNotch>> notches(blocks.size());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    const std::size_t last = std::min(vertices, (b + 1) * kBlock);
    fans_.each_edge(b * kBlock, last, [&](std::span<const HalfEdge> halves) {
      VertexNotes &low = notes[halves[0].low], &high = notes[halves[0].high];
      if (state(halves) != EdgeState::kSound) mark(low.disagree), mark(high.disagree);
      EdgePatch edge;
      const bool has_patch = edge_patch(halves, edge);
      if (edge.is_notch) notches[b].push_back({edge.v0, edge.v1, edge.facets});
      if (!has_patch) return;
      blocks[b].push_back(edge);
      mark(low.sticks_out), mark(high.sticks_out);
      if (!edge.nearly_flat) mark(low.is_sharp), mark(high.is_sharp);
    });
  });
  join(blocks, edges_);
  join(notches, notches_);
  return notes;
}

/// An edge gets a patch when it is convex by more than least_bend_, or when it has not two facets, or when
/// sides are not known and it is bent that much either way.
bool ClSurface::edge_patch(std::span<const HalfEdge> halves, EdgePatch& edge) const {
  const HalfEdge& first = halves[0];
  edge = {first.low, first.high, apex(mesh_.facets[first.facet], first), kNone, {first.facet, first.facet}};
  if (halves.size() > 2) edge.w0 = kNone;  // the whole cylinder, which never reaches outside the offset body
  if (halves.size() != 2) return true;
  edge.facets[1] = halves[1].facet;
  edge.w1 = apex(mesh_.facets[edge.facets[1]], halves[1]);
  const Vec3 apart = mesh_.vertices[edge.w1] - mesh_.vertices[edge.v0];
  const Vec3 along = mesh_.vertices[edge.v1] - mesh_.vertices[edge.v0];
  const Vec3 across = apart - along * (dot(apart, along) / squared_length(along));
  const double rise = dot(normals_[edge.facets[0]], apart);  // over the length of `across`: sine of the bend
  const double width2 = squared_length(across);
  const bool bent = rise * rise > least_bend_ * least_bend_ * width2;
  const bool flat = rise * rise <= kSeam * kSeam * width2;
  edge.nearly_flat = flat;
  const double turned = dot(normals_[edge.facets[0]], normals_[edge.facets[1]]);
  const bool folded = turned < kWideWedge;
  edge.is_notch = turned < 0.0 && rise > 0.0;
  if (folded) edge.nearly_flat = false;
  // Of a fold the tool's shape decides nothing: more pieces need all edges that fewer do (C4).
  return sides_ == Sides::kBoth ? folded || bent : (rise < 0.0 && bent) || (folded && (rise <= 0.0 || flat));
}

void ClSurface::find_vertices(const std::vector<VertexNotes>& notes) {
  const std::size_t vertices = mesh_.vertices.size();
  struct Block {
    std::vector<VertexPatch> vertices;
    std::vector<std::uint32_t> neighbours;
  };
  std::vector<Block> blocks(blocks_of(vertices));
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    std::vector<std::uint32_t>& all = blocks[b].neighbours;
    const auto end = static_cast<std::uint32_t>(std::min(vertices, (b + 1) * kBlock));
    for (auto v = static_cast<std::uint32_t>(b * kBlock); v < end; ++v) {
      if (notes[v].sticks_out == 0) continue;
      const std::size_t first = all.size();
      for (std::uint32_t f : fans_.of(v))
        for (std::uint32_t w : mesh_.facets[f])
          if (w != v) all.push_back(w);
      std::sort(all.begin() + first, all.end());
      all.erase(std::unique(all.begin() + first, all.end()), all.end());
      blocks[b].vertices.push_back({v, static_cast<std::uint32_t>(first),
                                    static_cast<std::uint32_t>(all.size()), notes[v].disagree == 0,
                                    notes[v].is_sharp == 0});
    }
  });
  std::size_t patches = 0, neighbours = 0;
  for (const Block& block : blocks) patches += block.vertices.size(), neighbours += block.neighbours.size();
  vertices_.reserve(patches), neighbours_.reserve(neighbours);
  for (Block& block : blocks) {
    const auto before = static_cast<std::uint32_t>(neighbours_.size());
    for (VertexPatch patch : block.vertices) {
      patch.first += before, patch.last += before;
      vertices_.push_back(patch);
    }
    neighbours_.insert(neighbours_.end(), block.neighbours.begin(), block.neighbours.end());
    block = {};
  }
}

std::vector<PatchId> ClSurface::numbers_of(const ClSurface& first) const {
  const auto faces = static_cast<PatchId>(mesh_.facets.size());
  std::vector<PatchId> numbers(first.features_);
  for (PatchId f = 0; f < faces; ++f) numbers[f] = f;
  // Both list what they need in the same order.
  PatchId at = faces, mine = 0;
  for (const EdgePatch& edge : first.edges_) {
    while (edges_[mine].v0 != edge.v0 || edges_[mine].v1 != edge.v1) ++mine;
    numbers[at++] = faces + mine;
  }
  const auto ends = faces + static_cast<PatchId>(edges_.size());
  mine = 0;
  for (const VertexPatch& patch : first.vertices_) {
    while (vertices_[mine].vertex != patch.vertex) ++mine;
    numbers[at++] = ends + mine;
  }
  const std::size_t pieces = first.pieces_.size();
  for (PatchId piece = 1; piece < pieces; ++piece)
    for (PatchId f = 0; f < first.features_; ++f) numbers.push_back(numbers[f] + piece * features_);
  return numbers;
}

bool ClSurface::is_fixture(PatchId feature) const {
  const std::size_t faces = mesh_.facets.size();
  if (feature < faces) return feature >= part_facets_;
  if (feature < faces + edges_.size()) return edges_[feature - faces].facets[0] >= part_facets_;
  return fan(vertices_[feature - faces - edges_.size()]).front() >= part_facets_;
}

std::uint32_t ClSurface::facet_of(PatchId patch) const {
  const std::size_t faces = mesh_.facets.size(), feature = feature_of(patch);
  if (feature < faces) return mesh_.source[feature];
  if (feature < faces + edges_.size()) return mesh_.source[edges_[feature - faces].facets[0]];
  return mesh_.source[fan(vertices_[feature - faces - edges_.size()]).front()];
}

bool ClSurface::top(const ToolPiece& piece, PatchId feature, const AxisLine& line, ClHit& hit,
                    double least) const {
  const double slack = kSeam * (piece.flat + piece.corner);
  if (feature < mesh_.facets.size()) {
    const Facet& f = mesh_.facets[feature];
    const Point<Part>&a = mesh_.vertices[f[0]], &b = mesh_.vertices[f[1]], &c = mesh_.vertices[f[2]];
    const Vec3& n = normals_[feature];
    if (sides_ == Sides::kBoth && dot(n, line.axis) < 0.0)
      return drop_on_facet(piece, a, c, b, -n, slack, line, hit, least);
    return drop_on_facet(piece, a, b, c, n, slack, line, hit, least);
  }
  feature -= static_cast<PatchId>(mesh_.facets.size());
  if (feature < edges_.size()) {
    const EdgePatch& edge = edges_[feature];
    return drop_on_edge(piece, mesh_.vertices[edge.v0], mesh_.vertices[edge.v1], slack, line, hit, least) &&
           behind(edge, hit.normal);
  }
  const VertexPatch& vertex = vertices_[feature - edges_.size()];
  return drop_on_vertex(piece, mesh_.vertices[vertex.vertex], line, hit, least) && behind(vertex, hit.normal);
}

/// (C6) Do the edge's facets lie behind the contact normal?
bool ClSurface::behind(const EdgePatch& edge, Vec3 normal) const {
  const Point<Part> p = mesh_.vertices[edge.v0];
  for (std::uint32_t apex : {edge.w0, edge.w1}) {
    if (apex == kNone) continue;
    const Vec3 d = mesh_.vertices[apex] - p;
    const double ahead = dot(normal, d);
    if (ahead <= 0.0) continue;
    const Vec3 e = mesh_.vertices[edge.v1] - p;
    if (ahead * ahead > kAhead * kAhead * squared_length(d - e * (dot(d, e) / squared_length(e))))
      return false;
  }
  return true;
}

/// Do all its edges?
bool ClSurface::behind(const VertexPatch& patch, Vec3 normal) const {
  const Point<Part> v = mesh_.vertices[patch.vertex];
  for (std::uint32_t k = patch.first; k < patch.last; ++k) {
    const Vec3 e = mesh_.vertices[neighbours_[k]] - v;
    const double ahead = dot(normal, e);
    if (ahead > 0.0 && ahead * ahead > kAhead * kAhead * squared_length(e)) return false;
  }
  return true;
}

bool ClSurface::covers(PatchId patch, Point<Part> p, Vec3 axis) const {
  const ToolPiece& tool = piece(patch);
  p = p + axis * tool.above_reference;  // of the ring: axial stock lowers it
  const double reach = tool.flat + tool.corner;
  const Core c = core(patch);
  if (c.count < 3) return distance_to_segment(p, c.corner[0], c.corner[c.count - 1]) < reach;
  return distance_to_triangle(p, c.corner, normals_[feature_of(patch)]) < reach;
}

void ClSurface::fetch(PatchId patch) const {
  std::size_t feature = patch % features();
  const auto vertex = [this](std::uint32_t v) { __builtin_prefetch(&mesh_.vertices[v]); };
  if (feature < mesh_.facets.size()) {
    std::ranges::for_each(mesh_.facets[feature], vertex);
    return;
  }
  feature -= mesh_.facets.size();
  if (feature < edges_.size()) {
    const EdgePatch& edge = edges_[feature];
    for (std::uint32_t v : {edge.v0, edge.v1, edge.w0, edge.w1})
      if (v != kNone) vertex(v);
    for (std::uint32_t f : edge.facets) __builtin_prefetch(&normals_[f]);
    return;
  }
  const VertexPatch& corner = vertices_[feature - edges_.size()];
  for (std::uint32_t k = corner.first; k < corner.last; ++k) vertex(neighbours_[k]);
  for (std::uint32_t f : fan(corner)) __builtin_prefetch(&normals_[f]);
}

ClSurface::Core ClSurface::core(PatchId patch) const {
  std::size_t feature = feature_of(patch);
  if (feature < mesh_.facets.size()) {
    const Facet& f = mesh_.facets[feature];
    return {{mesh_.vertices[f[0]], mesh_.vertices[f[1]], mesh_.vertices[f[2]]}, 3};
  }
  feature -= mesh_.facets.size();
  if (feature < edges_.size())
    return {{mesh_.vertices[edges_[feature].v0], mesh_.vertices[edges_[feature].v1], {}}, 2};
  return {{mesh_.vertices[vertices_[feature - edges_.size()].vertex], {}, {}}, 1};
}

bool ClSurface::normals(PatchId patch, int side, std::vector<Vec3>& normals) const {
  normals.clear();
  std::size_t feature = feature_of(patch);
  if (feature < mesh_.facets.size()) {
    normals.push_back(normals_[feature] * side);
    return true;
  }
  feature -= mesh_.facets.size();
  const bool is_ball = piece(patch).is_ball();
  if (feature < edges_.size()) {
    if (is_ball && edges_[feature].nearly_flat) return false;
    if (!narrow(edges_[feature])) return true;
    const auto [n0, n1] = convex_normals(edges_[feature]);
    normals = {n0, n1};
    return true;
  }
  const VertexPatch& vertex = vertices_[feature - edges_.size()];
  if (is_ball && vertex.nearly_flat) return false;
  if (!vertex.oriented) return true;
  for (std::uint32_t f : fan(vertex)) normals.push_back(normals_[f] * side);
  if (sides_ == Sides::kBoth) return true;
  std::array<Vec3, kMostSpokes> spokes;
  if (vertex.last - vertex.first > spokes.size()) return true;
  std::size_t count = 0;
  for (std::uint32_t k = vertex.first; k < vertex.last; ++k)
    spokes[count++] = mesh_.vertices[neighbours_[k]] - mesh_.vertices[vertex.vertex];
  return cut_cone(normals, {spokes.data(), count}, kSeam);
}

bool ClSurface::faces_away(PatchId patch, int side, Vec3 axis, double spread) const {
  const auto away = [&](Vec3 normal) { return dot(normal, axis) < -spread; };
  std::size_t feature = feature_of(patch);
  if (feature < mesh_.facets.size()) return away(normals_[feature] * side);
  feature -= mesh_.facets.size();
  if (feature < edges_.size()) {
    if (!narrow(edges_[feature])) return false;
    const auto [n0, n1] = convex_normals(edges_[feature]);
    return away(n0) && away(n1);
  }
  const VertexPatch& vertex = vertices_[feature - edges_.size()];
  if (!vertex.oriented) return false;
  const auto facets = fan(vertex);
  return std::all_of(facets.begin(), facets.end(), [&](std::uint32_t f) { return away(normals_[f] * side); });
}

/// Two facets, and the material between them no sharper than 60 degrees (the patch no wider than 120).
bool ClSurface::narrow(const EdgePatch& edge) const {
  if (edge.w0 == kNone || edge.w1 == kNone) return false;
  const Point<Part> p = mesh_.vertices[edge.v0];
  const Vec3 e = mesh_.vertices[edge.v1] - p;
  const auto across = [&](std::uint32_t apex) {
    const Vec3 d = mesh_.vertices[apex] - p;
    return d - e * (dot(d, e) / squared_length(e));
  };
  const Vec3 a = across(edge.w0), b = across(edge.w1);
  const double along = dot(a, b);
  return along <= 0.0 || along * along <= kWideWedge * kWideWedge * squared_length(a) * squared_length(b);
}

/// The normals of the two facets on the edge's convex side. Requires: narrow(edge).
std::array<Vec3, 2> ClSurface::convex_normals(const EdgePatch& edge) const {
  const Point<Part> p = mesh_.vertices[edge.v0];
  const auto turned = [&](std::uint32_t facet, std::uint32_t apex) {
    const Vec3 n = normals_[facet];
    return dot(n, mesh_.vertices[apex] - p) > 0.0 ? -n : n;
  };
  if (sides_ == Sides::kOutward) return {normals_[edge.facets[0]], normals_[edge.facets[1]]};
  return {turned(edge.facets[0], edge.w1), turned(edge.facets[1], edge.w0)};
}

}  // namespace tiltfeed::pathgen
