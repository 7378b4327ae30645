// The record of runs: what is counted while one goes on, what the spool keeps of it, what the service says.

#include <gtest/gtest.h>

#include <ctime>
#include <nlohmann/json.hpp>

#include "tests/peers/served_jobs.h"
#include "tests/peers/tcp_ring.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

using nlohmann::json;

SendState state_of_run(Phase phase, const std::string& machine = "Run", int feed = 0) {
  SendState state;
  state.phase = phase;
  state.machine = machine;
  state.feed_override = feed;
  return state;
}

TEST(RunTally, CountsHoldsTheirTimeAndTheSlowestAnswer) {
  RunTally tally;
  EXPECT_FALSE(tally.slowest_hold());
  tally.take(state_of_run(Phase::kRun), 10.0);
  tally.ask_hold(11.0);
  tally.take(state_of_run(Phase::kHold, "Run"), 11.1);  // sent, not yet obeyed
  EXPECT_FALSE(tally.slowest_hold());
  tally.take(state_of_run(Phase::kHold, "Hold:1"), 11.4);
  tally.take(state_of_run(Phase::kHold, "Hold:0"), 13.0);
  tally.ask_hold(13.5);  // it holds already
  tally.take(state_of_run(Phase::kRun), 14.1);
  EXPECT_EQ(tally.holds(), 1);
  EXPECT_DOUBLE_EQ(tally.held_seconds(), 3.0);
  EXPECT_NEAR(*tally.slowest_hold(), 0.4, 1e-12);
  // At the machine: nobody waits for an answer.
  tally.take(state_of_run(Phase::kHold, "Hold:0"), 20.0);
  tally.take(state_of_run(Phase::kDrain), 21.0);
  EXPECT_EQ(tally.holds(), 2);
  EXPECT_DOUBLE_EQ(tally.held_seconds(), 4.0);
  EXPECT_NEAR(*tally.slowest_hold(), 0.4, 1e-12);
  tally.ask_hold(22.0);
  tally.take(state_of_run(Phase::kHold, "Hold:0"), 22.1);
  EXPECT_NEAR(*tally.slowest_hold(), 0.4, 1e-12);
}

TEST(RunTally, TellsTheOverridesThatBlocksRanAt) {
  RunTally tally;
  tally.take(state_of_run(Phase::kConnect, "Idle", 50), 0.0);
  EXPECT_FALSE(tally.feed_override());
  for (const int percent : {100, 0, 80, 120, 110}) tally.take(state_of_run(Phase::kRun, "Run", percent), 1.0);
  tally.take(state_of_run(Phase::kHold, "Hold:0", 10), 2.0);
  ASSERT_TRUE(tally.feed_override());
  EXPECT_EQ(tally.feed_override()->least, 80);
  EXPECT_EQ(tally.feed_override()->most, 120);
}

TEST(RunTally, TellsHowLongTheControllerHadNothingToDo) {
  RunTally tally;
  const auto take = [&](std::optional<bool> starved, double now) {
    SendState state = state_of_run(Phase::kRun);
    state.starved = starved;
    tally.take(state, now);
  };
  take({}, 1.0);
  EXPECT_FALSE(tally.starved_seconds()) << "the link does not tell";
  take(false, 2.0);
  EXPECT_EQ(tally.starved_seconds(), 0.0);
  take(true, 3.0);
  take(true, 3.5);
  EXPECT_DOUBLE_EQ(*tally.starved_seconds(), 0.5) << "the time that lasts still is in it";
  take(false, 4.0);
  take(false, 9.0);
  take(true, 10.0);
  take({}, 10.25);
  take({}, 20.0);
  EXPECT_DOUBLE_EQ(*tally.starved_seconds(), 1.25);
}

class History : public testing::Test, protected ServedJobs {
 protected:
  History() : ServedJobs("history", std::chrono::seconds(300)) {}
  ~History() override {
    if (jobs_) leave();
  }
  void open() { ServedJobs::open(wide_machine("wide"), "modbus-tcp:" + machine_.place); }
  json runs(std::uint64_t job = 0, std::optional<std::uint64_t> after = {}) {
    return ask(ApiOp::kHistory, job, after).at("runs");
  }
  std::uint64_t submit(int feeds) { return submit_moves(feeds, feeds > 100 ? 600 : 6000); }
  void start_by(std::uint64_t job, std::uint32_t user) {
    ApiRequest request;
    request.op = ApiOp::kStart;
    request.job = job;
    EXPECT_TRUE(good(json::parse(answer_of(*jobs_, request, user))));
  }
  TcpRing machine_;
};

