// The tool that the page draws against the simulator's own reading of it.

#include "desk/view/tool_outline.h"

#include <gtest/gtest.h>

#include <string_view>

#include "sim/solid/tool_solid.h"

namespace tiltfeed::desk {
namespace {

using namespace pathgen;

TEST(ToolOutline, HasTheRadiusOfTheSolidAtEveryHeight) {
  const std::vector<HolderStep> holder{{20.0, 30.0, 15.0}, {40.0, 40.0, 30.0}};
  const std::vector<Cutter> cutters{
      {6.0, 80.0, 40.0},
      {10.0, 90.0, 50.0, CutterType::kBullNose, 2.0, {}, 20.0, 8.0, holder},
      {8.0, 70.0, 30.0, CutterType::kFlat, 0.0, {}, 12.0},
      {2.0, 70.0, 35.0, CutterType::kTaperBall, 0.0, Angle::from_degrees(4.0), 18.0, 6.0, holder}};
  for (const Cutter& cutter : cutters) {
    const sim::ToolSolid solid(cutter, {}, 0.0);
    std::array<std::size_t, 3> seen{};
    for (const ToolOutline& piece : tool_outline(cutter)) {
      const std::size_t part = std::string_view(piece.part) == "cutter"  ? 0
                               : std::string_view(piece.part) == "shank" ? 1
                                                                         : 2;
      const auto& solids = solid.pieces(sim::kToolParts[part]);
      ASSERT_LT(seen[part], solids.size());
      const sim::Revolved& body = solids[seen[part]++];
      for (const auto& [r, h] : piece.points) {
        // A flat end is a step: a little above it.
        const double radius = std::max(body.radius_at(h + 1e-9), body.radius_at(h - 1e-9));
        EXPECT_NEAR(r, std::max(0.0, radius), 1e-3) << piece.part << " at " << h << " of " << cutter.diameter;
      }
    }
    for (std::size_t part = 0; part < 3; ++part)
      EXPECT_EQ(seen[part], solid.pieces(sim::kToolParts[part]).size()) << part;
  }
}

}  // namespace
}  // namespace tiltfeed::desk
