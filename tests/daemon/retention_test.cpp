// What of the past goes: the choice against brute force, the jobs of a service, its history.

#include "daemon/service/retention.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <ctime>
#include <random>
#include <set>

#include "tests/peers/served_jobs.h"
#include "tests/peers/tcp_ring.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

TEST(Outdated, IsWhatTheLimitsSayForAnyJobs) {
  std::mt19937 random(22);
  const auto draw = [&](int most) { return std::uniform_int_distribution<int>(0, most)(random); };
  int by_age = 0, by_size = 0;
  for (int round = 0; round < 2000; ++round) {
    std::vector<KeptJob> jobs;
    const std::int64_t now = 2000 * kDay;
    for (int i = draw(12); i > 0; --i) {
      KeptJob job;
      job.id = static_cast<std::uint64_t>(i);
      job.ended = draw(3) > 0;
      job.since = now - draw(60) * kDay;
      job.bytes = static_cast<std::uint64_t>(draw(3)) << 20;
      jobs.push_back(job);
    }
    Retention limits;
    limits.days = draw(1) * draw(60);
    limits.mib = draw(1) * draw(20);
    std::set<std::uint64_t> gone;
    for (const Outdated& one : outdated(jobs, limits, now)) {
      EXPECT_TRUE(gone.insert(one.id).second);
      ++(one.by_age ? by_age : by_size);
    }
    std::uint64_t left = 0;
    for (const KeptJob& job : jobs) left += gone.contains(job.id) ? 0 : job.bytes;
    const std::uint64_t most = static_cast<std::uint64_t>(limits.mib) << 20;
    for (const KeptJob& job : jobs) {
      const bool old = limits.days > 0 && now - job.since > limits.days * kDay, goes = gone.contains(job.id);
      if (!job.ended) {
        EXPECT_FALSE(goes);
      }
      if (job.ended && old) {
        EXPECT_TRUE(goes);
      }
      if (goes && !old) {
        EXPECT_GT(limits.mib, 0);
        for (const KeptJob& other : jobs)
          if (other.ended && other.since < job.since) {
            EXPECT_TRUE(gone.contains(other.id));
          }
      }
      if (job.ended && !goes && limits.mib > 0) {
        EXPECT_LE(left, most) << "there was more to remove";
      }
    }
    // As few as that: with the last one that went for its size the files were too many.
    const auto all = outdated(jobs, limits, now);
    if (!all.empty() && !all.back().by_age)
      for (const KeptJob& job : jobs)
        if (job.id == all.back().id) {
          EXPECT_GT(left + job.bytes, most);
        }
  }
  EXPECT_GT(by_age, 1000);
  EXPECT_GT(by_size, 1000);
}

