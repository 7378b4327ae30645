// Program text, to the last byte, against files in golden/: any change of it is seen and judged.
// `golden_test --approve` writes the files anew.

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "config/job.h"
#include "daemon/block.h"
#include "kinematics/cl_file.h"
#include "kinematics/joint_path.h"
#include "pathgen/plan.h"

namespace tiltfeed {
namespace {

bool approve = false;

/// A pyramid of 40 mm with its tip up, 20 mm high.
CheckedMesh pyramid() {
  const Point<Part> tip{0, 0, 20};
  const std::array<Point<Part>, 4> base{{{-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}}};
  Stl stl;
  for (std::size_t i = 0; i < 4; ++i) stl.facets.push_back({base[i], base[(i + 1) % 4], tip});
  stl.facets.push_back({base[0], base[2], base[1]});
  stl.facets.push_back({base[0], base[3], base[2]});
  return *check_mesh(stl);
}

Job job_for(const std::string& axis, const std::string& along) {
  const std::string text =
      "part: {name: pyramid, stl: none.stl}\n"
      "cutter: {type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 40}\n"
      "axis: " +
      axis +
      "\n"
      "pattern: {along: " +
      along +
      ", direction: zigzag, side_step_mm: 14}\n"
      "tolerance_mm: 0.1\nclearance_mm: 4\napproach_mm: 1\n"
      "feeds: {cut_mm_per_min: 1500, plunge_mm_per_min: 300, spindle_rpm: 12000}\n"
      "setup: {part_zero_mm: [30, -10, 50], tilt_max_deg: 75}\n"
      "machine: generic-ac.yaml\n";
  return *parse_job(text, SOURCE_DIR "/config/machines/job.yaml");
}

void expect_golden(const std::string& name, const std::string& text) {
  const std::string path = SOURCE_DIR "/tests/golden/" + name;
  if (approve) {
    std::ofstream(path, std::ios::binary) << text;
    return;
  }
  std::ifstream in(path, std::ios::binary);
  ASSERT_TRUE(in) << path << " is missing; golden_test --approve writes it";
  std::istringstream want(std::string(std::istreambuf_iterator<char>(in), {})), have(text);
  std::string a, b;
  for (int line = 1;; ++line) {
    const bool more_a = static_cast<bool>(std::getline(want, a)),
               more_b = static_cast<bool>(std::getline(have, b));
    ASSERT_EQ(more_a, more_b) << path << ": length differs at line " << line;
    if (!more_a) break;
    ASSERT_EQ(a, b) << path << ":" << line;
  }
}

struct Case {
  const char* name;
  const char* axis;
  const char* along;
  Dialect dialect;
};

class Golden : public testing::TestWithParam<Case> {};

TEST_P(Golden, ProgramAndClFileAreUnchanged) {
  const Case& c = GetParam();
  Job job = job_for(c.axis, c.along);
  job.machine.format.dialect = c.dialect;
  const auto planned = plan(pyramid(), job.plan, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  const auto joints = to_joints(planned->path, job.machine.model, job.setup, {});
  ASSERT_TRUE(joints) << joints.error().message;
  std::ostringstream program, cl;
  ASSERT_TRUE(write_program(*joints, job, program));
  write_cl(planned->path, cl);
  expect_golden(std::string(c.name) + ".nc", program.str());
  expect_golden(std::string(c.name) + ".cls", cl.str());
}

INSTANTIATE_TEST_SUITE_P(
    Programs, Golden,
    testing::Values(Case{"fixed", "{mode: fixed}", "x", Dialect::kRs274},
                    Case{"point", "{mode: point, sense: outward, origin_mm: [0, 0, -10]}", "x",
                         Dialect::kGrbl},
                    Case{"line", "{mode: line, sense: outward, origin_mm: [0, 0, -15], t: [0, 1, 0]}", "y",
                         Dialect::kRs274},
                    Case{"circle",
                         "{mode: circle, sense: outward, origin_mm: [0, 0, -60], t: [1, 0, 0], n: [0, 0, 1], "
                         "circle_radius_mm: 40}",
                         "y", Dialect::kRs274}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace tiltfeed

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  for (int i = 1; i < argc; ++i)
    tiltfeed::approve = tiltfeed::approve || std::strcmp(argv[i], "--approve") == 0;
  return RUN_ALL_TESTS();
}
