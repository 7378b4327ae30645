// The features that may be the highest under a wide tool: against every feature asked one by one, and how few
// are asked.
#include "pathgen/surface/drop_bvh.h"

#include <gtest/gtest.h>

#include <optional>
#include <random>

#include "pathgen/envelope/envelope.h"
#include "pathgen/envelope/heights.h"
#include "pathgen/envelope/highest_patch.h"
#include "pathgen/pattern/region_pattern.h"
#include "pathgen/surface/cl_surface.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

AxisFrame frame_of(AxisMode mode, Sense sense) {
  return {mode, sense, {}, {1, 0, 0}, {0, 0, 1}, mode == AxisMode::kCircle ? 60.0 : 0.0};
}

/// A wavy sheet on which each seventh corner is drawn to the next one, but for this share of the way.
CheckedMesh rough_sheet(const AxisFrame& frame, int density, double nearly) {
  const bool fixed = frame.mode == AxisMode::kFixed, line = frame.mode == AxisMode::kLine;
  const double ground = fixed ? 0.0 : frame.sense == Sense::kOutward ? 40.0 : -40.0;
  const double u = fixed || line ? 20.0 : 0.4, v = fixed ? 12.0 : 0.3;
  CheckedMesh part = sheet(frame, {-u, u, -v, v, 12 * density, 8 * density}, [=](double x, double y) {
    return ground + 1.5 * std::sin(9.0 * x / u + 5.0 * y / v);
  });
  std::vector<Point<Part>>& at = part.mesh.vertices;
  for (std::size_t i = 7; i + 1 < at.size(); i += 7) at[i] = lerp(at[i + 1], at[i], nearly);
  return part;
}

std::vector<ToolPiece> wide_pieces() {
  const double lean = 0.6, corner = 3.0;
  ToolPiece ball, bull, flat, taper;
  ball.corner = ball.outer = 8.0;
  bull.flat = 5.0, bull.corner = 2.0, bull.outer = 7.0;
  flat.flat = flat.outer = 6.0, flat.above_reference = 1.0;
  taper.corner = corner, taper.taper_sin = std::sin(lean), taper.taper_cos = std::cos(lean),
  taper.outer = 25.0;
  return {ball, bull, flat, taper};
}

/// Of all patches, each with a hull that holds every place near, and one far away.
FlatHulls everywhere(const ClSurface& surface) {
  constexpr float kFarOff = 1e6f;
  FlatHulls hulls;
  hulls.corners.resize(4);
  hulls.corners[0] = {-kFarOff, -kFarOff}, hulls.corners[1] = {kFarOff, kFarOff};
  hulls.corners[2] = {3.0f * kFarOff, 3.0f * kFarOff}, hulls.corners[3] = {4.0f * kFarOff, 4.0f * kFarOff};
  hulls.hulls.resize(2 * surface.patch_count());
  for (std::uint32_t i = 0; i < hulls.hulls.size(); ++i) {
    hulls.hulls[i] = {};
    hulls.hulls[i].patch = i / 2, hulls.hulls[i].first = i % 2 * 2, hulls.hulls[i].count = 2;
  }
  return hulls;
}

/// A tree a piece.
std::vector<DropBvh> trees_of(const ClSurface& surface) {
  const FlatHulls hulls = everywhere(surface);
  std::vector<DropBvh> trees;
  for (std::size_t i = 0; i < surface.pieces().size(); ++i)
    trees.emplace_back(surface, hulls, 2 * i * surface.features(), 2 * (i + 1) * surface.features(), 0.0,
                       0.0);
  return trees;
}

class DropBvhs : public testing::TestWithParam<AxisFrame> {};

