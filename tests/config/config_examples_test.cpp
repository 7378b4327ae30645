// The job and machine files that come with the program: every key is documented, every job fits the machine.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "config/job.h"
#include "tests/shapes/public_models.h"
#include "tests/texts/bad_text.h"
#include "tests/texts/example_job.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

const std::string kMachine = SOURCE_DIR "/config/machines/generic-ac.yaml";

Job loaded(const std::string& name) {
  const Result<Job> job = load_job(SOURCE_DIR "/config/jobs/" + name + ".yaml");
  EXPECT_TRUE(job.has_value()) << job.error().message;
  return job.value_or(Job{});
}

/// The keys in "(known here: a, b)" of a refusal.
std::vector<std::string> listed_keys(const std::string& message) {
  const std::size_t list = message.find("(known here: ");
  EXPECT_NE(list, std::string::npos) << message;
  if (list == std::string::npos) return {};
  std::string words = message.substr(list + 13);
  for (char& letter : words)
    if (letter == ',' || letter == ')') letter = ' ';
  std::istringstream in(words);
  return {std::istream_iterator<std::string>(in), {}};
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
  return listed_keys(result.error().message);
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
  const std::vector<Line> lines = example_lines();
  const Result<Job> job = parse_example(lines);
  ASSERT_TRUE(job.has_value()) << job.error().message;
  std::map<std::string, std::size_t> last_used;  // line of a section's last key
  std::set<std::string> explained;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].key.empty()) continue;
    if (lines[i].used) last_used[lines[i].section] = i;
    if (lines[i].explained) explained.insert(lines[i].section + "." + lines[i].key);
  }
  std::size_t count = 0;
  for (const auto& [section, last] : last_used) {
    std::vector<Line> asking = lines;  // with a key that the reader cannot know
    asking[last].text = std::string(lines[last].indent, ' ') + "zzzzzz: 1\n" + lines[last].text;
    const Result<Job> refused = parse_example(asking);
    ASSERT_FALSE(refused.has_value()) << section;
    for (const std::string& key : listed_keys(refused.error().message)) {
      EXPECT_TRUE(explained.contains(section + "." + key)) << section << "." << key;
      ++count;
    }
  }
  // root, part, cutter, its holder, axis, pattern, containment, stock, points, guards, two of them, links,
  // feeds, program, setup, fixtures
  EXPECT_EQ(count, 22u + 6 + 12 + 3 + 16 + 12 + 9 + 2 + 5 + 2 + 2 + 2 + 3 + 7 + 9 + 3 + 12);
}

/// The words that a key may have, as the reader says.
std::vector<std::string> words_of(std::vector<Line> lines, const std::string& section,
                                  const std::string& key) {
  for (Line& line : lines)
    if (line.section == section && line.key == key)
      line.text = std::string(line.indent, ' ') + key + ": zzzzzz";
  const Result<Job> refused = parse_example(lines);
  EXPECT_FALSE(refused.has_value());
  std::string message = refused.error().message;
  const std::size_t from = message.find("expected one of "), to = message.find(", found");
  EXPECT_TRUE(from != std::string::npos && to != std::string::npos) << message;
  message = message.substr(from + 16, to - from - 16);
  std::replace(message.begin(), message.end(), ',', ' ');
  std::istringstream in(message);
  return {std::istream_iterator<std::string>(in), {}};
}

