// Admissible directions against the judge's solids, the choice of a sequence against trying them all.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "pathgen/free_axis/admissible.h"
#include "pathgen/free_axis/direction_choice.h"
#include "pathgen/free_slices/cl_slices.h"
#include "pathgen/mesh/mesh_check.h"
#include "sim/parts/parts.h"
#include "sim/solid/tool_solid.h"
#include "tests/shapes/soup.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

using soup::operator+;

constexpr double kSlack = 0.01;

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return normalized({normal(random), normal(random), normal(random)});
}

CheckedMesh sphere() {
  Stl stl;
  stl.facets = sim::hollow_sphere();
  return *check_mesh(stl);
}

/// The tool so long that it reaches out of the part: then it is clear where it stands if and only if it can
/// be drawn back.
void expect_judged_alike(const CheckedMesh& part, const Cutter& cutter, double step, int least_clear) {
  PlanOptions o;
  o.cutter = cutter;
  o.free.plane_normals = {{0, 0, 1}};
  o.pattern.side_step = step;
  const FacetBvh tree(part.mesh);
  const SweptTool tool(tree, o, kSlack);
  const sim::PartDistance surface(part.mesh);
  const sim::ToolSolid solid(cutter);
  std::mt19937 random(3);
  int clear = 0, stopped = 0;
  std::uint32_t hint = kNoFacet;
  for (const ClSlice& s :
       slice_cl_surface(part, tree, o, ToleranceBudget(0.01), [](double) { return true; })) {
    for (std::size_t i = 0; i < s.chain.points.size(); i += 7) {
      const ClPoint& p = s.chain.points[i];
      Vec3 axis = random_direction(random);
      if (dot(axis, p.normal) < 0.0) axis = -axis;
      const Pose pose{p.centre - axis * cutter.radius(), axis};
      double cutting = solid.clearance(surface, pose, sim::ToolPart::kCutter).value + kSlack, rest = 1e9;
      for (const sim::ToolPart other : {sim::ToolPart::kShank, sim::ToolPart::kHolder})
        if (solid.has(other)) rest = std::min(rest, solid.clearance(surface, pose, other).value);
      const double least = std::min(cutting, rest);
      if (std::abs(least) < 1e-3)
        continue;  // the taper's slack is along its radius, the judge's along the normal
      const bool stops = tool.stop(p.centre, axis, hint).has_value();
      EXPECT_EQ(stops, least < 0.0) << "least " << least << " at " << p.centre.x << ", " << p.centre.y << ", "
                                    << p.centre.z << " axis " << axis.x << ", " << axis.y << ", " << axis.z;
      ++(stops ? stopped : clear);
    }
  }
  EXPECT_GE(clear, least_clear);
  EXPECT_GE(stopped, least_clear);
}

TEST(FreeDirections, ABallMillIsStoppedWhereTheJudgeSaysSo) {
  expect_judged_alike(sphere(), {.diameter = 10, .length = 600, .shank_length = 500}, 6, 100);
}
TEST(FreeDirections, ATaperIsStoppedWhereTheJudgeSaysSo) {
  expect_judged_alike(sphere(),
                      {.diameter = 6,
                       .length = 600,
                       .shank_length = 500,
                       .type = CutterType::kTaperBall,
                       .taper = Angle::from_degrees(4),
                       .cutting_length = 120},
                      8, 100);
}
TEST(FreeDirections, AHolderIsStoppedWhereTheJudgeSaysSo) {
  expect_judged_alike(sphere(),
                      {.diameter = 8,
                       .length = 600,
                       .shank_length = 40,
                       .cutting_length = 20,
                       .shank_diameter = 6,
                       .holder = {{14, 30, 40}, {30, 30, 500}}},
                      8, 50);
}

