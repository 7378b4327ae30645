// Rows round the table's axis: the tool axis at every place stays as it is, and along a row the tilt stands.

#include "daemon/plan/shortest_time.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pathgen/axis/deformation.h"

namespace tiltfeed::daemon {
namespace {

struct FrameDice {
  std::mt19937 random;
  double operator()(double low, double high) { return std::uniform_real_distribution(low, high)(random); }
  Vec3 direction() {
    for (;;) {
      const Vec3 v{(*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)};
      if (length(v) > 0.1 && length(v) < 1.0) return normalized(v);
    }
  }
};

pathgen::PlanOptions through_point(FrameDice& dice, pathgen::Sense sense) {
  pathgen::PlanOptions plan;
  plan.axis.mode = pathgen::AxisMode::kPoint, plan.axis.sense = sense;
  plan.axis.origin = {dice(-9, 9), dice(-9, 9), dice(-9, 9)};
  plan.axis.t = dice.direction();
  plan.axis.n = normalized(cross(plan.axis.t, dice.direction()));
  plan.up = dice.direction();
  return plan;
}

TEST(RoundTable, TheToolAxisStaysAndTheTiltStandsAlongRows) {
  FrameDice dice{std::mt19937(7)};
  for (int run = 0; run < 500; ++run)
    for (const auto sense : {pathgen::Sense::kOutward, pathgen::Sense::kInward}) {
      const pathgen::PlanOptions plan = through_point(dice, sense);
      const auto frame = round_table(plan);
      ASSERT_TRUE(frame);
      EXPECT_NEAR(length(frame->t), 1.0, 1e-14);
      EXPECT_NEAR(length(frame->n), 1.0, 1e-14);
      EXPECT_NEAR(dot(frame->t, frame->n), 0.0, 1e-14);
      const double radius = dice(1, 20), row = dice(-1.4, 1.4) * radius;
      const pathgen::Deformation own(plan.axis, radius), now(*frame, radius);
      std::vector<double> tilts;
      for (const double turn : {-3.0, -1.0, 0.5, 2.5}) {
        const Point<Part> place =
            now.unflatten({turn * radius, row, sense == pathgen::Sense::kOutward ? 5.0 : -5.0});
        EXPECT_NEAR(length(own.axis_at(place) - now.axis_at(place)), 0.0, 1e-12);
        tilts.push_back(angle_between(now.axis_at(place), plan.up));
      }
      for (const double tilt : tilts) EXPECT_NEAR(tilt, tilts.front(), 1e-7);
      // Along the job's own rows it does not.
      const Vec3 b = cross(plan.axis.n, plan.axis.t);
      if (length(cross(b, plan.up)) < 0.3) continue;
      const double of_own = angle_between(own.axis_line(0.0, 0.0).axis, plan.up),
                   further = angle_between(own.axis_line(radius, 0.0).axis, plan.up),
                   on = angle_between(own.axis_line(2.0 * radius, 0.0).axis, plan.up);
      EXPECT_GT(std::abs(further - of_own) + std::abs(on - of_own), 1e-3);
    }
}

TEST(RoundTable, NothingWhereRowsGoRoundItOrTheJobSaysWhere) {
  FrameDice dice{std::mt19937(8)};
  const pathgen::PlanOptions plan = through_point(dice, pathgen::Sense::kOutward);
  pathgen::PlanOptions other = plan;
  other.axis = *round_table(plan);
  EXPECT_FALSE(round_table(other)) << "it goes round already";
  other = plan, other.axis.mode = pathgen::AxisMode::kLine;
  EXPECT_FALSE(round_table(other));
  other = plan, other.containment.first.low = 0.0;
  EXPECT_FALSE(round_table(other));
  other = plan, other.containment.second.high = 1.0;
  EXPECT_FALSE(round_table(other));
  other = plan, other.containment.boundary = {{0, 0}, {1, 0}, {0, 1}};
  EXPECT_FALSE(round_table(other));
  other = plan, other.containment.height.high = 10.0;
  EXPECT_TRUE(round_table(other)) << "heights are from the point, whatever the frame";
}

}  // namespace
}  // namespace tiltfeed::daemon
