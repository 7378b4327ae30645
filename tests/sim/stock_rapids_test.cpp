// Rapids of a roughing program against the stock that is there: a groove through a plate, and rapids in it,
// over it and beside it.

#include "sim/proof/stock_rapids.h"

#include <gtest/gtest.h>

#include "tests/shapes/plate_program.h"
#include "tests/texts/folder.h"

namespace tiltfeed::sim {
namespace {

/// A depth in stock is that of the middle of what is met: half of the way from its surface to the tool's end.
constexpr double kMiddle = 0.5;

struct Roughing {
  Job job = make_job();
  CheckedMesh part = checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}}));
  Folder folder{"stock_rapids"};

  Roughing() {
    part.sides = pathgen::Sides::kOutward;
    job.plan.pattern.kind = PatternKind::kRough;
    job.plan.pattern.step_down = 1.0;
  }
  /// A groove 2 mm deep along x, then the lines.
  Result<std::optional<RapidInStock>> found(const std::string& lines, std::size_t number = 1) {
    const std::string program = folder.write("p.nc",
                                             "G21 G90 G94\n"
                                             "G0 X-12 Y0 Z10 A0 C0\n"
                                             "G1 X-12 Y0 Z-2 F1000\n"
                                             "G1 X12 Y0 Z-2\n" +
                                                 lines);
    job.operation.number = number;
    return find_rapid_in_stock(program, {job}, part, 2, [](double) { return true; });
  }
};

TEST(StockRapids, AreFoundWithLineAndDepth) {
  Roughing shop;
  const auto clear = shop.found("G0 X-12 Y0 Z-2\nG0 Z10\nG0 X0 Y3\nG0 Z0.05\nG0 Z10\n");
  ASSERT_TRUE(clear) << clear.error().message;
  EXPECT_FALSE(*clear) << (*clear)->worst.depth;
  // The ball's end comes 1.5 mm under the plate's top, beside the groove.
  const auto deep = shop.found("G0 X-12 Y0 Z-2\nG0 Z10\nG0 X0 Y3.9\nG0 Z-1.5\nG0 Z10\n");
  ASSERT_TRUE(deep) << deep.error().message;
  ASSERT_TRUE(*deep);
  EXPECT_EQ((*deep)->worst.line, 8u);
  EXPECT_NEAR((*deep)->worst.depth, kMiddle * 1.5, 0.05);
  EXPECT_EQ((*deep)->operation, 0u);
  // A rapid over the groove before it is cut would be in stock: the moves count in their order.
  const auto along = shop.found("G0 Z10\nG0 X-12 Y0\nG0 Z-2.3\nG0 X12\nG0 Z10\n");
  ASSERT_TRUE(along && *along);
  EXPECT_EQ((*along)->worst.line, 8u);
  EXPECT_NEAR((*along)->worst.depth, kMiddle * 0.3, 0.02);
}

TEST(StockRapids, BeginAtTheBlank) {
  Roughing shop;
  const std::string over = "G0 Z10\nG0 X0 Y0\nG0 Z1\nG0 X-8\nG0 Z10\n",
                    beside = "G0 Z10\nG0 X0 Y3.9\nG0 Z1\nG0 Z10\n";
  EXPECT_FALSE(*shop.found(beside));
  shop.job.blank = Blank{BlankShape::kBox, 3.0, "", 1.0};
  const auto found = shop.found(beside);
  ASSERT_TRUE(found && *found);
  EXPECT_NEAR((*found)->worst.depth, kMiddle * 2.0, 0.05);
  EXPECT_EQ((*found)->stock.margin, 3.0);
  EXPECT_FALSE(*shop.found(over));  // in the groove, which is cut from the blank
  // With a blank the first operation counts, whatever its pattern; else only what roughs.
  shop.job.plan.pattern.kind = PatternKind::kRaster;
  EXPECT_TRUE(*shop.found(beside));
  shop.job.blank.reset();
  EXPECT_FALSE(*shop.found("G0 Z10\nG0 X0 Y3.9\nG0 Z-1.5\nG0 Z10\n"));
}

TEST(StockRapids, NobodyKnowsTheStockOfALaterOperationAlone) {
  Roughing shop;
  const std::string deep = "G0 Z10\nG0 X0 Y3.9\nG0 Z-1.5\nG0 Z10\n";
  EXPECT_TRUE(*shop.found(deep));
  EXPECT_FALSE(*shop.found(deep, 2));
}

}  // namespace
}  // namespace tiltfeed::sim
