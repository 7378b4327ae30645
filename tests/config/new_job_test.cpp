// A new job's text, read back.
#include "config/new_job.h"

#include <gtest/gtest.h>

#include "config/job.h"
#include "tests/texts/job_text.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

NewJob new_job(AxisMode mode) {
  NewJob job;
  job.name = job_name_of("/some where/p\"art,1.stl");
  job.stl = "../a b/\"quoted\\ part\".stl", job.machine = "../machines/generic-ac.yaml";
  job.stl_unit_mm = 25.4;
  job.cutter = parse_cutter("ball:6")->text;
  const Vec3 t = normalized(Vec3{1, 2, 3});
  job.axis = {mode, Sense::kInward, {1.25, -2.0 / 3.0, 3e-7}, t, normalized(cross(t, Vec3{0, 0, 1})), 0.0};
  if (mode == AxisMode::kCircle) job.axis.circle_radius = 123.456789;
  job.side_step = 0.6;
  job.part_zero = {1, -2, 203.5}, job.fixture_deg = {90, -0.0, 12.5};
  job.tilt_max = Angle::from_degrees(109.5);
  job.remarks = {"A remark.", "Another: [one]"};
  return job;
}

TEST(NewJob, ReadsBackAsItsValues) {
  for (const AxisMode mode : {AxisMode::kFixed, AxisMode::kPoint, AxisMode::kLine, AxisMode::kCircle,
                              AxisMode::kFree, AxisMode::kIndexed}) {
    const NewJob wanted = new_job(mode);
    const auto job = parse_job(new_job_text(wanted), kJobPath);
    ASSERT_TRUE(job) << job.error().message << "\n" << new_job_text(wanted);
    EXPECT_EQ(job->plan.name, "p_art_1");
    EXPECT_NE(job->stl_path.find("a b/\"quoted\\ part\".stl"), std::string::npos) << job->stl_path;
    EXPECT_EQ(job->stl_unit_mm, 25.4);
    EXPECT_EQ(job->plan.axis.mode, mode);
    EXPECT_EQ(job->plan.cutter.diameter, 6.0);
    EXPECT_EQ(job->plan.cutter.shank_length, 60.0);
    EXPECT_EQ(job->plan.cutter.length, 120.0);
    EXPECT_EQ(job->plan.pattern.side_step, 0.6);
    EXPECT_EQ(job->setup.part_zero, wanted.part_zero);
    EXPECT_NEAR(job->plan.tilt_max.degrees(), 109.5, 1e-12);
    if (mode == AxisMode::kFree || mode == AxisMode::kIndexed) continue;
    EXPECT_LT(distance(job->plan.axis.origin, wanted.axis.origin), 1e-9);
    EXPECT_LT(length(job->plan.axis.t - wanted.axis.t), 1e-8);
    EXPECT_LT(length(job->plan.axis.n - wanted.axis.n), 1e-8);
    if (mode != AxisMode::kFixed) {
      EXPECT_EQ(job->plan.axis.sense, Sense::kInward);
    }
    EXPECT_NEAR(job->plan.axis.circle_radius, wanted.axis.circle_radius, 1e-9);
  }
}

TEST(NewJob, TakesACutterAsAJobDoesOrInShort) {
  EXPECT_EQ(parse_cutter("flat:10")->cutter.type, CutterType::kFlat);
  EXPECT_EQ(parse_cutter("ball:0.5")->cutter.shank_length, 20.0);
  const auto full = parse_cutter(
      " {type: bull_nose, diameter_mm: 10, corner_radius_mm: 2, length_mm: 100, shank_length_mm: 40} ");
  ASSERT_TRUE(full) << full.error().message;
  EXPECT_EQ(full->cutter.corner_radius, 2.0);
  for (const char* wrong :
       {"", "ball", "bull:6", "ball:-6", "ball:6mm", "type: ball", "ball:6}, part: {name: x",
        "type: ball, diameter: 6, length_mm: 100, shank_length_mm: 40"}) {
    const auto cutter = parse_cutter(wrong);
    ASSERT_FALSE(cutter) << wrong;
    EXPECT_EQ(cutter.error().message.rfind("--cutter:", 0), 0u) << cutter.error().message;
  }
}

TEST(NewJob, NamesAreThoseOfJobs) {
  EXPECT_EQ(job_name_of("/a/b.stl"), "b");
  EXPECT_EQ(job_name_of("M\xc3\xbctze:1.stl"), "M__tze_1");
  EXPECT_EQ(job_name_of(std::string(90, 'x') + ".stl").size(), 40u);
  EXPECT_EQ(job_name_of(""), "part");
}

TEST(NewJob, ItsPlacementAsChangesMakesAnyOtherJobIt) {
  for (const AxisMode mode : {AxisMode::kFixed, AxisMode::kPoint, AxisMode::kLine, AxisMode::kCircle}) {
    const NewJob wanted = new_job(mode);
    NewJob other = new_job(AxisMode::kFixed);
    other.axis.origin = {7, 8, 9}, other.clearance = 9.0, other.part_zero = {0, 0, 1};
    std::string text = new_job_text(other);
    for (const YamlEdit& edit : placement_edits(wanted)) text = edited(text, edit, {}).value();
    const auto job = parse_job(text, kJobPath), right = parse_job(new_job_text(wanted), kJobPath);
    ASSERT_TRUE(job) << job.error().message << "\n" << text;
    EXPECT_EQ(describe(*job), describe(*right));
  }
}

TEST(NewJob, ACutterAsTextIsReadAsThatCutter) {
  for (const char* typed :
       {"ball:6", "flat:3.5",
        "type: bull_nose, diameter_mm: 10, corner_radius_mm: 0.1, length_mm: 99.5, "
        "cutting_length_mm: 20, shank_diameter_mm: 12, shank_length_mm: 50, holder: "
        "[{diameter_mm: 20, length_mm: 30}, {diameter_mm: 25, upper_diameter_mm: 40, "
        "length_mm: 10}]",
        "type: taper_ball, diameter_mm: 2, taper_deg: 3.3, length_mm: 90, shank_length_mm: 40"}) {
    const auto cutter = parse_cutter(typed);
    ASSERT_TRUE(cutter) << cutter.error().message;
    const auto again = parse_cutter(cutter_text(cutter->cutter));
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(cutter_text(again->cutter), cutter_text(cutter->cutter));
    EXPECT_EQ(again->cutter.cutting_end(), cutter->cutter.cutting_end());
    EXPECT_EQ(again->cutter.holder.size(), cutter->cutter.holder.size());
    EXPECT_NEAR(again->cutter.taper.degrees(), cutter->cutter.taper.degrees(), 1e-9);
    EXPECT_EQ(again->cutter.shank_radius(), cutter->cutter.shank_radius());
    EXPECT_EQ(again->cutter.corner_radius, cutter->cutter.corner_radius);
  }
}

}  // namespace
}  // namespace tiltfeed
