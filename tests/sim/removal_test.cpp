// Material removal: a clean program passes, and each kind of damage to it is found, with its size and place.

#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
namespace {

TEST(Removal, CleanProgramPasses) {
  for (const double cell : {0.5, 0.1}) {
    Shop shop;
    const auto [removal, verdict] = shop.run(cell);
    EXPECT_TRUE(verdict.passed()) << verdict.failures[0];
    EXPECT_TRUE(removal.troubles.empty());
    EXPECT_LE(verdict.gouge, 0.005);
    EXPECT_GT(removal.touched, 0u);
    // Between rows 0.4 apart a ball of radius 2 leaves ridges of 0.01 mm.
    EXPECT_NEAR(removal.excess[3], 0.0025, 0.004);
    EXPECT_GT(removal.excess[1], -0.005);
    EXPECT_LT(removal.air_seconds, 0.15 * removal.feed_seconds);
  }
}

// (removal.h, property 4)
TEST(Removal, SameForAnyNumberOfThreads) {
  Shop shop;
  shop.run(0.25, 1);
  const std::string one = shop.json;
  shop.run(0.25, 5);
  EXPECT_EQ(one, shop.json);
}

// (removal.h, property 1; verdict.h, property 1)
TEST(Removal, GougeIsFoundAtACoarseResolution) {
  for (const double cell : {1.0, 0.1}) {
    Shop shop;
    const std::size_t bad = shop.cuts[100];
    shift(shop.lines[bad], 'Z', -0.02);
    const auto [removal, verdict] = shop.run(cell);
    EXPECT_FALSE(verdict.passed());
    const Trouble* gouge = first_of(removal, TroubleKind::kGouge);
    ASSERT_NE(gouge, nullptr);
    EXPECT_NEAR(gouge->depth, 0.02, 0.002);
    EXPECT_NEAR(gouge->line, Shop::number(bad), 1);
    EXPECT_TRUE(gouge->facet == 1002 || gouge->facet == 1003);  // of the top
    EXPECT_NEAR(verdict.gouge, gouge->depth, 1e-12);
    EXPECT_EQ(removal.gouge.line, gouge->line);
    EXPECT_EQ(removal.gouge.facet, gouge->facet);
  }
}

// (removal.h, property 1)
TEST(Removal, TheDeepestGougeIsLocatedWithinTheTolerance) {
  for (const int threads : {1, 3}) {
    Shop shop;
    const std::size_t bad = shop.cuts[100];
    shift(shop.lines[bad], 'Z', -0.008);
    const auto [removal, verdict] = shop.run(0.5, threads);
    EXPECT_TRUE(verdict.passed());
    EXPECT_TRUE(removal.troubles.empty());
    EXPECT_NEAR(removal.gouge.depth, 0.008, 0.0015);
    EXPECT_EQ(removal.gouge.depth, verdict.gouge);
    EXPECT_NEAR(removal.gouge.line, Shop::number(bad), 1);
    EXPECT_EQ(removal.gouge.block + 1, removal.gouge.line);
    EXPECT_TRUE(removal.gouge.facet == 1002 || removal.gouge.facet == 1003);
    EXPECT_LT(distance(removal.gouge.place, shop.poses[bad - 1].tip), 0.3);
    EXPECT_NE(shop.json.find("\"deepest_gouge\""), std::string::npos);
    EXPECT_NE(shop.json.find("\"verdict\": \"passed\""), std::string::npos);
  }
}

// (verdict.h, properties 1 and 3)
TEST(Removal, DeletedBlockIsFound) {
  Shop shop;
  // Behind the plate stands a wall that the tool is led over at the end.
  shop.part = checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}, {Vec3{-8, 6, -6}, Vec3{8, 8, 4}}}));
  const Vec3 up = normalized({0.2, -0.5, 1.0});
  shop.move("G0", {Point<Part>{6, 20, 0} + up * 10.0, up});
  shop.lines.insert(shop.lines.begin(),
                    "(TILTFEED blocks " + std::to_string(shop.lines.size() - 1) + " time 1 s)");
  EXPECT_TRUE(shop.run(0.5).verdict.passed());
  // Without the last retract the tool runs into the wall; the header's count tells any deleted block.
  shop.lines.erase(shop.lines.end() - 2);
  const auto [removal, verdict] = shop.run(0.5);
  ASSERT_FALSE(verdict.failures.empty());
  EXPECT_NE(verdict.failures.back().find("header states"), std::string::npos);
  const Trouble* hit = first_of(removal, TroubleKind::kRapidPart);
  ASSERT_NE(hit, nullptr);
  EXPECT_EQ(hit->line, shop.lines.size());
}

