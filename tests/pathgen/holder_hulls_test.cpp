// Shank and holder in the envelope against every patch of every piece, one by one; and how few are asked.
#include "pathgen/surface/hull_bvh.h"

#include <gtest/gtest.h>

#include <random>

#include "pathgen/envelope/envelope.h"
#include "pathgen/linking/approach.h"
#include "pathgen/surface/cl_field.h"
#include "pathgen/tool/tool_pieces.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

struct Case {
  const char* name;
  AxisFrame frame;
};

/// A rough floor with towers that a holder meets, under a tool whose holder is 12 mm over its tip.
struct Yard {
  Deformation map;
  CheckedMesh part;
  PlanOptions options;
  ClSurface cutter, all;
  FlatIndex index;

  Yard(const AxisFrame& frame, int density)
      : map(frame, kGroundRadius),
        part(floor_of(frame, map, density)),
        options(options_of(frame)),
        cutter(part.mesh, part.sides, {tool_pieces(options).front()}),
        all(part.mesh, part.sides, tool_pieces(options)),
        index(FlatIndex(make_flat_hulls(cutter, map, 0.5), map), all.numbers_of(cutter),
              make_flat_hulls(all, map, 0.5, {},
                              [this](PatchId patch) { return all.piece(patch).part != ToolPart::kCutter; }),
              map) {}

  static PlanOptions options_of(const AxisFrame& frame) {
    PlanOptions options = options_with(frame);
    options.cutter = {3.0, 100.0, 12.0};
    options.cutter.holder = {{9.0, 13.0, 6.0}, {18.0, 18.0, 20.0}};
    options.holder = {0.5, Reaction::kRetract};
    return options;
  }
  static CheckedMesh floor_of(const AxisFrame& frame, const Deformation& map, int density) {
    const double ground = frame.mode == AxisMode::kFixed ? 0.0 : map.s() * kGroundRadius;
    const double u = frame.mode == AxisMode::kFixed || frame.mode == AxisMode::kLine ? 20.0 : 0.5;
    const double v = frame.mode == AxisMode::kFixed ? 12.0 : 0.35;
    return sheet(frame, {-u, u, -v, v, 20 * density, 12 * density}, [=](double x, double y) {
      const double rough = 0.4 * std::sin(9.0 * x / u + 5.0 * y / v), r = std::hypot(x / u + 0.6, y / v);
      return ground + rough + (r < 0.25 ? 17.0 : 0.0) + (x / u > 0.7 ? 14.5 : 0.0);
    });
  }
  /// By brute force.
  std::optional<double> highest(double x, double y) const {
    Deformation::Angles angles;
    const AxisLine line = map.axis_line(x, y, angles);
    std::optional<double> top;
    for (PatchId patch = 0; patch < all.patch_count(); ++patch)
      if (ClHit hit; all.top(patch, line, hit) && map.in_column(hit.z, angles, 0.0))
        top = std::max(top.value_or(hit.z), hit.z);
    return top;
  }
};

class GuardCells : public testing::TestWithParam<Case> {};

