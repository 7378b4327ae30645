// Ends of passes where a condition on their points begins or ends.

#include "pathgen/envelope/pass_trim.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pathgen/envelope/thinning.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

EnvelopePoint point_at(const Deformation& map, double x, PatchId patch) {
  EnvelopePoint p;
  p.centre = {x, 0.0, 5.0};
  p.flat = map.flatten(p.centre);
  p.axis = p.normal = {0.0, 0.0, 1.0};
  p.patch = patch;
  return p;
}

// Patches of shank and holder come after those of the cutting part. A move from one of theirs leaves what the
// cutting part touches, wherever it is cut.
TEST(PassTrim, AnEndOnAMoveFromTheHoldersPatchIsTheHolders) {
  const Deformation map(AxisFrame{}, 1.0);
  constexpr PatchId kCutter = 3, kHolder = 1000;
  for (const double border : {0.2, 0.8, 1.2, 1.8}) {
    const Pass pass{point_at(map, 0.0, kHolder), point_at(map, 1.0, kCutter), point_at(map, 2.0, kCutter)};
    const auto kept = keep_where(
        {pass}, map, [&](const EnvelopePoint& p) { return p.centre.x >= border; }, 0.0);
    ASSERT_EQ(kept.size(), 1u);
    EXPECT_NEAR(kept[0].front().centre.x, border, 1e-3);
    EXPECT_EQ(kept[0].front().patch, border < 1.0 ? kHolder : kCutter) << border;
    EXPECT_EQ(kept[0].back().patch, kCutter);
  }
}

// About a line in x: a move over the seam of y', whose ends state y' on either side of it, half a turn off.
// Each place of it is on the move, with the axis line that goes through it.
TEST(PassTrim, APlaceOnAMoveOverTheSeamIsOnItsOwnAxisLine) {
  AxisFrame frame;
  frame.mode = AxisMode::kLine, frame.t = {1, 0, 0}, frame.n = {0, 0, 1};
  const Deformation map(frame, 10.0);
  const auto at = [&](double angle) {
    EnvelopePoint p;
    p.axis = p.normal = {0.0, -std::sin(angle), std::cos(angle)};
    p.centre = Point<Part>{} + p.axis * 10.0;
    p.flat = map.flatten(p.centre);
    return p;
  };
  const EnvelopePoint a = at(kPi - 0.01), b = at(kPi + 0.01);
  ASSERT_GT(std::abs(a.flat.y - b.flat.y), map.period_y() / 2.0);
  const auto expect_own = [&](const EnvelopePoint& p) {
    EXPECT_LT(length(map.axis_line(p.flat.x, p.flat.y).axis - p.axis), 1e-6);
    EXPECT_NEAR(map.beside(p.flat, a.flat).y, p.flat.y, 1e-12) << "runs on from a";
  };
  for (const double share : {0.25, 0.5, 0.75}) expect_own(on_move(a, b, share, map));
  for (const double border : {-0.05, 0.05})
    for (const Pass& kept : keep_where(
             {{a, b}}, map, [&](const EnvelopePoint& p) { return p.centre.y >= border; }, 0.0))
      for (const EnvelopePoint& p : kept)
        EXPECT_LT(length(map.axis_line(p.flat.x, p.flat.y).axis - p.axis), 1e-6) << border;
}

}  // namespace
}  // namespace tiltfeed
