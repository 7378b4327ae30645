// The directions chosen along a pass against every direction there is, asked one by one.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pathgen/free_axis/stations.h"
#include "pathgen/free_slices/cl_slices.h"
#include "tests/shapes/soup.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kTolerance = 0.01;
/// (O3) A break costs a radian over this length, mm.
constexpr double kBreak = 40.0;

struct Costs {
  const Stations& row;
  double departure(std::size_t i, Vec3 axis) const {
    const double angle = angle_between(axis, row.stations()[i].wished);
    return angle * angle * row.share(i);
  }
  /// From station i - 1 to i.
  double turn(std::size_t i, Vec3 before, Vec3 axis) const {
    const double way = row.stations()[i].way - row.stations()[i - 1].way;
    if (angle_between(before, axis) > row.max_turn() * way + 1e-9) return kBreak;
    return row.scale() * row.scale() * squared_length(axis - before) / way;
  }
};

/// The cheapest of all sequences through these axes.
std::vector<Vec3> cheapest(const Costs& costs, const std::vector<std::vector<Vec3>>& axes) {
  std::vector<double> before;
  std::vector<std::vector<std::size_t>> from(axes.size());
  for (std::size_t i = 0; i < axes.size(); ++i) {
    std::vector<double> here;
    for (const Vec3 axis : axes[i]) {
      double least = i > 0 ? std::numeric_limits<double>::infinity() : 0.0;
      std::size_t best = 0;
      for (std::size_t k = 0; i > 0 && k < axes[i - 1].size(); ++k)
        if (before[k] < least)
          if (const double cost = before[k] + costs.turn(i, axes[i - 1][k], axis); cost < least)
            least = cost, best = k;
      here.push_back(least + costs.departure(i, axis)), from[i].push_back(best);
    }
    before = std::move(here);
  }
  std::vector<Vec3> sequence(axes.size());
  auto at = static_cast<std::size_t>(std::min_element(before.begin(), before.end()) - before.begin());
  for (std::size_t i = axes.size(); i-- > 0; at = from[i][at]) sequence[i] = axes[i][at];
  return sequence;
}

double cost_of(const Costs& costs, const std::vector<Vec3>& sequence) {
  double sum = 0.0;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    sum += costs.departure(i, sequence[i]) + (i > 0 ? costs.turn(i, sequence[i - 1], sequence[i]) : 0.0);
  return sum;
}

double cost_of_chosen(const Costs& costs) {
  std::vector<Vec3> sequence;
  for (const Station& s : costs.row.stations()) sequence.push_back(s.chosen);
  return cost_of(costs, sequence);
}

double least_cost(const Costs& costs, const std::vector<std::vector<Vec3>>& axes) {
  return cost_of(costs, cheapest(costs, axes));
}

CheckedMesh large_ell() {
  soup::Soup soup = soup::ell();
  for (auto& f : soup)
    for (Point<Part>& p : f) p = {p.x * 4, p.y * 4, p.z * 4};
  return soup::check(soup);
}

/// `max_turn`: of the axis, per mm.
PlanOptions with_holder(Angle max_turn) {
  PlanOptions o;
  o.cutter = {.diameter = 4, .length = 90, .shank_length = 20, .holder = {{16, 24, 20}, {24, 24, 40}}};
  o.free.plane_normals = {{0, 0, 1}, {0, 1, 0}};
  o.free.smoothing = 2, o.free.max_turn = max_turn, o.free.lead = Angle::from_degrees(15);
  o.pattern.side_step = 16;
  return o;
}

