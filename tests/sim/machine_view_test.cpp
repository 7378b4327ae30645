// What draws a machine: its axes followed here against the planner's own forward kinematics, its solids by
// their numbers.

#include "sim/collision/machine_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/shapes/collision_shop.h"

namespace tiltfeed::sim {
namespace {

using nlohmann::json;

struct Seen {
  json head;
  std::vector<float> corners;
};

Seen read(const std::string& bytes) {
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data(), sizeof length);
  Seen seen;
  EXPECT_EQ(length % 4, 0u);
  seen.head = json::parse(bytes.substr(sizeof length, length));
  seen.corners.resize((bytes.size() - sizeof length - length) / sizeof(float));
  std::memcpy(seen.corners.data(), bytes.data() + sizeof length + length,
              seen.corners.size() * sizeof(float));
  return seen;
}

Vec3 vector(const json& numbers) { return {numbers[0], numbers[1], numbers[2]}; }

/// The point turned about a line, by Rodrigues' formula.
Vec3 turned(Vec3 p, Vec3 on_line, Vec3 n, double degrees) {
  const double t = degrees * kPi / 180.0;
  const Vec3 v = p - on_line;
  return on_line + v * std::cos(t) + cross(n, v) * std::sin(t) + n * (dot(n, v) * (1.0 - std::cos(t)));
}

/// A point of the last link, as the part sees it: the page does the same.
Vec3 on_part(const json& head, Vec3 p, const std::array<double, 5>& words) {
  for (std::size_t k = head["joints"].size(); k-- > 0;) {
    const json& joint = head["joints"][k];
    const double by = joint["factor"].get<double>() * (words.at(joint["axis"]) - joint["home"].get<double>());
    const Vec3 along = vector(joint["direction"]);
    p = joint["turns"].get<bool>() ? turned(p, vector(joint["point"]), along, by) : p + along * by;
  }
  const Vec3 off = p - vector(head["part"]["shift"]);
  const json& columns = head["part"]["columns"];
  return {dot(vector(columns[0]), off), dot(vector(columns[1]), off), dot(vector(columns[2]), off)};
}

TEST(MachineView, follows_the_axes_of_every_structure) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-200.0, 200.0), turn(-80.0, 80.0);
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "linuxcnc-bridge-bc", "mill-4x-table-a",
                           "mill-4x-head-b", "dmu-nutating-bc", "vmc-bhead-bc", "mill-3x"}) {
    config::Job job = bare_job(name);
    job.setup.part_zero = {13, -8, 120};
    job.setup.fixture = rotation_about(normalized(Vec3{2, -1, 3}), 0.6);
    const auto view = machine_view(job);
    ASSERT_TRUE(view.has_value()) << view.error().message;
    const Seen seen = read(*view);
    for (int i = 0; i < 20; ++i) {
      Joints words{place(random), place(random), place(random), turn(random), turn(random)};
      if (!job.machine.model.tilt.present) words.a = 0.0;
      if (!job.machine.model.rotary.present) words.c = 0.0;
      const Vec3 tip =
          on_part(seen.head, vector(seen.head["tip"]), {words.x, words.y, words.z, words.a, words.c});
      EXPECT_LT(length(tip - from_origin(forward(job.machine.model, job.setup, words).tip)), 1e-9) << name;
    }
  }
}

TEST(MachineView, has_every_body_and_fixture_where_its_settings_put_it) {
  config::Job job = bare_job("generic-ac");
  job.machine = *config::load_machine(SOURCE_DIR "/config/machines/generic-ac.yaml");
  ASSERT_FALSE(job.machine.solid.bodies.empty());
  config::Fixture vice;
  vice.name = "vice", vice.colour = "#4a6fa5", vice.shape.kind = config::SolidKind::kBox;
  vice.shape.size = {40, 120, 60}, vice.shape.at = {10, 20, -200};
  job.fixtures.push_back(vice);
  const auto view = machine_view(job);
  ASSERT_TRUE(view.has_value());
  const Seen seen = read(*view);
  const json& bodies = seen.head["bodies"];
  ASSERT_EQ(bodies.size(), job.machine.solid.bodies.size() + 1);
  std::size_t facets = 0;
  for (const json& body : bodies) facets += body["facets"].get<std::size_t>();
  EXPECT_EQ(seen.corners.size(), 9 * facets);
  EXPECT_EQ(bodies.back()["name"], "vice");
  EXPECT_EQ(bodies.back()["colour"], "#4a6fa5");
  EXPECT_TRUE(bodies.back()["fixture"].get<bool>());
  EXPECT_EQ(bodies.back()["link"], 0);
  ASSERT_EQ(bodies.back()["facets"], 12);
  std::array<float, 3> low{1e9F, 1e9F, 1e9F}, high{-1e9F, -1e9F, -1e9F};
  for (std::size_t i = seen.corners.size() - 12 * 9; i < seen.corners.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], seen.corners[i]);
    high[i % 3] = std::max(high[i % 3], seen.corners[i]);
  }
  EXPECT_EQ(low, (std::array<float, 3>{-10, -40, -200}));
  EXPECT_EQ(high, (std::array<float, 3>{30, 80, -140}));
}

TEST(MachineView, names_the_fixture_whose_file_is_not_there) {
  config::Job job = bare_job("generic-ac");
  config::Fixture vice;
  vice.name = "vice", vice.shape.kind = config::SolidKind::kStl, vice.shape.stl = "/nowhere/vice.stl";
  job.fixtures.push_back(vice);
  const auto view = machine_view(job);
  ASSERT_FALSE(view.has_value());
  EXPECT_NE(view.error().message.find("fixture vice"), std::string::npos) << view.error().message;
}

}  // namespace
}  // namespace tiltfeed::sim