TEST_P(DropBvhs, ShowTheHighestOfAllFeatures) {
  const CheckedMesh part = rough_sheet(GetParam(), 2, 1e-5);
  const ClSurface surface(part.mesh, part.sides, wide_pieces());
  const std::vector<DropBvh> trees = trees_of(surface);
  const Deformation map(GetParam(), 40.0);
  std::mt19937 random(3);
  std::size_t hits = 0;
  for (int i = 0; i < 150; ++i) {
    const Point<Part>& from = part.mesh.vertices[random() % part.mesh.vertices.size()];
    const Point<Flat> near = map.flatten(from);
    std::uniform_real_distribution<double> aside(-4.0, 4.0);
    Deformation::Angles angles;
    const AxisLine line = map.axis_line(near.x + aside(random), near.y + aside(random), angles);
    // Also only what is under some height, as where a column ends.
    const double most = i % 2 == 0 ? std::numeric_limits<double>::infinity() : near.z + aside(random);
    for (const DropBvh& tree : trees) {
      const ToolPiece& piece = surface.piece(tree.first());
      double expected = -std::numeric_limits<double>::infinity(), found = expected;
      for (PatchId feature = 0; feature < surface.features(); ++feature)
        if (ClHit hit; surface.top(piece, feature, line, hit) && hit.z <= most && hit.z > expected)
          expected = hit.z;
      DropBvh::Heights asked{-std::numeric_limits<double>::infinity(), most};
      tree.each(0.0, 0.0, line, asked, [&](const DropBvh::Found& patch) {
        if (ClHit hit; surface.top(patch.patch, line, hit) && hit.z <= most && hit.z > found)
          found = asked.low = hit.z;
      });
      ASSERT_EQ(found, expected) << "place " << i << ", piece of radius " << piece.outer;
      if (expected == -std::numeric_limits<double>::infinity()) continue;
      ++hits;
    }
  }
  EXPECT_GT(hits, 300u);
}

/// Most of the part is never asked.
TEST_P(DropBvhs, AskFew) {
  for (const int density : {3, 9}) {
    const CheckedMesh part = rough_sheet(GetParam(), density, 0.5);
    const ClSurface surface(part.mesh, part.sides, wide_pieces());
    const std::vector<DropBvh> trees = trees_of(surface);
    const Deformation map(GetParam(), 40.0);
    std::size_t asked = 0, places = 0;
    for (std::size_t v = 0; v < part.mesh.vertices.size(); v += 1 + part.mesh.vertices.size() / 50) {
      const Point<Flat> near = map.flatten(part.mesh.vertices[v]);
      Deformation::Angles angles;
      const AxisLine line = map.axis_line(near.x + 0.1, near.y + 0.1, angles);
      for (const DropBvh& tree : trees) {
        DropBvh::Heights heights;
        ++places;
        tree.each(0.0, 0.0, line, heights, [&](const DropBvh::Found& patch) {
          ++asked;
          if (ClHit hit; surface.top(patch.patch, line, hit)) heights.low = std::max(heights.low, hit.z);
        });
      }
    }
    EXPECT_LT(asked, places * surface.features() / 20)
        << asked << " of " << surface.features() << " at " << places;
  }
}

