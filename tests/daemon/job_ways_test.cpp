// Every state of a job has a way to every sensible next one: one walk over all of them, on every link that
// the simulated machine offers. What is waited for are states that last.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <future>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "daemon/service/job_service.h"
#include "sim/wire/endpoint.h"
#include "tests/peers/drive_wire.h"
#include "tests/peers/served_jobs.h"
#include "tests/shapes/wide_machine.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

using nlohmann::json;

constexpr int kLong = 50000, kShort = 4;  // feeds of 0.1 s
constexpr double kSpeed = 40.0;           // of time

class JobWays : public testing::TestWithParam<const char*>, protected ServedJobs {
 protected:
  explicit JobWays(double speed = kSpeed)
      : ServedJobs(std::string(speed == kSpeed ? "job_ways_" : "job_changes_") + GetParam(),
                   std::chrono::seconds(240)),
        speed_(speed) {
    EXPECT_EQ(::pipe(stop_), 0);
    begin_machine();
    open();
  }
  ~JobWays() override {
    if (jobs_) leave();
    end_machine();
    ::close(stop_[0]);
    ::close(stop_[1]);
  }

  void begin_machine() {
    known_ = {};
    machine_ = std::thread([this] { serve(); });
    place_ = known_.get_future().get();
  }
  void end_machine() {
    char byte = 'x';
    EXPECT_EQ(::write(stop_[1], &byte, 1), 1);
    machine_.join();
    EXPECT_EQ(::read(stop_[0], &byte, 1), 1);
  }
  /// A control that is fed has no order from its wire: its operator resets it, and presses start.
  void at_the_control() {
    if (!drip()) return;
    end_machine();
    begin_machine();
  }
  void serve() {
    const std::string link = GetParam(), path = folder_.path + "/wire";
    sim::EndpointOptions options;
    options.stop_fd = stop_[0];
    options.speed = speed_;
    options.ready = [&](const std::string& text) {
      known_.set_value(link.ends_with("-tcp") || link.ends_with("-ws") ? text : path);
    };
    const sim::Motion::Sink sink = [this](const sim::TraceRow& row) {
      ++executed_;
      const std::lock_guard lock(cut_mutex_);
      if (row.command.op == sim::Op::kFeed && row.command.inverse_time) cut_.push_back(row.command.target.x);
    };
    if (link == "grbl" || link == "grbl-ws") {
      sim::GrblController grbl(wide_machine(), {}, {}, sink);
      EXPECT_TRUE(link == "grbl" ? sim::serve_pty(grbl, path, options)
                                 : sim::serve_ws(grbl, "127.0.0.1:0", options));
    } else if (link == "reprap") {
      sim::RepRapController marlin(wide_machine(), {}, {}, sink);
      EXPECT_TRUE(sim::serve_pty(marlin, path, options));
    } else if (link == "dnc") {
      sim::DripController control(wide_machine(), {}, {}, sink);
      EXPECT_TRUE(sim::serve_pty(control, path, options));
    } else if (drive()) {
      sim::DriveController axis(wide_machine(), {}, sink);
      DriveWire(axis, link.ends_with("-tcp"), speed_).serve(path, stop_[0], options.ready);
    } else {
      sim::ModbusOptions map;
      map.watchdog = 60.0;  // a busy computer is late with its heartbeats; that is another test's
      sim::ModbusController ring(wide_machine(), {}, map, sink);
      EXPECT_TRUE(link == "modbus-tcp" ? sim::serve_modbus_tcp(ring, "127.0.0.1", 0, options)
                                       : sim::serve_modbus_rtu(ring, path, options));
    }
  }
  bool ring() const { return std::string(GetParam()).starts_with("modbus"); }

  bool drive() const { return std::string(GetParam()).starts_with("drive"); }

  using ServedJobs::open;
  void open() { open(wide_machine("wide"), std::string(GetParam()) + ":" + place_); }
  void open(ToolChanges changes) {
    ServiceConfig shop = config(wide_machine("wide"), std::string(GetParam()) + ":" + place_);
    shop.machine.wire.tool_changes = changes;
    auto jobs = JobService::open(shop, [] {});
    ASSERT_TRUE(jobs) << jobs.error().message;
    jobs_ = std::make_unique<JobService>(std::move(*jobs));
  }

