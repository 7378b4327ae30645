// tiltfeed-cad as a child: what it says, how it ends, and that nothing of that ends who started it.

#include "config/cad_process.h"

#include <gtest/gtest.h>

#include "pathgen/part_file/cad_stream.h"
#include "tests/texts/folder.h"

namespace tiltfeed::config {
namespace {

/// A shell in its place.
Result<pathgen::PartModel> run_shell(const std::string& script, int wall_seconds = 600,
                                     const pathgen::ReportShare& report = {}) {
  return run_cad_program({"/bin/sh", "-c", script}, "part.step", report, wall_seconds);
}

void expect_end(const Result<pathgen::PartModel>& read, Code code, const std::string& piece) {
  ASSERT_FALSE(read) << "accepted; expected: " << piece;
  EXPECT_EQ(read.error().code, code) << read.error().message;
  EXPECT_NE(read.error().message.find(piece), std::string::npos)
      << read.error().message << "\nlacks: " << piece;
}

TEST(CadProcess, HowItEnds) {
  expect_end(run_shell("echo 'tiltfeed-cad: part.step: #12 ADVANCED_FACE gives no shape' >&2; exit 1"),
             Code::kInput, "part.step: #12 ADVANCED_FACE gives no shape");
  expect_end(
      run_shell(
          "printf 'failed inside OpenCASCADE while making shapes of part.step, after #7 EDGE_CURVE' >&2; "
          "kill -SEGV $$"),
      Code::kInput,
      "ended by signal 11: it failed inside OpenCASCADE while making shapes of part.step, after #7 "
      "EDGE_CURVE");
  expect_end(run_shell("kill -KILL $$"), Code::kLimit, "more memory or processor time than it may have");
  expect_end(run_shell("kill -TERM $$"), Code::kInput, "it was told to end: start again");
  expect_end(run_shell("exit 3"), Code::kInput, "ended with status 3");
  expect_end(run_shell("exit 0"), Code::kInput, "is cut short");
  expect_end(run_shell("printf 'TFCAD 1\\nrubbish, and more of it'"), Code::kInput, "wrong check sum");
  expect_end(run_cad_program({"/no/such/program"}, "part.step", {}, 600), Code::kIo,
             "No such file or directory");
}

TEST(CadProcess, ItIsStoppedAfterItsTimeAndWhenTheUserWants) {
  expect_end(run_shell("exec sleep 3600", 0), Code::kLimit, "was stopped after 0 s");
  expect_end(run_shell("exec sleep 3600", 600, [](double) { return false; }), Code::kCancelled, "cancelled");
}

TEST(CadProcess, ManyWordsAndALongStreamDoNotBlockIt) {
  pathgen::PartModel model;
  model.format = "STEP", model.bodies = {{"part", "part", true}}, model.faces.resize(1);
  pathgen::FaceFacets face;
  for (int i = 0; i < 100'000; ++i) {
    const double x = i % 1000, y = i / 1000;
    for (const Vec3 d : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}) {
      face.corners.push_back({x + d.x, y + d.y, 0.0});
      face.normals.push_back({0, 0, 1});
    }
    const auto first = static_cast<std::uint32_t>(3 * i);
    face.facets.push_back({first, first + 1, first + 2});
  }
  const Folder folder("cad_process");
  const std::string stream = folder.write("stream", pathgen::cad_stream(model, {face}));
  const auto read = run_shell(
      "i=0; while [ $i -lt 3000 ]; do echo 'a line of words that nobody asked for, number' $i >&2; "
      "i=$((i+1)); done; cat " +
      stream);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.facets.size(), 100'000u);
}

}  // namespace
}  // namespace tiltfeed::config
