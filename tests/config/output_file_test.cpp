// Files that appear whole or not at all, and which files a command may write.

#include "config/output_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <vector>

#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void put(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
  return names;
}

class OutputFiles : public testing::Test {
 protected:
  const Folder place{"output_file"};
  const fs::path folder = place.path;
  std::string path(const char* name) const { return (folder / name).string(); }
};

/// Killed at once, as by kill -9: nothing of the process cleans up.
void write_and_die(const std::string& path) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto file = OutputFile::open(path);
    file->stream() << "half";
    static_cast<void>(file->flush());
    ::kill(::getpid(), SIGKILL);
  }
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
}

TEST_F(OutputFiles, TheNextWriterRemovesWhatAKilledOneLeft) {
  write_and_die(path("a.nc"));
  write_and_die(path("a.nc"));
  write_and_die(path("b.nc"));
  put(path("a.nc.part-notes"), "mine");
  put(path("a.nc.part-0123456789abcdef.txt"), "mine");
  EXPECT_EQ(names_in(folder).size(), 4u) << "the second has removed what the first left";
  ASSERT_TRUE(write_file(path("a.nc"), "new"));
  const std::set<std::string> left = names_in(folder);
  EXPECT_EQ(left.size(), 4u) << "those of a.nc are gone, that of b.nc is not its business";
  EXPECT_TRUE(left.contains("a.nc") && left.contains("a.nc.part-notes"));
  EXPECT_TRUE(left.contains("a.nc.part-0123456789abcdef.txt"));
  ASSERT_TRUE(write_file(path("b.nc"), "new"));
  EXPECT_EQ(names_in(folder).size(), 4u);
}

TEST_F(OutputFiles, AWriterAtWorkKeepsItsFile) {
  auto first = OutputFile::open(path("a.nc"));
  ASSERT_TRUE(first);
  first->stream() << "first";
  ASSERT_TRUE(first->flush());
  const pid_t child = ::fork();  // another process writes the same file meanwhile
  if (child == 0) ::_exit(write_file(path("a.nc"), "second") ? 0 : 1);
  int status = 1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(text_of(path("a.nc")), "second");
  EXPECT_EQ(names_in(folder).size(), 2u);
  ASSERT_TRUE(first->commit());
  EXPECT_EQ(text_of(path("a.nc")), "first");
  EXPECT_EQ(names_in(folder), std::set<std::string>{"a.nc"});
}

/// Writers of one file, each process again and again: none loses its own to another's sweep.
TEST_F(OutputFiles, WritersOfOneFileAllEnd) {
  std::vector<pid_t> children;
  for (int i = 0; i < 4; ++i) {
    children.push_back(::fork());
    if (children.back() != 0) continue;
    for (int k = 0; k < 60; ++k)
      if (!write_file(path("a.nc"), "x")) ::_exit(1);
    ::_exit(0);
  }
  for (const pid_t child : children) {
    int status = 1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(names_in(folder), std::set<std::string>{"a.nc"});
}

TEST_F(OutputFiles, AppearWholeWhenCommitted) {
  put(path("a.nc"), "old");
  {
    auto file = OutputFile::open(path("a.nc"));
    ASSERT_TRUE(file) << file.error().message;
    file->stream() << std::string(1 << 20, 'x') << "end";
    ASSERT_TRUE(file->flush());
    ASSERT_TRUE(file->overwrite(2, "ABC"));
    EXPECT_EQ(text_of(path("a.nc")), "old");
    EXPECT_EQ(names_in(folder).size(), 2u);
    ASSERT_TRUE(file->commit());
  }
  std::string wanted = std::string(1 << 20, 'x') + "end";
  wanted.replace(2, 3, "ABC");
  EXPECT_EQ(text_of(path("a.nc")), wanted);
  EXPECT_EQ(names_in(folder), std::set<std::string>{"a.nc"});
}

TEST_F(OutputFiles, LeaveNothingWhenNot) {
  put(path("a.nc"), "old");
  {
    auto file = OutputFile::open(path("a.nc"));
    ASSERT_TRUE(file);
    file->stream() << "new";
  }
  EXPECT_EQ(text_of(path("a.nc")), "old");
  EXPECT_EQ(names_in(folder), std::set<std::string>{"a.nc"});
}

TEST_F(OutputFiles, HaveNamesBesideThatNobodyForesees) {
  std::set<std::string> seen;
  for (int i = 0; i < 4; ++i) {
    auto file = OutputFile::open(path("a.nc"));
    ASSERT_TRUE(file);
    for (const std::string& name : names_in(folder)) seen.insert(name);
  }
  EXPECT_EQ(seen.size(), 4u);
  for (const std::string& name : seen)
    EXPECT_EQ(name.find(std::to_string(getpid())), std::string::npos) << name;
  // A name as long as names may be.
  const std::string longest(255, 'n');
  EXPECT_TRUE(write_file((folder / longest).string(), "x"));
  EXPECT_EQ(names_in(folder), std::set<std::string>{longest});
}

/// A limit of the file's size makes write fail as a full disk does, with another reason.
TEST_F(OutputFiles, SayWhyTheyCannotBeWrittenAndKeepTheOldOne) {
  put(path("a.nc"), "old");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto written = write_file(path("a.nc"), std::string(1 << 20, 'x'));
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, Code::kIo);
  EXPECT_NE(written.error().message.find("a.nc"), std::string::npos);
  EXPECT_NE(written.error().message.find("File too large"), std::string::npos) << written.error().message;
  EXPECT_EQ(text_of(path("a.nc")), "old");
  EXPECT_EQ(names_in(folder), std::set<std::string>{"a.nc"});
}