/// The envelope takes to the tree under a wide tool; heights are those of asking every patch.
// (envelope.h, property 1)
TEST_P(DropBvhs, GiveTheEnvelopeTheSameHeights) {
  const CheckedMesh part = rough_sheet(GetParam(), 3, 0.5);
  const ClSurface surface(part.mesh, part.sides, {wide_pieces().back()});
  const Deformation map(GetParam(), 40.0);
  const FlatIndex index(make_flat_hulls(surface, map, 0.5), map);
  Envelope envelope(surface, map, index, {0.01, 0.05});
  const auto highest = [&](double x, double y) {
    Deformation::Angles angles;
    const AxisLine line = map.axis_line(x, y, angles);
    std::optional<double> top;
    for (PatchId patch = 0; patch < surface.patch_count(); ++patch)
      if (ClHit hit; surface.top(patch, line, hit) && map.in_column(hit.z, angles, 0.0))
        top = std::max(top.value_or(hit.z), hit.z);
    return top;
  };
  const FlatBounds& b = index.bounds();
  const std::vector<Point<Part>>& corners = part.mesh.vertices;
  std::size_t hits = 0;
  for (std::size_t i = 0; i < corners.size(); i += 1 + corners.size() / 300) {
    const Point<Flat> over = map.flatten(corners[i]);
    const double x = over.x + 0.05, y = over.y + 0.05;
    const auto found = envelope.at(x, y);
    const auto expected = highest(x, y);
    ASSERT_EQ(found.has_value(), expected.has_value()) << x << ", " << y;
    if (!found) continue;
    ++hits;
    EXPECT_EQ(found->flat.z, *expected) << x << ", " << y;
  }
  EXPECT_GT(hits, 200u);
  EXPECT_FALSE(index.drops_after(0, surface).empty()) << "nothing was looked up in the tree";
  for (const double share : {0.3, 0.6}) {
    const auto middle = static_cast<std::size_t>(share * static_cast<double>(corners.size()));
    const FlatLine line{b.min_x, map.flatten(corners[middle]).y, 1.0, 0.0, b.max_x - b.min_x};
    const LineEnvelope found = envelope.along(line);
    ASSERT_FALSE(found.passes.empty());
    for (const Pass& pass : found.passes)
      for (std::size_t i = 0; i < pass.size(); i += 1 + pass.size() / 60)
        EXPECT_EQ(pass[i].flat.z, highest(pass[i].flat.x, pass[i].flat.y).value_or(0.0));
  }
}

/// For a stretch the tree shows every patch that is the highest anywhere on it. A short line is traced with
/// few patches, and still is the highest of all of them wherever it has a point.
// (envelope.h, property 1)
TEST_P(DropBvhs, ServeShortLines) {
  const CheckedMesh part = rough_sheet(GetParam(), 3, 0.5);
  const ClSurface surface(part.mesh, part.sides, {wide_pieces().back()});
  const Deformation map(GetParam(), 40.0);
  const FlatIndex index(make_flat_hulls(surface, map, 0.5), map);
  FlatIndex::Scratch scratch;
  Envelope envelope(surface, map, index, {0.01, 0.05});
  std::mt19937 random(11);
  std::uniform_real_distribution<double> turn(-kPi, kPi), size(0.02, 3.0);
  const std::vector<Point<Part>>& corners = part.mesh.vertices;
  std::size_t points = 0, shown = 0;
  for (int n = 0; n < 200; ++n) {
    const Point<Flat> over = map.flatten(corners[random() % corners.size()]);
    const double way = turn(random);
    const FlatLine line{over.x, over.y, std::cos(way), std::sin(way), size(random)};
    const auto highest = [&](double x, double y, double& z) {
      Deformation::Angles angles;
      const AxisLine there = map.axis_line(x, y, angles);
      std::optional<PatchId> best;
      for (PatchId patch = 0; patch < surface.patch_count(); ++patch)
        if (ClHit hit; surface.top(patch, there, hit) && map.in_column(hit.z, angles, 0.0))
          if (!best || hit.z > z) best = patch, z = hit.z;
      return best;
    };
    double low = std::numeric_limits<double>::infinity();
    std::vector<PatchId> expected;
    for (int k = 0; k <= 6; ++k) {
      const double run = line.length * k / 6;
      double z = 0.0;
      const auto best = highest(line.x_at(run), line.y_at(run), z);
      if (best) expected.push_back(*best), low = std::min(low, z);
    }
    if (expected.size() == 7) {
      std::vector<Candidate> found;
      const double half = 0.5 * line.length;
      index.along_over(line, map.axis_line(line.x_at(half), line.y_at(half)), low, surface, map, scratch,
                       found);
      for (const PatchId patch : expected)
        EXPECT_TRUE(
            std::any_of(found.begin(), found.end(), [&](const Candidate& c) { return c.patch == patch; }))
            << "patch " << patch << " on line " << n;
      shown += found.size();
    }
    for (const Pass& pass : envelope.along_short(line, -std::numeric_limits<double>::infinity()).passes)
      for (const EnvelopePoint& p : pass) {
        double z = 0.0;
        ASSERT_TRUE(highest(p.flat.x, p.flat.y, z));
        EXPECT_EQ(p.flat.z, z) << "line " << n;
        ++points;
      }
  }
  EXPECT_GT(points, 1000u);
  EXPECT_LT(shown, 200 * surface.features() / 10);
}

