// The file of a plan's progress: over what it may be written, and what the service reads from it.

#include "daemon/command/progress_line.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "daemon/service/planner.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace daemon;
namespace {

TEST(PlanStage, IsWrittenOverNothingElse) {
  const Folder folder("stage_file");
  const std::string part = folder.path + "/part.stl", fresh = folder.path + "/fresh",
                    link = folder.path + "/link";
  std::ofstream(part) << "solid part";
  std::filesystem::create_symlink(part, link);
  EXPECT_FALSE(open_progress(part, {}));
  EXPECT_FALSE(open_progress(link, {}));
  EXPECT_FALSE(open_progress(fresh, {{"--out", fresh}}));
  EXPECT_FALSE(open_progress(folder.path, {}));
  EXPECT_FALSE(std::filesystem::exists(fresh));
  std::string text;
  std::getline(std::ifstream(part), text);
  EXPECT_EQ(text, "solid part");
  for (const double share : {0.1, 1.0}) {  // one's own of before
    const Result<int> file = open_progress(fresh, {});
    ASSERT_TRUE(file) << file.error().message;
    ProgressLine(*file).show("read", share);
  }
}

TEST(PlanStage, IsReadFromWhatThePlannerWrites) {
  const Folder folder("stage");
  EXPECT_FALSE(stage_of(folder.path)) << "not known yet";
  {
    ProgressLine line(*open_progress(folder.path + "/plan.progress", {}));
    line.show("clearance surface", 0.0);
    auto at = stage_of(folder.path);
    ASSERT_TRUE(at);
    EXPECT_EQ(at->stage, "clearance surface");
    EXPECT_EQ(at->percent, 0);
    line.show("a longer stage, far longer than a line of the file, far longer than a line of the file", 0.42);
    at = stage_of(folder.path);
    ASSERT_TRUE(at);
    EXPECT_EQ(at->percent, 42);
    line.show("links", 1.0);
    at = stage_of(folder.path);
    ASSERT_TRUE(at);
    EXPECT_EQ(at->stage, "links");
    EXPECT_EQ(at->percent, 100);
  }
  for (const char* text : {"", "x", "101 links\n", "5\n"}) {
    folder.write("plan.progress", text);
    EXPECT_FALSE(stage_of(folder.path)) << text;
  }
}

}  // namespace
}  // namespace tiltfeed