TEST(FreeDirections, TheGridIsEvenAndNested) {
  std::mt19937 random(5);
  for (int level = 0; level <= 4; ++level) {
    const DirectionGrid grid(level);
    ASSERT_EQ(grid.directions().size(), DirectionGrid::count(level));
    double furthest = 0.0;
    for (int i = 0; i < 300; ++i) {
      const Vec3 v = random_direction(random);
      double best = 10.0;
      for (const Vec3 d : grid.directions()) best = std::min(best, angle_between(v, d));
      furthest = std::max(furthest, best);
    }
    EXPECT_LE(furthest, DirectionGrid::coverage(level)) << level;
    for (const Vec3 d : grid.directions()) EXPECT_NEAR(length(d), 1.0, 1e-15);
    const std::vector<Vec3> finer = DirectionGrid(level + 1).directions();
    EXPECT_TRUE(std::equal(grid.directions().begin(), grid.directions().end(), finer.begin()));
  }
}

/// How many of the grid's directions are admissible.
std::size_t directions(const Admissibility& admissible, const ClPoint& point, DirectionQuery& query) {
  std::size_t found = 0;
  for (std::uint32_t i = 0; i < admissible.grid().directions().size(); ++i)
    found += admissible.admits(point, i, query) ? 1 : 0;
  return found;
}

TEST(FreeDirections, TheReasonIsTheFirstPartOfTheToolWithoutARoom) {
  // A shaft 10 wide and 30 deep.
  soup::Soup shaft = soup::cube(0, 40);
  shaft.erase(shaft.begin() + 2, shaft.begin() + 4);  // the top
  soup::Soup hole = soup::reversed(soup::box({15, 15, 10}, {25, 25, 40}));
  hole.erase(hole.begin() + 2, hole.begin() + 4);
  const auto at = [](double x, double y) { return Point<Part>{x, y, 40}; };
  const Point<Part> o[4] = {at(0, 0), at(40, 0), at(40, 40), at(0, 40)},
                    i[4] = {at(15, 15), at(25, 15), at(25, 25), at(15, 25)};
  for (int k = 0; k < 4; ++k) soup::add_quad(shaft, o[k], o[(k + 1) % 4], i[(k + 1) % 4], i[k]);
  const CheckedMesh part = soup::check(shaft + hole);
  ASSERT_EQ(part.sides, Sides::kOutward);
  const FacetBvh tree(part.mesh);
  const DirectionGrid grid(4);
  DirectionQuery query;
  const ClPoint bottom{{20, 20, 13}, {0, 0, 1}, 0};
  const auto why = [&](const Cutter& cutter, double tilt) {
    PlanOptions options;
    options.cutter = cutter;
    const SweptTool tool(tree, options, kSlack);
    const Admissibility admissible(tool, grid, {1, 0, 0}, Angle::from_degrees(tilt));
    return std::pair(directions(admissible, bottom, query), admissible.why_none(bottom, query));
  };
  EXPECT_GT(why({.diameter = 6, .length = 90, .shank_length = 60}, 180).first, 0u);
  EXPECT_EQ(why({.diameter = 6, .length = 90, .shank_length = 60}, 30),
            std::pair(std::size_t{0}, RestReason::kTilt));
  EXPECT_EQ(
      why({.diameter = 6, .length = 90, .shank_length = 60, .cutting_length = 10, .shank_diameter = 12}, 180),
      std::pair(std::size_t{0}, RestReason::kShank));
  EXPECT_EQ(why({.diameter = 6, .length = 90, .shank_length = 12, .holder = {{20, 20, 40}}}, 180),
            std::pair(std::size_t{0}, RestReason::kHolder));
  const CheckedMesh shut = soup::check(soup::cube(0, 40) + soup::reversed(soup::cube(10, 30)));
  const FacetBvh shut_tree(shut.mesh);
  PlanOptions options;
  options.cutter = {.diameter = 6, .length = 90, .shank_length = 60};
  const SweptTool tool(shut_tree, options, kSlack);
  const Admissibility admissible(tool, grid, {0, 0, 1}, Angle::from_degrees(180));
  DirectionQuery shut_query;  // a hint belongs to one part
  EXPECT_EQ(directions(admissible, bottom, shut_query), 0u);
  EXPECT_EQ(admissible.why_none(bottom, shut_query), RestReason::kCutter);
}

