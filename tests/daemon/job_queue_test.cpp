// The queue of the service: a job service with the simulated ring behind it, in one process. What ran is what
// the simulated machine executed, told by the Y of its feeds.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <fstream>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/service/job_service.h"
#include "tests/peers/served_jobs.h"
#include "tests/peers/tcp_ring.h"
#include "tests/shapes/wide_machine.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

using nlohmann::json;
using std::chrono::steady_clock;

constexpr int kShortJob = 8, kLongJob = 4000;  // feeds of 0.1 s; time runs four times as fast
constexpr auto kPatience = std::chrono::seconds(300);

class Queue : public testing::Test, protected ServedJobs {
 protected:
  Queue() : ServedJobs("queue", kPatience) { open(); }
  ~Queue() override {
    if (jobs_) leave();
  }

  using ServedJobs::ask;
  json ask(ApiOp op, std::uint64_t job, bool queue) {
    ApiRequest request;
    request.op = op;
    request.job = job;
    request.queue = queue;
    return ask(request);
  }
  /// A program whose feeds go to Y `job`, the number that it gets.
  void submit(int job, int feeds, const std::string& more = "") {
    std::string text = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93\n";
    for (int i = 0; i < feeds; ++i)
      text += "G1 X" + std::to_string(i % 2) + " Y" + std::to_string(job) + " Z50 A0 C0 F600\n";
    EXPECT_EQ(submit_text(text + more + "M2\n")["job"], job);
  }
  void submit_ready(int job, int feeds) {
    submit(job, feeds);
    until([&] { return state(job) == "ready"; });
  }
  using ServedJobs::open;
  void open() { open(wide_machine("wide"), "modbus-tcp:" + machine_.place); }
  int place(std::uint64_t job) { return ask(ApiOp::kShow, job).value("queue", 0); }
  bool moves(std::uint64_t job) { return ask(ApiOp::kShow, job).value("queue_moves", false); }
  /// Its run has come to its end, and that is not looked at yet.
  void wait_for_the_end() {
    for (const auto end = steady_clock::now() + kPatience; !jobs_->run_ended();) {
      ASSERT_LT(steady_clock::now(), end);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  /// Nothing starts: what would start by itself does so in a tick.
  void expect_rest() {
    for (int i = 0; i < 10; ++i) {
      jobs_->tick();
      ASSERT_FALSE(jobs_->busy());
    }
  }
  /// Job 1 runs; jobs 2 and 3 wait, short.
  void fill(int feeds = kLongJob) {
    submit_ready(1, feeds);
    submit_ready(2, kShortJob);
    submit_ready(3, kShortJob);
    ASSERT_TRUE(good(ask(ApiOp::kStart, 1)));
    ASSERT_TRUE(good(ask(ApiOp::kStart, 2, true)));
    ASSERT_TRUE(good(ask(ApiOp::kStart, 3, true)));
    until([&] { return !machine_.feeds().empty(); });
  }

  TcpRing machine_;
};

// (job_service.h, properties 1 and 4)
TEST_F(Queue, RunsEachJobOnceAndInTheOrderOfTheStarts) {
  for (const int job : {1, 2, 3, 4}) submit_ready(job, kShortJob);
  EXPECT_TRUE(good(ask(ApiOp::kStart, 2, true))) << "nothing is on the machine: it starts at once";
  EXPECT_EQ(state(2), "running");
  const json refused = ask(ApiOp::kStart, 4);
  EXPECT_FALSE(good(refused));
  EXPECT_NE(refused.value("error", "").find("tiltfeed start 4 --queue"), std::string::npos) << refused;
  for (const int job : {4, 1, 3}) EXPECT_TRUE(good(ask(ApiOp::kStart, job, true)));
  EXPECT_TRUE(good(ask(ApiOp::kStart, 4, true))) << "said twice";
  EXPECT_EQ(state(4), "queued");
  EXPECT_EQ(place(4), 1);
  EXPECT_EQ(place(1), 2);
  EXPECT_EQ(place(3), 3);
  EXPECT_TRUE(moves(4));
  until([&] { return state(3) == "done"; });
  std::vector<int> expected;
  for (const int job : {2, 4, 1, 3}) expected.insert(expected.end(), kShortJob, job);
  EXPECT_EQ(machine_.feeds(), expected);
  expect_rest();

  // A done job is a workpiece more; what comes after the last end waits for nothing but a word of its own.
  EXPECT_TRUE(good(ask(ApiOp::kStart, 1, true)));
  EXPECT_TRUE(good(ask(ApiOp::kStart, 2, true)));
  EXPECT_EQ(state(2), "queued");
  EXPECT_TRUE(good(ask(ApiOp::kStop, 2)));
  EXPECT_EQ(state(2), "done") << "as it was";
  until([&] { return state(1) == "done"; });
  expect_rest();
}

// (job_service.h, property 4)
TEST_F(Queue, StandsStillAfterAStopUntilAStart) {
  fill();
  ASSERT_TRUE(good(ask(ApiOp::kStop, 1)));
  until([&] { return state(1) == "stopped"; });
  expect_rest();
  EXPECT_EQ(state(2), "queued");
  EXPECT_FALSE(moves(2));
  submit_ready(4, kShortJob);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 4, true)));
  EXPECT_EQ(place(4), 3) << "behind those that wait";
  expect_rest();
  ASSERT_TRUE(good(ask(ApiOp::kStart, 3))) << "any of them";
  until([&] { return state(4) == "done"; });
  const std::vector<int> feeds = machine_.feeds();
  std::vector<int> expected;
  for (const int job : {3, 2, 4}) expected.insert(expected.end(), kShortJob, job);
  ASSERT_GT(feeds.size(), expected.size());
  EXPECT_EQ(std::vector<int>(feeds.end() - static_cast<long>(expected.size()), feeds.end()), expected);
}

