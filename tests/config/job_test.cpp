// Job files: values, defaults, files and paths. Options of the path: job_options_test.cpp; bad input:
// job_errors_test.cpp.

#include "config/job.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/texts/bad_text.h"
#include "tests/texts/example_job.h"
#include "tests/texts/folder.h"
#include "tests/texts/job_text.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

Job good(const std::string& from = "", const std::string& to = "") {
  const Result<Job> job = parse_job(from.empty() ? kGoodJob : replaced(kGoodJob, from, to), kJobPath);
  EXPECT_TRUE(job.has_value()) << job.error().message;
  return job.value_or(Job{});
}

double angle_between_rotations(const Rotation& a, const Rotation& b) {
  double worst = 0.0;
  for (int i = 0; i < 3; ++i) worst = std::max(worst, length(a.rows[i] - b.rows[i]));
  return worst;
}

TEST(Job, LeavesTheControlWhatItRoundsCornersOffBy) {
  const Folder folder("blend_job");
  const auto job_with = [&](const std::string& blend) {
    folder.write("m.yaml",
                 replaced(text_of(SOURCE_DIR "/config/machines/linuxcnc-bridge-bc.yaml"),
                          "path_control: exact", "path_control: blend, blend_tolerance_mm: " + blend));
    return load_job(folder.write("j.yaml", replaced(kGoodJob, "../machines/generic-ac.yaml", "m.yaml")));
  };
  const auto job = job_with("0.008");
  ASSERT_TRUE(job) << job.error().message;
  EXPECT_EQ(job->plan.tolerance, good().plan.tolerance - 0.008);
  EXPECT_NE(describe(*job).find("\ntolerance_mm: 0.02\n"), std::string::npos) << "as the job says";
  const auto greedy = job_with("0.011");
  ASSERT_FALSE(greedy);
  EXPECT_NE(greedy.error().message.find("tolerance_mm: 0.02 is less than twice the blend_tolerance_mm"),
            std::string::npos)
      << greedy.error().message;
}

TEST(Job, ReadsEveryValue) {
  const Job job = good();
  EXPECT_EQ(job.path, kJobPath);
  EXPECT_EQ(job.stl_path, kJobFolder + "p.stl");
  EXPECT_EQ(job.stl_unit_mm, 25.4);
  const PlanOptions& plan = job.plan;
  EXPECT_EQ(plan.name, "p-1");
  EXPECT_EQ(plan.cutter.diameter, 6.0);
  EXPECT_EQ(plan.cutter.length, 100.0);
  EXPECT_EQ(plan.cutter.shank_length, 30.0);
  EXPECT_EQ(plan.axis.mode, AxisMode::kCircle);
  EXPECT_EQ(plan.axis.sense, Sense::kInward);
  EXPECT_EQ(plan.axis.origin, (Point<Part>{1, 2, 3}));
  EXPECT_EQ(plan.axis.t, (Vec3{0, 1, 0}));
  EXPECT_EQ(plan.axis.n, (Vec3{0, 0, -1}));
  EXPECT_EQ(plan.axis.circle_radius, 50.0);
  EXPECT_EQ(plan.pattern.along, Along::kY);
  EXPECT_EQ(plan.pattern.direction, Direction::kOneWay);
  EXPECT_EQ(plan.pattern.side_step, 0.5);
  EXPECT_EQ(plan.tolerance, 0.02);
  EXPECT_EQ(plan.allowance, 0.3);
  EXPECT_EQ(plan.links.clearance, 5.0);
  EXPECT_EQ(plan.links.approach, 1.0);
  EXPECT_EQ(plan.cut_feed.mm_per_min(), 1000.0);
  EXPECT_EQ(plan.plunge_feed.mm_per_min(), 300.0);
  EXPECT_EQ(job.feeds.highest.mm_per_min(), 1000.0);
  EXPECT_EQ(job.feeds.lowest.mm_per_min(), 200.0);
  EXPECT_EQ(job.spindle_rpm, 9000.0);
  EXPECT_EQ(job.setup.part_zero, (Vec3{1, 2, 3}));
  EXPECT_EQ(job.setup.tool_length, 100.0);
  EXPECT_EQ(job.machine.model.name, "generic-ac");
  EXPECT_EQ(job.machine.path, SOURCE_DIR "/config/machines/generic-ac.yaml");
}

