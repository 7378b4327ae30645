// LineReader text, to the last byte, against files in golden/: any change of it is seen and judged. The same
// on any number of threads; none at all when it is cancelled. `golden_test --approve` writes the files anew.

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "config/job.h"
#include "config/output_file.h"
#include "daemon/post/block.h"
#include "kinematics/cl_text/cl_file.h"
#include "kinematics/joints/joint_path.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/plan/plan.h"
#include "tests/texts/folder.h"
#include "tests/texts/posted.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
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
  job.machine.format = usual_format(c.dialect);
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

/// A CL file of another CAM system, posted in every dialect.
TEST(DialectGolden, EveryDialect) {
  const AptProgram program = foreign();
  EXPECT_TRUE(program.notes.empty());
  for (const auto& [dialect, tcp] : dialect_cases()) {
    PostOptions options;
    options.setup.part_zero = {30, -10, 50};
    options.data.number = 42;
    const auto text = program_text(program, machine(dialect, tcp), options);
    ASSERT_TRUE(text) << text.error().message;
    expect_golden(std::string("dialect_") + name_of(dialect).name + (tcp ? "_tcp" : "") + ".nc", *text);
  }
}

TEST(DialectGolden, TiltedPlanes) {
  std::ifstream in(SOURCE_DIR "/tests/golden/planes.cls");
  const auto program = read_apt(in, "planes.cls", {});
  ASSERT_TRUE(program) << program.error().message;
  EXPECT_TRUE(program->notes.empty());
  for (const DialectName& one : kDialects) {
    if (!has_tilted_planes(one.dialect)) continue;
    const bool table = plane_follows_table(one.dialect);
    MachineProfile profile = machine(one.dialect, false, table ? "linuxcnc-trunnion-ac" : "generic-ac");
    profile.format.tilted_planes = true;
    PostOptions options;
    options.setup.part_zero = {0, 0, table ? 5.0 : 50.0};
    options.data.number = 42;
    const auto text = program_text(*program, profile, options);
    ASSERT_TRUE(text) << text.error().message;
    expect_golden(std::string("planes_") + one.name + ".nc", *text);
  }
}

/// A winding path long enough to be worked on in many parts, with moves past the pole now and then.
ToolPath long_path() {
  ToolPath path;
  path.name = "long";
  path.tool = {6, 3, 100};
  path.cut_feed = Feed::from_mm_per_min(1500);
  path.plunge_feed = Feed::from_mm_per_min(400);
  for (int i = 0; i < 20'000; ++i) {
    const double azimuth = 0.003 * i + (i / 900 % 2 == 0 ? 0.0 : 2.8), tilt = 0.5 + 0.4 * std::sin(0.004 * i);
    const Vec3 axis = normalized(
        Vec3{std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt)});
    const MoveKind kind = i % 900 < 2 ? MoveKind::kRapid : (i % 900 < 5 ? MoveKind::kPlunge : MoveKind::kCut);
    path.moves.push_back({{Point<Part>{0, 0, 0.001 * i} + axis * 30.0, axis}, kind, kNoFacet});
  }
  return path;
}

/// Joints and text made with so many threads, whether there are so many processors or not.
std::pair<JointPath, std::string> made_with(int threads, const ToolPath& path, const Job& job) {
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, threads);
  tbb::task_arena arena(threads);
  return arena.execute([&] {
    const auto joints = to_joints(path, job.machine.model, job.setup, {});
    std::ostringstream program;
    if (!joints || !write_program(*joints, job, program)) return std::pair{JointPath{}, std::string{}};
    return std::pair{*joints, program.str()};
  });
}

/// N words count every line once, in order, and no motion or axis word is said again, wherever one piece of
/// the text may end and the next begin.
void expect_no_seams(const std::string& text) {
  std::istringstream lines(text);
  std::map<char, std::string> said;
  int number = 0;
  for (std::string line, word; std::getline(lines, line);) {
    if (line.front() == '(') continue;
    if (line.find(" G0 ") != std::string::npos)
      said.erase('G');  // the way to the first block says it each time
    std::istringstream words(line);
    words >> word;
    ASSERT_EQ(word, "N" + std::to_string(++number));
    while (words >> word) {
      const char letter = word.front();
      if (letter == 'F' || letter == 'M' || letter == 'S' || (letter == 'G' && word.size() > 2)) continue;
      ASSERT_NE(said[letter], word) << line;
      said[letter] = word;
    }
  }
  EXPECT_GT(number, 20'000);
}

// (block.h, property 5)
TEST(Program, IsTheSameOnAnyNumberOfThreads) {
  const ToolPath path = long_path();
  Job job = job_for("{mode: fixed}", "x");
  job.machine.format.line_numbers = true;
  const auto [joints, text] = made_with(1, path, job);
  ASSERT_GT(joints.moves.size(), path.moves.size());
  for (const int threads : {2, 5}) {
    const auto [others, other_text] = made_with(threads, path, job);
    ASSERT_EQ(others.moves.size(), joints.moves.size());
    for (std::size_t i = 0; i < joints.moves.size(); ++i) {
      ASSERT_EQ(others.moves[i].joints, joints.moves[i].joints) << "block " << i;
      ASSERT_EQ(others.moves[i].seconds, joints.moves[i].seconds) << "block " << i;
      ASSERT_EQ(others.moves[i].move, joints.moves[i].move) << "block " << i;
    }
    EXPECT_EQ(others.report.seconds, joints.report.seconds);
    EXPECT_EQ(others.report.max_tip_deviation, joints.report.max_tip_deviation);
    EXPECT_EQ(others.report.subdivided_moves, joints.report.subdivided_moves);
    EXPECT_EQ(other_text, text);
  }
  expect_no_seams(text);
}

TEST(Program, CancelledItLeavesNoFile) {
  const ToolPath path = long_path();
  const Job job = job_for("{mode: fixed}", "x");
  // Asked `calls` times, then told to stop.
  int asked = 0;
  double last = 0.0;
  const auto until = [&](int calls) {
    asked = 0;
    last = 0.0;
    return [&asked, &last, calls](double fraction) {
      EXPECT_GE(fraction, last);
      EXPECT_LE(fraction, 1.0);
      last = fraction;
      return ++asked < calls;
    };
  };
  for (const int calls : {1, 3}) {
    const auto stopped = to_joints(path, job.machine.model, job.setup, {}, until(calls));
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, Code::kCancelled);
    EXPECT_EQ(asked, calls) << "it went on after it was told to stop";
  }
  const auto joints = to_joints(path, job.machine.model, job.setup, {}, until(1'000'000));
  ASSERT_TRUE(joints) << joints.error().message;

  const Folder folder("cancelled");
  const std::string file = folder.path + "/long.nc";
  for (const int calls : {1, 3}) {
    auto out = OutputFile::open(file);
    ASSERT_TRUE(out) << out.error().message;
    const auto stopped = write_program(*joints, job, out->stream(), until(calls));
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, Code::kCancelled);
    EXPECT_EQ(asked, calls) << "it went on after it was told to stop";
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path));
  {
    auto out = OutputFile::open(file);
    ASSERT_TRUE(out && write_program(*joints, job, out->stream(), until(1'000'000)) && out->commit());
    EXPECT_EQ(last, 1.0);
  }
  EXPECT_TRUE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace tiltfeed

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  for (int i = 1; i < argc; ++i)
    tiltfeed::approve = tiltfeed::approve || std::strcmp(argv[i], "--approve") == 0;
  return RUN_ALL_TESTS();
}
