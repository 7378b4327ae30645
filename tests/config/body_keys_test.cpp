// Bodies of a machine and fixtures of a job: what is read, and every kind of bad text with its key, value and
// remedy.

#include "config/body_keys.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "config/job.h"
#include "tests/texts/job_text.h"

namespace tiltfeed::config {
namespace {

const std::string kProfile = SOURCE_DIR "/config/machines/generic-ac.yaml";

std::string machine_text(const std::string& more) {
  std::ifstream in(kProfile);
  std::string text, line;
  // Without what follows `slides:`; all of that has defaults.
  while (std::getline(in, line) && line != "slides:") text += line + "\n";
  return text + more;
}

std::string refusal(const std::string& more) {
  const auto machine = parse_machine(machine_text(more), kProfile);
  return machine ? "none" : machine.error().message;
}

std::string body(const std::string& keys) { return "bodies: [{name: a, " + keys + "}]\n"; }

TEST(BodyKeys, EachShapeIsRead) {
  const auto machine = parse_machine(
      machine_text(
          "slides: {work: [y, x]}\n"
          "clearances: {head_mm: 7, rapid_factor: 3}\n"
          "bodies:\n"
          "  - {name: a, link: table, shape: box, size_mm: [1, 2, 3], at_mm: [4, 5, 6], rotation_deg: [0, 0, "
          "90]}\n"
          "  - {name: b, link: nose, shape: cone, diameter_mm: 50, upper_diameter_mm: 0, height_mm: 20}\n"
          "  - {name: c, link: head, shape: cylinder, diameter_mm: 9, height_mm: 4, colour: \"#01fFa9\"}\n"),
      kProfile);
  ASSERT_TRUE(machine) << machine.error().message;
  const MachineBodies& solid = machine->solid;
  ASSERT_EQ(solid.bodies.size(), 3u);
  EXPECT_EQ(solid.work_slides, (std::vector<int>{1, 0}));
  EXPECT_EQ(solid.tool_slides, (std::vector<int>{2}));
  EXPECT_EQ(solid.clearances.head, 7.0);
  EXPECT_EQ(solid.clearances.table, 5.0);
  EXPECT_EQ(solid.clearances.rapid_factor, 3.0);
  EXPECT_EQ(solid.bodies[0].shape.size, (Vec3{1, 2, 3}));
  EXPECT_EQ(solid.bodies[0].shape.rotation * (Vec3{1, 0, 0}), (Vec3{0, 1, 0}));
  EXPECT_EQ(solid.bodies[0].colour, kNoColour);
  EXPECT_EQ(solid.bodies[1].shape.upper_diameter, 0.0);
  EXPECT_EQ(solid.bodies[2].shape.upper_diameter, 9.0);
  EXPECT_EQ(solid.bodies[2].colour, "#01fFa9");
  EXPECT_NE(
      describe(*machine).find("bodies[2]: b on the link nose, cone of diameter 50 to 0, height 20 mm\n"),
      std::string::npos);
  const auto bare = parse_machine(machine_text(""), kProfile);
  ASSERT_TRUE(bare) << bare.error().message;
  EXPECT_TRUE(bare->solid.bodies.empty());
  EXPECT_NE(describe(*bare).find("bodies: none: the machine itself is not checked"), std::string::npos);
}

TEST(BodyKeys, BadTextIsRefusedWithItsRemedy) {
  const std::pair<std::string, const char*> cases[] = {
      {body("link: tabel, shape: box, size_mm: [1, 1, 1]"), "bodies[1].link: "},
      {body("link: cradle, shape: box, size_mm: [1, 1, 1]"), "cradle is no link of this structure"},
      {body("link: bed, shape: ball"), "bodies[1].shape: "},
      {body("link: bed, shape: box"), "missing key 'bodies[1].size_mm'"},
      {body("link: bed, shape: box, size_mm: [1, 0, 1]"), "'0' is out of range"},
      {body("link: bed, shape: box, size_mm: [1, 1, 1], diameter_mm: 3"),
       "bodies[1].diameter_mm: not used by the shape box; remove it"},
      {body("link: bed, shape: cylinder, diameter_mm: 3, height_mm: 2, upper_diameter_mm: 3"),
       "bodies[1].upper_diameter_mm: not used by the shape cylinder"},
      {body("link: bed, shape: stl, stl: nowhere.stl"),
       "is not a file that can be read; expected an STL file"},
      {body("link: bed, shape: box, size_mm: [1, 1, 1], colour: red"), "expected \"#rrggbb\""},
      {body("link: bed, shape: box, size_mm: [1, 1, 1], colour: \"#12345g\""), "found '#12345g'"},
      {body("link: bed, shape: box, size: [1, 1, 1]"), "nearest known key: size_mm"},
      {"bodies: []\n", "bodies: expected a list of 1 to 200 maps"},
      {"bodies: [{name: a, link: bed, shape: box, size_mm: [1, 1, 1]}, {name: a, link: bed, shape: box, "
       "size_mm: [1, 1, 1]}]\n",
       "'a' is there twice"},
      {"slides: {work: [a]}\n", "slides.work: expected none, or some of x, y, z, each once, found 'a'"},
      {"slides: {work: [x], tool: [x, y, z]}\n", "slides.tool: expected each of x, y, z once"},
      {"clearances: {rapid_factor: 0.5}\n", "clearances.rapid_factor: '0.5' is out of range"},
      {"clearances: {table_mm: -1}\n", "clearances.table_mm: '-1' is out of range"},
  };
  for (const auto& [text, said] : cases) {
    const std::string message = refusal(text);
    EXPECT_NE(message.find(said), std::string::npos) << text << message;
    EXPECT_EQ(message.find(kProfile + ":"), 0u) << message;
  }
}

TEST(BodyKeys, FixturesAreOnTheTableOrThePart) {
  const auto job =
      parse_job(kGoodJob +
                    "fixtures: [{name: vice, shape: box, size_mm: [1, 2, 3]}, {name: pin, on: part, "
                    "shape: cylinder, diameter_mm: 5, height_mm: 9}]\n",
                kJobPath);
  ASSERT_TRUE(job) << job.error().message;
  ASSERT_EQ(job->fixtures.size(), 2u);
  EXPECT_FALSE(job->fixtures[0].on_part);
  EXPECT_TRUE(job->fixtures[1].on_part);
  EXPECT_NE(describe(*job).find("fixtures[2]: pin on the part, cylinder of diameter 5, height 9 mm\n"),
            std::string::npos);
  const auto bad =
      parse_job(kGoodJob + "fixtures: [{name: vice, on: bed, shape: box, size_mm: [1, 2, 3]}]\n", kJobPath);
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().message.find("fixtures[1].on: "), std::string::npos) << bad.error().message;
}

}  // namespace
}  // namespace tiltfeed::config
