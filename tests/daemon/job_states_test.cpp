// What a damaged table and a full disk may not change: a job service with the simulated machine behind it, in
// one process. What is waited for are states that last.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/service/job_service.h"
#include "sim/wire/endpoint.h"
#include "tests/peers/served_jobs.h"
#include "tests/shapes/wide_machine.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

using nlohmann::json;

class JobStates : public testing::Test, protected ServedJobs {
 protected:
  JobStates() : ServedJobs("jobs_states", std::chrono::seconds(120)) {
    EXPECT_EQ(::pipe(stop_), 0);
    std::promise<std::string> where;
    std::future<std::string> known = where.get_future();
    machine_ = std::thread([this, promise = std::move(where)]() mutable {
      sim::ModbusController ring(wide_machine(), {}, {}, [this](const sim::TraceRow&) { ++executed_; });
      sim::EndpointOptions options;
      options.stop_fd = stop_[0];
      options.speed = 4.0;
      options.ready = [&](const std::string& text) { promise.set_value(text); };
      EXPECT_TRUE(sim::serve_modbus_tcp(ring, "127.0.0.1", 0, options));
    });
    place_ = known.get();
    open();
  }
  ~JobStates() override {
    if (jobs_) leave();
    EXPECT_EQ(::write(stop_[1], "x", 1), 1);
    machine_.join();
    ::close(stop_[0]);
    ::close(stop_[1]);
  }

  using ServedJobs::open;
  void open() { open(wide_machine("wide"), "modbus-tcp:" + place_); }
  void submit_ready(std::uint64_t job, int feeds) {
    std::string text = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93\n";
    for (int i = 0; i < feeds; ++i) text += "G1 X" + std::to_string(i % 2) + " F600\n";
    EXPECT_EQ(submit_text(text + "G94\nM2\n")["job"], job);
    until([&] { return state(job) == "ready"; });
  }
  std::string note(std::uint64_t job) { return field(job, "note"); }

  int stop_[2] = {-1, -1};
  std::atomic<std::size_t> executed_{0};
  std::thread machine_;
  std::string place_;
};

TEST_F(JobStates, OneBadByte_OfAPoisonedTableIsHealedAtStart) {
  submit_ready(1, 4);
  leave();
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder_.path + "/spool/jobs.db").c_str(), &db), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(db, "UPDATE jobs SET note = CAST(X'6FEB' AS TEXT)", nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(db);
  open();
  EXPECT_EQ(note(1), "o?");
  EXPECT_TRUE(good(ask(ApiOp::kList)));
  leave();
  ASSERT_EQ(sqlite3_open((folder_.path + "/spool/jobs.db").c_str(), &db), SQLITE_OK);
  std::string kept;
  sqlite3_exec(
      db, "SELECT note FROM jobs",
      [](void* to, int, char** values, char**) { return *static_cast<std::string*>(to) = values[0], 0; },
      &kept, nullptr);
  sqlite3_close(db);
  EXPECT_EQ(kept, "o?");
}

TEST_F(JobStates, StopBeforeARingIsFoundAgain_EndsWhatItStillHas) {
  submit_ready(1, 4000);
  EXPECT_TRUE(good(ask(ApiOp::kStart, 1)));
  until([&] { return ask(ApiOp::kShow, 1).value("executed", 0) > 3; });
  leave();
  open();
  ASSERT_EQ(state(1), "interrupted") << note(1);
  const int before = ask(ApiOp::kShow, 1).at("executed");
  ASSERT_GT(before, 3);
  // At once, so that the order overtakes the first word of the controller.
  EXPECT_TRUE(good(ask(ApiOp::kResume, 1)));
  EXPECT_TRUE(good(ask(ApiOp::kStop)));
  until([&] { return state(1) != "running"; });
  EXPECT_EQ(state(1), "stopped") << note(1);
  EXPECT_EQ(note(1).find("nothing was sent"), std::string::npos) << note(1);
  EXPECT_GE(ask(ApiOp::kShow, 1).at("executed"), before);
  const std::size_t executed = executed_;
  // The ring has forgotten the run: the next job gets the machine, and nothing of the first moves any more.
  submit_ready(2, 4);
  EXPECT_TRUE(good(ask(ApiOp::kStart, 2)));
  until([&] { return state(2) != "running"; });
  EXPECT_EQ(state(2), "done") << note(2);
  EXPECT_EQ(executed_, executed + 6) << "G0, four feeds, M2";
}

// (job_service.h, property 2)
TEST_F(JobStates, AFullDisk_ShowsTheTrueStateAtOnce) {
  submit_ready(1, 20000);
  ASSERT_TRUE(good(ask(ApiOp::kStart, 1)));
  until([&] { return executed_ > 3; });
  // From now on no file grows.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  until([&] { return !jobs_->busy(); });
  jobs_->tick();
  const std::string shown = state(1), why = note(1);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, old);
  EXPECT_NE(shown, "running") << why;
  EXPECT_NE(why.find("not in the spool yet"), std::string::npos) << why;
  // There is room again: it is written, and true after a restart.
  jobs_->tick();
  EXPECT_EQ(note(1).find("not in the spool yet"), std::string::npos) << "now it is: " << note(1);
  leave();
  open();
  EXPECT_EQ(state(1), shown) << note(1);
}

}  // namespace
}  // namespace tiltfeed