TEST_F(OutputFiles, ReplaceNothingButARegularFile) {
  put(path("part.stl"), "solid");
  fs::create_symlink("part.stl", path("link.nc"));
  fs::create_symlink("nothing", path("dangling.nc"));
  fs::create_directory(path("folder.nc"));
  ASSERT_EQ(::mkfifo(path("fifo.nc").c_str(), 0600), 0);
  for (const std::string& name : {path("link.nc"), path("dangling.nc"), path("folder.nc"), path("fifo.nc"),
                                  std::string("/dev/null"), std::string("/dev/full"), path("folder.nc/")}) {
    const auto file = OutputFile::open(name);
    ASSERT_FALSE(file) << name;
    EXPECT_EQ(file.error().code, Code::kUsage) << name;
    EXPECT_FALSE(check_outputs({{"--out", name}}, {})) << name;
  }
  EXPECT_FALSE(OutputFile::open(path("no/such/a.nc")));
  EXPECT_FALSE(OutputFile::open(path("part.stl/a.nc")));
  EXPECT_EQ(text_of(path("part.stl")), "solid");
}

TEST_F(OutputFiles, AreNoInputAndNoOtherOutputByWhateverPath) {
  put(path("part.stl"), "solid");
  fs::create_symlink("part.stl", path("link.stl"));
  fs::create_hard_link(path("part.stl"), path("hard.stl"));
  fs::create_directory(path("sub"));
  fs::create_directory_symlink("sub", path("sub2"));
  const auto refused = [&](const char* out, const std::vector<NamedFile>& others,
                           const std::vector<NamedFile>& inputs) {
    std::vector<NamedFile> outputs = others;
    outputs.push_back({"--out", path(out)});
    const auto checked = check_outputs(outputs, inputs);
    return !checked && checked.error().code == Code::kUsage &&
           checked.error().message.find("also") != std::string::npos;
  };
  EXPECT_TRUE(refused("part.stl", {}, {{"part.stl", path("part.stl")}}));
  EXPECT_TRUE(refused("./sub/../part.stl", {}, {{"part.stl", path("part.stl")}}));
  EXPECT_TRUE(refused("hard.stl", {}, {{"part.stl", path("part.stl")}}));
  EXPECT_TRUE(refused("part.stl", {}, {{"part.stl", path("link.stl")}}));
  EXPECT_TRUE(refused("a.nc", {{"--cl", path("a.nc")}}, {}));
  EXPECT_TRUE(refused("sub/a.nc", {{"--cl", path("sub2/a.nc")}}, {}));
  EXPECT_TRUE(check_outputs({{"--out", path("a.nc")}, {"--cl", path("a.cls")}, {"--map", ""}},
                            {{"JOB", path("part.stl")}, {"--stl", ""}}));
  EXPECT_FALSE(check_outputs({{"--out", "-"}, {"--cl", "-"}}, {}));
  EXPECT_TRUE(check_outputs({{"--out", "-"}}, {}));
}

TEST_F(OutputFiles, AreTheSameByNamesFromTheFolderThatOneStandsIn) {
  const fs::path before = fs::current_path();
  fs::create_directory(path("sub"));
  fs::current_path(path("sub"));
  for (const std::string& name :
       {std::string("./a.nc"), std::string("../sub/a.nc"), std::string(".//a.nc"), path("sub/a.nc")})
    EXPECT_FALSE(check_outputs({{"--out", "a.nc"}, {"--cl", name}}, {})) << name;
  EXPECT_TRUE(check_outputs({{"--out", "a.nc"}, {"--cl", "../a.nc"}}, {}));
  fs::current_path(before);
}

TEST_F(OutputFiles, DoNotFollowALinkThatAppearsMeanwhile) {
  put(path("part.stl"), "solid");
  auto file = OutputFile::open(path("a.nc"));
  ASSERT_TRUE(file);
  file->stream() << "program";
  fs::create_symlink("part.stl", path("a.nc"));
  EXPECT_FALSE(file->commit());
  EXPECT_EQ(text_of(path("part.stl")), "solid");
}

}  // namespace
}  // namespace tiltfeed
