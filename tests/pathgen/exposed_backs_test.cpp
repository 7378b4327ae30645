// Facets that show the tool their inside: level plates, some facing down. What keeps a ball above a place is
// told plate by plate, in closed form.
#include "pathgen/surface/exposed_backs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "pathgen/mesh/folds.h"
#include "pathgen/plan/plan.h"
#include "pathgen/surface/flat_hulls.h"
#include "tests/shapes/cut_passes.h"
#include "tests/shapes/soup.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kBall = 1.5;  ///< radius, mm

struct Plate {
  double x, y, wide, deep, z;
  bool up;
  bool holds(double px, double py) const { return px >= x && px <= x + wide && py >= y && py <= y + deep; }
  /// Height at which the tip of a ball let down there comes to rest on it: on its outside, or beside it on
  /// its border; its inside carries nothing.
  double tip(double px, double py) const {
    constexpr double kNever = -1e9;
    if (holds(px, py)) return up ? z : kNever;
    const double out_x = std::max({x - px, px - x - wide, 0.0}),
                 out_y = std::max({y - py, py - y - deep, 0.0});
    const double d = std::hypot(out_x, out_y);
    return d < kBall ? z - kBall + std::sqrt(kBall * kBall - d * d) : kNever;
  }
};

/// Two facets each, 2 k and 2 k + 1 of plate k.
Mesh mesh_of(const std::vector<Plate>& plates) {
  Mesh mesh;
  for (const Plate& p : plates) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const double y : {p.y, p.y + p.deep})
      for (const double x : {p.x, p.x + p.wide}) mesh.vertices.push_back({x, y, p.z});
    const std::uint32_t a = first, b = first + 1, c = first + 2, d = first + 3;
    if (p.up) mesh.facets.push_back({a, b, d}), mesh.facets.push_back({a, d, c});
    if (!p.up) mesh.facets.push_back({a, d, b}), mesh.facets.push_back({a, c, d});
    for (int i = 0; i < 2; ++i) mesh.source.push_back(static_cast<std::uint32_t>(mesh.source.size()));
  }
  return mesh;
}

/// `by_tree`: where many patches lie over a place.
std::vector<std::uint32_t> exposed(const Mesh& mesh, bool by_tree = false) {
  const ToolPiece ball{.corner = kBall, .outer = kBall};
  const ClSurface surface(mesh, Sides::kOutward, {ball});
  const Deformation fixed(AxisFrame{}, 1.0);
  const FlatIndex index(make_flat_hulls(surface, fixed, 0.1), fixed);
  EXPECT_NE(by_tree, index.drops_after(by_tree ? 100'000'000 : 0, surface).empty());
  return exposed_backs(surface, fixed, index, kBall);
}

TEST(Exposure, LiesBetweenAllAndSomeOfTheFacetOpen) {
  std::mt19937 random(3);
  const auto in = [&](double low, double high) { return low + (high - low) * (random() * 0x1.0p-32); };
  std::size_t open = 0, covered = 0, partly = 0, beside = 0;
  for (int round = 0; round < 80; ++round) {
    std::vector<Plate> plates;
    for (int k = 0; k < 12; ++k)
      plates.push_back({in(0, 20), in(0, 20), in(1, 9), in(1, 9), in(0, 8), in(0, 1) < 0.5});
    const auto is_free = [&](Point<Part> p) {
      return std::none_of(plates.begin(), plates.end(),
                          [&](const Plate& q) { return q.tip(p.x, p.y) >= p.z; });
    };
    const Mesh mesh = mesh_of(plates);
    const std::vector<std::uint32_t> found = exposed(mesh);
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
    for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) {
      const bool is_found = std::binary_search(found.begin(), found.end(), f);
      if (plates[f / 2].up) {
        EXPECT_FALSE(is_found) << "its outside is up";
        continue;
      }
      std::size_t free = 0, places = 0;
      const auto& [a, b, c] = mesh.facets[f];
      const Point<Part> pa = mesh.vertices[a], pb = mesh.vertices[b], pc = mesh.vertices[c];
      const Point<Part> centre = lerp(lerp(pa, pb, 0.5), pc, 1.0 / 3.0);
      for (double u = 0.0; u <= 1.0; u += 0.02)
        for (double v = 0.0; u + v <= 1.0 + 1e-9; v += 0.02) {
          const Point<Part> p = lerp(centre, pa + (pb - pa) * u + (pc - pa) * v, 0.85);
          ++places, free += is_free(p) ? 1 : 0;
        }
      if (free == 0 || free == places) {
        EXPECT_EQ(is_found, free > 0) << "round " << round << " facet " << f;
      } else if (!is_free(centre) && is_free({centre.x, centre.y, centre.z + distance(centre, pc)}) &&
                 is_free(lerp(centre, pc, 0.8))) {
        EXPECT_TRUE(is_found) << "open to one side, round " << round << " facet " << f;
        ++beside;
      }
      ++(free == places ? open : free == 0 ? covered : partly);
    }
  }
  EXPECT_GT(open, 100U);
  EXPECT_GT(covered, 70U);
  EXPECT_GT(partly, 30U);
  EXPECT_GT(beside, 10U);
}