// (envelope.h, properties 1 and 3)
TEST_P(GuardCells, PlacesAndLinesEqualEveryPatchAsked) {
  const Yard yard(GetParam().frame, 2);
  const EnvelopeOptions limits{0.004, 0.03};
  Envelope envelope(yard.all, yard.map, yard.index, limits), by_tree = envelope;
  const HullBvh tree = yard.index.tree(yard.map);
  by_tree.look_up_in(tree);
  std::mt19937 random(5);
  const FlatBounds& b = yard.index.bounds();
  std::size_t raised = 0;
  for (int i = 0; i < 120; ++i) {
    const double x = std::uniform_real_distribution(b.min_x, b.max_x)(random);
    const double y = std::uniform_real_distribution(b.min_y, b.max_y)(random);
    const auto expected = yard.highest(x, y);
    const auto found = envelope.at(x, y), again = by_tree.at(x, y);
    ASSERT_EQ(found.has_value(), expected.has_value()) << x << ", " << y;
    ASSERT_EQ(again.has_value(), expected.has_value()) << x << ", " << y;
    if (!found) continue;
    for (const double off : {-3.0, -1e-9, 0.0, 1e-9, 3.0}) {
      EXPECT_EQ(envelope.rises_over(x, y, *expected + off), off < 0.0) << x << ", " << y << ", " << off;
      EXPECT_EQ(by_tree.rises_over(x, y, *expected + off), off < 0.0) << x << ", " << y << ", " << off;
    }
    EXPECT_EQ(found->flat.z, *expected) << x << ", " << y;
    EXPECT_EQ(again->flat.z, *expected) << x << ", " << y;
    EXPECT_EQ(again->patch, found->patch);
    raised += found->patch >= yard.all.features() ? 1 : 0;
  }
  EXPECT_GT(raised, 20u);
  std::size_t moves = 0, joined = 0;
  for (const double share : {0.3, 0.45, 0.5, 0.62}) {
    const FlatLine line{b.min_x, b.min_y + share * (b.max_y - b.min_y), 1.0, 0.0, b.max_x - b.min_x};
    const LineEnvelope found = envelope.along(line);
    EXPECT_TRUE(found.guarded);
    for (const Pass& pass : found.passes)
      for (std::size_t i = 0; i + 1 < pass.size(); i += 1 + pass.size() / 50) {
        const EnvelopePoint &p = pass[i], &q = pass[i + 1];
        EXPECT_EQ(p.flat.z, yard.highest(p.flat.x, p.flat.y).value_or(0.0));
        const double run = q.flat.x - p.flat.x, rise = q.flat.z - p.flat.z;
        if (std::abs(rise) > 0.5 * run) continue;  // a flank
        ++moves;
        const auto middle = yard.highest((p.flat.x + q.flat.x) / 2.0, p.flat.y);
        ASSERT_TRUE(middle);
        EXPECT_LE(*middle, (p.flat.z + q.flat.z) / 2.0 + 2.0 * limits.tolerance)
            << p.flat.x << ", " << p.flat.y;
      }
    // Nothing is torn where a stretch was traced anew.
    const auto whole = [](const std::vector<Pass>& passes) {
      double all = 0.0;
      for (const Pass& pass : passes) all += pass.back().flat.x - pass.front().flat.x;
      return all;
    };
    joined += found.passes.size();
    EXPECT_GT(whole(found.passes), 0.85 * line.length);
  }
  EXPECT_GT(moves, 60u);
  EXPECT_LE(joined, 8u);
}

/// Over a height z the envelope is whole; under it shank and holder may be left out.
// (envelope.h, property 4)
TEST_P(GuardCells, LinesAreWholeWhereShankAndHolderAreOverTheHeight) {
  const Yard yard(GetParam().frame, 2);
  const EnvelopeOptions limits{0.004, 0.03};
  Envelope envelope(yard.all, yard.map, yard.index, limits);
  const FlatBounds& b = yard.index.bounds();
  const double ground = GetParam().frame.mode == AxisMode::kFixed ? 0.0 : yard.map.s() * kGroundRadius;
  std::size_t over = 0, left_out = 0, under = 0;
  for (const double share : {0.3, 0.45, 0.5, 0.62}) {
    const FlatLine line{b.min_x, b.min_y + share * (b.max_y - b.min_y), 1.0, 0.0, b.max_x - b.min_x};
    for (const double z : {ground + 1.0, ground + 4.0, ground + 30.0}) {
      const LineEnvelope found = envelope.along(line, z);
      double top = -1e9;
      for (const Pass& pass : found.passes)
        for (std::size_t i = 0; i < pass.size(); i += 1 + pass.size() / 40) {
          const auto whole = yard.highest(pass[i].flat.x, pass[i].flat.y);
          ASSERT_TRUE(whole);
          if (*whole > z) {
            EXPECT_EQ(pass[i].flat.z, *whole) << pass[i].flat.x << ", " << pass[i].flat.y;
            ++over;
          } else {
            EXPECT_LE(pass[i].flat.z, *whole) << pass[i].flat.x << ", " << pass[i].flat.y;
            left_out += pass[i].flat.z < *whole ? 1 : 0;
          }
          top = std::max(top, pass[i].flat.z);
        }
      under += top <= z ? 1 : 0;
    }
  }
  EXPECT_GT(over, 60u);
  EXPECT_GT(left_out, 20u);
  EXPECT_GE(under, 4u);
}