/// Many small facets under a wide taper are a crowd on short lines alone; under a small ball they are none. A
/// curve of such lines is laid exactly.
TEST_P(DropBvhs, LayCurvesInACrowd) {
  const CheckedMesh part = rough_sheet(GetParam(), 5, 0.5);
  ToolPiece small;
  small.corner = small.outer = 0.3;
  const Deformation map(GetParam(), 40.0);
  const ClSurface under_taper(part.mesh, part.sides, {wide_pieces().back()}),
      under_ball(part.mesh, part.sides, {small});
  const FlatIndex taper(make_flat_hulls(under_taper, map, 0.5), map),
      ball(make_flat_hulls(under_ball, map, 0.1), map);
  const EnvelopeOptions limits{0.01, 0.05};
  const Envelope of_taper(under_taper, map, taper, limits), of_ball(under_ball, map, ball, limits);
  const Point<Flat> middle = map.flatten(part.mesh.vertices[part.mesh.vertices.size() / 2]);
  EXPECT_TRUE(of_taper.is_crowded({middle.x, middle.y, 0.6, 0.8, 0.2}));
  EXPECT_FALSE(of_taper.is_crowded({middle.x, middle.y, 0.6, 0.8, 2.0 * wide_pieces().back().outer}));
  EXPECT_FALSE(of_ball.is_crowded({middle.x, middle.y, 0.6, 0.8, 0.2}));
  const ClField field{under_taper, map, taper, taper.bounds()};
  Heights heights(field, limits);
  FlatCurve curve;
  for (int k = 0; k < 9; ++k) curve.push_back({middle.x + 0.15 * k, middle.y + 0.2 * (k % 3)});
  const std::vector<Pass> laid = lay_curve(curve, heights);
  ASSERT_EQ(laid.size(), 1u);
  EXPECT_NEAR(laid[0].front().flat.x, curve.front().x, 1e-9);
  EXPECT_NEAR(laid[0].back().flat.x, curve.back().x, 1e-9);
  const auto highest = [&](double x, double y) {
    Deformation::Angles angles;
    const AxisLine there = map.axis_line(x, y, angles);
    double z = -std::numeric_limits<double>::infinity();
    for (PatchId patch = 0; patch < under_taper.patch_count(); ++patch)
      if (ClHit hit; under_taper.top(patch, there, hit) && map.in_column(hit.z, angles, 0.0))
        z = std::max(z, hit.z);
    return z;
  };
  for (const EnvelopePoint& p : laid[0]) EXPECT_EQ(p.flat.z, highest(p.flat.x, p.flat.y));
  // What is between the places of a profile, as in the cells of a grid for contours, lies near to them.
  const FlatLine line{middle.x, middle.y, 0.6, 0.8, 0.4};
  ASSERT_TRUE(of_taper.is_crowded(line));
  const std::vector<HeightSample> profile = heights.profile(line);
  ASSERT_GE(profile.size(), 2u);
  EXPECT_LT(profile.front().run, 0.002);
  EXPECT_GT(profile.back().run, line.length - 0.002);
  for (std::size_t i = 0; i < profile.size(); ++i) {
    EXPECT_NEAR(profile[i].z, highest(line.x_at(profile[i].run), line.y_at(profile[i].run)), 1e-9);
    if (i == 0) continue;
    for (const double share : {0.25, 0.5, 0.75}) {
      const double run = std::lerp(profile[i - 1].run, profile[i].run, share);
      EXPECT_NEAR(std::lerp(profile[i - 1].z, profile[i].z, share), highest(line.x_at(run), line.y_at(run)),
                  0.03);
    }
  }
}