  bool drip() const { return std::string(GetParam()) == "dnc"; }

  std::string shown(std::uint64_t job) {
    const std::string phase = state(job) == "running" ? field(job, "phase") : "";
    return phase == "hold" ? "held" : state(job);
  }

  json override_by(const char* words) {
    ApiRequest request;
    request.op = ApiOp::kMachine;
    request.command = "override";
    request.words = words;
    return ServedJobs::ask(request);
  }
  /// What the controller does not take is refused, by either order.
  void overrides_are_told(std::uint64_t job) {
    const bool grbl = std::string(GetParam()).starts_with("grbl"), feed = !drip() && !drive();
    EXPECT_EQ(good(override_by("feed 90")), feed);
    ApiRequest request;
    request.op = ApiOp::kOverride;
    request.job = job;
    request.percent = 100;
    const auto at_once = jobs_->order(request);
    ASSERT_TRUE(at_once);
    EXPECT_EQ(good(json::parse(*at_once)), feed) << *at_once;
    for (const char* words : {"rapid 50", "spindle 90"}) {
      const json answer = override_by(words);
      EXPECT_EQ(good(answer), grbl) << answer;
      if (!grbl && feed) {
        EXPECT_NE(answer.value("error", "").find("feed override only"), std::string::npos) << answer;
      }
    }
  }

