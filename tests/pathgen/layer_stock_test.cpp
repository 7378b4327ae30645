// Rapids of roughing against stock that is cut column by column as the moves go.

#include "pathgen/plan/layer_stock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "kinematics/basics/units.h"
#include "pathgen/plan/plan.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kTop = 20.0, kApproach = 1.0, kStepDown = 4.0;

constexpr double kHalf = 28.0;

/// A cone of 28 mm at its foot and 5 mm at its top, 20 mm high: its stock is a box, with corners where there
/// is nothing of the part.
CheckedMesh cone() {
  constexpr std::uint32_t kSides = 64;
  CheckedMesh part;
  std::vector<Point<Part>>& at = part.mesh.vertices;
  for (const auto& [r, z] : {std::pair{kHalf, 0.0}, {5.0, kTop}})
    for (std::uint32_t i = 0; i < kSides; ++i)
      at.push_back({r * std::cos(2.0 * kPi * i / kSides), r * std::sin(2.0 * kPi * i / kSides), z});
  at.push_back({0, 0, 0}), at.push_back({0, 0, kTop});
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const std::uint32_t next = (i + 1) % kSides;
    for (const std::array<std::uint32_t, 3>& facet : {std::array{i, next, kSides + next},
                                                      {i, kSides + next, kSides + i},
                                                      {2 * kSides, next, i},
                                                      {2 * kSides + 1, kSides + i, kSides + next}})
      part.mesh.facets.push_back(facet);
  }
  for (std::uint32_t f = 0; f < part.mesh.facets.size(); ++f) part.mesh.source.push_back(f);
  part.bounds = {{-kHalf, -kHalf, 0}, {kHalf, kHalf, kTop}};
  return part;
}

/// Heights of the stock over a grid: at first those of the part's box, `beyond` larger to the sides.
class Columns {
 public:
  explicit Columns(double beyond) {
    const double half = kHalf + beyond;
    for (double x = -half; x <= half; x += kGrid) lines_.push_back(x);
    columns_.assign(lines_.size() * lines_.size(), kTop);
  }

  /// The ball of radius r at the end of the tool goes there; how deep it was in the stock, mm.
  double cut(Point<Part> tip, double r) {
    double deepest = 0.0;
    const auto near = [&](double at) {
      return std::pair(std::lower_bound(lines_.begin(), lines_.end(), at - r) - lines_.begin(),
                       std::upper_bound(lines_.begin(), lines_.end(), at + r) - lines_.begin());
    };
    const auto [x0, x1] = near(tip.x);
    const auto [y0, y1] = near(tip.y);
    for (auto ix = x0; ix < x1; ++ix)
      for (auto iy = y0; iy < y1; ++iy) {
        const double dx = lines_[ix] - tip.x, dy = lines_[iy] - tip.y;
        const double square = r * r - dx * dx - dy * dy;
        if (square < 0.0) continue;
        const double height = tip.z + r - std::sqrt(square);
        double& column = columns_[ix * lines_.size() + iy];
        deepest = std::max(deepest, column - height);
        column = std::min(column, height);
      }
    return deepest;
  }

 private:
  static constexpr double kGrid = 0.5;
  std::vector<double> lines_;    ///< x, and y, of the columns
  std::vector<double> columns_;  ///< their upper ends, by x, then y
};

struct Cut {
  double rapid = 0.0, plunge = 0.0;  ///< how deep in the stock, mm, at most
  double rapid_way_down = 0.0, plunge_way = 0.0;
};

Cut cut(const std::vector<Move>& moves, double radius, double beyond) {
  Columns stock(beyond);
  Cut all;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const Point<Part> a = moves[i - 1].pose.tip, b = moves[i].pose.tip;
    const double steps = std::max(1.0, std::ceil(distance(a, b) / 0.25));
    const bool high = std::min(a.z, b.z) > kTop;
    for (double k = 1; k <= steps && !high; ++k) {
      const double deep = stock.cut(lerp(a, b, k / steps), radius);
      if (moves[i].kind == MoveKind::kRapid) all.rapid = std::max(all.rapid, deep);
      if (moves[i].kind == MoveKind::kPlunge) all.plunge = std::max(all.plunge, deep);
    }
    if (moves[i].kind == MoveKind::kRapid) all.rapid_way_down += std::max(0.0, a.z - b.z);
    if (moves[i].kind == MoveKind::kPlunge) all.plunge_way += distance(a, b);
  }
  return all;
}

PlanOptions roughing() {
  PlanOptions o;
  o.cutter.type = CutterType::kBall, o.cutter.diameter = 8.0;
  o.cutter.cutting_length = o.cutter.shank_length = 60.0, o.cutter.length = 80.0;
  o.pattern.kind = PatternKind::kRough;
  o.pattern.side_step = 2.0, o.pattern.step_down = kStepDown;
  o.tolerance = 0.02, o.allowance = 0.3;
  o.links.clearance = 5.0, o.links.approach = kApproach;
  o.cut_feed = Feed::from_mm_per_min(2000.0), o.plunge_feed = Feed::from_mm_per_min(400.0);
  return o;
}

// (U7)
TEST(LayerStock, NoRapidIsInStockThatTheLayersAboveLeave) {
  const CheckedMesh part = cone();
  const PlanOptions o = roughing();
  const Result<Plan> planned = plan(part, o, {});
  ASSERT_TRUE(planned) << planned.error().message;
  const Cut found = cut(planned->path.moves, o.cutter.radius(), 0.0);
  EXPECT_LT(found.rapid, 0.05);
  EXPECT_GT(found.plunge, 0.2) << "nothing to come down into";
}

TEST(LayerStock, AContainmentSaysThatThereIsStockBesideThePart) {
  const CheckedMesh part = cone();
  PlanOptions o = roughing();
  o.containment.first = o.containment.second = {-33.0, 33.0};
  const Result<Plan> planned = plan(part, o, {});
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_LT(cut(planned->path.moves, o.cutter.radius(), 5.0).rapid, 0.05);
}

TEST(LayerStock, BesideThePartARapidGoesDownAsFarAsTheApproachLets) {
  const CheckedMesh part = cone();
  const PlanOptions o = roughing();
  const Deformation map(o.axis, 1.0);
  const std::vector<double> floors{20.0, 16.0, 12.0};
  const LayerStock stock(part.bounds, o, map, floors, 40.0);
  const double radius = o.cutter.radius() + o.allowance;
  EXPECT_EQ(stock.free_from({0, 0, 12.0}, 13.0), 17.0);
  EXPECT_EQ(stock.free_from({0, 0, 14.0}, 15.0), 17.0) << "on its way up the part";
  EXPECT_EQ(stock.free_from({0, 0, 16.0}, 17.0), 21.0);
  EXPECT_EQ(stock.free_from({0, 0, 20.0}, 21.0), 21.0) << "nothing above the stock's top";
  EXPECT_EQ(stock.free_from({0, 0, 16.0}, 23.0), 23.0) << "the part asks for more";
  EXPECT_EQ(stock.free_from({kHalf + radius, 0, 3.0}, 4.0), 4.0);
  EXPECT_EQ(stock.free_from({kHalf + radius - 0.1, 0, 3.0}, 4.0), 13.0);
  EXPECT_EQ(LayerStock(part.bounds, o, map, {}, 40.0).free_from({0, 0, 3.0}, 4.0), 4.0);
}

}  // namespace
}  // namespace tiltfeed