/// The least distance of a segment from a triangle, by places of the segment this far apart at most.
double distance_from(Point<Part> from, Point<Part> to, const Corners& triangle) {
  constexpr int kSteps = 200;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i) {
    const Point<Part> p = lerp(from, to, static_cast<double>(i) / kSteps);
    least = std::min(least, distance(p, nearest_point(p, triangle)));
  }
  return least;
}

/// Has a place of the triangle, of very many, the line within `reach`, at a height from 0 to `length`?
bool in_cylinder(Point<Part> from, Vec3 along, double length, double reach, const Corners& triangle) {
  constexpr int kSteps = 40;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j) {
      const Point<Part> p = triangle[0] + (triangle[1] - triangle[0]) * (static_cast<double>(i) / kSteps) +
                            (triangle[2] - triangle[0]) * (static_cast<double>(j) / kSteps);
      const double height = dot(p - from, along);
      if (height >= 0.0 && height <= length && distance(p, from + along * height) < reach) return true;
    }
  return false;
}

TEST(FreeDirections, TheTreeMissesNoFacetNearASegmentInACylinderOrInABox) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> at(-50.0, 50.0), small(-6.0, 6.0), reach_of(0.01, 15.0);
  soup::Soup soup;
  const auto place = [&](double far) { return Point<Part>{far + at(random), at(random), at(random)}; };
  constexpr double kFar = 1000.0;  // from the part's zero
  for (int i = 0; i < 400; ++i) {
    const Point<Part> a = place(kFar);
    const double sliver = i % 4 == 0 ? 10.0 : 1.0;
    soup.push_back({a, a + Vec3{sliver * small(random), small(random), small(random)},
                    a + Vec3{small(random) / sliver, small(random), small(random)}});
  }
  const CheckedMesh part = soup::check(soup);
  const FacetBvh tree(part.mesh);
  std::size_t near = 0, inside = 0, visited = 0;
  for (int i = 0; i < 300; ++i) {
    const Point<Part> from = place(kFar);
    Point<Part> to = place(kFar);
    if (i % 3 == 0) to = from + Vec3{0, 0, small(random)};  // level, and short
    const double reach = reach_of(random), length = distance(from, to);
    const Vec3 direction = (to - from) / length;
    std::vector<std::uint8_t> along(part.mesh.facets.size()), around(along), in(along);
    const auto mark = [](std::vector<std::uint8_t>& seen) {
      return [&seen](std::uint32_t f, const PlacedFacet&) { return seen[f] = 1, false; };
    };
    tree.any_along(from, direction, 0.0, length, reach, mark(along));
    tree.any_in_cylinder(from, direction, 0.0, length, reach, mark(around));
    const Vec3 pad{reach, reach, reach};
    tree.each_in({from - pad, from + pad}, [&](std::uint32_t f, const PlacedFacet&) { in[f] = 1; });
    for (std::uint32_t f = 0; f < part.mesh.facets.size(); ++f) {
      const Corners& c = tree.facet(f).corners;
      if (distance_from(from, to, c) < reach) {
        ++near;
        EXPECT_EQ(along[f], 1) << i << " facet " << f;
      }
      if (in_cylinder(from, direction, length, reach, c)) {
        ++inside;
        EXPECT_EQ(around[f], 1) << i << " facet " << f;
      }
      visited += around[f];
      if (distance(from, nearest_point(from, c)) < reach) {
        EXPECT_EQ(in[f], 1) << i << " facet " << f;
      }
    }
  }
  EXPECT_GT(near, 1000u);
  EXPECT_GT(inside, 1000u);
  EXPECT_LT(visited, 2 * inside);  // and visits few others
}