TEST(Job, DefaultsAreTheDocumentedOnes) {
  const std::string least =
      "part: {name: p, stl: /abs/p.stl}\n"
      "cutter: {type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 30}\n"
      "axis: {mode: fixed}\n"
      "pattern: {side_step_mm: 0.5}\n"
      "clearance_mm: 5\n"
      "approach_mm: 5\n"
      "feeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 300}\n"
      "setup: {part_zero_mm: [0, 0, 0]}\n"
      "machine: ../machines/generic-ac.yaml\n";
  const Result<Job> job = parse_job(least, kJobPath);
  ASSERT_TRUE(job.has_value()) << job.error().message;
  EXPECT_EQ(job->stl_path, "/abs/p.stl");
  EXPECT_EQ(job->stl_unit_mm, 1.0);
  EXPECT_EQ(job->plan.axis.mode, AxisMode::kFixed);
  EXPECT_EQ(job->plan.axis.origin, (Point<Part>{0, 0, 0}));
  EXPECT_EQ(job->plan.axis.t, (Vec3{1, 0, 0}));
  EXPECT_EQ(job->plan.axis.n, (Vec3{0, 0, 1}));
  EXPECT_EQ(job->plan.pattern.along, Along::kX);
  EXPECT_EQ(job->plan.pattern.direction, Direction::kZigzag);
  EXPECT_EQ(job->plan.tolerance, 0.01);
  EXPECT_EQ(job->plan.allowance, 0.0);
  EXPECT_EQ(job->spindle_rpm, 0.0);
  EXPECT_EQ(job->setup.fixture, Rotation{});
}

TEST(Job, UnitsOfTheStl) {
  EXPECT_EQ(good("unit: inch", "unit: mm").stl_unit_mm, 1.0);
  EXPECT_EQ(good("unit: inch", "unit: m").stl_unit_mm, 1000.0);
  EXPECT_EQ(good("unit: inch", "unit: 0.001").stl_unit_mm, 0.001);
  EXPECT_EQ(good("unit: inch", "unit: +25.4").stl_unit_mm, 25.4);
  EXPECT_EQ(good("unit: inch", "unit: 1e1").stl_unit_mm, 10.0);
}

TEST(Job, NumbersAreReadInEveryPlainForm) {
  EXPECT_EQ(good("clearance_mm: 5", "clearance_mm: 5.").plan.links.clearance, 5.0);
  EXPECT_EQ(good("clearance_mm: 5", "clearance_mm: 50e-1").plan.links.clearance, 5.0);
  EXPECT_EQ(good("allowance_mm: 0.3", "allowance_mm: .3").plan.allowance, 0.3);
  EXPECT_FALSE(std::signbit(good("allowance_mm: 0.3", "allowance_mm: -0").plan.allowance));
}

TEST(Job, FixtureRotationTurnsAboutXThenYThenZ) {
  // By the axis-angle formula of geometry.h, which shares nothing with the reader's matrices.
  const auto about = [](Vec3 axis, double degrees) {
    return rotation_about(axis, Angle::from_degrees(degrees).radians());
  };
  const Rotation expected = about({0, 0, 1}, 30) * about({0, 1, 0}, 20) * about({1, 0, 0}, 10);
  EXPECT_LT(angle_between_rotations(good().setup.fixture, expected), 1e-15);

  const std::string angles = "fixture_rotation_deg: [10, 20, 30]";
  const Rotation upright = good(angles, "fixture_rotation_deg: [90, 0, 0]").setup.fixture;
  EXPECT_EQ(upright * (Vec3{0, 1, 0}), (Vec3{0, 0, 1}));  // exactly: no rounding of pi
  const Rotation ordered = good(angles, "fixture_rotation_deg: [-270, 0, 90]").setup.fixture;
  EXPECT_EQ(ordered * (Vec3{0, 1, 0}), (Vec3{0, 0, 1}));  // z first would give -x
  EXPECT_EQ(ordered * (Vec3{1, 0, 0}), (Vec3{0, 1, 0}));
  EXPECT_EQ(good(angles, "fixture_rotation_deg: [360, -360, 180]").setup.fixture * (Vec3{1, 2, 3}),
            (Vec3{-1, -2, 3}));
}

TEST(Job, RoundedDirectionsBecomeExactlyPerpendicular) {
  const Job job = good("n: [0, 0, -3]", "n: [0, 0.00002, -3]");  // off by 6.7e-6 rad
  EXPECT_EQ(job.plan.axis.t, (Vec3{0, 1, 0}));
  EXPECT_EQ(dot(job.plan.axis.t, job.plan.axis.n), 0.0);
  EXPECT_NEAR(length(job.plan.axis.n), 1.0, 1e-15);
  EXPECT_LT(angle_between(job.plan.axis.n, {0, 0, -1}), 1e-15);
}

class JobFiles : public testing::Test {
 protected:
  const Folder folder_{"job_files"};
};

TEST_F(JobFiles, UnreadableFilesAreIoErrors) {
  const std::string missing = folder_.path + "/none.yaml";
  for (const std::string& path : {missing, folder_.path}) {
    const Result<Job> job = load_job(path);
    ASSERT_FALSE(job.has_value());
    EXPECT_EQ(job.error().code, Code::kIo);
    EXPECT_EQ(job.error().message.find(path + ": cannot read: "), 0u) << job.error().message;
  }
  EXPECT_NE(load_job(missing).error().message.find("No such file"), std::string::npos);
}