  /// The order is taken, and leads there.
  void way(std::uint64_t job, const char* order, ApiOp op, const std::string& to,
           std::optional<std::uint64_t> from = {}) {
    const std::string before = shown(job);
    if (op == ApiOp::kStart || from) at_the_control();
    const json done = ask(op, job, from, from.has_value());
    ASSERT_TRUE(done.value("ok", false)) << before << ", " << order << ": " << done;
    if (op == ApiOp::kRemove) {
      const bool may_be_held = before == "interrupted" || before == "uncertain";
      EXPECT_EQ(done.value("text", "").find("may still have of it") != std::string::npos, may_be_held)
          << before << ": " << done;
      EXPECT_FALSE(ask(ApiOp::kShow, job).value("ok", false));
    } else {
      const std::uint64_t follows = from ? newest() : job;
      until([&] { return shown(follows) == to; });
      ASSERT_EQ(shown(follows), to) << before << ", " << order << ": " << field(follows, "note");
      if (to == "done") {
        EXPECT_EQ(field(follows, "note").find("executed") == std::string::npos, drip() || drive());
      }
    }
    walked_.insert(before + " -- " + order + " --> " + to);
  }
  /// The order is refused with a text that has this in it; nothing changes.
  void no_way(std::uint64_t job, const char* order, ApiOp op, const std::string& why) {
    const std::string before = shown(job);
    const json refused = ask(op, job);
    ASSERT_FALSE(refused.value("ok", false)) << before << ", " << order << ": " << refused;
    EXPECT_NE(refused.value("error", "").find(why), std::string::npos)
        << before << ", " << order << ": " << refused;
    EXPECT_EQ(shown(job), before);
    walked_.insert(before + " -- " + order + " --> refused");
  }
  void none_moves(std::uint64_t job) {
    no_way(job, "hold", ApiOp::kHold, "not on the machine");
    no_way(job, "override", ApiOp::kOverride, "not on the machine");
  }
  std::uint64_t newest() { return ask(ApiOp::kList)["jobs"].back().value("job", std::uint64_t{0}); }
  /// Its number; it is planned.
  std::uint64_t submit(int feeds, const std::string& more = "") {
    std::string text = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93\n";
    for (int i = 0; i < feeds; ++i) text += "G1 X" + std::to_string(i % 2) + " F600\n";
    const json taken = submit_text(text + more + "G94\nM2\n");
    EXPECT_TRUE(taken.value("ok", false)) << taken;
    const std::uint64_t job = taken.value("job", std::uint64_t{0});
    until([&] { return state(job) != "received"; });
    return job;
  }
  void until_it_cuts() {
    const std::size_t before = executed_;
    until([&] { return executed_ > before + 3; });
  }
  /// As when the power of the host fails while the job runs: journal and table are as they were then.
  void cut_off(std::uint64_t job) {
    const std::string spool = folder_.path + "/spool",
                      journal = spool + "/jobs/" + std::to_string(job) + "/journal";
    until_it_cuts();
    std::filesystem::copy_file(journal, folder_.path + "/journal",
                               std::filesystem::copy_options::overwrite_existing);
    leave();
    std::filesystem::copy_file(folder_.path + "/journal", journal,
                               std::filesystem::copy_options::overwrite_existing);
    {
      auto table = Spool::open(spool);
      ASSERT_TRUE(table) << table.error().message;
      SpooledJob running = *table->find(job);
      running.state = JobState::kRunning;
      ASSERT_TRUE(table->update(running));
    }
    open();
    ASSERT_EQ(state(job), ring() ? "interrupted" : "uncertain") << field(job, "note");
    EXPECT_EQ(field(job, "note").find("--from") == std::string::npos, ring() || drive())
        << field(job, "note");
    walked_.insert(std::string("running -- power loss --> ") + state(job));
  }
  /// The host fails while the way back is on the machine, or right before the change is in the table.
  void cut_off_before_change(std::uint64_t job) {
    leave();
    {
      auto table = Spool::open(folder_.path + "/spool");
      ASSERT_TRUE(table) << table.error().message;
      SpooledJob running = *table->find(job);
      running.state = JobState::kRunning;
      ASSERT_TRUE(table->update(running));
    }
    open();
    ASSERT_EQ(state(job), "tool change") << field(job, "note");
    walked_.insert("running -- power loss on the way back --> tool change");
  }
  void reset() {
    ASSERT_TRUE(ask(ApiOp::kReset).contains("confirm"));
    ASSERT_TRUE(ask(ApiOp::kReset, 0, {}, true).value("ok", false));
    until([&] { return ask(ApiOp::kList).value("reset", "in work") != "in work"; });
    const std::string said = ask(ApiOp::kList).value("reset", "");
    EXPECT_NE(said.find(drip() ? "reset it at the control" : "done: "), std::string::npos) << said;
  }
  /// Out of a state after which nothing goes on by itself: shown first, then a job of its own.
  void enter_near_the_end(std::uint64_t job) {
    const json shows = ask(ApiOp::kResume, job, kLong - 5);
    if (drive()) {
      // It does not tell where its axes are: what is left is made a program of its own.
      EXPECT_NE(shows.value("error", "").find("a program of what is left"), std::string::npos) << shows;
      walked_.insert(shown(job) + " -- resume --from --> refused");
      const std::uint64_t rest = submit(kShort);
      return way(rest, "start (a job of the rest)", ApiOp::kStart, "done");
    }
    ASSERT_TRUE(shows.contains("confirm")) << shows;
    way(job, "resume --from", ApiOp::kResume, "done", kLong - 5);
  }

  /// Feeds to X1, X2 and so on, a tool change in the middle, or two.
  std::uint64_t submit_changes(int feeds, const std::string& first, const std::string& second = "") {
    std::string text =
        "G21 G90 G94\nG0 X0 Y0 Z50 A10 C20\n(TILTFEED tool length 80 mm is in the words)\nM3 S500\nG93\n";
    for (int i = 1; i <= 2 * feeds; ++i) {
      if (i == feeds + 1) text += first;
      if (i == feeds + 2) text += second;
      text += "G1 X" + std::to_string(i) + " F600\n";
    }
    const json taken = submit_text(text + "G94\nM5\nM2\n");
    EXPECT_TRUE(taken.value("ok", false)) << taken;
    const std::uint64_t job = taken.value("job", std::uint64_t{0});
    until([&] { return state(job) != "received"; });
    EXPECT_EQ(state(job), "ready") << field(job, "note");
    const std::lock_guard lock(cut_mutex_);
    cut_.clear();
    return job;
  }
  /// Every feed of the program once, in order.
  void expect_cut(int count) {
    const std::lock_guard lock(cut_mutex_);
    ASSERT_EQ(cut_.size(), static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) EXPECT_NEAR(cut_[static_cast<std::size_t>(i)], i + 1, 1e-9);
  }
  json tool(std::uint64_t job, const std::string& command, const std::string& words = "") {
    ApiRequest request;
    request.op = ApiOp::kTool;
    request.job = job;
    request.command = command;
    request.words = words;
    return ask(request);
  }
  /// The operator says go, and has seen what moves.
  void go(std::uint64_t job, const std::string& to) {
    const json shown = ask(ApiOp::kResume, job);
    ASSERT_TRUE(shown.contains("confirm")) << shown;
    ApiRequest request;
    request.op = ApiOp::kResume;
    request.job = job;
    request.confirmed = true;
    const json gone = ask(request);
    ASSERT_TRUE(gone.value("ok", false)) << gone;
    until([&] { return shown_as(job, to); });
    walked_.insert("tool change -- go --> " + to);
  }
  bool shown_as(std::uint64_t job, const std::string& to) {
    return shown(job) == to && (to != "tool change" || !jobs_->busy());
  }

