// Jobs whose plan fails: the message names the cause, its figures and the key, on boxes where all is known.
#include "pathgen/plan/likely_cause.h"

#include <gtest/gtest.h>

#include "pathgen/plan/plan.h"
#include "tests/shapes/cut_passes.h"
#include "tests/shapes/soup.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

using soup::operator+;

AxisFrame frame(AxisMode mode, Sense sense, Point<Part> origin) {
  return {mode, sense, origin, {1, 0, 0}, {0, 0, 1}, mode == AxisMode::kCircle ? 60.0 : 0.0};
}

std::string refusal(const CheckedMesh& part, const PlanOptions& options) {
  const auto planned = plan(part, options, {});
  EXPECT_FALSE(planned);
  return planned ? "" : planned.error().message;
}

testing::AssertionResult has(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words)
    if (text.find(word) == std::string::npos) return testing::AssertionFailure() << word << " in: " << text;
  return testing::AssertionSuccess();
}

CheckedMesh hollow_cube() { return soup::check(soup::cube(0, 40) + soup::reversed(soup::cube(10, 30))); }

/// All of a solid cube faces outward, from its middle as from a line through it, but for the line's ends.
TEST(Causes, InsideWorkOnASolidNamesTheSense) {
  const CheckedMesh cube = soup::check(soup::cube(0, 40));
  EXPECT_TRUE(has(refusal(cube, options_with(frame(AxisMode::kPoint, Sense::kInward, {20, 20, 20}))),
                  {"axis point lies in the material", "100 % of the part's area",
                   "0 % one that points inward", "use axis.sense: outward"}));
  EXPECT_TRUE(has(refusal(cube, options_with(frame(AxisMode::kLine, Sense::kInward, {20, 20, 20}))),
                  {"axis line lies in the material at 24 of 24 places", "66.7 % of the part's area",
                   "use axis.sense: outward"}));
}

/// The cavity's walls are 10 mm from its middle.
TEST(Causes, ACutterTooBigForTheHollowIsNamedWithTheRoom) {
  PlanOptions o = options_with(frame(AxisMode::kPoint, Sense::kInward, {20, 20, 20}));
  o.cutter = {30.0, 100.0, 30.0};
  o.allowance = 0.5;
  EXPECT_TRUE(has(refusal(hollow_cube(), o), {"cutter is too big", "radius of 15.5 mm", "at most 10 mm",
                                              "cutter.diameter_mm below 19", "axis point"}));
}

/// A bar under the point: a tool that points outward would come from below.
TEST(Causes, WhereOnlyTheOtherSenseIsWithinTheTiltItIsNamed) {
  const CheckedMesh bar = soup::check(soup::box({-10, -10, -40}, {10, 10, -30}));
  PlanOptions o = options_with(frame(AxisMode::kPoint, Sense::kOutward, {0, 0, 0}));
  o.tilt_max = Angle::from_degrees(60.0);
  EXPECT_TRUE(has(refusal(bar, o), {"axis.sense looks wrong", "0 % of the part's area", "25 % one that",
                                    "use axis.sense: inward", "setup.tilt_max_deg"}));
}

/// A slot of 3 to 4 mm in a plate that stands off the axis feature, and work in the slot only: outside work,
/// in every mode. The message names a cutter that serves.
TEST(Causes, ACutterTooBigForEverySlotIsNamedInOutsideWork) {
  for (const AxisMode mode : {AxisMode::kFixed, AxisMode::kLine, AxisMode::kCircle}) {
    SCOPED_TRACE(static_cast<int>(mode));
    const AxisFrame axis = frame(mode, Sense::kOutward, {1, 2, 3});
    const double turn = mode == AxisMode::kFixed ? 1.0 : 50.0, u = mode == AxisMode::kCircle ? 100.0 : 1.0;
    // u in mm or, round the circle of 60 mm, in rad at about 100 mm.
    const CheckedMesh part = sheet(axis, {-10 / u, 10 / u, -10 / turn, 10 / turn, 40, 20},
                                   [&](double x, double) { return std::abs(x * u) < 1.6 ? 35.0 : 40.0; });
    PlanOptions o = options_with(axis);
    o.cutter = {10.0, 100.0, 60.0};
    o.containment.first = {-6 / u, 6 / u}, o.containment.second = {-6 / turn, 6 / turn};
    o.containment.height = {0.0, 43.0};
    const std::string said = refusal(part, o);
    EXPECT_TRUE(has(said, {"the cutter is too big for every hollow", "radius of 5 mm", "at none of",
                           "use a cutter.diameter_mm below ", "It showed first so: "}));
    const std::string words = "cutter.diameter_mm below ";
    const double diameter = std::strtod(said.c_str() + said.find(words) + words.size(), nullptr);
    EXPECT_GT(diameter, 2.8);
    EXPECT_LT(diameter, 4.2);
    o.cutter.diameter = diameter - 0.1;
    const auto served = plan(part, o, {});
    EXPECT_TRUE(served) << served.error().message;
    EXPECT_EQ(likely_cause(part, o), "");
  }
}

