#include "pathgen/surface/exposed_backs.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <array>
#include <cmath>

#include "kinematics/basics/tool_path.h"

namespace tiltfeed::pathgen {

namespace {

/// Steeper facets (cosine against the axis) are walls: they carry no height, whichever way they face.
constexpr double kWall = 0.02;
/// What keeps the tool less than this (mm) below a facet still covers it: rounding.
constexpr double kTouching = 1e-6;
/// Side of the tiles in which facets are looked at together, against the distance of neighbouring hulls:
/// what covers one is still in the processor's cache for the next.
constexpr double kTile = 16.0;
/// What covers so many facets lies in the cache anyway, and files mostly list neighbours together.
constexpr std::size_t kFewFacets = 400'000;

class BackLook {
 public:
  BackLook(const ClSurface& surface, const Deformation& deformation, const FlatIndex& index,
           double reference_height)
      : surface_(surface), map_(deformation), index_(index), reference_height_(reference_height) {}

  /// The facets whose centres turn their back to the tool; of many, those of a tile together.
  std::vector<std::uint32_t> backs() const {
    // Tiles of the part: there is no need of flat places yet. Their numbers, 10 bits each, may repeat.
    const double per_mm = 1.0 / (kTile * index_.spacing());
    const auto tile = [per_mm](double at) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(at * per_mm))) & 0x3FF;
    };
    constexpr std::size_t kBlocks = 64;  // worked on side by side
    std::array<std::vector<std::uint64_t>, kBlocks> blocks;
    const std::size_t facets = surface_.mesh().facets.size();
    tbb::parallel_for(std::size_t{0}, kBlocks, [&](std::size_t b) {
      for (std::size_t i = facets * b / kBlocks; i < facets * (b + 1) / kBlocks; ++i) {
        const Point<Part> centre = centre_of(static_cast<std::uint32_t>(i));
        if (!is_back(static_cast<std::uint32_t>(i), centre)) continue;
        blocks[b].push_back(tile(centre.z) << 52 | tile(centre.y) << 42 | tile(centre.x) << 32 | i);
      }
    });
    std::vector<std::uint64_t> all;
    for (const std::vector<std::uint64_t>& block : blocks) all.insert(all.end(), block.begin(), block.end());
    if (facets > kFewFacets) tbb::parallel_sort(all);
    std::vector<std::uint32_t> backs(all.size());
    std::transform(all.begin(), all.end(), backs.begin(),
                   [](std::uint64_t k) { return static_cast<std::uint32_t>(k); });
    return backs;
  }

  /// Requires: f is one of backs().
  bool is_exposed(std::uint32_t f) const {
    const auto& corners = surface_.mesh().facets[f];
    const Point<Part> centre = centre_of(f);
    double size = 0.0;
    for (std::uint32_t v : corners)
      size = std::max(size, squared_length(surface_.mesh().vertices[v] - centre));
    if (!open_at(centre, std::sqrt(size))) return false;  // well below the surface, all of it
    if (open_at(centre, 0.0)) return true;
    return std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
      const Point<Part> beside = lerp(centre, surface_.mesh().vertices[v], kBeside);
      return is_back(f, beside) && open_at(beside, 0.0);
    });
  }

 private:
  Point<Part> centre_of(std::uint32_t f) const {
    const Mesh& mesh = surface_.mesh();
    const auto& [a, b, c] = mesh.facets[f];
    return lerp(lerp(mesh.vertices[a], mesh.vertices[b], 0.5), mesh.vertices[c], 1.0 / 3.0);
  }

  bool is_back(std::uint32_t f, Point<Part> p) const {
    return dot(surface_.facet_normal(f), map_.axis_at(p)) < -kWall;
  }

  /// Does nothing keep the tool `margin` above p, on p's own axis line?
  bool open_at(Point<Part> p, double margin) const {
    const Point<Flat> flat = map_.flatten(p);
    const Vec3 axis = map_.axis_at(p);
    const AxisLine line{p - axis * flat.z, axis};
    const double least = flat.z + margin - kTouching;
    const auto keeps_above = [&](PatchId patch) {
      ClHit hit;
      return surface_.top(patch, line, hit) && hit.z - reference_height_ >= least;
    };
    return !index_.any_touched(
        flat.x, flat.y, line, {.low = least + reference_height_}, surface_,
        [](const ToolPiece&) { return true; }, keeps_above);
  }

  const ClSurface& surface_;
  const Deformation& map_;
  const FlatIndex& index_;
  double reference_height_;
};

}  // namespace

std::vector<std::uint32_t> exposed_backs(const ClSurface& surface, const Deformation& deformation,
                                         const FlatIndex& index, double reference_height,
                                         const ReportShare& report) {
  const BackLook look(surface, deformation, index, reference_height);
  std::vector<std::uint32_t> facets = look.backs();
  Watch watch(report, facets.size());
  tbb::parallel_for(std::size_t{0}, facets.size(), [&](std::size_t i) {
    if (!watch.next() || !look.is_exposed(facets[i])) facets[i] = kNoFacet;
  });
  std::erase(facets, kNoFacet);
  std::sort(facets.begin(), facets.end());
  return facets;
}

}  // namespace tiltfeed::pathgen
