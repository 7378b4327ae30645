#include "daemon/plan/path_drawing.h"

#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

namespace tiltfeed {
using namespace daemon;
namespace {

/// On three straight axes the tip is where the words are; a head about x leans the axis in the plane y z.
TEST(PathDrawing, states_pose_time_and_kind_of_each_block) {
  MachineModel machine;
  machine.tilt.direction = {1, 0, 0};
  machine.rotary.direction = {0, 0, 1};
  tiltfeed::Setup setup;
  setup.tool_length = 100.0;
  JointPath path;
  path.moves = {{{1, 2, 3, 0, 0}, 0.0, MoveKind::kRapid, 0},
                {{4, 5, 6, 0, 0}, 2.0, MoveKind::kPlunge, 1},
                {{4, 5, 7, 30, 0}, 3.0, MoveKind::kCut, 2},
                {{4, 5, 7, 0, 90}, 3.0, MoveKind::kCut, 3}};
  std::ostringstream out;
  write_path_drawing(path, {0.0, 2.5, 3.25, 4.0}, machine, setup, 0.0, out);
  const std::string bytes = out.str();
  ASSERT_EQ(bytes.size(), path.moves.size() * kDrawnNumbers * sizeof(float));
  std::vector<float> numbers(path.moves.size() * kDrawnNumbers);
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  const auto record = [&](std::size_t i) {
    return std::vector<float>(numbers.begin() + static_cast<std::ptrdiff_t>(i * kDrawnNumbers),
                              numbers.begin() + static_cast<std::ptrdiff_t>((i + 1) * kDrawnNumbers));
  };
  EXPECT_EQ(record(0), (std::vector<float>{1, 2, 3, 0, 0, 1, 0, 0, 0, 1, 2, 3, 0, 0}));
  EXPECT_EQ(record(1), (std::vector<float>{4, 5, 6, 0, 0, 1, 2.5, 1, 2.5, 4, 5, 6, 0, 0}));
  EXPECT_FLOAT_EQ(std::abs(record(2)[4]), 0.5f);
  EXPECT_FLOAT_EQ(record(2)[5], static_cast<float>(std::sqrt(3.0) / 2.0));
  EXPECT_FLOAT_EQ(record(2)[6], 5.75f);
  EXPECT_EQ(record(2)[7], 2.0f);
  // A quarter turn of the table carries (4, 5) to (5, -4) or back, seen from the part.
  EXPECT_FLOAT_EQ(std::abs(record(3)[0]), 5.0f);
  EXPECT_FLOAT_EQ(std::abs(record(3)[1]), 4.0f);
  EXPECT_FLOAT_EQ(record(3)[6], 9.75f);
  const std::vector<float> last = record(3), words(last.begin() + 8, last.end());
  EXPECT_EQ(words, (std::vector<float>{4, 4, 5, 7, 0, 90}));
}

}  // namespace
}  // namespace tiltfeed