/// Whether anything keeps the tool above a place: asked in the list and, in a crowd, of the trees that come
/// once the list has cost as much.
TEST_P(DropBvhs, TellWhatKeepsAboveAPlace) {
  const CheckedMesh part = rough_sheet(GetParam(), 5, 0.5);
  const Deformation map(GetParam(), 40.0);
  const ClSurface surface(part.mesh, part.sides, {wide_pieces()[1], wide_pieces().back()});
  const FlatIndex index(make_flat_hulls(surface, map, 0.5), map);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> aside(-0.5, 0.5);
  std::size_t kept = 0, listed = 0, asked = 0;
  constexpr int kPlaces = 100;
  for (int n = 0; n < kPlaces; ++n) {
    const Point<Part> near = part.mesh.vertices[random() % part.mesh.vertices.size()];
    const Point<Flat> f = map.flatten(near + Vec3{aside(random), aside(random), aside(random)});
    const AxisLine line = map.axis_line(f.x, f.y);
    // Of the second piece alone, up to beside its highest place.
    double top = -std::numeric_limits<double>::infinity();
    std::size_t in_list = 0;
    ClHit hit;
    index.any_at(f.x, f.y, [&](PatchId patch) {
      if (++in_list; patch >= surface.features() && surface.top(patch, line, hit)) top = std::max(top, hit.z);
      return false;
    });
    for (const double off : {-1.0, -1e-9, 0.0, 1e-9, 1.0}) {
      std::size_t visited = 0;
      const bool is_kept = index.any_touched(
          f.x, f.y, line, {.low = top + off}, surface,
          [&](const ToolPiece& piece) { return &piece != &surface.pieces().front(); },
          [&](PatchId patch) {
            EXPECT_GE(patch, surface.features());
            return ++visited, surface.top(patch, line, hit) && hit.z >= top + off;
          });
      EXPECT_EQ(is_kept, off <= 0.0) << "place " << n << ", off " << off;
      kept += is_kept ? 1 : 0;
      if (n >= kPlaces / 2) listed += in_list, asked += visited;
    }
  }
  EXPECT_GT(kept, 250u);
  EXPECT_LT(asked, listed / 10) << "by the trees";
}

/// Facets too wide for one hull, of the cutting part and of a guard.
TEST_P(DropBvhs, AreHeldByEachHullOfAPatch) {
  const bool fixed = GetParam().mode == AxisMode::kFixed;
  const double ground = GetParam().sense == Sense::kOutward ? 40.0 : -40.0;
  const CheckedMesh part =
      sheet(GetParam(), {-0.4, 0.4, -0.5, 0.5, 1, 1}, [=](double, double) { return ground; });
  const Deformation map(GetParam(), 40.0);
  const ClSurface cutter(part.mesh, part.sides, {wide_pieces()[0]});
  const ClSurface all(part.mesh, part.sides, {wide_pieces()[0], wide_pieces()[2]});
  const auto guards_of = [&] {
    return make_flat_hulls(all, map, 0.5, {}, [&](PatchId patch) { return patch >= all.features(); });
  };
  const FlatIndex alone(make_flat_hulls(cutter, map, 0.5), map);
  const FlatIndex index(alone, all.numbers_of(cutter), guards_of(), map);
  const auto check = [&](const FlatIndex& of, const FlatHulls& hulls, std::span<const PatchId> numbers) {
    std::size_t more = 0;
    for (std::uint32_t i = 0, first = 0; i < hulls.hulls.size(); ++i) {
      if (hulls.hulls[i].patch != hulls.hulls[first].patch) first = i;
      more += i > first ? 1 : 0;
      const PatchId patch = hulls.hulls[i].patch;
      const DropBvh::Found found{numbers.empty() ? patch : numbers[patch], first};
      const FlatBox box = box_of(hulls, hulls.hulls[i]);
      EXPECT_TRUE(of.holds(found, 0.5 * (box.low_x + box.high_x), 0.5 * (box.low_y + box.high_y)))
          << "hull " << i << " of patch " << patch;
      EXPECT_FALSE(of.holds(found, of.bounds().max_x + 5.0, of.bounds().max_y + 5.0));
    }
    EXPECT_EQ(more == 0, fixed);
  };
  const std::vector<PatchId> numbers = all.numbers_of(cutter);
  check(alone, make_flat_hulls(cutter, map, 0.5), {});
  check(index, make_flat_hulls(cutter, map, 0.5), numbers);
  check(index, guards_of(), {});
}