/// A rapid ends where shank and holder, too, have the approach between them and the part.
TEST_P(GuardCells, RapidsEndOverWhatEveryPieceOfTheToolTouches) {
  constexpr double kApproach = 1.5;
  const Yard yard(GetParam().frame, 2);
  const ClField field{yard.all, yard.map, yard.index, yard.index.bounds()};
  const ClSurface& surface = field.surface;
  Envelope envelope(surface, field.deformation, field.index, {});
  std::vector<ToolPiece> grown = surface.pieces();
  for (ToolPiece& piece : grown) piece.corner += kApproach, piece.outer += kApproach * piece.taper_cos;
  std::mt19937 random(9);
  const FlatBounds& b = field.bounds;
  const double from = GetParam().frame.sense == Sense::kInward ? -12.0 : 90.0;
  Approaches approaches(field, kApproach, from);
  std::size_t by_holder = 0;
  for (int i = 0; i < 150; ++i) {
    const auto at = envelope.at(std::uniform_real_distribution(b.min_x, b.max_x)(random),
                                std::uniform_real_distribution(b.min_y, b.max_y)(random));
    if (!at) continue;
    Deformation::Angles angles;
    const AxisLine line = field.deformation.axis_line(at->flat.x, at->flat.y, angles);
    double expected = at->flat.z + kApproach;
    bool holder = false;
    for (PatchId feature = 0; feature < surface.features(); ++feature)
      for (const ToolPiece& piece : grown)
        if (ClHit hit; surface.top(piece, feature, line, hit) &&
                       field.deformation.in_column(hit.z, angles, 0.0) && hit.z > expected)
          expected = hit.z, holder = piece.part != ToolPart::kCutter;
    ASSERT_LT(expected, from);
    EXPECT_EQ(approaches.rapid_end(at->flat), expected) << at->flat.x << ", " << at->flat.y;
    by_holder += holder ? 1 : 0;
  }
  EXPECT_GT(by_holder, 10u);
}

/// Under a wide holder lie the more hulls the finer the mesh is. Over the cutting part's own height few of
/// them are asked, and in the open, where none of them is that high, none.
TEST_P(GuardCells, FewAreAskedWhateverTheMesh) {
  for (const int density : {2, 6}) {
    const Yard yard(GetParam().frame, density);
    const HullBvh& tree = yard.index.guards();
    const FlatIndex own(make_flat_hulls(yard.cutter, yard.map, 0.5), yard.map);
    Envelope cutter(yard.cutter, yard.map, own, {});
    const FlatBounds& b = own.bounds();
    std::size_t over = 0, asked = 0, places = 0, none = 0;
    for (int i = 1; i < 20; ++i)
      for (int j = 1; j < 20; ++j) {
        const double x = b.min_x + (b.max_x - b.min_x) * i / 20, y = b.min_y + (b.max_y - b.min_y) * j / 20;
        const FlatBox place{x, x, y, y};
        const auto found = cutter.at(x, y);
        if (!found) continue;
        ++places;
        const std::size_t before = asked;
        tree.each(
            place, [](const FlatBox&, float) { return true; }, [&](const HullBvh::Found&) { ++over; });
        Deformation::Angles angles;
        const AxisLine line = yard.map.axis_line(x, y, angles);
        double best = found->flat.z;
        tree.each(
            place, [&](const FlatBox&, float top) { return static_cast<double>(top) >= best; },
            [&](const HullBvh::Found& guard) {
              ++asked;
              if (ClHit hit; yard.all.top(guard.patch, line, hit)) best = std::max(best, hit.z);
            });
        none += asked == before ? 1 : 0;
      }
    ASSERT_GT(places, 100u);
    EXPECT_GT(over, (density == 2 ? 120 : 1000) * places);
    EXPECT_LT(asked, over / 4) << asked << " of " << over << " over " << places << " places";
    EXPECT_GT(none, places / 5) << none << " of " << places;
  }
}

/// A step whose rim runs aslant to the axis line, and a tower on it: the holder meets that over a part of the
/// rim.
struct Step {
  static constexpr double kGround = 40.0, kTop = 57.0, kTower = 85.0;
  AxisFrame frame{AxisMode::kLine, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0};
  Deformation map{frame, kGround};
  Mesh mesh;
  PlanOptions options = Yard::options_of(frame);
  ClSurface cutter, all;
  FlatIndex index;