/// What a sequence costs.
double cost(const std::vector<AxisCandidates>& stations, const std::vector<double>& ways,
            const TurnPrices& prices, const std::vector<std::uint32_t>& chosen) {
  double sum = 0.0;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    sum += stations[i][chosen[i]].cost;
    if (i == 0) continue;
    const double turn = angle_between(stations[i - 1][chosen[i - 1]].axis, stations[i][chosen[i]].axis);
    sum += turn > prices.max_turn * ways[i - 1] + prices.spare
               ? prices.jump
               : prices.turn * 2.0 * (1.0 - std::cos(turn)) / ways[i - 1];
  }
  return sum;
}

TEST(FreeDirections, TheSequenceIsTheCheapestOfAll) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int round = 0; round < 200; ++round) {
    std::vector<AxisCandidates> stations(5);
    std::vector<double> ways;
    for (auto& s : stations) {
      const int count = 1 + static_cast<int>(uniform(random) * 4);
      for (int k = 0; k < count; ++k) s.push_back({random_direction(random), uniform(random)});
      std::sort(s.begin(), s.end(), [](const auto& a, const auto& b) { return a.axis.z < b.axis.z; });
    }
    for (int i = 0; i < 4; ++i) ways.push_back(0.2 + uniform(random));
    // A jump is dearer than any turn that is allowed, as on a pass.
    const TurnPrices prices{1.0, 1.5, 0.1, 20.0};
    double best = std::numeric_limits<double>::infinity();
    std::vector<std::uint32_t> tried(5, 0);
    for (;;) {
      best = std::min(best, cost(stations, ways, prices, tried));
      std::size_t i = 0;
      while (i < 5 && ++tried[i] == stations[i].size()) tried[i++] = 0;
      if (i == 5) break;
    }
    std::vector<const AxisCandidates*> lists;
    for (const AxisCandidates& list : stations) lists.push_back(&list);
    CheapestSequence search(lists, ways, prices, nullptr);
    EXPECT_NEAR(cost(stations, ways, prices, search.find()), best, 1e-12);
  }
}

TEST(FreeDirections, NeighboursOnTheGridFindTheSameSequence) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const DirectionGrid grid(Admissibility::kAdmissibleLevel + 1);
  const DirectionNeighbours near(grid, Admissibility::kAdmissibleLevel, 0.6);
  const std::uint32_t coarse = DirectionGrid::count(Admissibility::kAdmissibleLevel);
  for (int round = 0; round < 20; ++round) {
    std::vector<AxisCandidates> stations(6);
    std::vector<double> ways;
    for (auto& s : stations) {
      const Vec3 about = random_direction(random);
      for (std::uint32_t d = 0; d < coarse; ++d)
        if (dot(grid.directions()[d], about) > 0.0 && uniform(random) < 0.5)
          s.push_back({grid.directions()[d], uniform(random), d, false});
      for (int k = 0; k < 3; ++k) s.push_back({random_direction(random), uniform(random)});
      std::stable_sort(s.begin(), s.end(), [](const auto& a, const auto& b) { return a.axis.z < b.axis.z; });
      ways.push_back(0.2 + 0.3 * uniform(random));
    }
    ways.pop_back();
    const TurnPrices prices{1.0, 1.0, 1e-9, 20.0};
    std::vector<const AxisCandidates*> lists;
    for (const AxisCandidates& list : stations) lists.push_back(&list);
    CheapestSequence plain(lists, ways, prices, nullptr), quick(lists, ways, prices, &near);
    EXPECT_NEAR(cost(stations, ways, prices, quick.find()), cost(stations, ways, prices, plain.find()),
                1e-12);
    // Asked again after a list has lost what was chosen.
    const std::size_t changed = 3;
    stations[changed].erase(stations[changed].begin() + quick.find()[changed]);
    EXPECT_NEAR(cost(stations, ways, prices, quick.find(changed)), cost(stations, ways, prices, plain.find()),
                1e-12);
  }
}

}  // namespace
}  // namespace tiltfeed