TEST_F(History, EveryRunIsOnRecordWithWhoWhatAndHowItEnded) {
  open();
  EXPECT_EQ(runs().size(), 0u);
  const auto before = std::time(nullptr);
  const std::uint64_t quick = submit(8), slow = submit(4000);
  for (int workpiece = 0; workpiece < 2; ++workpiece) {
    start_by(quick, 1001);
    until([&] { return state(quick) == "done"; });
  }
  start_by(slow, 1002);
  until([&] { return ask(ApiOp::kShow, slow).value("executed", 0) > 3; });
  EXPECT_EQ(runs(slow).at(0).at("outcome"), "running");
  EXPECT_TRUE(runs(slow).at(0).at("ended").is_null());
  EXPECT_TRUE(good(ask(ApiOp::kHold)));
  until([&] { return field(slow, "phase") == "hold" && field(slow, "machine").starts_with("Hold"); });
  EXPECT_TRUE(good(ask(ApiOp::kResume)));
  until([&] { return field(slow, "phase") == "run"; });
  EXPECT_TRUE(good(ask(ApiOp::kStop)));
  until([&] { return state(slow) == "stopped"; });

  const json all = runs();
  ASSERT_EQ(all.size(), 3u);
  for (const json& run : all) {
    EXPECT_EQ(run.at("sha256"), ask(ApiOp::kShow, run.at("job")).at("sha256"));
    EXPECT_GE(run.at("began"), before);
    EXPECT_GE(run.at("ended"), run.at("began"));
    EXPECT_LE(run.at("ended"), std::time(nullptr));
    EXPECT_EQ(run.at("first_block"), 1);
  }
  for (const int i : {0, 1}) {
    EXPECT_EQ(all[i].at("job"), quick);
    EXPECT_EQ(all[i].at("user"), 1001);
    EXPECT_EQ(all[i].at("outcome"), "done");
    EXPECT_EQ(all[i].at("executed"), all[i].at("blocks"));
    EXPECT_EQ(all[i].at("holds"), 0);
    EXPECT_TRUE(all[i].at("slowest_hold_seconds").is_null());
    EXPECT_GE(all[i].at("starved_seconds"), 0.0);
  }
  EXPECT_EQ(all[2].at("user"), 1002);
  EXPECT_EQ(all[2].at("outcome"), "stopped");
  EXPECT_GE(all[2].at("holds"), 1);
  EXPECT_GE(all[2].at("slowest_hold_seconds"), 0.0);
  EXPECT_LT(all[2].at("executed"), all[2].at("blocks"));
  EXPECT_EQ(all[2].at("executed"), ask(ApiOp::kShow, slow).at("executed"));

  EXPECT_EQ(runs(0, 2).size(), 1u);
  EXPECT_EQ(runs(quick).size(), 2u);
  EXPECT_TRUE(good(ask(ApiOp::kRemove, quick)));
  EXPECT_EQ(runs(quick).size(), 2u) << "the history outlives its job";
  leave();
  open();
  EXPECT_EQ(runs(), all);
}

TEST_F(History, ARunWhoseEndNobodySawSaysSo) {
  const std::string spool = folder_.path + "/spool";
  {
    auto table = Spool::open(spool);
    ASSERT_TRUE(table);
    RunReport run;
    run.job = 7;
    run.name = "of a service that was killed";
    run.blocks = 90;
    ASSERT_TRUE(table->begin_run(run));
  }
  open();
  const json all = runs();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].at("outcome"), "unknown");
  for (const char* const key : {"user", "ended", "sent", "seconds", "holds", "starved_seconds"})
    EXPECT_TRUE(all[0].at(key).is_null());
}

TEST_F(History, AJobThatIsCutOffEndsItsRunAsTheJournalDecides) {
  open();
  const std::uint64_t job = submit(4000);
  start_by(job, 1001);
  until([&] { return ask(ApiOp::kShow, job).value("executed", 0) > 3; });
  leave();  // held, the wire let go of: the next service finds it interrupted
  open();
  const json all = runs(job);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].at("outcome"), state(job));
  EXPECT_EQ(state(job), "interrupted");
  EXPECT_TRUE(good(ask(ApiOp::kResume, job)));
  until([&] { return runs(job).size() == 2; });
  EXPECT_GT(runs(job).at(1).at("first_block"), 1);
  EXPECT_TRUE(good(ask(ApiOp::kStop)));
  until([&] { return state(job) != "running"; });
}

}  // namespace
}  // namespace tiltfeed
