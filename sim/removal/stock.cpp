#include "sim/removal/stock.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"
#include "sim/basics/workers.h"
#include "sim/solid/half_edges.h"

namespace tiltfeed::sim {
namespace {

// A line's ends at a stock that is the very part may differ by rounding.
constexpr double kCoverSlack = 1e-3;
// Besides the lines: what reading, probes (removal.h) and the report take, and what must stay free.
constexpr double kMemoryShare = 0.7;

std::optional<double> number(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

pathgen::Box widened(const pathgen::Box& box, double by) {
  const Vec3 g{by, by, by};
  return {box.min - g, box.max + g};
}

/// What is within `margin` outside of a closed shell: over each facet a prism, over each convex edge a
/// capsule.
class Offset {
 public:
  Offset(const pathgen::Mesh& part, double margin) : mesh_(part), margin_(margin) {
    const std::vector<HalfEdge> halves = half_edges(part.facets, part.vertices.size());
    for (std::size_t i = 0; i + 1 < halves.size(); ++i) {
      const HalfEdge &a = halves[i], &b = halves[i + 1];
      if (a.low == b.low && a.high == b.high && is_convex(a.facet, b.facet, a.low, a.high))
        edges_.push_back({a.low, a.high});
    }
  }

  /// What a stripe is filled with, as numbers.
  struct Near {
    std::vector<std::vector<std::uint32_t>> facets, edges;  ///< by stripe
  };
  Near near(const Dexels& dexels) const {
    return {dexels.by_stripe(mesh_, margin_), dexels.by_stripe(edges_.size(), [&](std::uint32_t edge) {
              const SweptBody body = capsule(edge);
              return std::pair{body.low, body.high};
            })};
  }

  void fill(Dexels& dexels, int stripe, const Near& near) const {
    dexels.fill(stripe, mesh_, near.facets[stripe]);
    for (const std::uint32_t facet : near.facets[stripe]) {
      const auto& [a, b, c] = mesh_.facets[facet];
      dexels.fill(stripe, prism({mesh_.vertices[a], mesh_.vertices[b], mesh_.vertices[c]}, margin_));
    }
    for (const std::uint32_t edge : near.edges[stripe]) dexels.fill(stripe, capsule(edge));
  }

 private:
  /// Does b's corner beside the edge lie below the plane of a?
  bool is_convex(std::uint32_t a, std::uint32_t b, std::uint32_t low, std::uint32_t high) const {
    const auto& f = mesh_.facets[a];
    const Point<Part> at = mesh_.vertices[f[0]];
    const Vec3 n = cross(mesh_.vertices[f[1]] - at, mesh_.vertices[f[2]] - at);
    for (const std::uint32_t v : mesh_.facets[b])
      if (v != low && v != high) return dot(mesh_.vertices[v] - mesh_.vertices[low], n) < 0.0;
    return false;
  }

  SweptBody capsule(std::uint32_t edge) const {
    const Point<Part> from = mesh_.vertices[edges_[edge][0]], to = mesh_.vertices[edges_[edge][1]];
    return SweptBody::round(from, {}, to - from, margin_, ToolPart::kCutter);
  }

  const pathgen::Mesh& mesh_;
  double margin_;
  std::vector<std::array<std::uint32_t, 2>> edges_;  ///< convex ones
};

/// The mesh of another file, closed.
Result<pathgen::CheckedMesh> read_shell(const std::string& path, double unit_mm) {
  const Result<pathgen::Stl> stl = pathgen::read_stl(path, unit_mm);
  if (!stl) return tl::unexpected(stl.error());
  return pathgen::check_mesh(*stl);
}

Result<void> must_be_closed(const pathgen::CheckedMesh& mesh, const std::string& what) {
  if (mesh.sides == pathgen::Sides::kOutward) return {};
  return fail(Code::kMesh, what + " is not a closed surface, so what is inside it is not known: repair it" +
                               (what == "the part" ? ", or give --stock box" : ""));
}

/// A round bar about the table's direction round the middle of the part.
SweptBody bar(const pathgen::Box& box, const pathgen::CheckedMesh& part, Vec3 up, double margin,
              Revolved& solid) {
  const Point<Part> middle = lerp(box.min, box.max, 0.5);
  double low = kInfinity, high = -kInfinity, radius = 0.0;
  for (const Point<Part> p : part.mesh.vertices) {
    const double h = dot(p - middle, up);
    low = std::min(low, h), high = std::max(high, h);
    radius = std::max(radius, length(p - middle - up * h));
  }
  radius += margin;
  solid = Revolved::from_rims({{radius, 0.0}, {radius, high - low + 2.0 * margin}});
  return SweptBody::revolved(solid, {middle + up * (low - margin), up}, {}, ToolPart::kCutter);
}

/// What the three bundles are filled with.
struct Filling {
  Filling(const pathgen::CheckedMesh& the_part, const StockShape& the_shape)
      : part(the_part), shape(the_shape) {}

  const pathgen::CheckedMesh& part;
  const StockShape& shape;
  pathgen::Box box;
  std::optional<pathgen::CheckedMesh> shell;
  std::optional<Offset> offset;
  Revolved solid = Revolved::from_rims({{1.0, 0.0}, {1.0, 1.0}});
  std::optional<SweptBody> round;

  /// Of what is laid out for these lines.
  Offset::Near near(const Dexels& dexels) const {
    if (offset) return offset->near(dexels);
    if (shell) return {dexels.by_stripe(shell->mesh, 0.0), {}};
    return {};
  }
  void fill(Dexels& dexels, int stripe, const Offset::Near& near) const {
    if (offset)
      offset->fill(dexels, stripe, near);
    else if (shell)
      dexels.fill(stripe, shell->mesh, near.facets[stripe]);
    else if (round)
      dexels.fill(stripe, *round);
    else
      dexels.fill(stripe, box);
    dexels.settle(stripe);
  }
};

Result<void> prepare(Filling& f, const config::Job& job) {
  f.box = widened(f.part.bounds, f.shape.margin);
  if (f.shape.kind == StockKind::kOffset) {
    if (auto closed = must_be_closed(f.part, "the part"); !closed) return closed;
    f.offset.emplace(f.part.mesh, f.shape.margin);
  } else if (f.shape.kind == StockKind::kFile) {
    auto shell = read_shell(f.shape.path, f.shape.unit_mm > 0.0 ? f.shape.unit_mm : job.stl_unit_mm);
    if (!shell) return tl::unexpected(shell.error());
    if (auto closed = must_be_closed(*shell, "the stock " + f.shape.path); !closed) return closed;
    f.shell = std::move(*shell);
    f.box = f.shell->bounds;
  } else if (f.shape.kind == StockKind::kCylinder) {
    f.round = bar(f.part.bounds, f.part, job.plan.up, f.shape.margin, f.solid);
    f.box = {Point<Part>{} + f.round->low, Point<Part>{} + f.round->high};
  }
  return {};
}

Result<void> check_memory(const pathgen::Box& box, double cell, const std::vector<int>& axes) {
  const std::uint64_t need = stock_bytes(box, cell, axes), have = free_bytes();
  if (have == 0 || static_cast<double>(need) < kMemoryShare * static_cast<double>(have)) return {};
  // The need grows with the square of the lines per mm.
  const double would_do =
      cell * std::sqrt(static_cast<double>(need) / (kMemoryShare * static_cast<double>(have)));
  return fail(Code::kLimit, "a resolution of " + number_text(cell) + " mm needs about " +
                                std::to_string(need >> 20) + " MB for the stock, and " +
                                std::to_string(have >> 20) + " MB are free: use --resolution " +
                                number_text(std::ceil(would_do * 100.0 + 1.0) / 100.0) + " or coarser");
}

/// The part must be inside of what was filled.
Result<void> check_cover(const Stock& stock, const StockShape& shape, const pathgen::CheckedMesh& part,
                         int threads) {
  if (shape.kind != StockKind::kFile || part.sides != pathgen::Sides::kOutward) return {};
  const auto outside = [&](double mm, Point<Part> at) {
    return fail(Code::kInput, "the stock " + shape.path + " does not hold the part: " + number_text(mm) +
                                  " mm of it have no stock round " + to_string(at) +
                                  "; is it in the part's coordinates and unit?");
  };
  for (const Point<Part> p : part.mesh.vertices) {
    const double out = std::max({stock.box.min.x - p.x, stock.box.min.y - p.y, stock.box.min.z - p.z,
                                 p.x - stock.box.max.x, p.y - stock.box.max.y, p.z - stock.box.max.z});
    if (out > kCoverSlack) return outside(out, p);
  }
  std::vector<Dexels::Lack> lacks(stock.bundles.size() * Dexels::kStripes);
  std::vector<std::vector<std::vector<std::uint32_t>>> facets;  // by bundle and stripe
  for (const Dexels& bundle : stock.bundles) facets.push_back(bundle.by_stripe(part.mesh, 0.0));
  in_parallel(lacks.size(), threads, [&](std::size_t i) {
    const std::size_t bundle = i / Dexels::kStripes, stripe = i % Dexels::kStripes;
    lacks[i] = stock.bundles[bundle].missing(static_cast<int>(stripe), part.mesh, facets[bundle][stripe],
                                             kCoverSlack);
  });
  const auto most = std::max_element(lacks.begin(), lacks.end(),
                                     [](const auto& a, const auto& b) { return a.length < b.length; });
  if (most->length > 0.0) return outside(most->length, most->place);
  return {};
}

}  // namespace

Result<StockShape> parse_stock(const std::string& text) {
  const std::size_t colon = text.find(':');
  const std::string word = text.substr(0, colon);
  StockShape shape;
  if (word == "offset" || word == "box" || word == "cylinder") {
    shape.kind = word == "offset" ? StockKind::kOffset
                 : word == "box"  ? StockKind::kBox
                                  : StockKind::kCylinder;
    const auto margin = colon == std::string::npos ? std::optional<double>() : number(text.substr(colon + 1));
    if ((colon != std::string::npos || shape.kind == StockKind::kOffset) && (!margin || *margin < 0.0))
      return fail(Code::kUsage,
                  "--stock " + text + ": " + word + ":MM wants a length in mm, such as " + word + ":2");
    shape.margin = margin.value_or(0.0);
    return shape;
  }
  if (!std::ifstream(text))
    return fail(Code::kUsage,
                "--stock " + text +
                    ": offset:MM, box, box:MM, cylinder, cylinder:MM, or an STL file that can be read");
  return StockShape{StockKind::kFile, 0.0, text};
}

StockShape default_stock(const config::Job& job) {
  if (job.blank && job.operation.number == 1) {
    const config::Blank& blank = *job.blank;
    if (blank.shape == config::BlankShape::kFile) return {StockKind::kFile, 0.0, blank.path, blank.unit_mm};
    const bool box = blank.shape == config::BlankShape::kBox;
    return {box ? StockKind::kBox : StockKind::kCylinder, blank.margin, {}};
  }
  if (job.plan.pattern.kind == pathgen::PatternKind::kRough) return {StockKind::kBox, 0.0, {}};
  return {StockKind::kOffset, 0.5 * job.plan.links.approach, {}};
}

double default_cell(const config::Job& job, const pathgen::CheckedMesh& part) {
  // A tenth of the cutter, and so many cells along the part's longest side at most.
  constexpr double kCellsPerDiameter = 10.0, kCellsPerSide = 1500.0;
  const Vec3 size = part.bounds.max - part.bounds.min;
  const double cell = std::max(job.plan.cutter.diameter / kCellsPerDiameter,
                               std::max({size.x, size.y, size.z}) / kCellsPerSide);
  return std::ceil(cell * 100.0) / 100.0;
}

std::string to_string(const StockShape& shape) {
  switch (shape.kind) {
    case StockKind::kOffset:
      return "offset:" + number_text(shape.margin);
    case StockKind::kBox:
      return "box:" + number_text(shape.margin);
    case StockKind::kCylinder:
      return "cylinder:" + number_text(shape.margin);
    case StockKind::kFile:
      break;
  }
  return shape.path;
}

double Stock::volume() const {
  double sum = 0.0;
  for (const Dexels& bundle : bundles) sum += bundle.volume();
  return sum / static_cast<double>(std::max<std::size_t>(1, bundles.size()));
}

std::size_t Stock::bytes() const {
  std::size_t sum = 0;
  for (const Dexels& bundle : bundles) sum += bundle.bytes();
  return sum;
}

std::uint64_t stock_bytes(const pathgen::Box& box, double cell, const std::vector<int>& axes) {
  std::uint64_t lines = 0;
  for (const int axis : axes) lines += Dexels::line_count(axis, box, cell);
  return lines * Dexels::kBytesPerLine;
}

std::uint64_t free_bytes() {
  std::ifstream info("/proc/meminfo");
  std::string key, unit;
  std::uint64_t kilobytes = 0;
  while (info >> key >> kilobytes && std::getline(info, unit))
    if (key == "MemAvailable:") return kilobytes << 10;
  return 0;
}

Result<Stock> make_stock(const StockShape& shape, const pathgen::CheckedMesh& part, const config::Job& job,
                         double cell, int threads, const std::vector<int>& axes) {
  Filling filling(part, shape);
  if (auto ready = prepare(filling, job); !ready) return tl::unexpected(ready.error());
  if (auto fits = check_memory(filling.box, cell, axes); !fits) return tl::unexpected(fits.error());
  Stock stock{{}, filling.box, cell};
  for (const int axis : axes) stock.bundles.emplace_back(axis, filling.box, cell);
  std::vector<Offset::Near> near(stock.bundles.size());
  in_parallel(near.size(), threads, [&](std::size_t i) { near[i] = filling.near(stock.bundles[i]); });
  in_parallel(stock.bundles.size() * Dexels::kStripes, threads, [&](std::size_t i) {
    const std::size_t bundle = i / Dexels::kStripes;
    filling.fill(stock.bundles[bundle], static_cast<int>(i) % Dexels::kStripes, near[bundle]);
  });
  if (auto held = check_cover(stock, shape, part, threads); !held) return tl::unexpected(held.error());
  return stock;
}

}  // namespace tiltfeed::sim
