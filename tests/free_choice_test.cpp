// The directions chosen along a pass against every direction there is, asked one by one.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pathgen/cl_slices.h"
#include "pathgen/pass_stations.h"
#include "tests/soup.h"

namespace tiltfeed {
namespace {

constexpr double kTolerance = 0.01;
/// (O3) A break costs a radian over this length, mm.
constexpr double kBreak = 20.0;

struct Costs {
  const PassStations& row;
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

double cost_of_chosen(const Costs& costs) {
  const std::vector<Station>& s = costs.row.stations();
  double sum = 0.0;
  for (std::size_t i = 0; i < s.size(); ++i)
    sum += costs.departure(i, s[i].chosen) + (i > 0 ? costs.turn(i, s[i - 1].chosen, s[i].chosen) : 0.0);
  return sum;
}

/// Of all sequences through these axes.
double least_cost(const Costs& costs, const std::vector<std::vector<Vec3>>& axes) {
  std::vector<double> before;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    std::vector<double> here;
    for (const Vec3 axis : axes[i]) {
      double least = i > 0 ? std::numeric_limits<double>::infinity() : 0.0;
      for (std::size_t k = 0; i > 0 && k < axes[i - 1].size(); ++k)
        if (before[k] < least) least = std::min(least, before[k] + costs.turn(i, axes[i - 1][k], axis));
      here.push_back(least + costs.departure(i, axis));
    }
    before = std::move(here);
  }
  return *std::min_element(before.begin(), before.end());
}

/// Of the candidates that are admissible none makes a cheaper sequence than the one chosen. Neither do all
/// admissible directions of the coarser grid within the windows, with which the choice begins; and it is no
/// cheaper than the best of all directions of the finer grid.
TEST(FreeChoice, IsTheCheapestOfTheAdmissible) {
  soup::Soup soup = soup::ell();
  for (auto& f : soup)
    for (Point<Part>& p : f) p = {p.x * 4, p.y * 4, p.z * 4};
  const CheckedMesh part = soup::check(soup);
  PlanOptions o;
  o.cutter = {.diameter = 4, .length = 90, .shank_length = 20, .holder = {{16, 24, 20}, {24, 24, 40}}};
  o.free.plane_normals = {{0, 0, 1}, {0, 1, 0}};
  o.free.smoothing = 2, o.free.max_turn = Angle::from_degrees(10), o.free.lead = Angle::from_degrees(15);
  o.pattern.side_step = 16;
  const FacetTree tree(part.mesh);
  const SweptTool tool(tree, o, 0.4 * kTolerance);
  const DirectionGrid grid(Admissibility::kAdmissibleLevel + 1);
  const Admissibility admissible(tool, grid, {0, 0, 1}, Angle::from_degrees(120));
  const std::uint32_t coarse = DirectionGrid::count(Admissibility::kAdmissibleLevel);
  std::size_t passes = 0, refused = 0;
  for (const ClSlice& slice : slice_cl_surface(part, tree, o, 0.004, [](double) { return true; })) {
    DirectionQuery query;
    const PassCurve curve(slice.chain, o.free);
    PassStations row(curve, admissible, o.free, query);
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

}  // namespace
}  // namespace tiltfeed