/// A line that leaves the material half way along the part: told only where a plan fails.
TEST(Causes, ALineThroughTheSurfaceIsNamedInOutsideWork) {
  const CheckedMesh part =
      soup::check(soup::box({-40, -10, -10}, {0, 10, 10}) + soup::box({10, -10, -40}, {50, 10, -20}));
  PlanOptions o = options_with(frame(AxisMode::kLine, Sense::kOutward, {0, 0, 0}));
  const std::string cause = likely_cause(part, o);
  EXPECT_TRUE(has(cause, {"axis line runs through the part's surface", "of 24 places along the part",
                          "move axis.origin_mm"}));
  const CheckedMesh bar = soup::check(soup::box({-40, -10, -10}, {50, 10, 10}));
  EXPECT_EQ(likely_cause(bar, o), "") << "all of it inside";
  o.axis.origin = {0, 0, -25};
  EXPECT_EQ(likely_cause(bar, o), "") << "all of it below";
}

/// The line runs in a bar and then close under it: what leaves 0.1 mm round the line is no hollow.
TEST(Causes, InsideWorkUnderABarNamesTheSense) {
  const CheckedMesh part =
      soup::check(soup::box({-40, -10, -10}, {-10, 10, 10}) + soup::box({-9.9, -10, 0.1}, {40, 10, 10}));
  PlanOptions o = options_with(frame(AxisMode::kLine, Sense::kInward, {0, 0, 0}));
  o.cutter = {6.0, 100.0, 60.0};
  EXPECT_TRUE(has(likely_cause(part, o), {"axis.sense looks wrong", "use axis.sense: outward"}));
}

/// A tube that ends in the material: the line runs on into it.
TEST(Causes, ALineThatEntersTheMaterialIsNamedInInsideWork) {
  const CheckedMesh part = soup::check(soup::box({-60, -30, -30}, {40, 30, 30}) +
                                       soup::reversed(soup::box({-50, -20, -20}, {20, 20, 20})));
  PlanOptions o = options_with(frame(AxisMode::kLine, Sense::kInward, {0, 0, 0}));
  o.cutter = {4.0, 100.0, 60.0};
  EXPECT_TRUE(has(likely_cause(part, o), {"axis line runs through the part's surface",
                                          "inside work wants all", "move axis.origin_mm"}));
}

/// From the one level, 12 mm from the point, a step goes past it. The surface ends 8 mm before it: there is
/// room for the clearance, and what is in the way is the wall behind the tool.
TEST(Causes, AStepDownWiderThanTheHollowIsNone) {
  PlanOptions o = options_with(frame(AxisMode::kPoint, Sense::kInward, {20, 20, 20}));
  o.cutter = {4.0, 100.0, 60.0};
  o.links.clearance = 2.0;
  o.pattern.kind = PatternKind::kZLevel;
  o.pattern.step_down = 14.0, o.pattern.side_step = 0.5;
  o.containment.height = {0.0, 12.0};
  EXPECT_TRUE(has(refusal(hollow_cube(), o), {"shank or holder would hit the part beyond the point"}));
}

/// What fails for another reason keeps its message.
TEST(Causes, NoCauseIsMadeUp) {
  PlanOptions o = options_with(frame(AxisMode::kPoint, Sense::kInward, {20, 20, 20}));
  o.cutter = {4.0, 100.0, 60.0};
  o.links.clearance = 9.0;
  EXPECT_EQ(refusal(hollow_cube(), o).find("clearance_mm of 9"), 0u);
  EXPECT_EQ(likely_cause(hollow_cube(), o), "");
  EXPECT_EQ(likely_cause(soup::check(soup::cube(0, 40)), options_with(AxisFrame{})), "");
}

}  // namespace
}  // namespace tiltfeed