/// The example says in [ ] which words of `chooser` go with a key: with those the job is accepted, and with
/// any key too many or too few of them it is refused, and the message names the key.
void expect_users_to_be_right(const std::string& section, const std::string& chooser,
                              const std::vector<std::string>& followers, std::size_t word_count) {
  const std::vector<Line> example = example_lines();
  const auto follows = [&](const Line& line) {
    return !line.users.empty() &&
           std::find(followers.begin(), followers.end(), line.section) != followers.end();
  };
  const std::vector<std::string> words = words_of(example, section, chooser);
  EXPECT_EQ(words.size(), word_count);
  for (const std::string& word : words) {
    SCOPED_TRACE(chooser + ": " + word);
    std::vector<Line> lines = example;
    const auto fits = [&](const Line& line) {
      return std::find(line.users.begin(), line.users.end(), word) != line.users.end();
    };
    for (Line& line : lines) {
      if (line.section == section && line.key == chooser)
        line.text = std::string(line.indent, ' ') + chooser + ": " + word;
      if (follows(line)) line.used = fits(line);
    }
    // What a free axis does not go with beside its own section and the containment.
    for (Line& line : lines)
      if (word == "free" &&
          ((line.section == "pattern" && (line.key == "along" || line.key == "angle_deg")) ||
           (line.section == "guards.holder" && line.key == "reaction")))
        line.used = false;
    const Result<Job> job = parse_example(lines);
    EXPECT_TRUE(job.has_value()) << job.error().message;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!follows(lines[i]) || fits(lines[i])) continue;
      std::vector<Line> too_many = lines;
      too_many[i].used = true;
      const Result<Job> refused = parse_example(too_many);
      ASSERT_FALSE(refused.has_value()) << lines[i].key;
      const std::string wanted = lines[i].section + "." + lines[i].key + ": not used ";
      EXPECT_NE(refused.error().message.find(wanted), std::string::npos) << refused.error().message;
    }
  }
}

TEST(Examples, SayWhichKindsOfPatternUseAKey) { expect_users_to_be_right("pattern", "kind", {"pattern"}, 7); }
TEST(Examples, SayWhichTypesOfCutterUseAKey) { expect_users_to_be_right("cutter", "type", {"cutter"}, 4); }
TEST(Examples, SayWhichModesOfTheAxisUseAKey) {
  expect_users_to_be_right("axis", "mode", {"axis", "containment"}, 6);
}

TEST(Examples, KeysInCommentsAreReadAsTheyStand) {
  std::vector<Line> lines = example_lines();
  for (Line& line : lines) {
    if (line.key == "scallop_mm") line.used = true;
    if (line.key == "measure") line.text = "  measure: scallop";
  }
  const Result<Job> job = parse_example(lines);
  ASSERT_TRUE(job.has_value()) << job.error().message;
  EXPECT_EQ(job->plan.pattern.scallop, 0.005);
}

TEST(Examples, EveryKeyOfAMachineIsInTheProfileWithAComment) {
  const std::string text = text_of(kMachine);
  const auto parse = [](const std::string& changed) { return parse_machine(changed, kMachine); };
  std::size_t count = 0;
  for (const char* before :
       {"\nname:", "\n  x:", "\n    min_mm:", "\n  letter:", "\n  look_ahead_blocks:", "\n  dialect:",
        "\n  default:", "\n    link: table", "\n  tool: [y", "\n  cutter_mm:"}) {
    for (const std::string& key : known_keys(text, before, parse)) {
      EXPECT_NE(text.find(key + ":"), std::string::npos) << key;
      ++count;
    }
  }
  EXPECT_EQ(count, 18u + 3 + 5 + 12 + 3 + 32 + 3 + 12 + 2 + 6);
  for (const char* key : {"structure",
                          "letter",
                          "direction",
                          "sign",
                          "zero_deg",
                          "word",
                          "continuous",
                          "min_deg",
                          "prefer",
                          "table_centre_mm",
                          "pivot_to_gauge_mm",
                          "spindle_direction",
                          "dialect",
                          "linear_decimals",
                          "rotary_decimals",
                          "units",
                          "max_line_length",
                          "line_numbers",
                          "line_number_step",
                          "line_end",
                          "percent",
                          "start",
                          "end",
                          "max_blocks",
                          "max_program_bytes",
                          "tcp",
                          "tilted_planes",
                          "feed_mode",
                          "feed_measure",
                          "max_inverse_time_per_min",
                          "max_feed_mm_per_min",
                          "path_control",
                          "retract",
                          "clamp_tilt",
                          "unclamp_tilt",
                          "clamp_rotary",
                          "unclamp_rotary",
                          "preselect_tools",
                          "through_coolant_on",
                          "through_coolant_off",
                          "default",
                          "receive_buffer_bytes",
                          "look_ahead_blocks",
                          "corner_time_ms",
                          "blend_rotary",
                          "check",
                          "work",
                          "tool",
                          "shape",
                          "cutter_mm",
                          "head_mm",
                          "rapid_factor",
                          "bytes_per_s"})
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

TEST(Examples, AllMachinesLoadAndStateWhereTheirFiguresComeFrom) {
  std::set<std::string> structures;
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SOURCE_DIR "/config/machines")) {
    SCOPED_TRACE(entry.path().string());
    const Result<MachineProfile> profile = load_machine(entry.path().string());
    ASSERT_TRUE(profile.has_value()) << profile.error().message;
    EXPECT_EQ(profile->model.name, entry.path().stem().string());
    const std::string text = text_of(entry.path().string());
    const std::string said = text.substr(0, text.find("\nname:"));
    EXPECT_TRUE(said.find("Source") != std::string::npos || said.find("made-up") != std::string::npos);
    const std::string described = describe(*profile);
    const std::size_t at = described.find("structure: ");
    structures.insert(described.substr(at, described.find('\n', at) - at));
    ++count;
  }
  EXPECT_GE(count, 6u);
  EXPECT_EQ(structures.size(), 3u);
}

