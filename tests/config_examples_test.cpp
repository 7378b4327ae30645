// The job and machine files that come with the program: every key is documented, every job fits the machine.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "config/job.h"
#include "tests/bad_text.h"

namespace tiltfeed {
namespace {

const std::string kExample = SOURCE_DIR "/config/jobs/example.yaml";
const std::string kMachine = SOURCE_DIR "/config/machines/generic-ac.yaml";

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

Job loaded(const std::string& name) {
  const Result<Job> job = load_job(SOURCE_DIR "/config/jobs/" + name + ".yaml");
  EXPECT_TRUE(job.has_value()) << job.error().message;
  return job.value_or(Job{});
}

/// The keys that the reader itself says it knows, asked with a key that it cannot know.
template <class Parse>
std::vector<std::string> known_keys(const std::string& text, const std::string& before, const Parse& parse) {
  const std::size_t at = text.find(before);
  EXPECT_NE(at, std::string::npos) << before;
  const std::size_t indent = before.find_first_not_of("\n {") - before.find_last_of("\n{") - 1;
  const std::string asking =
      before[0] == '{' ? "{zzzzzz: 1, " : "\n" + std::string(indent, ' ') + "zzzzzz: 1";
  const auto result = parse(text.substr(0, at) + asking + text.substr(before[0] == '{' ? at + 1 : at));
  EXPECT_FALSE(result.has_value());
  if (result) return {};
  const std::string& message = result.error().message;
  const std::size_t list = message.find("(known here: ");
  EXPECT_NE(list, std::string::npos) << message;
  if (list == std::string::npos) return {};
  std::string words = message.substr(list + 13);
  std::vector<std::string> keys;
  for (char& letter : words)
    if (letter == ',' || letter == ')') letter = ' ';
  std::istringstream in(words);
  for (std::string key; in >> key;) keys.push_back(key);
  return keys;
}

/// Key `key` stands at the start of a line, and that line or the one above has a comment.
bool documented(const std::string& text, const std::string& key) {
  std::istringstream in(text);
  std::string above;
  for (std::string line; std::getline(in, line); above = line) {
    const std::size_t start = line.find_first_not_of(' ');
    if (start == std::string::npos || line.compare(start, key.size() + 1, key + ":") != 0) continue;
    if (line.find('#') != std::string::npos || above.find('#') != std::string::npos) return true;
  }
  return false;
}

TEST(Examples, EveryKeyOfAJobIsInTheExampleWithAComment) {
  const std::string text = text_of(kExample);
  const auto parse = [](const std::string& changed) { return parse_job(changed, kExample); };
  ASSERT_TRUE(parse(text).has_value()) << parse(text).error().message;
  std::size_t count = 0;
  for (const char* before : {"\npart:", "\n  name:", "\n  type:", "\n  mode:", "\n  along:",
                             "\n  cut_mm_per_min:", "\n  part_zero_mm:"}) {
    for (const std::string& key : known_keys(text, before, parse)) {
      const bool opens_section = text.find("\n" + key + ":\n") != std::string::npos;
      EXPECT_TRUE(opens_section || documented(text, key)) << key;
      EXPECT_NE(text.find(key + ":"), std::string::npos) << key;
      ++count;
    }
  }
  EXPECT_EQ(count, 33u);  // 11 + 3 + 4 + 6 + 3 + 3 + 3
}

TEST(Examples, EveryKeyOfAMachineIsInTheProfileWithAComment) {
  const std::string text = text_of(kMachine);
  const auto parse = [](const std::string& changed) { return parse_machine(changed, kMachine); };
  std::size_t count = 0;
  for (const char* before :
       {"\nname:", "\n  x:", "\n    min_mm:", "\n  letter:", "\n  dialect:", "\n  default:"}) {
    for (const std::string& key : known_keys(text, before, parse)) {
      EXPECT_NE(text.find(key + ":"), std::string::npos) << key;
      ++count;
    }
  }
  EXPECT_EQ(count, 8u + 3 + 4 + 8 + 6 + 2);
  for (const char* key :
       {"letter", "direction", "sign", "zero_deg", "min_deg", "table_centre_mm", "pivot_to_gauge_mm",
        "dialect", "linear_decimals", "rotary_decimals", "max_line_length", "line_numbers",
        "max_inverse_time_per_min", "default", "receive_buffer_bytes"})
    EXPECT_TRUE(documented(text, key)) << key;
}

TEST(Examples, ProgramAndLinkStateTheDefaults) {
  // The profile says so: without both sections the resolved settings must be the same.
  const std::string text = text_of(kMachine);
  const std::string least = text.substr(0, text.find("\nprogram:") + 1);
  const Result<MachineProfile> full = parse_machine(text, kMachine),
                               defaults = parse_machine(least, kMachine);
  ASSERT_TRUE(full.has_value() && defaults.has_value());
  EXPECT_EQ(describe(*full), describe(*defaults));
}

TEST(Examples, TheMachineIsTheDocumentedOne) {
  const Result<MachineProfile> profile = load_machine(kMachine);
  ASSERT_TRUE(profile.has_value()) << profile.error().message;
  EXPECT_EQ(profile->model.tilt.letter, 'A');
  EXPECT_EQ(profile->model.tilt.direction, (Vec3{1, 0, 0}));
  EXPECT_EQ(profile->model.tilt.sign, +1);
  EXPECT_EQ(profile->model.tilt.min, -110.0);
  EXPECT_EQ(profile->model.tilt.max, 110.0);
  EXPECT_EQ(profile->model.rotary.sign, -1);  // (K3): phi = -C
  EXPECT_EQ(profile->model.rotary.max, 36000.0);
  EXPECT_EQ(profile->model.pivot_to_gauge, (Vec3{0, 0, -150}));
}

TEST(Examples, AllJobsLoad) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(SOURCE_DIR "/config/jobs"))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  EXPECT_GE(names.size(), 4u);
  for (const std::string& name : names) {
    const Job job = loaded(name);
    EXPECT_LE(std::abs(dot(job.plan.axis.t, job.plan.axis.n)), 1e-16) << name;
    EXPECT_NEAR(length(job.plan.axis.n), 1.0, 1e-15) << name;
    EXPECT_EQ(job.setup.tool_length, job.plan.cutter.length) << name;
  }
}