// (verdict.h, property 2)
TEST(Removal, DeletedBlockThatCutsNothingWrongIsLocatedByItsTime) {
  // On a plane the tool passes straight over the place of a missing block: only the time of the next one
  // tells.
  Shop shop;
  const double feed = shop.time_by_tip();
  shop.job.plan.cut_feed = shop.job.plan.plunge_feed = Feed::from_mm_per_min(feed);
  EXPECT_TRUE(shop.run(0.5).verdict.passed());
  const std::size_t bad = shop.cuts[100];
  shop.lines.erase(shop.lines.begin() + static_cast<std::ptrdiff_t>(bad));
  const auto [removal, verdict] = shop.run(0.5);
  ASSERT_EQ(verdict.failures.size(), 1u);
  EXPECT_EQ(verdict.failures[0].find("feed: "), 0u) << verdict.failures[0];
  EXPECT_EQ(removal.haste.moves, 1u);
  EXPECT_EQ(removal.haste_line, Shop::number(bad));
  EXPECT_NEAR(removal.haste.feed, 2.0 * feed, 0.05 * feed);
  EXPECT_TRUE(removal.troubles.empty());
}

TEST(Removal, WrongSignOfTheTiltIsFound) {
  Shop shop;
  const std::size_t bad = shop.cuts[200];
  const std::size_t at = shop.lines[bad].find('A') + 1;
  shop.lines[bad].insert(at, "-");
  const auto [removal, verdict] = shop.run(0.5);
  EXPECT_FALSE(verdict.passed());
  ASSERT_FALSE(removal.troubles.empty());
  bool located = false;
  for (const Trouble& t : removal.troubles)
    located |= t.line + 1 >= Shop::number(bad) && t.line <= Shop::number(bad) + 1;
  EXPECT_TRUE(located);
}

// (verdict.h, properties 1 and 4)
TEST(Removal, WrongToolLengthIsFound) {
  for (const double longer : {0.5, -0.5}) {
    Shop shop;
    // The control does not know: what is longer reaches further down from the same place of the head.
    shop.job.machine.model.pivot_to_gauge.z -= longer;
    for (std::string& line : shop.lines)
      if (line.find('Z') != std::string::npos) shift(line, 'Z', -longer);
    const auto [removal, verdict] = shop.run(0.5);
    ASSERT_FALSE(verdict.passed()) << longer;
    const Trouble* gouge = first_of(removal, TroubleKind::kGouge);
    if (longer < 0.0) {  // all is left, nowhere in particular
      EXPECT_EQ(gouge, nullptr);
      EXPECT_NE(verdict.failures[0].find("is left"), std::string::npos) << verdict.failures[0];
      EXPECT_GT(removal.excess[3], 0.35);
      continue;
    }
    ASSERT_NE(gouge, nullptr);
    // Along the tool's axis, which leans by about half a radian.
    EXPECT_NEAR(gouge->depth, 0.5 * std::cos(0.48), 0.03);
    EXPECT_TRUE(gouge->facet == 1002 || gouge->facet == 1003);
    // Every row is wrong from its first cut to its last.
    EXPECT_LE(gouge->last_move - gouge->first_move, shop.lines.size());
    EXPECT_GE(gouge->line, Shop::number(shop.cuts.front()) - 1);
    EXPECT_LE(gouge->line, Shop::number(shop.cuts.back()));
  }
}

// (verdict.h, property 1)
TEST(Removal, RapidThroughThePartIsFound) {
  Shop shop;
  const std::size_t bad = shop.cuts[50];
  shift(shop.lines[bad], 'Z', -3.0);
  shop.lines[bad].replace(0, 2, "G0");
  const auto [removal, verdict] = shop.run(0.5);
  EXPECT_FALSE(verdict.passed());
  const Trouble* hit = first_of(removal, TroubleKind::kRapidPart);
  ASSERT_NE(hit, nullptr);
  EXPECT_EQ(hit->line, Shop::number(bad));
  EXPECT_GT(hit->depth, 1.0);
}

// (verdict.h, property 1)
TEST(Removal, HolderHitIsFound) {
  Shop shop;
  shop.job.plan.cutter.shank_length = 15.0;
  shop.job.plan.cutter.cutting_length = 8.0;
  shop.job.plan.cutter.holder = {{20.0, 24.0, 20.0}};
  EXPECT_TRUE(shop.run(0.5).verdict.passed());
  // A post of stock beside the plate, as high as the holder is low.
  shop.part = checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}, {Vec3{-8, -14, -6}, Vec3{8, -11, 16}}}));
  const auto [removal, verdict] = shop.run(0.5);
  EXPECT_FALSE(verdict.passed());
  const Trouble* in_part = first_of(removal, TroubleKind::kGouge);
  ASSERT_NE(in_part, nullptr);
  EXPECT_EQ(in_part->tool, ToolPart::kHolder);
  // The tool leans towards the post: its first rows are the nearest.
  EXPECT_GE(in_part->line, Shop::number(shop.cuts.front()) - 2);
  EXPECT_LE(in_part->line, Shop::number(shop.cuts[100]));
  EXPECT_GE(in_part->facet, 1000u + 12u);
  EXPECT_EQ(in_part->block + 1, in_part->line);
  const Trouble* in_stock = first_of(removal, TroubleKind::kStockHit);
  ASSERT_NE(in_stock, nullptr);
  EXPECT_EQ(in_stock->tool, ToolPart::kHolder);
}

}  // namespace
}  // namespace tiltfeed::sim
