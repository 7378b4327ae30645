// Where a rapid ends on its way down, against exact distances of the ball from the part.
#include "pathgen/linking/approach.h"

#include <gtest/gtest.h>

#include <random>

#include "pathgen/envelope/envelope.h"
#include "sim/solid/distance.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kApproach = 1.5;

struct Mode {
  AxisMode mode;
  Sense sense;
};
const Mode kModes[] = {{AxisMode::kFixed, Sense::kOutward}, {AxisMode::kLine, Sense::kOutward},
                       {AxisMode::kLine, Sense::kInward},   {AxisMode::kPoint, Sense::kOutward},
                       {AxisMode::kPoint, Sense::kInward},  {AxisMode::kCircle, Sense::kOutward},
                       {AxisMode::kCircle, Sense::kInward}};

AxisFrame frame_of(Mode m) {
  return {m.mode, m.sense, {1, 2, 3}, {1, 0, 0}, {0, 0, 1}, m.mode == AxisMode::kCircle ? 90.0 : 0.0};
}

PlanOptions approach_options(const AxisFrame& axis) {
  PlanOptions o = options_with(axis);
  o.links.approach = kApproach;
  return o;
}

TEST(Approach, EndsWhereTheToolGrownByItTouches) {
  std::mt19937 random(7);
  for (const Mode m : kModes) {
    SCOPED_TRACE(static_cast<int>(m.mode) * 2 + static_cast<int>(m.sense));
    const AxisFrame axis = frame_of(m);
    const CheckedMesh part = slab(axis);
    const PlanOptions o = approach_options(axis);
    std::vector<std::string> warnings;
    const auto field = make_field(part, o, warnings);
    ASSERT_TRUE(field);
    const sim::PartDistance distances(part.mesh);
    Envelope envelope((*field)->surface, (*field)->deformation, (*field)->index, {});
    Approaches approaches(**field, kApproach, (*field)->deformation.s() * kGroundRadius + 20.0);
    const FlatBounds b = (*field)->bounds;
    std::uniform_real_distribution<double> x(b.min_x, b.max_x), y(b.min_y, b.max_y);
    const double r = o.cutter.radius() + kApproach;
    int beside = 0, over = 0;
    for (int i = 0; i < 3000; ++i) {
      const auto at = envelope.at(x(random), y(random));
      if (!at) continue;
      const double end = approaches.rapid_end(at->flat);
      ASSERT_GE(end, at->flat.z + kApproach);
      const auto room = [&](double z) {
        return distances.nearest(at->centre + at->axis * (z - at->flat.z), 2.0 * r).value;
      };
      for (double up : {0.0, 0.01, 0.1, 0.5, 1.0, 3.0}) ASSERT_GE(room(end + up), r - 1e-4) << i << " " << up;
      if (end == at->flat.z + kApproach) continue;
      ASSERT_NEAR(room(end), r, 1e-4) << i;  // no longer than it must be
      ++(end > at->flat.z + 1.1 * kApproach ? beside : over);
    }
    EXPECT_GT(beside, 300);
    EXPECT_GT(over, 30);
  }
}

TEST(Approach, NoRapidComesDownThroughALayerAsThick) {
  for (const Mode m : kModes) {
    SCOPED_TRACE(static_cast<int>(m.mode) * 2 + static_cast<int>(m.sense));
    const AxisFrame axis = frame_of(m);
    const CheckedMesh part = slab(axis);
    const PlanOptions o = approach_options(axis);
    const auto planned = plan(part, o, nullptr);
    ASSERT_TRUE(planned) << planned.error().message;
    const sim::PartDistance distances(part.mesh);
    const double r = o.cutter.radius();
    const std::vector<Move>& moves = planned->path.moves;
    double nearest = 1e9;
    int ways = 0;
    for (std::size_t i = 1; i + 1 < moves.size(); ++i) {
      if (moves[i].kind != MoveKind::kRapid || moves[i + 1].kind != MoveKind::kPlunge) continue;
      ++ways;
      for (double share = 0.0; share <= 1.0; share += 0.05) {
        const Point<Part> tip = lerp(moves[i - 1].pose.tip, moves[i].pose.tip, share);
        nearest = std::min(nearest, distances.nearest(tip + moves[i].pose.axis * r, 50.0).value);
      }
    }
    EXPECT_GT(ways, 3);
    EXPECT_GE(nearest, r + kApproach - 1e-3);
  }
}

}  // namespace
}  // namespace tiltfeed
