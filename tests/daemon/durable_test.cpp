// Spool and journal over the real file layer, SQLite's included, on a disk that keeps only what was synced,
// and that fails at any call: no job and no record is lost, doubled or understated.

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "daemon/service/spool_backup.h"
#include "tests/peers/forgetful_disk.h"
#include "tests/peers/spool_lives.h"
#include "tests/samples.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

namespace fs = std::filesystem;

// As many as a release is held to, or a part of them in the developer's loop.
#ifdef TILTFEED_POWER_LOSSES
constexpr int kLosses = TILTFEED_POWER_LOSSES;
#else
constexpr int kLosses = 200;
#endif

/// Beneath a file system in memory where there is one: what the real disk does takes time and matters to
/// nobody. Empty at first: a process that was killed leaves its folder, and a later one has its number.
struct Place {
  Place() {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Place() { fs::remove_all(path); }
  const std::string path = std::string(::access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp") +
                           "/tiltfeed_durable_" + std::to_string(::getpid());
};

class Durable : public testing::Test {
 protected:
  Durable() { fs::create_directory(root_); }
  void anew() {
    fs::remove_all(root_);
    fs::create_directory(root_);
  }
  /// What is left, judged on a copy: the next life finds it as it is.
  void look(SpoolLives& lives) {
    const std::string copy = folder_.path + "/copy";
    fs::remove_all(copy);
    fs::create_directory(copy);
    if (fs::exists(spool_)) fs::copy(spool_, copy, fs::copy_options::recursive);
    lives.look(copy);
  }

  const Place folder_;
  const std::string root_ = folder_.path + "/disk", spool_ = root_ + "/state/mill";
};

TEST_F(Durable, C16AJobThatWasTakenIsThereAfterAPowerLoss) {
  ForgetfulDisk disk(root_);
  SpoolLives lives(spool_, 1);
  for (int i = 0; i < 5; ++i) {
    lives.live(8);
    disk.lose_power(nullptr);
    lives.reboot();
    look(lives);
    ASSERT_EQ(lives.wrong(), "");
  }
  EXPECT_GT(lives.submissions(), 3u);
  EXPECT_GT(lives.runs(), 3u);
}

TEST_F(Durable, C16ABackupIsThereAfterAPowerLoss) {
  ForgetfulDisk disk(root_);
  SpoolLives lives(spool_, 2);
  lives.story();
  const std::string copy = root_ + "/away/copies/monday";
  const Result<std::uint64_t> jobs = back_up(spool_, copy);
  ASSERT_TRUE(jobs) << jobs.error().message;
  disk.lose_power(nullptr);
  const Result<Spool> kept = Spool::open(copy);
  ASSERT_TRUE(kept) << kept.error().message;
  const auto rows = kept->list();
  ASSERT_TRUE(rows) << rows.error().message;
  EXPECT_EQ(rows->size(), *jobs);
  for (const SpooledJob& job : *rows) EXPECT_TRUE(fs::exists(kept->file(job.id, "program.nc"))) << job.id;
}

/// The first layout, as the first service wrote it.
constexpr const char* kFirst =
    "PRAGMA journal_mode=WAL;"
    "CREATE TABLE jobs (id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL, program INTEGER NOT NULL, "
    "state TEXT NOT NULL, note TEXT NOT NULL, total INTEGER NOT NULL, executed INTEGER NOT NULL, hash TEXT "
    "NOT NULL, user INTEGER NOT NULL, created INTEGER NOT NULL);"
    "INSERT INTO jobs VALUES (3, 'old', 1, 'uncertain', 'cut off', 70, 60, 'ab', 1000, 1700000000);";

TEST_F(Durable, C19AnOldTableSurvivesThePowerLossOfItsMigration) {
  std::mt19937_64 random(19);
  int lost = 0;
  for (bool through = false; !through; ++lost) {
    anew();
    fs::create_directories(spool_ + "/jobs/3");
    std::ofstream(spool_ + "/jobs/3/program.nc") << "G0X0\n";
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open((spool_ + "/jobs.db").c_str(), &db), SQLITE_OK);
    ASSERT_EQ(sqlite3_exec(db, kFirst, nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
    ForgetfulDisk disk(root_);
    disk.begin({lost + 1, lost % 2 == 0 ? EIO : ENOSPC, true, lost % 3 == 0});
    static_cast<void>(Spool::open(spool_));
    const std::string failed = disk.failed();
    through = failed.empty();
    disk.rest();
    disk.lose_power(&random);
    const auto spool = Spool::open(spool_);
    ASSERT_TRUE(spool) << "at call " << lost + 1 << ", " << failed << ": " << spool.error().message;
    const auto jobs = *spool->list();
    ASSERT_EQ(jobs.size(), 1u) << failed;
    EXPECT_EQ(jobs[0].name, "old");
    EXPECT_EQ(jobs[0].state, JobState::kUncertain);
    EXPECT_EQ(jobs[0].executed, 60u);
    EXPECT_EQ(file_text(spool->file(3, "program.nc")), "G0X0\n");
  }
  EXPECT_GT(lost, 20);
  std::printf("%d power losses of a migration: 0 lost\n", lost);
}

TEST_F(Durable, C16PowerLostAtAnyCall) {
  std::mt19937_64 random(20261123);
  int losses = 0, whole = 0;
  std::uint64_t submissions = 0, runs = 0, calls = 0;
  while (losses < kLosses) {
    anew();
    ForgetfulDisk disk(root_);
    SpoolLives lives(spool_, random());
    for (int life = 0; life < 40 && losses < kLosses; ++life, ++losses) {
      const int at = 1 + static_cast<int>(random() % (random() % 2 == 0 ? 60 : 250));
      disk.begin({at, EIO, true, false});
      lives.live(3);
      const std::string failed = disk.failed();
      if (failed.empty()) ++whole;
      calls += static_cast<std::uint64_t>(std::min(disk.calls(), at));
      disk.rest();
      disk.lose_power(&random);
      lives.reboot();
      look(lives);
      ASSERT_EQ(lives.wrong(), "") << "after loss " << losses << ", at call " << at << " of life " << life
                                   << ": " << failed;
    }
    submissions += lives.submissions(), runs += lives.runs();
  }
  std::printf(
      "%d power losses (%d after the last call of a life), %llu calls, %llu submissions, %llu runs: 0 lost, "
      "doubled or understated\n",
      losses, whole, static_cast<unsigned long long>(calls), static_cast<unsigned long long>(submissions),
      static_cast<unsigned long long>(runs));
}

TEST_F(Durable, C16EveryCallFails) {
  struct Way {
    const char* name;
    int error;
    bool after, part;
  };
  std::mt19937_64 random(18);
  constexpr int kWays = 4, kStep = kWays / samples(kWays);  // over 1: each call fails in one way, in turn
  int turn = 0;
  for (const Way way : {Way{"EIO once", EIO, false, false},
                        {"EIO from then on", EIO, true, false},
                        {"ENOSPC once", ENOSPC, false, false},
                        {"ENOSPC from then on, after half a write", ENOSPC, true, true}}) {
    int call = 1 + turn++ % kStep, points = 0;
    for (bool through = false; !through; call += kStep, ++points) {
      anew();
      ForgetfulDisk disk(root_);
      SpoolLives lives(spool_, 3);
      disk.begin({call, way.error, way.after, way.part});
      lives.story();
      const std::string failed = disk.failed();
      through = failed.empty();
      disk.rest();
      look(lives);
      ASSERT_EQ(lives.wrong(), "") << way.name << " at call " << call << ": " << failed;
      disk.lose_power(&random);
      lives.reboot();
      look(lives);
      ASSERT_EQ(lives.wrong(), "") << "power lost after " << way.name << " at call " << call << ": "
                                   << failed;
    }
    std::printf("%s: %d calls failed, one after the other: 0 lost, doubled or understated\n", way.name,
                points - 1);
    EXPECT_GT(points, samples(200)) << way.name;
  }
}

/// A spool on a disk of which every byte is used, or every one of its user's.
class FullDisk : public Durable, public testing::WithParamInterface<int> {
 protected:
  static Spool open(const std::string& folder) {
    Result<Spool> spool = Spool::open(folder);
    if (!spool) throw std::runtime_error(spool.error().message);
    if (const Result<void> ended = spool->end_lost_runs(); !ended)
      throw std::runtime_error(ended.error().message);
    return std::move(*spool);
  }
  static std::uint64_t add(Spool& spool, std::size_t bytes) {
    SpooledJob job;
    job.name = "a";
    job.program = true;
    job.id = spool.begin(job).value();
    std::ofstream(spool.file(job.id, "program.nc")) << std::string(bytes, 'G');
    job.state = JobState::kReady;
    if (const Result<void> done = spool.finish(job); !done) throw std::runtime_error(done.error().message);
    return job.id;
  }
  static void begin_run(Spool& spool, std::uint64_t job) {
    RunReport run;
    run.job = job;
    run.name = "a";
    spool.begin_run(run).value();
  }
  static std::vector<RunReport> runs(const Spool& spool) { return spool.runs(0, 0, 100).value(); }
};

/// The service can be started there, so that somebody can make room.
TEST_P(FullDisk, AServiceThatWasStoppedOpensItsSpool) {
  ForgetfulDisk disk(root_);
  std::uint64_t job = 0;
  {
    Spool spool = open(spool_);
    job = add(spool, 100000);
    begin_run(spool, job);
  }
  disk.fill(GetParam());
  {
    Spool spool = open(spool_);
    EXPECT_EQ(runs(spool).at(0).outcome, "unknown") << "nobody writes its end";
    spool.save_remembered();
    EXPECT_EQ(runs(spool).at(0).outcome, "unknown");
    EXPECT_TRUE(spool.remove(job)) << "its files give the room";
    EXPECT_TRUE(spool.list().value().empty());
    spool.save_remembered();
  }
  disk.rest();
  EXPECT_EQ(runs(open(spool_)).at(0).outcome, "unknown");
}

/// One who hands in too large a program uses up the disk: the part that came is gone with the refusal.
TEST_P(FullDisk, AJobWhoseFilesUsedItUpIsRemoved) {
  ForgetfulDisk disk(root_);
  Spool spool = open(spool_);
  const std::uint64_t first = add(spool, 100), second = add(spool, 1 << 20);
  disk.fill(GetParam());
  EXPECT_FALSE(spool.begin({})) << "no room";
  ASSERT_TRUE(spool.remove(second));
  ASSERT_EQ(spool.list().value().size(), 1u);
  EXPECT_EQ(spool.list().value()[0].id, first);
  EXPECT_FALSE(fs::exists(spool.folder_of(second)));
  EXPECT_TRUE(spool.begin({})) << "there is room again";
}

/// Files that are smaller than what the table needs: the job is no longer told as ready.
TEST_P(FullDisk, AJobWithoutItsFilesIsNotReady) {
  ForgetfulDisk disk(root_);
  Spool spool = open(spool_);
  const std::uint64_t job = add(spool, 100);
  disk.fill(GetParam());
  const Result<void> removed = spool.remove(job);
  ASSERT_FALSE(removed);
  EXPECT_NE(removed.error().message.find("make room"), std::string::npos) << removed.error().message;
  EXPECT_EQ(spool.find(job)->state, JobState::kFailed);
  EXPECT_EQ(spool.find(job)->note, "was to be removed; its files are gone");
  disk.rest();
  spool.save_remembered();
  EXPECT_TRUE(spool.remove(job));
  EXPECT_FALSE(spool.find(job));
}

/// What waits for room is told as it is, and ends no later run.
TEST_P(FullDisk, TheHistoryTellsEndsThatWaitForRoom) {
  ForgetfulDisk disk(root_);
  Spool spool = open(spool_);
  const std::uint64_t job = add(spool, 100);
  begin_run(spool, job);
  disk.fill(GetParam());
  RunReport end;
  end.job = job;
  end.executed = 7;
  end.outcome = "stopped";
  spool.end_run(end);
  EXPECT_EQ(runs(spool).at(0).outcome, "stopped");
  EXPECT_EQ(runs(spool).at(0).executed, 7u);
  RunReport next;
  next.job = job;
  EXPECT_FALSE(spool.begin_run(next));
  disk.rest();
  EXPECT_TRUE(spool.begin_run(next));
  ASSERT_EQ(runs(spool).size(), 2u);
  EXPECT_EQ(runs(spool)[0].outcome, "stopped");
  EXPECT_EQ(runs(spool)[1].outcome, "") << "this one goes on";
}

INSTANTIATE_TEST_SUITE_P(Of, FullDisk, testing::Values(ENOSPC, EDQUOT),
                         [](const auto& param) { return param.param == ENOSPC ? "TheMachine" : "ItsUser"; });

}  // namespace
}  // namespace tiltfeed