  const double speed_;
  int stop_[2] = {-1, -1};
  std::atomic<std::size_t> executed_{0};
  std::promise<std::string> known_;
  std::thread machine_;
  std::string place_;
  std::set<std::string> walked_;
  std::mutex cut_mutex_;
  std::vector<double> cut_;  // X of the feeds in inverse time: of the programs only
};

TEST_P(JobWays, B9EveryStateHasItsWaysOut) {
  const std::uint64_t bad = submit(1, "G1 X!\n"), brief = submit(kShort), lengthy = submit(kLong);
  ASSERT_EQ(state(bad), "failed");
  none_moves(bad);
  no_way(bad, "start", ApiOp::kStart, "is failed");
  no_way(bad, "stop", ApiOp::kStop, "not on the machine");
  no_way(bad, "resume", ApiOp::kResume, "nothing to resume");
  way(bad, "remove", ApiOp::kRemove, "gone");

  none_moves(lengthy);
  no_way(lengthy, "resume", ApiOp::kResume, "nothing to resume");
  way(lengthy, "start", ApiOp::kStart, "running");
  until_it_cuts();
  no_way(lengthy, "start", ApiOp::kStart, "is running");
  no_way(lengthy, "remove", ApiOp::kRemove, "stop it first");
  no_way(brief, "start", ApiOp::kStart, "busy with job");
  overrides_are_told(lengthy);
  way(lengthy, "hold", ApiOp::kHold, "held");
  no_way(lengthy, "remove", ApiOp::kRemove, "stop it first");
  way(lengthy, "resume", ApiOp::kResume, "running");
  until_it_cuts();
  way(lengthy, "hold", ApiOp::kHold, "held");
  way(lengthy, "stop", ApiOp::kStop, "stopped");

  none_moves(lengthy);
  no_way(lengthy, "start", ApiOp::kStart, "is stopped");
  no_way(lengthy, "start", ApiOp::kStart,
         drive() ? "a job of its own" : "`tiltfeed resume " + std::to_string(lengthy) + " --from BLOCK`");
  no_way(lengthy, "stop", ApiOp::kStop, "not on the machine");
  no_way(lengthy, "resume", ApiOp::kResume, "cannot go on by itself");
  reset();
  enter_near_the_end(lengthy);
  way(brief, "start", ApiOp::kStart, "done");
  none_moves(brief);
  way(brief, "start", ApiOp::kStart, "done");
  way(lengthy, "remove", ApiOp::kRemove, "gone");

  const std::uint64_t cut = submit(kLong);
  way(cut, "start", ApiOp::kStart, "running");
  cut_off(cut);
  if (ring()) {
    none_moves(cut);
    no_way(cut, "start", ApiOp::kStart, "is interrupted");
    no_way(cut, "start", ApiOp::kStart, "`tiltfeed resume " + std::to_string(cut) + "` goes on");
    way(cut, "resume", ApiOp::kResume, "running");
    cut_off(cut);
    const auto notes = [&](const char* text) { return field(cut, "note").find(text) != std::string::npos; };
    EXPECT_TRUE(notes("may have run") && notes("resume asks the controller")) << field(cut, "note");
    way(cut, "stop", ApiOp::kStop, "stopped");
    EXPECT_TRUE(notes("may have run")) << field(cut, "note");
    EXPECT_FALSE(notes("asks the controller")) << "it was told to forget the run: " << field(cut, "note");
    enter_near_the_end(cut);
    way(cut, "remove", ApiOp::kRemove, "gone");

    const std::uint64_t again = submit(kLong);
    way(again, "start", ApiOp::kStart, "running");
    cut_off(again);
    reset();
    ASSERT_EQ(state(again), "uncertain");
    walked_.insert("interrupted -- reset --> uncertain");
    no_way(again, "start", ApiOp::kStart, "is uncertain");
    no_way(again, "resume", ApiOp::kResume, "cannot go on by itself");
    enter_near_the_end(again);

    const std::uint64_t forgotten = submit(kLong);
    way(forgotten, "start", ApiOp::kStart, "running");
    cut_off(forgotten);
    way(forgotten, "remove", ApiOp::kRemove, "gone");
    reset();  // of what the controller still has of it
  } else {
    no_way(cut, "start", ApiOp::kStart, "is uncertain");
    no_way(cut, "stop", ApiOp::kStop, drip() ? "a reset at the control" : "tiltfeed reset");
    no_way(cut, "resume", ApiOp::kResume, "cannot go on by itself");
    reset();
    enter_near_the_end(cut);
    way(cut, "remove", ApiOp::kRemove, "gone");
  }
  way(brief, "start", ApiOp::kStart, "done");
  way(brief, "remove", ApiOp::kRemove, "gone");
  std::cout << GetParam() << ": " << walked_.size() << " ways walked\n";
  for (const std::string& one : walked_) std::cout << "  " << one << "\n";
}