TEST(Examples, AllJobsLoad) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(SOURCE_DIR "/config/jobs"))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  EXPECT_GE(names.size(), 5u);
  for (const std::string& name : names) {
    const auto jobs = load_operations(SOURCE_DIR "/config/jobs/" + name + ".yaml", {});
    ASSERT_TRUE(jobs) << jobs.error().message;
    for (const Job& job : *jobs) {
      EXPECT_LE(std::abs(dot(job.plan.axis.t, job.plan.axis.n)), 1e-16) << name;
      EXPECT_NEAR(length(job.plan.axis.n), 1.0, 1e-15) << name;
      EXPECT_EQ(job.setup.tool_length, job.plan.cutter.length) << name;
    }
  }
}

TEST(Examples, EveryPlannedPublicModelHasAJobOfItsPlacement) {
  std::size_t count = 0;
  for (const models::Model& model : models::all()) {
    if (model.refused || !model.file.starts_with("public/")) continue;
    const std::string name = model.file.substr(7);
    SCOPED_TRACE(name);
    const Result<Job> job = load_job(SOURCE_DIR "/tests/jobs/" + name + ".yaml");
    ASSERT_TRUE(job.has_value()) << job.error().message;
    ++count;
    EXPECT_EQ(job->plan.name, name);
    EXPECT_EQ(
        std::filesystem::path(job->stl_path),
        std::filesystem::path(SOURCE_DIR "/../shared/models/" + model.file + ".stl").lexically_normal());
    EXPECT_EQ(job->stl_unit_mm, model.unit_mm);
    const AxisFrame &axis = job->plan.axis, &wanted = model.placement.axis;
    EXPECT_EQ(axis.mode, wanted.mode);
    EXPECT_EQ(axis.sense, wanted.sense);
    EXPECT_EQ(axis.origin, wanted.origin);
    EXPECT_EQ(axis.t, wanted.t);
    EXPECT_EQ(axis.n, wanted.n);
    EXPECT_EQ(axis.circle_radius, wanted.circle_radius);
    EXPECT_EQ(job->machine.model.name, "generic-ac");
  }
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SOURCE_DIR "/tests/jobs"))
    files += entry.path().extension() == ".yaml";
  EXPECT_EQ(files, count);
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
  const Job tyre = loaded("tyre"), pin = loaded("pin"), sphere = loaded("sphere"), handle = loaded("handle");
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
  for (double theta = -105; theta <= 105; theta += 15)
    for (double along = -75; along <= 75; along += 15)
      for (const double rho : {5.0, 50.0})
        expect_reachable(handle, pose_at(handle.plan.axis, theta * kDegree, 0, along, rho));
}

}  // namespace
}  // namespace tiltfeed