// (job_service.h, property 4)
TEST_F(Queue, StandsStillWhenTheMachineIsLost) {
  fill();
  machine_.stop();
  until([&] { return !jobs_->busy(); });
  EXPECT_EQ(state(1), "interrupted");
  expect_rest();
  ASSERT_TRUE(good(ask(ApiOp::kStart, 2))) << "it finds no machine";
  until([&] { return !jobs_->busy(); });
  EXPECT_EQ(state(2), "ready");
  expect_rest();
  EXPECT_EQ(state(3), "queued");
}

// (service.h, property 5; job_service.h, properties 3 and 4)
TEST_F(Queue, IsKeptOverARestartAndNothingInItStarts) {
  constexpr int kFeeds = 80;
  fill(kFeeds);
  leave();
  open();
  EXPECT_EQ(state(1), "interrupted");
  EXPECT_EQ(place(2), 1);
  EXPECT_EQ(place(3), 2);
  expect_rest();
  ASSERT_TRUE(good(ask(ApiOp::kResume, 1)));
  until([&] { return state(1) == "done"; });
  expect_rest();  // a resume is no start
  EXPECT_EQ(state(2), "queued");
  ASSERT_TRUE(good(ask(ApiOp::kStart, 2)));
  until([&] { return state(3) == "done"; });
  std::vector<int> expected(kFeeds, 1);
  for (const int job : {2, 3}) expected.insert(expected.end(), kShortJob, job);
  EXPECT_EQ(machine_.feeds(), expected);
}

TEST_F(Queue, NothingStartsWhileTheServiceEnds) {
  for (const int job : {1, 2}) submit_ready(job, kShortJob);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 1)));
  ASSERT_TRUE(good(ask(ApiOp::kStart, 2, true)));
  wait_for_the_end();
  leave();  // job 1 was executed to its end
  open();
  EXPECT_EQ(state(2), "queued");
  expect_rest();
}

TEST_F(Queue, WaitsForTheCheckOfItsProgramAndStandsStillWhereThatFails) {
  submit_ready(1, kLongJob);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 1)));
  submit(2, kShortJob);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 2, true)));
  EXPECT_EQ(state(2), "received");
  EXPECT_EQ(place(2), 1);
  until([&] { return state(2) == "queued"; });
  EXPECT_TRUE(moves(2));
  submit(3, kShortJob, "G1 X!\n");
  ASSERT_TRUE(good(ask(ApiOp::kStart, 3, true)));
  until([&] { return state(3) == "failed"; });
  EXPECT_EQ(place(3), 0);
  EXPECT_EQ(place(2), 1);
  EXPECT_FALSE(moves(2));
}

TEST_F(Queue, TheMachineWaitsForTheNextAndForNoOther) {
  for (const int job : {1, 2}) submit_ready(job, kShortJob);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 1)));
  submit(3, kShortJob);  // no tick yet: nobody looks at it
  ASSERT_TRUE(good(ask(ApiOp::kStart, 3, true)));
  wait_for_the_end();
  jobs_->tick();
  ASSERT_EQ(state(1), "done");
  EXPECT_EQ(state(3), "received");
  EXPECT_TRUE(moves(3));
  const json refused = ask(ApiOp::kStart, 2);
  EXPECT_FALSE(good(refused));
  EXPECT_NE(refused.value("error", "").find("job 3 is the next"), std::string::npos) << refused;
  ASSERT_TRUE(good(ask(ApiOp::kStart, 2, true)));
  until([&] { return state(2) == "done"; });
  std::vector<int> expected;
  for (const int job : {1, 3, 2}) expected.insert(expected.end(), kShortJob, job);
  EXPECT_EQ(machine_.feeds(), expected);
}