/// Ways down at plunge feed from the top of the travel are long.
class JobChanges : public JobWays {
 protected:
  JobChanges() : JobWays(2000.0) {}
};

constexpr const char* kNoTool = "say first how long the tool is";

/// Each run of the program is executed once and in order, whatever comes between its parts.
TEST_P(JobChanges, D21AToolChangeHasItsWaysOut) {
  const std::uint64_t brief = submit(kShort),
                      job = submit_changes(10, "M5\nT3 M6 (ball 6 mm)\n", "T4\nM0\nM3 S900\n");
  way(job, "start", ApiOp::kStart, "tool change");
  EXPECT_NE(field(job, "note").find("T3 (ball 6 mm), before line 17"), std::string::npos)
      << field(job, "note");
  EXPECT_EQ(field(job, "parked"), "parked, spindle and coolant off");
  expect_cut(10);
  no_way(job, "start", ApiOp::kStart, "is tool change");
  no_way(job, "start", ApiOp::kStart, "`tiltfeed tool " + std::to_string(job) + "`");
  no_way(brief, "start", ApiOp::kStart, "waits for a tool change");
  no_way(job, "override", ApiOp::kOverride, "not on the machine");
  EXPECT_TRUE(good(ask(ApiOp::kHold, job)));
  EXPECT_EQ(state(job), "tool change");

  // The tool must be the program's.
  no_way(job, "go without a length", ApiOp::kResume, kNoTool);
  EXPECT_NE(tool(job, "length", "79.5").value("error", "").find("0.5 mm shorter"), std::string::npos);
  EXPECT_FALSE(good(tool(job, "length", "long")));
  no_way(job, "go without a length", ApiOp::kResume, kNoTool);
  EXPECT_NE(tool(job, "length", "80.05").value("text", "").find("0.05 mm longer"), std::string::npos);
  EXPECT_NE(tool(job, "").value("text", "").find("T3 (ball 6 mm)"), std::string::npos);

  // A restart of the service changes nothing but what nobody wrote down.
  leave();
  open();
  ASSERT_EQ(state(job), "tool change") << field(job, "note");
  walked_.insert("tool change -- restart --> tool change");
  const bool parks = !ring();
  EXPECT_EQ(field(job, "parked").find("machine tool park") != std::string::npos, parks)
      << field(job, "parked");
  EXPECT_EQ(field(job, "parked").find("`tiltfeed reset`") != std::string::npos, !parks)
      << field(job, "parked");
  EXPECT_TRUE(good(tool(job, "length", "80")));
  go(job, "tool change");
  EXPECT_NE(field(job, "note").find("T4, before"), std::string::npos) << field(job, "note");
  expect_cut(11);

  // Killed on the way back, or before the spool knew of the change: it stands before the change.
  cut_off_before_change(job);
  EXPECT_NE(field(job, "note").find("T4, before"), std::string::npos) << field(job, "note");
  EXPECT_TRUE(good(tool(job, "length", "80")));
  go(job, "done");
  expect_cut(20);
  way(brief, "start", ApiOp::kStart, "done");

  // Stopped, and entered again.
  const std::uint64_t other = submit_changes(5, "T3 M6\n");
  way(other, "start", ApiOp::kStart, "tool change");
  const std::string waits = field(other, "note");
  EXPECT_FALSE(good(ask(ApiOp::kResume, other, 9999, true))) << "there is no such block";
  EXPECT_EQ(state(other), "tool change") << "a re-entry that came to nothing ends no tool change";
  EXPECT_EQ(field(other, "note"), waits);
  EXPECT_TRUE(good(tool(other, "")));
  way(other, "stop", ApiOp::kStop, "stopped");
  no_way(other, "resume", ApiOp::kResume, "cannot go on by itself");
  way(other, "resume --from", ApiOp::kResume, "done", 13);
  const std::uint64_t removed = submit_changes(5, "T3 M6\n");
  way(removed, "start", ApiOp::kStart, "tool change");
  way(removed, "remove", ApiOp::kRemove, "gone");
  way(brief, "start", ApiOp::kStart, "done");
  const std::uint64_t entered = submit_changes(5, "T3 M6\n");
  way(entered, "start", ApiOp::kStart, "tool change");
  way(entered, "resume --from", ApiOp::kResume, "done", 13);
  EXPECT_EQ(state(entered), "stopped");
  const std::string as = "entered again at the tool change, as job ", note = field(entered, "note");
  ASSERT_NE(note.find(as), std::string::npos) << note;
  // Its way off is from where the machine stood then.
  const std::uint64_t entry = std::stoull(note.substr(note.find(as) + as.size()));
  no_way(entry, "start", ApiOp::kStart, "--from 13` makes it anew from where it stands now");
  way(brief, "start", ApiOp::kStart, "done");

  // The profile leaves changes to the control from now on: it does not stand there by itself.
  const std::uint64_t handed = submit_changes(5, "T3 M6\n");
  way(handed, "start", ApiOp::kStart, "tool change");
  leave();
  open(ToolChanges::kControl);
  EXPECT_EQ(state(handed), "uncertain") << field(handed, "note");
  EXPECT_NE(field(handed, "note").find("the control changes tools now"), std::string::npos)
      << field(handed, "note");
  leave();
  open();
  way(handed, "remove", ApiOp::kRemove, "gone");
  way(brief, "start", ApiOp::kStart, "done");

  // Without its journal nobody can say that it stands there.
  const std::uint64_t lost = submit_changes(5, "T3 M6\n");
  way(lost, "start", ApiOp::kStart, "tool change");
  leave();
  std::filesystem::remove(folder_.path + "/spool/jobs/" + std::to_string(lost) + "/journal");
  open();
  EXPECT_EQ(state(lost), "uncertain") << field(lost, "note");
  walked_.insert("tool change -- journal lost --> uncertain");
  std::cout << GetParam() << ": " << walked_.size() << " ways walked\n";
}

INSTANTIATE_TEST_SUITE_P(Links, JobWays,
                         testing::Values("grbl", "grbl-ws", "reprap", "dnc", "modbus-tcp", "modbus-rtu",
                                         "drive-tcp", "drive-rtu"));

INSTANTIATE_TEST_SUITE_P(Links, JobChanges,
                         testing::Values("grbl", "grbl-ws", "reprap", "modbus-tcp", "modbus-rtu"));

}  // namespace
}  // namespace tiltfeed
