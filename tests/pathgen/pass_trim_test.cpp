// Ends of passes where a condition on their points begins or ends.

#include "pathgen/envelope/pass_trim.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace tiltfeed