TEST_F(Queue, StandsStillWhereTheNextIsTakenOut) {
  for (const int job : {1, 2}) submit_ready(job, kShortJob);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 1)));
  submit(3, kShortJob);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 3, true)));
  ASSERT_TRUE(good(ask(ApiOp::kStart, 2, true)));
  wait_for_the_end();
  jobs_->tick();
  ASSERT_EQ(state(1), "done");
  ASSERT_TRUE(good(ask(ApiOp::kStop, 3)));
  expect_rest();
  EXPECT_EQ(state(2), "queued");
}

TEST_F(Queue, ABadProgramStopsWhatComesAfterTheRun) {
  for (const int job : {1, 2}) submit_ready(job, kShortJob);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 1)));
  submit(3, kShortJob, "G1 X!\n");
  ASSERT_TRUE(good(ask(ApiOp::kStart, 2, true)));
  ASSERT_TRUE(good(ask(ApiOp::kStart, 3, true)));
  until([&] { return state(1) == "done"; });
  EXPECT_EQ(state(3), "failed");
  expect_rest();
  EXPECT_EQ(state(2), "queued");
}

TEST_F(Queue, AProgramThatWasChangedLeavesTheQueueWithItsError) {
  for (const int job : {1, 2, 3}) submit_ready(job, kShortJob);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 1)));
  ASSERT_TRUE(good(ask(ApiOp::kStart, 2, true)));
  ASSERT_TRUE(good(ask(ApiOp::kStart, 3, true)));
  std::ofstream(folder_.path + "/spool/jobs/2/program.nc", std::ios::app) << "G0\n";
  until([&] { return state(2) == "ready"; });
  EXPECT_NE(ask(ApiOp::kShow, 2).value("note", "").find("was changed"), std::string::npos);
  expect_rest();
  EXPECT_EQ(state(3), "queued");
  EXPECT_EQ(machine_.feeds(), std::vector<int>(kShortJob, 1));
}

TEST_F(Queue, StopAndRemoveTakeAJobOut) {
  fill();
  submit_ready(4, kShortJob);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 4, true)));
  ASSERT_TRUE(good(ask(ApiOp::kStop, 3)));
  EXPECT_EQ(state(3), "ready");
  ASSERT_TRUE(good(ask(ApiOp::kRemove, 2)));
  EXPECT_EQ(place(4), 1);
  EXPECT_TRUE(moves(4)) << "the run goes on, and so does what comes after it";
  EXPECT_FALSE(good(ask(ApiOp::kHold, 4))) << "not on the machine";
}

TEST_F(Queue, TakesNothingThatCannotBeStarted) {
  fill();
  ASSERT_TRUE(good(ask(ApiOp::kStop, 1)));
  until([&] { return state(1) == "stopped"; });
  EXPECT_FALSE(good(ask(ApiOp::kStart, 1, true)));
  EXPECT_FALSE(good(ask(ApiOp::kStart, 99, true)));
  EXPECT_EQ(place(1), 0);
}

TEST(Spool, OfAnEarlierVersionGetsAQueue) {
  const Folder folder("queue_old");
  sqlite3* old = nullptr;
  ASSERT_EQ(sqlite3_open((folder.path + "/jobs.db").c_str(), &old), SQLITE_OK);
  ASSERT_EQ(
      sqlite3_exec(
          old,
          "CREATE TABLE jobs (id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL, program INTEGER "
          "NOT NULL, state TEXT NOT NULL, note TEXT NOT NULL, total INTEGER NOT NULL, executed INTEGER "
          "NOT NULL, hash TEXT NOT NULL, user INTEGER NOT NULL, created INTEGER NOT NULL);"
          "INSERT INTO jobs VALUES (7, 'old', 1, 'ready', '', 5, 0, 'ab', 7, 9);",
          nullptr, nullptr, nullptr),
      SQLITE_OK);
  sqlite3_close(old);
  for (const std::uint64_t place : {0u, 3u}) {  // brought up to date once, and found so
    auto spool = Spool::open(folder.path);
    ASSERT_TRUE(spool) << spool.error().message;
    auto job = spool->find(7);
    ASSERT_TRUE(job) << job.error().message;
    EXPECT_EQ(job->name, "old");
    EXPECT_EQ(job->place, place);
    job->place = 3;
    ASSERT_TRUE(spool->update(*job));
    EXPECT_EQ(spool->queue()->size(), 1u);
  }
}

}  // namespace
}  // namespace tiltfeed