/// Between a circle and its axis a chord is further from the circle in its middle than at its ends: what
/// bounds the height of a patch must know, or the list of patches is left too early. List and tree find the
/// same there.
TEST(DropBvhInACircle, ListAndTreeFindTheSameInsideTheCircle) {
  const AxisFrame frame{AxisMode::kCircle, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 46.0};
  const CheckedMesh part = sheet(frame, {-1.2, 1.2, 1.9, 2.9, 14, 10}, [](double x, double y) {
    return 38.0 + 2.0 * std::sin(5.0 * x) * std::sin(7.0 * y);
  });
  const Deformation map(frame, 40.0);
  ToolPiece cutter, disc;
  cutter.flat = 0.6, cutter.corner = 0.2, cutter.outer = 0.8;
  disc.part = ToolPart::kHolder, disc.flat = disc.outer = 3.0, disc.above_reference = 25.0;
  const ClSurface alone(part.mesh, part.sides, {cutter}), all(part.mesh, part.sides, {cutter, disc});
  const FlatIndex cut(make_flat_hulls(alone, map, 0.5), map);
  const auto guards = [&](PatchId patch) { return patch >= all.features(); };
  const FlatIndex index(cut, all.numbers_of(alone), make_flat_hulls(all, map, 0.5, {}, guards), map);
  const FlatBounds& b = index.bounds();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> x(b.min_x, b.max_x), y(b.min_y, b.max_y), aside(-1.0, 1.0);
  std::size_t held = 0, cuts = 0;
  for (int i = 0; i < 20000; ++i) {
    const double px = x(random), py = y(random);
    Deformation::Angles angles;
    const AxisLine line = map.axis_line(px, py, angles);
    const auto tree = [&](std::optional<double> over) {
      HighestPatch highest(all, map, angles, line);
      if (over) highest.ask_over(*over);
      for (const DropBvh& drops : index.drops(all))
        highest.take_from(drops, px, py, [&](const DropBvh::Found& f) { return index.holds(f, px, py); });
      return highest;
    };
    const HighestPatch found = tree(std::nullopt);
    if (!found.found()) continue;
    ++(guards(found.patch()) ? held : cuts);
    Envelope fresh(all, map, index, {0.01, 0.05});
    for (const double z : {found.hit().z - 1e-3, found.hit().z + 1e-3, found.hit().z + aside(random)}) {
      const bool over = fresh.rises_over(px, py, z);
      if (fresh.shut_by()) continue;  // the part reaches to the column's end
      EXPECT_EQ(over, tree(z).found()) << px << ", " << py << " over " << z;
    }
  }
  EXPECT_GT(held, 300u);
  EXPECT_GT(cuts, 3000u);
}

