// Spool and journal over the real file layer, as a power loss would leave it: the content of a file and the
// names of a folder are there as of their last sync, and nothing else is. fsync and fdatasync are this test's
// own.

#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <iterator>
#include <map>

#include "daemon/journal/job_run.h"
#include "daemon/service/spool.h"
#include "tests/peers/journal_subject.h"
#include "tests/peers/spool_add.h"
#include "tests/texts/folder.h"

namespace {

struct Disk {
  std::map<ino_t, std::string> content;                 // of files, as of their last sync
  std::map<ino_t, std::map<std::string, ino_t>> names;  // of folders, likewise
} disk;

/// Syncs, counted from 1, those of children too; which one fails, 0: none.
struct Count {
  int syncs = 0, fails_at = 0;
};
Count& count = *static_cast<Count*>(
    ::mmap(nullptr, sizeof(Count), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));

ino_t inode(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 ? status.st_ino : 0;
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// SQLite sees to its own failures, and what it syncs is not counted on.
bool is_ours(const void* caller) {
  Dl_info info{};
  return ::dladdr(caller, &info) == 0 ||
         std::string_view(info.dli_fname).find("sqlite") == std::string_view::npos;
}

int next_sync(int fd, const char* real) {
  return reinterpret_cast<int (*)(int)>(::dlsym(RTLD_NEXT, real))(fd);
}

int sync_to_disk(int fd, const char* real, const void* caller) {
  if (!is_ours(caller)) return next_sync(fd, real);
  if (++count.syncs == count.fails_at) {
    errno = EIO;
    return -1;
  }
  const std::string path = std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(fd)).string();
  if (std::filesystem::is_directory(path)) {
    auto& names = disk.names[inode(path)];
    names.clear();
    for (const auto& entry : std::filesystem::directory_iterator(path))
      names[entry.path().filename().string()] = inode(entry.path().string());
  } else {
    disk.content[inode(path)] = bytes_of(path);
  }
  return next_sync(fd, real);
}

}  // namespace

extern "C" int fsync(int fd) { return sync_to_disk(fd, "fsync", __builtin_return_address(0)); }
extern "C" int fdatasync(int fd) { return sync_to_disk(fd, "fdatasync", __builtin_return_address(0)); }

namespace tiltfeed {
namespace {

class Durable : public testing::Test {
 protected:
  Durable() {
    disk = {};
    count = {};
  }
  /// What a power loss leaves of a file beneath the folder; nothing when a name on the way is lost.
  std::optional<std::string> left(const std::string& path) const {
    ino_t at = inode(folder_.path);
    for (const auto& name : std::filesystem::path(path)) {
      const auto found = disk.names[at].find(name.string());
      if (found == disk.names[at].end()) return std::nullopt;
      at = found->second;
    }
    return disk.content[at];
  }
  Result<std::uint64_t> submit(const std::string& spool) const {
    Result<Spool> opened = Spool::open(spool);
    if (!opened) return tl::unexpected<Error>(opened.error());
    const int fd = ::open(folder_.write("program.nc", kProgram).c_str(), O_RDONLY);
    SpooledJob job;
    job.program = true;
    job.state = JobState::kReady;
    const Result<std::uint64_t> id = add_job(*opened, job, {fd});
    ::close(fd);
    return id;
  }
  static constexpr const char* kProgram = "G21\nG1 X1 F600\nM2\n";
  const Folder folder_{"durable"};
};

TEST_F(Durable, C16AJobThatWasTakenIsThereAfterAPowerLoss) {
  ASSERT_TRUE(submit(folder_.path));
  EXPECT_EQ(left("jobs/1/program.nc"), kProgram);
}

TEST_F(Durable, C16WhatLeavesIsReservedAfterAPowerLossAtAnyMoment) {
  const RunSubject now = subject_of(20000);
  RunSubject rebooted = now;
  rebooted.host[3] = 9;
  ASSERT_TRUE(begin_journal(folder_.path + "/journal", now));
  ASSERT_TRUE(left("journal"));
  EXPECT_EQ(decide_resume(read_journal(*left("journal")), rebooted).way, ResumeWay::kFresh);
  Journal journal = *Journal::open(*journal_file(folder_.path + "/journal"));
  RunRecorder recorder = *RunRecorder::begin(journal, now);
  SendState state;
  state.total = now.total;
  state.boot = 5;
  for (std::uint64_t offered = 0; offered < now.total;) {
    ASSERT_TRUE(recorder.progress(state, Time{0}));
    offered = *recorder.reserve(offered + 1, Time{0});
    state.executed = state.acknowledged = offered / 2;
    ASSERT_TRUE(left("journal"));
    const ResumeDecision d = decide_resume(read_journal(*left("journal")), rebooted);
    ASSERT_GE(d.may_have, offered);
    ASSERT_LE(d.executed, state.executed);
  }
  state.executed = state.acknowledged = now.total;
  ASSERT_TRUE(recorder.end(RunEvent::kExecuted, state));
  EXPECT_EQ(decide_resume(read_journal(*left("journal")), rebooted).way, ResumeWay::kFinished);
}

TEST_F(Durable, C16ASyncThatFailsIsNeverSaidToBeDone) {
  int points = 0;
  for (bool done = false; !done; ++points) {
    ASSERT_LT(points, 500);
    const std::string spool = folder_.path + "/" + std::to_string(points);
    std::filesystem::create_directory(spool);
    disk = {};
    count = {};
    count.fails_at = points + 1;
    const RunSubject now = subject_of(3000);
    const auto run = [&]() -> bool {
      if (!submit(spool) || !begin_journal(spool + "/journal", now)) return false;
      auto file = journal_file(spool + "/journal");
      if (!file) return false;
      Journal journal = *Journal::open(*file);
      auto recorder = RunRecorder::begin(journal, now);
      if (!recorder) return false;
      for (std::uint64_t offered = 0; offered < now.total;) {
        const auto upto = recorder->reserve(offered + 1, Time{0});
        if (!upto) return false;
        offered = *upto;
      }
      return bool(recorder->end(RunEvent::kStopped, {}));
    };
    done = run();
    EXPECT_EQ(done, count.syncs < count.fails_at) << "sync " << count.fails_at;
  }
  EXPECT_GT(points, 10);
}

}  // namespace
}  // namespace tiltfeed
