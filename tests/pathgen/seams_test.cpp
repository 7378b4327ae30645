// Between neighbouring patches the tool must not fall through: heights of the envelope against those of every
// facet, edge and vertex of the mesh, however flat, asked one by one without cells, cones or bends. What the
// tool touches on any of them it cannot pass, so the highest is its height.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "pathgen/envelope/envelope.h"
#include "pathgen/surface/flat_hulls.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kClose = 2e-5;  ///< mm

struct Tool {
  const char* name;
  ToolPiece piece;
};
std::array<Tool, 4> tools() {
  const double taper = 0.1;
  return {
      {{"ball", {.corner = 2.0, .outer = 2.0}},
       {"bull-nose", {.flat = 1.5, .corner = 0.5, .outer = 2.0}},
       {"flat", {.flat = 2.0, .outer = 2.0}},
       {"taper", {.corner = 1.0, .taper_sin = std::sin(taper), .taper_cos = std::cos(taper), .outer = 3.0}}}};
}

double height(const ToolPiece& tool, const Mesh& mesh, const AxisLine& line) {
  double top = -1e9;
  ClHit hit;
  const auto see = [&](bool touches) { top = touches ? std::max(top, hit.z) : top; };
  for (const Facet& f : mesh.facets) {
    const Point<Part>&a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]], &c = mesh.vertices[f[2]];
    see(drop_on_facet(tool, a, b, c, normalized(cross(b - a, c - a)), 0.0, line, hit));
    see(drop_on_edge(tool, a, b, 0.0, line, hit)), see(drop_on_edge(tool, b, c, 0.0, line, hit));
    see(drop_on_edge(tool, c, a, 0.0, line, hit));
  }
  for (const Point<Part>& v : mesh.vertices) see(drop_on_vertex(tool, v, line, hit));
  return top;
}

/// A plate of cells 5 mm wide whose corners lie up to `noise` off their plane, which climbs by `slope`.
Mesh plate(double slope, double noise) {
  constexpr int kCells = 6;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Mesh mesh;
  for (int i = 0; i <= kCells; ++i)
    for (int j = 0; j <= kCells; ++j) {
      const double x = 5.0 * i + unit(random), y = 5.0 * j + unit(random);
      mesh.vertices.push_back({x, y, slope * x + noise * unit(random)});
    }
  const auto at = [](int i, int j) { return static_cast<std::uint32_t>(i * (kCells + 1) + j); };
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      mesh.facets.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.facets.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) mesh.source.push_back(f);
  return mesh;
}

const AxisFrame kSeamFrame{AxisMode::kFixed, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0};

// (cl_surface.h, property 2)
TEST(Seams, NearlyFlatPlatesHaveNoHoles) {
  const Deformation map(kSeamFrame, 1.0);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(8.0, 22.0);
  for (const Tool& tool : tools())
    for (const double slope : {0.0, 1e-4, 0.1})
      for (const double noise : {0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3}) {
        SCOPED_TRACE(std::string(tool.name) + ", slope " + std::to_string(slope) + ", noise " +
                     std::to_string(noise * 1e9) + " nm");
        const Mesh mesh = plate(slope, noise);
        const ClSurface surface(mesh, Sides::kOutward, {tool.piece});
        const FlatIndex index(make_flat_hulls(surface, map, 0.1), map);
        Envelope envelope(surface, map, index, {0.0025, 0.02});
        for (int k = 0; k < 150; ++k) {
          const double x = place(random), y = place(random);
          const auto found = envelope.at(x, y);
          ASSERT_TRUE(found) << "at " << x << ", " << y;
          ASSERT_NEAR(found->flat.z, height(tool.piece, mesh, map.axis_line(x, y)), kClose)
              << "at " << x << ", " << y;
        }
      }
}

/// What a tool touches an edge with is tangent to it, however little the edge climbs: facets beside it are
/// told to lie behind by the contact normal.
// (cl_surface.h, property 3)
TEST(Seams, ContactNormalsAreSquareToTheEdge) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const AxisLine line{{0, 0, 0}, {0, 0, 1}};
  for (const Tool& tool : tools()) {
    int touched = 0;
    for (int k = 0; k < 20000; ++k) {
      const double climb = std::pow(10.0, 4.0 * unit(random) - 4.0);
      const double share = std::pow(10.0, 2.0 * unit(random) - 2.2);
      const double away = tool.piece.corner > 0.0 ? tool.piece.flat + tool.piece.corner * share
                                                  : tool.piece.flat * (1.0 - share);
      const Vec3 along{1, 0, climb};
      const Point<Part> foot{unit(random), away, unit(random)};
      ClHit hit;
      if (!drop_on_edge(tool.piece, foot + along * -50.0, foot + along * 50.0, 0.0, line, hit)) continue;
      ++touched;
      const double least = 1e-7 + 2.0 * kLevel * (climb < kLevel);
      ASSERT_LE(std::abs(dot(hit.normal, along)) / length(along), least)
          << tool.name << " climb " << climb << " away " << away;
      ASSERT_NEAR(length(hit.normal), 1.0, 1e-7);
    }
    EXPECT_GT(touched, 10000);
  }
}

}  // namespace
}  // namespace tiltfeed