/// Crumbs, of which a dozen and more lie near enough to hold a ball over each place.
TEST(Exposure, IsFoundInACrowd) {
  std::mt19937 random(8);
  const auto in = [&](double low, double high) { return low + (high - low) * (random() * 0x1.0p-32); };
  std::vector<Plate> plates;
  for (int k = 0; k < 900; ++k)
    plates.push_back({in(0, 20), in(0, 20), in(0.1, 0.6), in(0.1, 0.6), in(0, 12), in(0, 1) < 0.5});
  const Mesh mesh = mesh_of(plates);
  const std::vector<std::uint32_t> found = exposed(mesh, true);
  EXPECT_EQ(found, exposed(mesh, false));
  std::size_t open = 0, covered = 0;
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) {
    if (plates[f / 2].up) continue;
    double lowest = 1e9, highest = -1e9;  // of where the ball stops, over places of the facet
    const auto& [a, b, c] = mesh.facets[f];
    for (double u = 0.0; u <= 1.0; u += 0.1)
      for (double v = 0.0; u + v <= 1.0 + 1e-9; v += 0.1) {
        const Point<Part> p = mesh.vertices[a] + (mesh.vertices[b] - mesh.vertices[a]) * u +
                              (mesh.vertices[c] - mesh.vertices[a]) * v;
        double top = -1e9;
        for (const Plate& q : plates)
          if (&q != &plates[f / 2]) top = std::max(top, q.tip(p.x, p.y));
        lowest = std::min(lowest, top), highest = std::max(highest, top);
      }
    const bool is_found = std::binary_search(found.begin(), found.end(), f);
    if (highest < plates[f / 2].z) {
      EXPECT_TRUE(is_found) << "facet " << f;
      ++open;
    } else if (lowest > plates[f / 2].z) {
      EXPECT_FALSE(is_found) << "facet " << f;
      ++covered;
    }
  }
  EXPECT_GT(open, 30u);
  EXPECT_GT(covered, 300u);
}