/// A wavy tube round the axis of a circle: what is beyond the axis is in no column, and is not asked.
TEST(DropBvhInACircle, EndsAtTheAxis) {
  for (const Sense sense : {Sense::kOutward, Sense::kInward}) {
    const AxisFrame frame = frame_of(AxisMode::kCircle, sense);
    const Deformation map(frame, 40.0);
    const CheckedMesh part = sheet(frame, {-2.8, 2.8, kPi - 0.5, kPi + 0.5, 60, 20}, [&](double u, double v) {
      return map.s() * (60.0 / -std::cos(v) - 3.0 + 2.0 * std::sin(7.0 * u + 9.0 * v));
    });
    ToolPiece ball;
    ball.corner = ball.outer = 1.0;
    const ClSurface surface(part.mesh, part.sides, {ball});
    const std::vector<DropBvh> trees = trees_of(surface);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> u(-2.6, 2.6), v(kPi - 0.45, kPi + 0.45);
    std::size_t hits = 0, far = 0, cost = 0;
    constexpr std::size_t kTried = 200;
    for (std::size_t i = 0; i < kTried; ++i) {
      // Each in its own statement: compilers differ in which argument of a call they evaluate first.
      const double along = u(random) * map.scale_x();
      const double round = v(random) * map.scale_y();
      Deformation::Angles angles;
      const AxisLine line = map.axis_line(along, round, angles);
      std::optional<double> expected;
      for (PatchId patch = 0; patch < surface.patch_count(); ++patch)
        if (ClHit hit; surface.top(patch, line, hit) && map.in_column(hit.z, angles, 0.0))
          expected = std::max(expected.value_or(hit.z), hit.z);
      HighestPatch highest(surface, map, angles, line);
      highest.take_from(trees.front(), 0.0, 0.0, [](const DropBvh::Found&) { return true; });
      cost += highest.cost();
      ASSERT_EQ(highest.found(), expected.has_value()) << "place " << i;
      if (!expected) continue;
      EXPECT_EQ(highest.hit().z, *expected) << "place " << i;
      ++hits, far += std::abs(*expected) > 60.0 ? 1 : 0;
    }
    EXPECT_GT(hits, kTried / 2);
    EXPECT_GT(far, kTried / 20);
    EXPECT_LT(cost, kTried * surface.features() / 40);
  }
}

/// The widened borders of a sliver meet far beyond its corners.
TEST(DropBvhOfASliver, ReachesAsFarAsItsContacts) {
  const ToolPiece ball = wide_pieces()[0];
  std::mt19937 random(13);
  std::uniform_real_distribution<double> any(-5.0, 5.0), share(0.0, 1.0);
  std::size_t contacts = 0, missed = 0;
  for (int i = 0; i < 300; ++i) {
    const Point<Part> a{any(random), any(random), any(random)}, c{any(random), any(random), any(random)};
    const Point<Part> b = lerp(a, c, share(random)) + Vec3{any(random), any(random), any(random)} * 2e-5;
    Mesh mesh;
    mesh.vertices = {a, b, c}, mesh.facets = {{0, 1, 2}}, mesh.source = {0};
    const ClSurface surface(mesh, Sides::kBoth, {ball});
    const std::vector<DropBvh> trees = trees_of(surface);
    const Vec3 n = surface.facet_normal(0) * (surface.facet_normal(0).z < 0.0 ? -1.0 : 1.0);
    for (const Point<Part>& from : mesh.vertices)
      for (const Point<Part>& to : mesh.vertices)
        for (double beyond = 1e-5; beyond < 1e3; beyond *= 1.5) {
          const AxisLine line{to + (to - from) * beyond + n * ball.corner, {0.0, 0.0, 1.0}};
          ClHit hit;
          if (from == to || !surface.top(0, line, hit)) continue;
          bool shown = false;
          trees.front().each(0.0, 0.0, line, {hit.z, hit.z},
                             [&](const DropBvh::Found& found) { shown = shown || found.patch == 0; });
          ++contacts, missed += shown ? 0 : 1;
        }
  }
  EXPECT_GT(contacts, 1000u);
  EXPECT_EQ(missed, 0u) << "of " << contacts;
}

INSTANTIATE_TEST_SUITE_P(Modes, DropBvhs,
                         testing::Values(frame_of(AxisMode::kFixed, Sense::kOutward),
                                         frame_of(AxisMode::kLine, Sense::kOutward),
                                         frame_of(AxisMode::kLine, Sense::kInward),
                                         frame_of(AxisMode::kPoint, Sense::kOutward),
                                         frame_of(AxisMode::kCircle, Sense::kInward)));

}  // namespace
}  // namespace tiltfeed
