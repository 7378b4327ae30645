// Parts that fixtures hold, planned and proven as a user does it: the check of the printed program, which
// knows nothing of the planner, finds no collision; what a fixture keeps the tool from is told by its name.

#include <gtest/gtest.h>

#include "daemon/plan/plan_program.h"
#include "tests/shapes/held_part.h"

namespace tiltfeed {
namespace {

const std::string kFixed = "{mode: fixed, t: [1, 0, 0], n: [0, 0, 1]}";
const std::string kLeaning = "{mode: fixed, t: [1, 0, 0], n: [0, 0, 1], lean_limit_deg: 40}";
const std::string kLeaningLine =
    "{mode: line, sense: outward, origin_mm: [0, 0, 0], t: [0, 0, 1], n: [0, 1, 0], lean_limit_deg: 40}";
const std::string kTilt = "guards: {shank: {reaction: tilt}, holder: {clearance_mm: 0.5, reaction: tilt}}\n";
const std::string kLine = "{mode: line, sense: outward, origin_mm: [0, 0, 0], t: [0, 0, 1], n: [0, 1, 0]}";
const std::string kPoint =
    "{mode: point, sense: inward, origin_mm: [0, 0, 120], n: [0, 0, -1], t: [1, 0, 0]}";
const std::string kWide = "containment: {boundary: [[-17, -12], [17, -12], [17, 12], [-17, 12]]}\n";
const std::string kBall = "type: ball, diameter_mm: 6";

std::string circle(const std::string& sense, int height, int radius) {
  return "{mode: circle, sense: " + sense + ", origin_mm: [0, 0, " + std::to_string(height) +
         "], n: [0, 1, 0], t: [1, 0, 0], circle_radius_mm: " + std::to_string(radius) + "}";
}
const std::string kFree = "{mode: free, plane_normals: [[1, 0, 0]], max_turn_deg_per_mm: 5}";
const std::string kIndexed = "{mode: indexed, most_directions: 3}";

const std::string kPost = "{name: post, shape: cylinder, diameter_mm: 60, height_mm: 100}";

std::vector<std::string> vice(int top) {
  const std::string base = std::to_string(top - 30);
  return {box_fixture("left jaw", "60, 20, 30", "0, -25, " + base),
          box_fixture("right jaw", "60, 20, 30", "0, 25, " + base), kPost};
}
std::vector<std::string> chuck() {
  return {box_fixture("jaw 1", "10, 30, 14", "16, 0, -4"), box_fixture("jaw 2", "10, 30, 14", "-16, 0, -4"),
          round_fixture("chuck", 60, 60, "0, 0, -64")};
}

struct HeldCase {
  HeldJob job;
  std::vector<std::string> told;  ///< fixtures that keep the tool from something
  std::string refused;            ///< what the refusal says; empty: proven
  bool leans = false;             ///< the tool leans somewhere
};

void PrintTo(const HeldCase& held, std::ostream* out) { *out << held.job.name; }

std::vector<HeldCase> cases() {
  return {
      {{"low_vice", "hill", kFixed, vice(8)}, {}, ""},
      {{"high_vice", "hill", kFixed, vice(16)}, {"left jaw", "right jaw"}, ""},
      {{"clamps",
        "hill",
        kFixed,
        {box_fixture("clamp a", "10, 12, 8", "-18, -12, 12.5"),
         box_fixture("clamp b", "10, 12, 8", "18, 12, 12.5"), kPost}},
       {"clamp a", "clamp b"},
       ""},
      {{"strap", "hill", kFixed, {box_fixture("strap", "8, 50, 6", "0, 0, 20"), kPost}}, {"strap"}, ""},
      {{"cover", "hill", kFixed, {box_fixture("cover", "60, 50, 6", "0, 0, 20"), kPost}},
       {},
       "nothing is left to cut: at every point of the path the tool would come nearer to a fixture than its "
       "clearance (cover)"},
      {{"studs",
        "hill",
        kFixed,
        {round_fixture("stud a", 10, 60, "-28, 0, 0"), round_fixture("stud b", 10, 60, "28, 6, 0"), kPost}},
       {"stud a", "stud b"},
       ""},
      {{"chuck_line", "rod", kLine, chuck()}, {"jaw 1", "jaw 2", "chuck"}, ""},
      {{"chuck_free", "rod", kFree, chuck(), "{direction: zigzag, side_step_mm: 4}"},
       {"jaw 1", "jaw 2", "chuck"},
       ""},
      {{"leaning_vice", "hill", kLeaning, vice(34), "{along: x, direction: zigzag, side_step_mm: 3}",
        "type: ball, diameter_mm: 6", kTilt},
       {},
       "",
       true},
      {{"leaning_chuck", "rod", kLeaningLine, chuck(), "{along: x, direction: zigzag, side_step_mm: 3}",
        "type: taper_ball, taper_deg: 3, diameter_mm: 6, cutting_length_mm: 20", kTilt},
       {"chuck"},
       "",
       true},
      {{"vice_point", "hill", kPoint, vice(15)}, {"left jaw", "right jaw"}, ""},
      {{"tower_indexed", "hill", kIndexed, {round_fixture("tower", 14, 70, "26, -20, 0"), kPost}},
       {"tower", "post"},
       ""},
      {{"flat_end", "hill", kFixed, vice(16), "{along: x, direction: zigzag, side_step_mm: 3}",
        "type: flat, diameter_mm: 6", "links: {join_distance_mm: 4, lead_radius_mm: 1}\n"},
       {"left jaw", "right jaw"},
       ""},
      {{"bull_nose", "hill", kFixed, vice(16), "{along: y, direction: zigzag, side_step_mm: 3}",
        "type: bull_nose, diameter_mm: 8, corner_radius_mm: 2"},
       {"left jaw", "right jaw"},
       ""},
      {{"levels",
        "hill",
        kFixed,
        {box_fixture("clamp a", "10, 12, 8", "-18, -12, 12.5")},
        "{kind: z_level, step_down_mm: 5}"},
       {"clamp a"},
       ""},
      {{"split",
        "hill",
        kFixed,
        {box_fixture("clamp a", "10, 12, 8", "-18, -12, 12.5")},
        "{kind: split, along: x, side_step_mm: 3, step_down_mm: 3}"},
       {"clamp a"},
       ""},
      {{"contour",
        "hill",
        kFixed,
        {box_fixture("clamp a", "10, 12, 8", "-18, -12, 12.5")},
        "{kind: contour, side_step_mm: 3}",
        kBall,
        kWide},
       {"clamp a"},
       ""},
      {{"spiral",
        "hill",
        kFixed,
        {box_fixture("clamp a", "10, 12, 8", "-18, -12, 12.5")},
        "{kind: spiral, side_step_mm: 3}",
        kBall,
        kWide},
       {"clamp a"},
       ""},
      {{"vice_circle", "hill", circle("inward", 80, 30), vice(16)}, {"left jaw", "right jaw"}, ""},
      {{"vice_circle_out", "hill", circle("outward", -40, 60), vice(16)}, {"left jaw", "right jaw"}, ""},
      {{"vice_line_in", "hill",
        "{mode: line, sense: inward, origin_mm: [0, 0, 90], n: [0, 0, -1], t: [1, 0, 0]}", vice(16)},
       {"left jaw", "right jaw"},
       ""},
      {{"rough",
        "hill",
        kFixed,
        {round_fixture("tower", 14, 70, "26, -20, 0")},
        "{kind: rough, along: x, step_down_mm: 6, side_step_mm: 5}",
        "type: ball, diameter_mm: 6",
        "containment: {x_mm: [-20, 20], y_mm: [-15, 15]}\n"},
       {"tower"},
       ""},
  };
}

class HeldParts : public ::testing::TestWithParam<HeldCase> {};

TEST_P(HeldParts, AreProvenClearOfTheirFixturesOrRefusedByName) {
  const HeldCase& held = GetParam();
  const Folder folder("held_" + held.job.name);
  daemon::PlanFiles files;
  files.job = write_held_job(folder, held.job), files.program = folder.path + "/out.nc";
  const auto told = daemon::plan_program(files, {});
  if (!held.refused.empty()) {
    ASSERT_FALSE(told) << *told;
    EXPECT_NE(told.error().message.find(held.refused), std::string::npos) << told.error().message;
    return;
  }
  ASSERT_TRUE(told) << told.error().message;
  EXPECT_NE(told->find("no collision"), std::string::npos) << *told;
  EXPECT_EQ(told->find("lean: the tool leans") != std::string::npos, held.leans) << *told;
  for (const std::string& name : held.told)
    EXPECT_NE(told->find("the fixture " + name + " keeps the tool from"), std::string::npos) << *told;
}

INSTANTIATE_TEST_SUITE_P(SetUps, HeldParts, ::testing::ValuesIn(cases()),
                         [](const auto& one) { return one.param.job.name; });

}  // namespace
}  // namespace tiltfeed