TEST_F(JobFiles, AMissingMachineIsReportedAtTheJobsKey) {
  const std::string path =
      folder_.write("job.yaml", replaced(kGoodJob, "../machines/generic-ac.yaml", "m.yaml"));
  const Result<Job> job = load_job(path);
  ASSERT_FALSE(job.has_value());
  EXPECT_EQ(job.error().code, Code::kIo);
  EXPECT_EQ(job.error().message.find(path + ":17:10: machine: " + folder_.path + "/m.yaml"), 0u)
      << job.error().message;
}

TEST_F(JobFiles, AMachinesErrorNamesTheMachinesFile) {
  const std::string path =
      folder_.write("job.yaml", replaced(kGoodJob, "../machines/generic-ac.yaml", "m.yaml"));
  const std::string machine = folder_.write(
      "m.yaml", replaced(text_of(SOURCE_DIR "/config/machines/generic-ac.yaml"), "letter: A", "letter: X"));
  const Result<Job> job = load_job(path);
  ASSERT_FALSE(job.has_value());
  EXPECT_EQ(job.error().message.find(machine + ":"), 0u) << job.error().message;
  EXPECT_NE(job.error().message.find("tilt.letter"), std::string::npos);
}

TEST_F(JobFiles, PathsAreRelativeToTheJobFile) {
  folder_.write("m.yaml", text_of(SOURCE_DIR "/config/machines/generic-ac.yaml"));
  const Result<Job> job =
      load_job(folder_.write("job.yaml", replaced(kGoodJob, "../machines/generic-ac.yaml", "./m.yaml")));
  ASSERT_TRUE(job.has_value()) << job.error().message;
  EXPECT_EQ(job->machine.path, folder_.path + "/m.yaml");
  EXPECT_EQ(job->stl_path, folder_.path + "/p.stl");
}

TEST_F(JobFiles, LargeFilesAreRefused) {
  const std::string path = folder_.write("job.yaml", std::string((1u << 20) + 1, '#'));
  const Result<Job> job = load_job(path);
  ASSERT_FALSE(job.has_value());
  EXPECT_EQ(job.error().code, Code::kInput);
  EXPECT_NE(job.error().message.find("over the limit of 1048576 bytes"), std::string::npos);
}

TEST(Job, TiltIsLimitedAgainstTheTablesAxis) {
  const std::string angles = "fixture_rotation_deg: [10, 20, 30]";
  EXPECT_EQ(good().plan.tilt_max.degrees(), 180.0);
  const Job job = good(angles, "fixture_rotation_deg: [90, 0, 0], tilt_max_deg: 75");
  EXPECT_NEAR(job.plan.tilt_max.degrees(), 75.0, 1e-12);
  // Turned about x by 90 degrees, the part's y points up.
  EXPECT_LT(length(job.plan.up - Vec3{0, 1, 0}), 1e-15);
}

TEST(Job, DescribesEveryValue) {
  const std::string text = describe(good());
  for (const char* line : {
           "part.name: p-1\n",
           "part.unit_mm: 25.4\n",
           "cutter.type: ball\n",
           "cutter.diameter_mm: 6\n",
           "cutter.length_mm: 100\n",
           "cutter.cutting_length_mm: 30\n",
           "cutter.shank_diameter_mm: 6\n",
           "cutter.shank_length_mm: 30\n",
           "cutter.holder: none\n",
           "containment: none\n",
           "blank: none\n",
           "guards.shank.reaction: trim\n",
           "axis.mode: circle\n",
           "axis.sense: inward\n",
           "axis.origin_mm: [1, 2, 3]\n",
           "axis.t: [0, 1, 0]\n",
           "axis.n: [0, 0, -1]\n",
           "axis.circle_radius_mm: 50\n",
           "pattern.along: y\n",
           "pattern.direction: one_way\n",
           "pattern.side_step_mm: 0.5\n",
           "tolerance_mm: 0.02\n",
           "allowance_mm: 0.3\n",
           "clearance_mm: 5\n",
           "approach_mm: 1\n",
           "feeds.cut_mm_per_min: 1000\n",
           "feeds.plunge_mm_per_min: 300\n",
           "feeds.spindle_rpm: 9000\n",
           "feeds.highest_mm_per_min: 1000\n",
           "feeds.lowest_mm_per_min: 200\n",
           "feeds.load_percent: 100\n",
           "feeds.change_percent_per_mm: 0\n",
           "setup.part_zero_mm: [1, 2, 3]\n",
           "setup.tilt_max_deg: 180\n",
           "setup.tool_length_mm: 100\n",
           "machine.name: generic-ac\n",
           "machine.rotary.sign: -1\n",
       })
    EXPECT_NE(("\n" + text).find(std::string("\n") + line), std::string::npos) << line << text;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_NE(line.find(": "), std::string::npos) << line;
  EXPECT_EQ(text, describe(good()));
}

}  // namespace
}  // namespace tiltfeed