TEST(Examples, RoundedDirectionsOfTheJobs) {
  EXPECT_NEAR(length(loaded("pin").plan.axis.n - Vec3{std::sin(Angle::from_degrees(15).radians()), 0,
                                                      std::cos(Angle::from_degrees(15).radians())}),
              0.0, 1e-6);
  EXPECT_NEAR(length(loaded("sphere").plan.axis.n - Vec3{0, -1 / std::sqrt(3.0), std::sqrt(2.0 / 3.0)}), 0.0,
              1e-5);
}

/// A pose as the job's axis field has it, `rho` from the point, line or circle.
Pose pose_at(const AxisFrame& f, double theta, double phi, double along, double rho) {
  const double s = static_cast<int>(f.sense);
  const Vec3 b = cross(f.n, f.t) * s;
  Vec3 centre = from_origin(f.origin), out;
  if (f.mode == AxisMode::kLine) {
    centre = centre + f.t * along;
    out = f.n * std::cos(theta) + b * std::sin(theta);
  } else {
    const Vec3 round = f.n * std::cos(theta) + f.t * std::sin(theta);
    if (f.mode == AxisMode::kCircle) centre = centre + round * f.circle_radius;
    out = round * std::cos(phi) + b * std::sin(phi);
  }
  const Vec3 ball = centre + out * rho;
  return {{ball.x, ball.y, ball.z}, out * s};
}

/// One of the two head positions, with the table on some turn, is inside every travel.
void expect_reachable(const Job& job, const Pose& pose) {
  const auto both = inverse(job.machine.model, job.setup, pose, 0.0);
  ASSERT_TRUE(both.has_value()) << both.error().message;
  std::string broken;
  for (const Joints& joints : *both) {
    const auto limit = broken_limit(job.machine.model, joints);
    if (!limit) return;
    broken += *limit + "; ";
  }
  FAIL() << job.plan.name << ": " << broken;
}

TEST(Examples, ThePartsOfTheJobsLieWithinTheMachinesTravel) {
  constexpr double kDegree = kPi / 180.0;
  const Job tyre = loaded("tyre"), pin = loaded("pin"), sphere = loaded("sphere");
  for (double theta = -20; theta <= 20; theta += 5)
    for (double phi = -55; phi <= 55; phi += 5)
      for (const double rho : {70.0, 90.0})  // clearance surface, tread ground
        expect_reachable(tyre, pose_at(tyre.plan.axis, theta * kDegree, phi * kDegree, 0, rho));
  for (double theta = -180; theta < 180; theta += 15)
    for (const double along : {-2.0, 31.0, 64.0})
      for (const double rho : {10.0, 30.0}) {
        const Pose pose = pose_at(pin.plan.axis, theta * kDegree, 0, along, rho);
        EXPECT_NEAR((pin.setup.fixture * pose.axis).z, 0.0, 1e-15);  // the pin stands upright
        expect_reachable(pin, pose);
      }
  for (double theta = -180; theta < 180; theta += 15)
    for (double phi = -90; phi <= 90; phi += 15) {
      const Pose pose = pose_at(sphere.plan.axis, theta * kDegree, phi * kDegree, 0, 60);
      if (pose.axis.z > std::cos(109 * kDegree)) expect_reachable(sphere, pose);
    }
}

}  // namespace
}  // namespace tiltfeed
