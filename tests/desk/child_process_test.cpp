#include "desk/work/child_process.h"

#include <gtest/gtest.h>
#include <poll.h>

#include <filesystem>

#include "desk/work/scratch_folder.h"

namespace tiltfeed::desk {
namespace {

ChildEnd wait_for(ChildProcess& child) {
  pollfd look{child.descriptor(), POLLIN, 0};
  while (::poll(&look, 1, -1) >= 0 && !child.listen()) {
  }
  return child.end();
}

ChildEnd shell(const std::string& script) {
  Result<ChildProcess> child = ChildProcess::start({"/bin/sh", "-c", script});
  EXPECT_TRUE(child);
  return wait_for(*child);
}

TEST(ChildProcess, tells_status_and_both_outputs) {
  const ChildEnd end = shell("echo one; echo two >&2; exit 3");
  EXPECT_EQ(end.status, 3);
  EXPECT_EQ(end.text, "one\ntwo\n");
  EXPECT_EQ(shell("kill -9 $$").status, -9);
}

TEST(ChildProcess, keeps_the_last_of_much) {
  const ChildEnd end = shell("i=0; while [ $i -lt 20000 ]; do echo line $i; i=$((i+1)); done");
  EXPECT_EQ(end.text.size(), ChildProcess::kKept);
  EXPECT_EQ(end.text.substr(end.text.size() - 11), "line 19999\n");
}

TEST(ChildProcess, gets_no_descriptor_of_ours_and_no_input) {
  EXPECT_EQ(shell("ls /proc/self/fd | wc -l; cat").text, "4\n") << "0, 1, 2 and the folder that ls reads";
}

TEST(ChildProcess, can_be_interrupted) {
  Result<ChildProcess> child =
      ChildProcess::start({"/bin/sh", "-c", "trap 'exit 7' INT; echo ready; while :; do sleep 0.01; done"});
  ASSERT_TRUE(child);
  pollfd look{child->descriptor(), POLLIN, 0};
  ASSERT_EQ(::poll(&look, 1, -1), 1);  // the trap is set
  child->interrupt();
  EXPECT_EQ(wait_for(*child).status, 7);
}

TEST(ChildProcess, dies_with_its_owner) {
  pollfd look{};
  {
    Result<ChildProcess> child = ChildProcess::start({"/bin/sleep", "1000000"});
    ASSERT_TRUE(child);
    look = {child->descriptor(), POLLIN, 0};
    EXPECT_EQ(::poll(&look, 1, 0), 0);
  }  // does not wait for the sleep
}

TEST(ChildProcess, says_where_a_program_belongs_that_is_not_there) {
  Result<ChildProcess> child = ChildProcess::start({"/nowhere/program"});
  ASSERT_TRUE(child);
  const ChildEnd end = wait_for(*child);
  EXPECT_EQ(end.status, 127);
  EXPECT_NE(end.text.find("install both"), std::string::npos);
}

TEST(ScratchFolder, is_ours_alone_and_goes_with_what_is_in_it) {
  std::string path;
  {
    Result<ScratchFolder> folder = ScratchFolder::make();
    ASSERT_TRUE(folder);
    path = folder->path();
    EXPECT_EQ(std::filesystem::status(path).permissions(), std::filesystem::perms::owner_all);
    std::filesystem::create_directories(path + "/a/b");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace tiltfeed::desk