  Step()
      : mesh(soup()),
        cutter(mesh, Sides::kBoth, {tool_pieces(options).front()}),
        all(mesh, Sides::kBoth, tool_pieces(options)),
        index(FlatIndex(make_flat_hulls(cutter, map, 0.5), map), all.numbers_of(cutter),
              make_flat_hulls(all, map, 0.5, {},
                              [this](PatchId patch) { return all.piece(patch).part != ToolPart::kCutter; }),
              map) {}

  static Mesh soup() {
    Mesh mesh;
    const auto quad = [&mesh](Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.insert(mesh.vertices.end(), {a, b, c, d});
      mesh.facets.push_back({first, first + 1, first + 2}),
          mesh.facets.push_back({first, first + 2, first + 3});
      mesh.source.insert(mesh.source.end(), 2, static_cast<std::uint32_t>(mesh.source.size()));
    };
    quad({-20, -15, kGround}, {20, -15, kGround}, {20, 15, kGround}, {-20, 15, kGround});
    quad({-20, -15, kTop}, {-6, -15, kTop}, {6, 15, kTop}, {-20, 15, kTop});
    quad({-6, -15, kGround}, {6, 15, kGround}, {6, 15, kTop}, {-6, -15, kTop});
    quad({-6.4, -15, kTop}, {-6.4, 1, kTop}, {-6.4, 1, kTower}, {-6.4, -15, kTower});
    quad({-20, 1, kTop}, {-6.4, 1, kTop}, {-6.4, 1, kTower}, {-20, 1, kTower});
    return mesh;
  }
  /// By brute force.
  double highest(const ClSurface& surface, double x, double y) const {
    Deformation::Angles angles;
    const AxisLine line = map.axis_line(x, y, angles);
    double top = -1e9;
    for (PatchId patch = 0; patch < surface.patch_count(); ++patch)
      if (ClHit hit; surface.top(patch, line, hit)) top = std::max(top, hit.z);
    return top;
  }
  /// The last x' at which the cutting part touches the rim.
  double rim(double y) const {
    double on = -4.0, off = 12.0;
    while (off - on > 1e-12) {
      const double middle = 0.5 * (on + off);
      (highest(cutter, middle, y) > kTop ? on : off) = middle;
    }
    return on;
  }
};

/// A straight move along the rim stays up. Its flat line is beside the rim by a hair: places of it, asked one
/// by one where the tower cuts the move up, fall past the rim. There the rim meets the holder, lower than
/// anything that the whole move has to ask for.
TEST(GuardHulls, AMoveAlongARimThatIsCutUpKeepsTheHolderOff) {
  const Step step;
  Envelope envelope(step.all, step.map, step.index, {0.02, 0.03});
  // Where the holder no longer meets the tower.
  double met = 0.8, clear = 3.8;
  while (clear - met > 1e-6) {
    const double middle = 0.5 * (met + clear);
    (step.highest(step.all, step.rim(middle), middle) > Step::kTop + 5.0 ? met : clear) = middle;
  }
  std::mt19937 random(3);
  std::size_t past = 0, over = 0;
  for (int i = 0; i < 60; ++i) {
    const double y = std::uniform_real_distribution(met - 0.02, met + 0.04)(random),
                 y2 = y + std::uniform_real_distribution(0.2, 0.3)(random);
    const double x = step.rim(y), x2 = step.rim(y2), run = std::hypot(x2 - x, y2 - y);
    const FlatLine line{x, y, (x2 - x) / run, (y2 - y) / run, run};
    for (const LineEnvelope& found : {envelope.along(line), envelope.along_short(line, kAnyHeight)})
      for (const Pass& pass : found.passes)
        for (const EnvelopePoint& p : pass) {
          EXPECT_EQ(p.flat.z, step.highest(step.all, p.flat.x, p.flat.y)) << y << ", " << y2;
          ++(step.highest(step.cutter, p.flat.x, p.flat.y) < Step::kTop - 5.0 ? past : over);
        }
  }
  EXPECT_GT(past, 50u);
  EXPECT_GT(over, 50u);
}

INSTANTIATE_TEST_SUITE_P(
    Modes, GuardCells,
    testing::Values(Case{"fixed", {AxisMode::kFixed, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}},
                    Case{"line", {AxisMode::kLine, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}},
                    Case{"into_a_line", {AxisMode::kLine, Sense::kInward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}},
                    Case{"point", {AxisMode::kPoint, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 0.0}}),
    [](const testing::TestParamInfo<Case>& tested) { return tested.param.name; });

}  // namespace
}  // namespace tiltfeed
