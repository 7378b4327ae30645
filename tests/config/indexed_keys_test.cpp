// The keys of the axis mode indexed: values, defaults, and one case for each kind of bad text.

#include <gtest/gtest.h>

#include <string>

#include "config/job.h"
#include "tests/texts/job_text.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

std::string job_text(const std::string& axis, const std::string& type = "ball",
                     const std::string& pattern = "side_step_mm: 0.5", const std::string& more = "") {
  return "part: {name: p-1, stl: p.stl}\n"
         "cutter: {type: " +
         type + ", diameter_mm: 6, length_mm: 100, shank_length_mm: 30}\n" + "axis: {mode: " + axis +
         "}\npattern: {" + pattern + "}\n" + more +
         "tolerance_mm: 0.02\nclearance_mm: 5\napproach_mm: 1\n"
         "feeds: {cut_mm_per_min: 1000, plunge_mm_per_min: 300}\n"
         "setup: {part_zero_mm: [1, 2, 3]}\nmachine: ../machines/generic-ac.yaml\n";
}

TEST(IndexedKeys, HaveDefaultsAndValues) {
  const auto plain = parse_job(job_text("indexed"), kJobPath);
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_EQ(plain->plan.axis.mode, AxisMode::kIndexed);
  EXPECT_EQ(plain->plan.indexed.most_directions, 6u);
  EXPECT_EQ(plain->plan.indexed.coverage, 0.995);
  EXPECT_EQ(plain->plan.indexed.least_gain, 0.005);
  EXPECT_EQ(plain->plan.indexed.steepest.degrees(), 75.0);
  const auto given =
      parse_job(job_text("indexed, most_directions: 9, coverage_percent: 90, least_gain_percent: 2, "
                         "steepest_deg: 60",
                         "ball", "side_step_mm: 0.5", "containment: {x_mm: [1, 2], z_mm: [3, 4]}\n"),
                kJobPath);
  ASSERT_TRUE(given) << given.error().message;
  EXPECT_EQ(given->plan.indexed.most_directions, 9u);
  EXPECT_EQ(given->plan.indexed.coverage, 0.9);
  EXPECT_EQ(given->plan.indexed.least_gain, 0.02);
  EXPECT_NEAR(given->plan.indexed.steepest.degrees(), 60.0, 1e-12);
  EXPECT_EQ(given->plan.containment.first.low, 1.0);
  EXPECT_EQ(given->plan.containment.height.high, 4.0);
  const std::string said = describe(*given);
  for (const char* line : {"axis.mode: indexed\n", "axis.most_directions: 9\n", "axis.coverage_percent: 90\n",
                           "axis.least_gain_percent: 2\n", "axis.steepest_deg: 60\n"})
    EXPECT_NE(said.find(line), std::string::npos) << line << said;
}

TEST(IndexedKeys, EveryKindOfBadTextIsRefused) {
  const struct {
    std::string text;
    const char* message;
  } kCases[] = {
      {job_text("indexed, most_directions: 0"), "axis.most_directions"},
      {job_text("indexed, most_directions: 33"), "axis.most_directions"},
      {job_text("indexed, most_directions: 2.5"), "axis.most_directions"},
      {job_text("indexed, coverage_percent: 101"), "axis.coverage_percent"},
      {job_text("indexed, coverage_percent: 0.99"), "axis.coverage_percent"},
      {job_text("indexed, least_gain_percent: -1"), "axis.least_gain_percent"},
      {job_text("indexed, least_gain_percent: 51"), "axis.least_gain_percent"},
      {job_text("free, plane_normals: [[0, 0, 1]], least_gain_percent: 1"),
       "axis.least_gain_percent: not used in the mode free"},
      {job_text("indexed, steepest_deg: 90"), "axis.steepest_deg"},
      {job_text("indexed, n: [0, 0, 1]"), "axis.n: not used in the mode indexed"},
      {job_text("indexed, lead_deg: 5"), "axis.lead_deg: not used in the mode indexed"},
      {job_text("fixed, most_directions: 3"), "axis.most_directions: not used in the mode fixed"},
      {job_text("indexed", "flat"), "use ball or taper_ball"},
      {job_text("indexed", "ball", "kind: spiral, side_step_mm: 0.5"), "expected raster, z_level or split"},
      {job_text("indexed", "ball", "side_step_mm: 0.5",
                "containment: {boundary: [[0, 0], [1, 0], [0, 1]]}\n"),
       "not used in the mode indexed"},
  };
  for (const auto& c : kCases) {
    const auto job = parse_job(c.text, kJobPath);
    ASSERT_FALSE(job) << c.text;
    EXPECT_EQ(job.error().code, Code::kInput);
    EXPECT_NE(job.error().message.find(c.message), std::string::npos) << job.error().message;
  }
}

}  // namespace
}  // namespace tiltfeed