class Kept : public testing::Test, protected ServedJobs {
 protected:
  Kept() : ServedJobs("retention", std::chrono::seconds(300)) {}
  ~Kept() override {
    if (jobs_) leave();
  }
  void open() { ServedJobs::open(wide_machine("wide"), "modbus-tcp:" + machine_.place); }
  void sql(const std::string& text) const {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open((folder_.path + "/spool/jobs.db").c_str(), &db), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(db, text.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
  }
  std::uint64_t submit(int feeds = 3, std::size_t bytes = 0) {
    std::string padding;
    while (padding.size() < bytes) padding += "(" + std::string(60, 'x') + ")\n";
    return submit_moves(feeds, 600, padding);
  }
  std::set<std::uint64_t> listed() {
    std::set<std::uint64_t> jobs;
    const nlohmann::json answer = ask(ApiOp::kList);
    for (const auto& job : answer.at("jobs")) jobs.insert(job.at("job").get<std::uint64_t>());
    return jobs;
  }
  static std::string days_ago(int days) { return std::to_string(std::time(nullptr) - days * kDay); }
  TcpRing machine_;
};

TEST_F(Kept, OldJobsThatEndedGoWithTheirFilesAndNoOthers) {
  open();
  for (int i = 0; i < 7; ++i) submit();
  leave();
  sql("UPDATE jobs SET created = " + days_ago(40) +
      ";"
      "UPDATE jobs SET state = 'done' WHERE id IN (1, 2, 7); UPDATE jobs SET state = 'uncertain' WHERE id = "
      "4;"
      "UPDATE jobs SET state = 'stopped' WHERE id = 5; UPDATE jobs SET state = 'failed' WHERE id = 6;"
      "UPDATE jobs SET created = " +
      days_ago(20) + " WHERE id = 2; UPDATE jobs SET place = 1 WHERE id = 7;");
  const std::string run =
      "INSERT INTO runs (job, name, hash, link, began, ended, first, blocks, executed, outcome) VALUES (";
  const std::string rest = ", 1, 9, 9, 'done');";
  // Of a job that is there, long ago and lately; of jobs that are gone, long ago and lately.
  sql(run + "1, 'a', '', '', 0, " + days_ago(39) + rest + run + "5, 'b', '', '', 0, " + days_ago(3) + rest +
      run + "90, 'c', '', '', 0, " + days_ago(39) + rest + run + "91, 'd', '', '', 0, " + days_ago(3) + rest);
  open();
  for (int i = 0; i < 20; ++i) jobs_->tick();
  EXPECT_EQ(listed().size(), 7u) << "without limits all is kept";
  leave();
  retention_ = {30, 0, 30};
  open();
  until([&] { return listed() == std::set<std::uint64_t>{2, 3, 4, 5, 7}; });
  for (int i = 0; i < 20; ++i) jobs_->tick();
  EXPECT_EQ(listed(), (std::set<std::uint64_t>{2, 3, 4, 5, 7}));
  for (const int id : {1, 6})
    EXPECT_FALSE(std::filesystem::exists(folder_.path + "/spool/jobs/" + std::to_string(id)));
  const nlohmann::json runs = ask(ApiOp::kHistory).at("runs");
  ASSERT_EQ(runs.size(), 3u) << runs.dump(1);
  EXPECT_EQ(runs[0].at("name"), "a") << "it stayed while its job was there";
  EXPECT_EQ(runs[1].at("name"), "b");
  EXPECT_EQ(runs[2].at("name"), "d");
}

TEST_F(Kept, FilesAreBroughtDownToTheLimitButNeverDuringARun) {
  open();
  for (int i = 0; i < 4; ++i) submit(3, 800 << 10);
  const std::uint64_t slow = submit(4000);
  leave();
  sql("UPDATE jobs SET state = 'done' WHERE id < 5; UPDATE jobs SET created = " + days_ago(9) +
      " WHERE id = 3;"
      "UPDATE jobs SET created = " +
      days_ago(5) + " WHERE id = 1;");
  open();
  EXPECT_TRUE(good(ask(ApiOp::kStart, slow)));
  until([&] { return ask(ApiOp::kShow, slow).value("executed", 0) > 3; });
  EXPECT_FALSE(jobs_->reload(config(wide_machine("wide"), "modbus-tcp:127.0.0.1:9")))
      << "another could take the machine of the run";
  retention_.mib = 2;
  ASSERT_TRUE(jobs_->reload(config(wide_machine("wide"), "modbus-tcp:" + machine_.place)));
  for (int i = 0; i < 50; ++i) jobs_->tick();
  EXPECT_EQ(listed().size(), 5u) << "a run goes on";
  EXPECT_TRUE(good(ask(ApiOp::kStop)));
  until([&] { return state(slow) == "stopped"; });
  until([&] { return listed() == std::set<std::uint64_t>{2, 4, slow}; });
  for (int i = 0; i < 20; ++i) jobs_->tick();
  EXPECT_EQ(listed(), (std::set<std::uint64_t>{2, 4, slow}));
}

}  // namespace
}  // namespace tiltfeed
