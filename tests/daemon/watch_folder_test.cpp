// Programs that somebody moves into the watch folder: none is lost, none comes twice, nothing else is
// touched.

#include <dirent.h>
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>

#include "tests/peers/served_jobs.h"
#include "tests/shapes/wide_machine.h"

namespace {

/// The disk of the watched folder has gone: from the second name on it cannot be read.
std::atomic<bool> lost{false};
std::atomic<int> names{0};

template <class Entry>
Entry* read_name(const char* function, DIR* folder) {
  Entry* const entry = reinterpret_cast<Entry* (*)(DIR*)>(::dlsym(RTLD_NEXT, function))(folder);
  const bool named = entry != nullptr && entry->d_name[0] != '.';
  return lost && named && ++names > 1 ? (errno = EIO, nullptr) : entry;
}

}  // namespace

extern "C" {
dirent* readdir(DIR* folder) { return read_name<dirent>("readdir", folder); }
dirent64* readdir64(DIR* folder) { return read_name<dirent64>("readdir64", folder); }
}

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

namespace fs = std::filesystem;
constexpr const char* kProgram = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM2\n";

class Watched : public testing::Test, protected ServedJobs {
 protected:
  Watched() : ServedJobs("watched", std::chrono::seconds(300)) {
    watch_ = folder_.path + "/in";
    fs::create_directory(watch_);
    open(wide_machine("wide"), "grbl:" + folder_.path + "/absent");
  }
  ~Watched() override {
    lost = false;
    leave();
  }
  std::string put(const std::string& name, const std::string& text = kProgram) {
    const std::string whole = folder_.write("whole.tmp", text);
    fs::rename(whole, watch_ + "/" + name);
    return watch_ + "/" + name;
  }
  std::size_t jobs() { return ask(ApiOp::kList).at("jobs").size(); }
  static std::size_t descriptors() {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), {}));
  }
};

TEST_F(Watched, AProgramIsTakenOnceAndThenRemoved) {
  const std::string path = put("part.nc");
  until([&] { return !fs::exists(path); });
  until([&] { return state(1) == "ready"; });
  EXPECT_EQ(field(1, "name"), "part");
  EXPECT_EQ(file_text(folder_.path + "/spool/jobs/1/program.nc"), kProgram);
  put("part.nc");  // of the same name, as often as it is put there
  until([&] { return jobs() == 2 && state(2) == "ready"; });
}

TEST_F(Watched, WhatIsNotTakenStaysUntilItChanges) {
  const std::string path = put("part.nc", "");
  ASSERT_EQ(::truncate(path.c_str(), static_cast<off_t>(kMaxProgramBytes) + 1), 0);
  const std::string next = put("quit.nc");
  until([&] { return !fs::exists(next); });
  EXPECT_TRUE(fs::exists(path)) << "the only copy of a program is gone";
  ASSERT_EQ(jobs(), 1u);
  put("part.nc");
  until([&] { return !fs::exists(path); });
  until([&] { return jobs() == 2; });
}

TEST_F(Watched, ManyTakeFewDescriptors) {
  constexpr std::size_t kMany = 100, kFew = 10;
  for (std::size_t i = 0; i < kMany; ++i) put("part" + std::to_string(i) + ".nc");
  const std::size_t before = descriptors();
  std::size_t most = 0;
  until([&] { return most = std::max(most, descriptors()), jobs() == kMany && fs::is_empty(watch_); });
  EXPECT_LE(most, before + kFew) << "none would be left for who comes with an order";
}

TEST_F(Watched, OnlyProgramsAreTouched) {
  ASSERT_EQ(::mkfifo((watch_ + "/a.nc").c_str(), 0600), 0);
  fs::create_directory(watch_ + "/b.nc");
  fs::create_symlink(folder_.write("elsewhere.nc", kProgram), watch_ + "/c.nc");
  put("d.ngc");
  const std::string last = put("e.nc");
  until([&] { return !fs::exists(last); });
  EXPECT_EQ(jobs(), 1u);
  for (const char* const name : {"a.nc", "b.nc", "c.nc", "d.ngc"})
    EXPECT_TRUE(fs::symlink_status(watch_ + "/" + name).type() != fs::file_type::not_found) << name;
}

TEST_F(Watched, AFolderThatCannotBeReadAnyMoreIsNoEnd) {
  for (const char* const name : {"a.txt", "b.txt", "c.txt"}) put(name);
  names = 0;
  lost = true;
  until([] { return names > 2; });
  EXPECT_TRUE(good(ask(ApiOp::kList)));
  lost = false;
  const std::string path = put("part.nc");
  until([&] { return !fs::exists(path); });
}

}  // namespace
}  // namespace tiltfeed
