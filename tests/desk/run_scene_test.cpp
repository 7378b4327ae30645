// What is drawn of a run of several operations: each has its tool, and the tip is where that tool ends.

#include "desk/api/run_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "desk/service/tool_place.h"

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

std::vector<config::Job> pin_operations() {
  auto jobs = config::load_operations(std::string(SOURCE_DIR) + "/config/jobs/pin_operations.yaml", {});
  EXPECT_TRUE(jobs.has_value()) << jobs.error().message;
  return jobs ? *jobs : std::vector<config::Job>{};
}

TEST(RunScene, tells_the_tool_of_each_operation_in_the_order_of_the_program) {
  const std::vector<config::Job> jobs = pin_operations();
  ASSERT_EQ(jobs.size(), 3u);
  RunScene scene("/nowhere/tiltfeed", "/nowhere/tiltfeed-desk", ::testing::TempDir() + "run_scene_test",
                 [] {});
  SceneInput input = scene_of(jobs, "", "");
  input.job = 7;
  scene.begin(std::move(input));
  const json told = json::parse(scene.describe());
  EXPECT_EQ(told["job"], 7);
  ASSERT_EQ(told["operations"].size(), 3u);
  EXPECT_EQ(told["tool"], told["operations"][0]["tool"]) << "the first begins";
  const double diameters[] = {4.0, 2.0, 2.0};
  for (std::size_t i = 0; i < 3; ++i) {
    const json& one = told["operations"][i];
    EXPECT_EQ(one["name"], jobs[i].operation.name);
    double widest = 0.0;
    const json& outline = one["tool"][0]["outline"];
    for (const json& point : outline) widest = std::max(widest, point[0].get<double>());
    EXPECT_NEAR(2.0 * widest, diameters[i], 1e-9) << one["name"];
  }
}

/// The control counts the tool's length where the head stands upright. Tilted by an angle about its pivot the
/// tip of a tool that is 10 mm shorter is off by the chord of that angle at 10 mm.
TEST(RunScene, the_tip_is_that_of_the_operations_tool) {
  const std::vector<config::Job> jobs = pin_operations();
  const Placing placing = placing_of_operations(jobs);
  const AxisPlaces axes{{"X", 0.0}, {"Y", 0.0}, {"Z", 0.0}, {"A", 30.0}, {"C", 0.0}};
  const auto tip = [&](const std::string& operation) {
    const auto pose = tool_place(axes, placing.machine, placing.of(operation));
    EXPECT_TRUE(pose.has_value());
    return pose->tip;
  };
  const Vec3 moved = tip("semi-finish") - tip("finish");
  EXPECT_NEAR(length(moved), 2.0 * 10.0 * std::sin(15.0 * std::acos(-1.0) / 180.0), 1e-9);
  EXPECT_EQ(length(tip("finish") - tip("middle once more")), 0.0);
  EXPECT_EQ(length(tip("") - tip("semi-finish")), 0.0) << "nobody has said which: the first";
}

}  // namespace
}  // namespace tiltfeed::desk