/// So many that they are looked at tile by tile: pairs far apart, a cover over each plate or beside it.
TEST(Exposure, IsFoundAmongVeryMany) {
  std::vector<Plate> plates;
  std::vector<std::uint32_t> expected;
  for (int i = 0; i < 340; ++i)
    for (int j = 0; j < 300; ++j) {
      const double x = 12.0 * i, y = 9.0 * j;
      const bool beside = (i * 7 + j * 3) % 11 == 0;
      const auto first = static_cast<std::uint32_t>(2 * plates.size());
      if (beside) expected.push_back(first), expected.push_back(first + 1);
      plates.push_back({x, y, 3.0, 4.0, 0.0, false});
      plates.push_back({beside ? x + 6.0 : x - 0.5, y - 0.5, 4.0, 5.0, 0.5, true});
    }
  EXPECT_GT(2 * plates.size(), 400'000U);
  EXPECT_EQ(exposed(mesh_of(plates)), expected);
}

using soup::operator+;

CheckedMesh hollow_cube() { return soup::check(soup::cube(0, 40) + soup::reversed(soup::cube(10, 30))); }

/// From the wall the cavity is behind facets that show their inside: the wall would be cut from inside.
TEST(InsideSolid, ThePointMayNotLieInTheMaterial) {
  PlanOptions o = options_with({AxisMode::kPoint, Sense::kInward, {5, 20, 20}, {1, 0, 0}, {0, 0, 1}, 0.0});
  o.cutter = {2.0, 100.0, 3.0}, o.links.clearance = 0.5, o.links.approach = 0.5;
  const auto planned = plan(hollow_cube(), o, {});
  ASSERT_FALSE(planned);
  EXPECT_EQ(planned.error().code, Code::kUnreachable);
  EXPECT_NE(planned.error().message.find("lies in the material"), std::string::npos)
      << planned.error().message;
}

/// Outside work on the inner half of a circle comes from the axis of Theta, here in the wall of the cavity.
TEST(InsideSolid, TheAxisOfThetaMayNotLieInTheMaterial) {
  PlanOptions o = options_with({AxisMode::kCircle, Sense::kOutward, {5, 20, 20}, {1, 0, 0}, {0, 1, 0}, 60.0});
  o.cutter = {2.0, 100.0, 3.0}, o.links.clearance = 0.5, o.links.approach = 0.5;
  const auto planned = plan(hollow_cube(), o, {});
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_TRUE(
      std::any_of(planned->report.warnings.begin(), planned->report.warnings.end(),
                  [](const std::string& w) { return w.find("lies in the material") != std::string::npos; }));
  std::size_t cuts = 0;
  for (const Move& move : planned->path.moves) {
    if (move.kind != MoveKind::kCut) continue;
    ++cuts;
    const Point<Part> centre = move.pose.tip + move.pose.axis * o.cutter.radius();
    const auto is_within = [&](double low, double high) {
      return std::min({centre.x, centre.y, centre.z}) > low &&
             std::max({centre.x, centre.y, centre.z}) < high;
    };
    EXPECT_TRUE(is_within(10, 30) || !is_within(0, 40)) << centre.x << ' ' << centre.y << ' ' << centre.z;
  }
  EXPECT_GT(cuts, 50u);
}

/// A line through a cavity and through the walls at its ends: what it sees from the walls is left out.
TEST(InsideSolid, OfALinePartlyInTheMaterialTheRestIsCut) {
  PlanOptions o = options_with({AxisMode::kLine, Sense::kInward, {0, 20, 20}, {1, 0, 0}, {0, 0, 1}, 0.0});
  o.cutter = {4.0, 100.0, 6.0};
  o.links.clearance = 2.0;
  const auto planned = plan(hollow_cube(), o, {});
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_TRUE(
      std::any_of(planned->report.warnings.begin(), planned->report.warnings.end(),
                  [](const std::string& w) { return w.find("lies in the material") != std::string::npos; }));
  std::size_t cuts = 0;
  for (const Move& move : planned->path.moves) {
    if (move.kind != MoveKind::kCut) continue;
    ++cuts;
    for (const double at : {move.pose.tip.x, move.pose.tip.y, move.pose.tip.z}) {
      EXPECT_GE(at, 10.0 - o.tolerance);
      EXPECT_LE(at, 30.0 + o.tolerance);
    }
  }
  EXPECT_GT(cuts, 50u);
}

/// A wedge 20 mm long and 30 wide. At its thin end the upper side is at `up`, the lower at `down`: where that
/// is higher, both sides cross just before, and the last bit is turned inside out.
CheckedMesh wedge(double up, double down) {
  const auto at = [&](double x, double y, double z) { return Point<Part>{x, y, z}; };
  soup::Soup s;
  soup::add_quad(s, at(0, 0, 0), at(0, 30, 0), at(20, 30, down), at(20, 0, down));
  soup::add_quad(s, at(0, 0, 4), at(20, 0, up), at(20, 30, up), at(0, 30, 4));
  soup::add_quad(s, at(0, 0, 0), at(0, 0, 4), at(0, 30, 4), at(0, 30, 0));
  soup::add_quad(s, at(20, 0, down), at(20, 30, down), at(20, 30, up), at(20, 0, up));
  soup::add_quad(s, at(0, 0, 0), at(20, 0, down), at(20, 0, up), at(0, 0, 4));
  soup::add_quad(s, at(0, 30, 0), at(0, 30, 4), at(20, 30, up), at(20, 30, down));
  return soup::check(s);
}

std::vector<std::uint32_t> folds_of(const Mesh& mesh) {
  const ToolPiece ball{.corner = kBall, .outer = kBall};
  return folded_facets(mesh, ClSurface(mesh, Sides::kOutward, {ball}).notches());
}

TEST(Folds, AWedgeWhoseThinEndIsTurnedInsideOutIsNotCutInto) {
  for (const double over : {-0.1, 0.1}) {
    const CheckedMesh part = wedge(0.2, 0.2 + over);
    ASSERT_EQ(part.sides, Sides::kOutward);
    EXPECT_EQ(!folds_of(part.mesh).empty(), over > 0.0);
    PlanOptions o = options_with(AxisFrame{});
    o.cutter = {4.0, 100.0, 30.0};
    o.tolerance = 0.01;
    const auto planned = plan(part, o, {});
    ASSERT_TRUE(planned) << planned.error().message;
    const auto& warnings = planned->report.warnings;
    EXPECT_EQ(std::any_of(warnings.begin(), warnings.end(),
                          [](const std::string& w) { return w.find("folded") != std::string::npos; }),
              over > 0.0);
    const double highest = 0.2 + std::max(0.0, over);  // of the thin end
    for (const Move& move : planned->path.moves) {
      const Point<Part> centre = move.pose.tip + move.pose.axis * 2.0;
      if (centre.y < 0.0 || centre.y > 30.0) continue;
      const double up = std::max(0.0, centre.z - highest);  // the shank is above the ball
      EXPECT_GE(std::hypot(centre.x - 20.0, up), 2.0 - o.tolerance) << centre.x << ' ' << centre.z;
    }
  }
}

/// An open notch as narrow is no fold: there is material behind it.
TEST(Folds, ANarrowNotchIsNone) {
  soup::Soup s;
  const std::array<std::array<double, 2>, 7> section{
      {{0, 0}, {20, 0}, {20, 8}, {11, 8}, {10, 2}, {9, 8}, {0, 8}}};
  for (std::size_t i = 0; i < section.size(); ++i) {
    const auto& [x, z] = section[i];
    const auto& [next_x, next_z] = section[(i + 1) % section.size()];
    soup::add_quad(s, {x, 0, z}, {next_x, 0, next_z}, {next_x, 30, next_z}, {x, 30, z});
  }
  for (const double y : {0.0, 30.0})  // a fan about the notch's foot
    for (std::size_t i = 5; i < 5 + 5; ++i) {
      const auto& a = section[i % 7];
      const auto& b = section[(i + 1) % 7];
      const soup::Corners f{Point<Part>{10, y, 2}, {a[0], y, a[1]}, {b[0], y, b[1]}};
      s.push_back(y == 0.0 ? f : soup::reversed(f));
    }
  const CheckedMesh part = soup::check(s);
  ASSERT_EQ(part.sides, Sides::kOutward);
  EXPECT_TRUE(folds_of(part.mesh).empty());
}

/// A knife edge folded over itself by next to nothing. With a flat piece, for which a surface has more edges,
/// those that the ball needs are all among them.
// (cl_surface.h, property 4)
TEST(ExposedBacks, OfAFoldMorePiecesNeedWhatFewerDo) {
  const ToolPiece ball{.corner = 1.0, .outer = 1.0};
  const ToolPiece flat{.part = ToolPart::kHolder, .flat = 2.0, .outer = 2.0};
  for (double rise = 1e-14; rise < 1.0; rise *= 3.0) {
    Mesh mesh;
    mesh.vertices = {{0, 0, 0}, {10, 0, 0}, {5, 5, 0}, {5, 5, 5.0 * rise}};
    mesh.facets = {{0, 1, 2}, {1, 0, 3}}, mesh.source = {0, 1};
    const ClSurface few(mesh, Sides::kOutward, {ball}), all(mesh, Sides::kOutward, {ball, flat});
    ASSERT_GE(all.features(), few.features()) << rise;
    EXPECT_EQ(all.numbers_of(few).size(), few.features()) << rise;
  }
}

}  // namespace
}  // namespace tiltfeed
