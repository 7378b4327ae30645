// Orders in an order that nobody thought of: a random walk over jobs of a service with a simulated machine
// behind it, restarts of the service included. Whatever is said is held against what the machine executed,
// told by the words of its blocks.

#include <gtest/gtest.h>

#include <cmath>
#include <future>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>

#include "sim/wire/endpoint.h"
#include "tests/peers/served_jobs.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

using nlohmann::json;

/// One feed as the machine executed it, at the height of the cut.
struct Cut {
  int mark = 0, feed = 0;
};

/// What all machines of a walk have cut, one after the other.
class Trace {
 public:
  void take(const sim::TraceRow& row) {
    const sim::Block& done = row.command;
    const Cut cut{static_cast<int>(std::lround(done.target.y)),
                  static_cast<int>(std::lround(done.target.x * 10.0))};
    const std::lock_guard lock(mutex_);
    if (done.op == sim::Op::kFeed && std::abs(done.target.z - kHeight) < 1e-6 && cut.mark > 0)
      cuts_.push_back(cut);
  }
  std::vector<Cut> cuts() const {
    const std::lock_guard lock(mutex_);
    return cuts_;
  }
  static constexpr double kHeight = 50.0;

 private:
  mutable std::mutex mutex_;
  std::vector<Cut> cuts_;
};

/// A simulated machine behind a port of its own, from its start to its power loss.
template <class Controller>
class Machine {
 public:
  explicit Machine(Trace& trace) {
    EXPECT_EQ(::pipe(stop_), 0);
    std::promise<std::string> where;
    std::future<std::string> known = where.get_future();
    thread_ = std::thread([this, &trace, promise = std::move(where)]() mutable {
      sim::EndpointOptions options;
      options.stop_fd = stop_[0];
      options.speed = 4.0;
      bool told = false;
      options.ready = [&](const std::string& text) {
        if (!std::exchange(told, true)) promise.set_value(text);
      };
      Controller controller(wide_machine(), {}, {}, [&](const sim::TraceRow& row) { trace.take(row); });
      if constexpr (std::is_same_v<Controller, sim::ModbusController>)
        EXPECT_TRUE(sim::serve_modbus_tcp(controller, "127.0.0.1", 0, options));
      else
        EXPECT_TRUE(sim::serve_tcp(controller, "127.0.0.1:0", options));
    });
    place = known.get();
  }
  ~Machine() {
    EXPECT_EQ(::write(stop_[1], "x", 1), 1);
    thread_.join();
    ::close(stop_[0]);
    ::close(stop_[1]);
  }
  std::string place;

 private:
  int stop_[2] = {-1, -1};
  std::thread thread_;
};

constexpr int kFeeds = 120;       // of each program
constexpr int kChangeAfter = 60;  // feeds, in programs with a tool change
constexpr int kSteps = 60;        // orders of a walk
constexpr int kMostJobs = 8;

template <class Controller>
class Walk : private ServedJobs {
 public:
  Walk(const std::string& link, unsigned seed)
      : ServedJobs("walk" + std::to_string(seed), std::chrono::seconds(120)), link_(link), random_(seed) {
    power();
  }
  ~Walk() {
    if (jobs_) leave();
  }

  void run() {
    for (int step = 0; step < kSteps && !testing::Test::HasFailure(); ++step) {
      order();
      turn(pick(30));
      judge("step " + std::to_string(step));
    }
    if (!testing::Test::HasFailure()) return;
    for (const std::string& line : told_) std::cout << line << "\n";
  }

 private:
  static constexpr bool kRing = std::is_same_v<Controller, sim::ModbusController>;
  /// Blocks before the first feed: G0 on the ring, three lines elsewhere.
  static constexpr int kBefore = kRing ? 1 : 3;

  struct Job {
    int mark = 0;           ///< of its feeds; a re-entry has that of the job that it enters again
    int first = 1;          ///< feed that a run begins with
    bool changes = false;   ///< has a tool change
    bool again = false;     ///< a re-entry: its blocks have numbers of their own
    std::size_t since = 0;  ///< cuts of before its newest run
    bool entered = false;   ///< what is said of it is about a run that another has gone on with since
  };