/// Of the candidates that are admissible none makes a cheaper sequence than the one chosen. Neither do all
/// admissible directions of the coarser grid within the windows, with which the choice begins; and it is no
/// cheaper than the best of all directions of the finer grid.
TEST(FreeChoice, IsTheCheapestOfTheAdmissible) {
  const CheckedMesh part = large_ell();
  const PlanOptions o = with_holder(Angle::from_degrees(10));
  const FacetBvh tree(part.mesh);
  const SweptTool tool(tree, o, 0.4 * kTolerance);
  const DirectionGrid grid(Admissibility::kAdmissibleLevel + 1);
  const Admissibility admissible(tool, grid, {0, 0, 1}, Angle::from_degrees(120));
  const std::uint32_t coarse = DirectionGrid::count(Admissibility::kAdmissibleLevel);
  std::size_t passes = 0, refused = 0;
  for (const ClSlice& slice :
       slice_cl_surface(part, tree, o, ToleranceBudget(0.01), [](double) { return true; })) {
    DirectionQuery query;
    const PassCurve curve(slice.chain, o.free);
    Stations row(curve, admissible, o.free, query);
    row.choose();
    const std::vector<Station>& stations = row.stations();
    if (std::any_of(stations.begin(), stations.end(), [](const Station& s) { return s.candidates.empty(); }))
      continue;
    std::vector<std::vector<Vec3>> near(stations.size()), all(near), candidates(near);
    DirectionQuery own;
    for (std::size_t i = 0; i < stations.size(); ++i) {
      const Station& s = stations[i];
      EXPECT_TRUE(admissible.admits(s.point, s.chosen, own)) << i;
      for (const AxisCandidate& c : s.candidates)
        if (admissible.admits(s.point, c.axis, own)) candidates[i].push_back(c.axis);
      if (admissible.admits(s.point, s.wished, own))
        near[i].push_back(s.wished), all[i].push_back(s.wished);
      else
        ++refused;
      for (std::uint32_t d = 0; d < grid.directions().size(); ++d) {
        const Vec3 axis = grid.directions()[d];
        if (!admissible.admits(s.point, axis, own)) continue;
        all[i].push_back(axis);
        if (d < coarse && angle_between(axis, s.wished) < s.window - 1e-9) near[i].push_back(axis);
      }
    }
    const Costs costs{row};
    const double chosen = cost_of_chosen(costs);
    EXPECT_NEAR(chosen, least_cost(costs, candidates), 1e-9) << "slice at " << slice.height;
    EXPECT_LE(chosen, least_cost(costs, near) + 1e-9) << "slice at " << slice.height;
    EXPECT_GE(chosen, least_cost(costs, all) - 1e-9) << "slice at " << slice.height;
    ++passes;
  }
  EXPECT_GE(passes, 3u);
  EXPECT_GE(refused, 10u);
}

/// What is not looked at would hardly have helped, round bends that the axis cannot follow neither: the
/// choice is as cheap as that of all admissible directions of the coarser grid, and then of the finer one's
/// round it.
TEST(FreeChoice, LooksFarEnough) {
  constexpr double kAround = 0.17;  // rad, (O3)
  const CheckedMesh part = large_ell();
  std::size_t looked_at = 0, all = 0;
  for (const double degrees_per_mm : {10.0, 3.0}) {
    const PlanOptions o = with_holder(Angle::from_degrees(degrees_per_mm));
    const FacetBvh tree(part.mesh);
    const SweptTool tool(tree, o, 0.4 * kTolerance);
    const DirectionGrid grid(Admissibility::kAdmissibleLevel + 1);
    const Admissibility admissible(tool, grid, {0, 0, 1}, Angle::from_degrees(120));
    double chosen = 0.0, least = 0.0;
    for (const ClSlice& slice :
         slice_cl_surface(part, tree, o, ToleranceBudget(0.01), [](double) { return true; })) {
      DirectionQuery query, own;
      const PassCurve curve(slice.chain, o.free);
      Stations row(curve, admissible, o.free, query);
      row.choose();
      const std::vector<Station>& stations = row.stations();
      if (std::any_of(stations.begin(), stations.end(),
                      [](const Station& s) { return s.candidates.empty(); }))
        continue;
      std::vector<std::vector<Vec3>> coarse, fine;
      for (const Station& s : stations) {
        coarse.emplace_back(), fine.emplace_back();
        if (admissible.admits(s.point, s.wished, own))
          coarse.back().push_back(s.wished), fine.back().push_back(s.wished);
        for (std::uint32_t d = 0; d < DirectionGrid::count(Admissibility::kAdmissibleLevel); ++d) {
          const Vec3 axis = grid.directions()[d];
          if (!admissible.admits(s.point, axis, own)) continue;
          coarse.back().push_back(axis);
          looked_at += angle_between(axis, s.wished) < s.window ? 1u : 0u, ++all;
        }
      }
      const Costs costs{row};
      const std::vector<Vec3> best = cheapest(costs, coarse);
      for (std::size_t i = 0; i < stations.size(); ++i)
        for (const Vec3 axis : grid.directions())
          if (angle_between(axis, best[i]) < kAround && admissible.admits(stations[i].point, axis, own))
            fine[i].push_back(axis);
      chosen += cost_of_chosen(costs), least += least_cost(costs, fine);
    }
    EXPECT_GT(least, 10.0);
    EXPECT_LE(chosen, 1.01 * least) << degrees_per_mm << " degrees per mm";
  }
  EXPECT_LT(2 * looked_at, all);
}

}  // namespace
}  // namespace tiltfeed
