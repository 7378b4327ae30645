// The floor of a line's passes: how it is lowered where they are traced anew and lie lower.
#include "pathgen/envelope/pass_floor.h"

#include <gtest/gtest.h>

#include <limits>

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kLow = -std::numeric_limits<double>::infinity();
constexpr double kSlack = 0.01;
const FlatLine kLine{2.0, 5.0, 1.0, 0.0, 10.0};

/// Points at each whole mm from `from` to `to` of the line, all at one height.
Pass level(int from, int to, double z) {
  Pass pass;
  for (int run = from; run <= to; ++run) {
    pass.emplace_back();
    pass.back().flat = {kLine.x_at(run), kLine.y_at(run), z};
  }
  return pass;
}

TEST(PassFloor, GoesDownToWhatWasTracedAnewAndNoFurther) {
  const std::vector<Pass> whole{level(0, 10, 20.0)};
  PassFloor floor(whole, kLine, kSlack, kLow);
  EXPECT_EQ(floor.lowest(0.5, 9.5), 20.0 - kSlack);
  EXPECT_FALSE(floor.open_over(whole, kLine));
  const std::vector<Pass> anew{level(4, 6, 13.0)};
  EXPECT_TRUE(floor.open_over(anew, kLine));
  EXPECT_LE(floor.lowest(4.5, 5.5), 13.0);
  EXPECT_GE(floor.lowest(4.5, 5.5), 13.0 - 4.0 * kSlack);
  EXPECT_EQ(floor.lowest(0.5, 3.5), 20.0 - kSlack);
  EXPECT_EQ(floor.lowest(7.5, 9.5), 20.0 - kSlack);
  EXPECT_FALSE(floor.open_over(anew, kLine));
}

/// Of a floor that has a least height no more is asked than that.
TEST(PassFloor, IsNeverLowerThanTheLeast) {
  const std::vector<Pass> whole{level(0, 10, 20.0)}, anew{level(0, 10, 13.0)};
  PassFloor floor(whole, kLine, kSlack, 15.0);
  EXPECT_TRUE(floor.open_over(anew, kLine));
  EXPECT_EQ(floor.lowest(0.5, 9.5), 15.0);
  EXPECT_FALSE(floor.open_over(anew, kLine));
}

/// Each time what is traced lies a hair under the floor: half a metre down takes no more than some twenty
/// times.
TEST(PassFloor, IsLoweredAFewTimesOnly) {
  const std::vector<Pass> whole{level(0, 10, 0.0)};
  PassFloor floor(whole, kLine, kSlack, kLow);
  int times = 0;
  while (floor.lowest(0.5, 9.5) > -500.0 && times < 100) {
    const std::vector<Pass> anew{level(0, 10, floor.lowest(0.5, 9.5) - 1e-9)};
    ASSERT_TRUE(floor.open_over(anew, kLine));
    ++times;
  }
  EXPECT_LE(times, 20);
}

}  // namespace
}  // namespace tiltfeed