  int pick(int below) { return static_cast<int>(random_() % static_cast<unsigned>(below)); }
  void tell(const std::string& what) { told_.push_back(what); }
  void open() { ServedJobs::open(wide_machine("wide"), link_ + machine_->place); }
  void turn(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      jobs_->tick();
    }
  }

  void submit() {
    const int mark = static_cast<int>(jobs_made_.size()) + 1;
    const bool changes = mark % 2 == 0;
    std::string text = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG93\n";
    for (int i = 1; i <= kFeeds; ++i) {
      char line[64];
      std::snprintf(line, sizeof line, "G1 X%.1f Y%d Z50 A0 C0 F3000\n", i * 0.1, mark);
      text += line;
      if (changes && i == kChangeAfter) text += "T2 M6\n";
    }
    const json taken = submit_text(text + "G94\nM2\n");
    ASSERT_TRUE(good(taken)) << taken;
    const int id = taken.at("job");
    jobs_made_[id] = {mark, 1, changes, false};
    until([&] { return state(static_cast<std::uint64_t>(id)) == "ready"; });
  }

  void order() {
    if (jobs_made_.empty()) return submit();
    const auto at = std::next(jobs_made_.begin(), pick(static_cast<int>(jobs_made_.size())));
    const auto job = static_cast<std::uint64_t>(at->first);
    const int what = pick(28);
    if (what == 0 && jobs_made_.size() < kMostJobs) return tell("submit"), submit();
    if (what <= 4) return say(ApiOp::kStart, job, false, pick(3) == 0);
    if (what <= 8) return say(ApiOp::kHold, pick(3) == 0 ? job : 0);
    if (what <= 12) return say(ApiOp::kResume, pick(2) == 0 ? job : 0, pick(2) == 0);
    if (what <= 14) return say(ApiOp::kStop, pick(2) == 0 ? job : 0);
    if (what == 15) return say(ApiOp::kReset, 0, true);
    if (what == 16 && pick(4) == 0) return say(ApiOp::kRemove, job);
    if (what <= 18) return restart();
    if (what == 19) return say(ApiOp::kOverride, 0);
    if (what == 20) return tell("power loss"), power();
    if (what <= 22) return enter_again(at->first);
    if (what <= 25) return go(job);
    wait();
  }
  json say(const ApiRequest& request) {
    // As the socket's thread does it.
    const std::optional<std::string> at_once = jobs_->order(request);
    const json answer = at_once ? json::parse(*at_once) : ask(request);
    tell(write_request(request) + " -> " + answer.dump());
    return answer;
  }
  void say(ApiOp op, std::uint64_t job, bool confirmed = false, bool queue = false) {
    ApiRequest request;
    request.op = op;
    request.job = job;
    request.confirmed = confirmed;
    request.queue = queue;
    request.percent = 10 + pick(190);
    const std::size_t before = trace_.cuts().size();
    if (good(say(request)) && op == ApiOp::kStart) jobs_made_.at(static_cast<int>(job)).since = before;
  }
  /// The tool is mounted.
  void go(std::uint64_t job) {
    ApiRequest request;
    request.op = ApiOp::kTool;
    request.job = job;
    request.command = pick(4) == 0 ? "" : "go";
    request.confirmed = true;
    say(request);
  }
  /// Before a feed that has surely been reached, or the one after.
  void enter_again(int id) {
    const Job& job = jobs_made_.at(id);
    if (job.again || jobs_made_.size() >= kMostJobs) return;
    const json shown = ask(ApiOp::kShow, static_cast<std::uint64_t>(id));
    const int executed = shown.value("executed", 0), feed = feed_of(executed + 1, job);
    if (feed < 2 || feed > kFeeds) return;
    ApiRequest request;
    request.op = ApiOp::kResume;
    request.job = static_cast<std::uint64_t>(id);
    request.from = static_cast<std::uint64_t>(executed + 1);
    request.confirmed = true;
    const json answer = say(request);
    EXPECT_FALSE(good(answer) && shown.at("state") == "running") << "entered again while it runs: " << answer;
    if (!good(answer)) return;
    const int begun = answer.value("begins", 0);
    ASSERT_GT(begun, 0) << answer;
    jobs_made_[id].entered = true;
    jobs_made_[begun] = {job.mark, feed, job.changes, true};
  }
  void restart() {
    tell("restart");
    leave();
    open();
  }
  /// Another controller, whose power comes on; the one before it has lost everything.
  void power() {
    machine_.reset();
    if (jobs_) until([&] { return !jobs_->busy(); });
    jobs_.reset();
    machine_ = std::make_unique<Machine<Controller>>(trace_);
    open();
  }
  /// For what runs to come to an end, or to a stand.
  void wait() {
    tell("wait");
    for (int i = 0; i < 40 && jobs_->busy(); ++i) {
      turn(10);
      if (ask(ApiOp::kList).dump().find("\"phase\":\"hold\"") != std::string::npos) break;
    }
  }

  /// The newest feed in the blocks up to this one.
  static int feed_of(int block, const Job& job) {
    const int feed = block - kBefore;
    return job.changes && feed > kChangeAfter ? feed - 1 : feed;
  }

  /// Within a run no feed comes twice and none is left out; the last step down
  /// of a way to the part ends where the feed before it did.
  void judge_order(const std::vector<Cut>& cuts, const std::string& where) {
    std::map<int, int> last;
    for (const Cut& cut : cuts) {
      const int before = std::exchange(last[cut.mark], cut.feed);
      bool begins = cut.feed == before + 1 || cut.feed == 1;
      for (const auto& [id, job] : jobs_made_) {
        if (job.mark != cut.mark) continue;
        begins = begins || (job.again && (cut.feed == job.first || cut.feed == job.first - 1)) ||
                 (job.changes && cut.feed == kChangeAfter && before == kChangeAfter);
      }
      EXPECT_TRUE(begins) << where << ": feed " << cut.feed << " of " << cut.mark << " after " << before;
    }
  }

  /// The newest feed of a job's newest run; 0: none.
  static int reached(const std::vector<Cut>& cuts, const Job& job) {
    for (std::size_t i = cuts.size(); i > job.since; --i)
      if (cuts[i - 1].mark == job.mark) return cuts[i - 1].feed;
    return 0;
  }

  void judge(const std::string& where) {
    const std::vector<Cut> before = trace_.cuts();
    judge_order(before, where);
    const json list = ask(ApiOp::kList);
    const std::vector<Cut> after = trace_.cuts();
    for (const json& said : list.at("jobs")) {
      const auto found = jobs_made_.find(said.at("job"));
      ASSERT_NE(found, jobs_made_.end()) << where << ": " << said;
      const Job& job = found->second;
      const std::string state = said.at("state"), note = said.at("note");
      if (job.entered) continue;
      const int then = reached(before, job), now = reached(after, job);
      if (state == "done") {
        EXPECT_EQ(then, kFeeds) << where << ": " << said;
      }
      if (job.again) continue;
      const bool fresh = state == "ready" || state == "queued";
      if (fresh) {
        EXPECT_TRUE(then == 0 || then == kFeeds) << where << ": " << said;
      }
      if (state == "tool change") {
        EXPECT_EQ(then, kChangeAfter) << where << ": " << said;
      }
      const int executed = said.at("executed");
      if (!fresh) {
        EXPECT_LE(std::min(feed_of(executed, job), kFeeds), now) << where << ": " << said;
      }
      const bool cut_off = state == "stopped" || state == "uncertain" || state == "interrupted";
      if (!cut_off) continue;
      std::smatch range;
      if (std::regex_search(note, range, std::regex("blocks? (\\d+)(?: to (\\d+))? may have run"))) {
        const int first = std::stoi(range[1]), most = range[2].matched ? std::stoi(range[2]) : first;
        EXPECT_LE(feed_of(first - 1, job), then) << where << ": " << said;
        EXPECT_LE(then, std::max(feed_of(most, job), 0)) << where << ": " << said;
      } else if (note.find("nothing was sent") != std::string::npos &&
                 note.find("have run") == std::string::npos) {
        EXPECT_EQ(then, 0) << where << ": " << said;
      }
    }
  }

  std::string link_;
  std::mt19937 random_;
  Trace trace_;
  std::unique_ptr<Machine<Controller>> machine_;
  std::map<int, Job> jobs_made_;  ///< by number, removed ones included
  std::vector<std::string> told_;
};

/// So many walks from this seed on: WALKS=100 FIRST=1000 looks for more than the tests do.
unsigned setting(const char* name, unsigned usual) {
  const char* const text = std::getenv(name);
  return text == nullptr ? usual : static_cast<unsigned>(std::atoi(text));
}

template <class Controller>
void walk(const std::string& link) {
  const unsigned first = setting("FIRST", 1), end = first + setting("WALKS", 2);
  for (unsigned seed = first; seed < end && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Walk<Controller>(link, seed).run();
  }
}

TEST(JobWalk, OverTheRing) { walk<sim::ModbusController>("modbus-tcp:"); }
TEST(JobWalk, OverGrbl) { walk<sim::GrblController>("grbl-tcp:"); }

}  // namespace
}  // namespace tiltfeed
