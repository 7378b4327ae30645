// How far the tool may lean from a predefined axis: axis.lean_limit_deg and the reaction tilt.

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "config/job.h"
#include "config/job_keys.h"
#include "tests/texts/bad_text.h"
#include "tests/texts/job_text.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

/// The job of all options with a ball and no stock, whose guards tilt.
std::string leaning_job() {
  std::string text = kOptionsJob;
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"stock: {radial_mm: 0.1, axial_mm: 0.2}\n", ""},
           {"type: bull_nose\n  diameter_mm: 10\n  corner_radius_mm: 2", "type: ball\n  diameter_mm: 10"},
           {"sense: outward}", "sense: outward, lean_limit_deg: 20}"},
           {"reaction: retract", "reaction: tilt"},
           {"reaction: report", "reaction: tilt"}})
    text = replaced(text, from, to);
  return text;
}

TEST(LeanKeys, AreRead) {
  const Result<Job> job = parse_job(leaning_job(), kJobPath);
  ASSERT_TRUE(job) << job.error().message;
  EXPECT_DOUBLE_EQ(job->plan.lean.limit.degrees(), 20.0);
  EXPECT_EQ(job->plan.shank.reaction, Reaction::kTilt);
  EXPECT_EQ(job->plan.holder.reaction, Reaction::kTilt);
  EXPECT_TRUE(may_lean(job->plan));
  EXPECT_EQ(job->plan.lean.max_turn, default_turn(job->machine.model, job->plan.cutter, job->plan.cut_feed));
  const std::string text = describe(*job);
  for (const char* line :
       {"axis.lean_limit_deg: 20\n", "guards.shank.reaction: tilt\n", "guards.holder.reaction: tilt\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
}

TEST(LeanKeys, TheTurnMayBeStated) {
  const Result<Job> job = parse_job(
      replaced(leaning_job(), "lean_limit_deg: 20", "lean_limit_deg: 20, max_turn_deg_per_mm: 3"), kJobPath);
  ASSERT_TRUE(job) << job.error().message;
  EXPECT_DOUBLE_EQ(job->plan.lean.max_turn.degrees(), 3.0);
  EXPECT_NE(describe(*job).find("axis.max_turn_deg_per_mm: 3\n"), std::string::npos);
}

TEST(LeanKeys, WithoutThemNothingLeans) {
  const Result<Job> job = parse_job(kOptionsJob, kJobPath);
  ASSERT_TRUE(job) << job.error().message;
  EXPECT_FALSE(may_lean(job->plan));
  EXPECT_NE(describe(*job).find("axis.lean_limit_deg: 0\n"), std::string::npos);
}

/// A machine whose one direction would do for the mode cannot lean.
TEST(LeanKeys, TakeTwoRotaryAxes) {
  const std::string fixed = replaced(kGoodJob,
                                     "  mode: circle\n  sense: inward\n  origin_mm: [1, 2, 3]\n  t: [0, 2, "
                                     "0]\n  n: [0, 0, -3]\n  circle_radius_mm: 50\n",
                                     "  mode: fixed\n  n: [0, 0, 1]\n  lean_limit_deg: 20\n");
  const std::string plain = replaced(fixed, ", fixture_rotation_deg: [10, 20, 30]", "");
  const std::string mill = replaced(plain, "generic-ac", "mill-3x");
  const auto tilting = [](const std::string& text) {
    return parse_job(
        replaced(text, "clearance_mm: 5\n", "clearance_mm: 5\nguards: {shank: {reaction: tilt}}\n"),
        kJobPath);
  };
  EXPECT_TRUE(tilting(plain)) << tilting(plain).error().message;
  EXPECT_TRUE(parse_job(mill, kJobPath));
  ASSERT_FALSE(tilting(mill));
  EXPECT_NE(tilting(mill).error().message.find("the reaction tilt turns the tool every way"),
            std::string::npos)
      << tilting(mill).error().message;
}

TEST(LeanKeys, WhatDoesNotGoTogetherIsRefused) {
  struct Case {
    std::string from, to, told;
  };
  const std::vector<Case> cases = {
      {", lean_limit_deg: 20", "", "guards.shank: the reaction tilt needs axis.lean_limit_deg above 0"},
      {"lean_limit_deg: 20", "lean_limit_deg: 61", "axis.lean_limit_deg: '61' is out of range"},
      {"lean_limit_deg: 20", "max_turn_deg_per_mm: 3",
       "max_turn_deg_per_mm: not used without lean_limit_deg"},
      {"type: ball\n  diameter_mm: 10", "type: flat\n  diameter_mm: 10",
       "axis.lean_limit_deg: a cutter that leans touches elsewhere unless it ends in a ball"},
      {"{clearance_mm: 2, reaction: tilt}", "{clearance_mm: 2, reaction: report}",
       "guards.holder: the reaction report does not go with tilt"},
      {"{clearance_mm: 0.5, reaction: tilt}", "{clearance_mm: 0.5, reaction: retract}",
       "guards.shank: the reaction retract does not go with tilt"},
      {"links:", "stock: {radial_mm: 0.1}\nlinks:", "a tool that leans cuts into it"},
      {"mode: point, sense: outward, lean_limit_deg: 20",
       "mode: free, plane_normals: [[0, 0, 1]], lean_limit_deg: 20",
       "axis.lean_limit_deg: not used in the mode free"},
      {"mode: point, sense: outward, lean_limit_deg: 20", "mode: indexed",
       "guards.shank: the reaction tilt is not used in the axis mode indexed"},
      {"mode: point, sense: outward, lean_limit_deg: 20", "mode: indexed, lean_limit_deg: 20",
       "axis.lean_limit_deg: not used in the mode indexed"},
  };
  for (const Case& one : cases) {
    const std::string text = leaning_job();
    ASSERT_NE(text.find(one.from), std::string::npos) << one.from;
    const Result<Job> job = parse_job(replaced(text, one.from, one.to), kJobPath);
    ASSERT_FALSE(job) << one.to;
    EXPECT_NE(job.error().message.find(one.told), std::string::npos) << job.error().message;
  }
}

}  // namespace
}  // namespace tiltfeed
