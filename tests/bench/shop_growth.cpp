// Many machines of a shop in one process: the services' own threads of the queue, over spools in memory, with
// operators and machines that only pass the time.
//
//   shop_growth URL MACHINES JOB_SECONDS SECONDS
//
// Every machine takes jobs, an operator starts what waits, a job takes JOB_SECONDS on the average and is held
// once; as many are submitted as are done. Once every machine has one it prints "ready", and after SECONDS of
// that one JSON object: what was counted on this side meanwhile. It goes on until its input ends.

#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include "daemon/shop/shop_live.h"
#include "daemon/shop/shop_orders.h"
#include "daemon/shop/shop_thread.h"

namespace {

using namespace tiltfeed;
using namespace tiltfeed::daemon;
using Steady = std::chrono::steady_clock;

constexpr std::size_t kProgramBytes = 256 * 1024;
constexpr double kOperator = 0.1;  ///< until an operator starts what waits, as a share of a job
constexpr std::chrono::milliseconds kStep{20};

std::atomic<std::uint64_t> turns{0}, changes{0}, taken{0}, done{0}, submitted{0}, connected{0}, troubles{0};
std::atomic<bool> over{false};

std::uint64_t wall_ms() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
}

/// A service's record, without its disk.
class LightMachine {
 public:
  LightMachine(const std::string& url, unsigned seed, double job_seconds)
      : random_(seed), job_seconds_(job_seconds) {
    shop_.machine = make_uuid();
    shop_.name = "light " + std::to_string(seed);
    shop_.offer.profile = "light";
    note(kShopIdle);
    thread_ = std::make_unique<ShopThread>(url, ledger());
  }
  void end() { thread_->end(); }

  /// Operator and machine.
  void pass(Steady::time_point now) {
    const std::lock_guard lock(mutex_);
    if (now < due_) return;
    for (auto& [id, job] : jobs_) {
      if (job.report.state == "running") {
        if (job.held == 1) return held(job, kShopHeld, now, 0.02);
        if (job.held == 2) return held(job, kShopRunning, now, 0.5);
        set(job, "done");
        first_ = false;
        ++done;
        note(kShopIdle);
        return wait(now, 0.01);
      }
    }
    for (auto& [id, job] : jobs_)
      if (job.report.state == "ready") {
        job.report.blocks = 1000;
        job.held = 1;
        set(job, "running");
        note(kShopRunning);
        return wait(now, 0.5);
      }
  }

 private:
  struct Known {
    ShopReport report;
    std::uint64_t told = 0;
    int held = 0;
  };
  /// The first job is somewhere on its way when it is taken, so that the machines are not in step.
  void wait(Steady::time_point now, double share) {
    std::uniform_real_distribution<double> spread(first_ ? 0.0 : 0.5, first_ ? 1.0 : 1.5);
    due_ = now + std::chrono::duration_cast<Steady::duration>(
                     std::chrono::duration<double>(job_seconds_ * share * spread(random_)));
  }
  void held(Known& job, const char* word, Steady::time_point now, double share) {
    ++job.held;
    note(word);
    wait(now, share);
    if (thread_) thread_->wake();
  }
  void note(const char* word) {
    states_.push_back({std::max(wall_ms(), states_.empty() ? 0 : states_.back().at + 1), word});
    word_ = word;
    ++changes;
  }
  void set(Known& job, const char* state) {
    job.report.state = state;
    ++job.report.version;
    if (thread_) thread_->wake();
  }
  Result<LocalShop> read() {
    LocalShop local = shop_;
    std::size_t waits = 0;
    for (const auto& [id, job] : jobs_) {
      const std::string& state = job.report.state;
      if (state == "claimed") local.claimed.push_back(job.report.job);
      if (state == "accepted") local.accepted.push_back(job.report.job);
      if (state == "ready") local.waiting.push_back(id);
      if (state != "done" && state != "running") ++waits;
      if (state != "claimed" && job.report.version > job.told && local.reports.size() < 100)
        local.reports.push_back(job.report);
    }
    local.wants = waits < 1;
    local.states = states_;
    ShopLive live;
    live.state = word_;
    live.clock = wall_ms();
    local.live = live_json(live);
    return local;
  }
  ShopLedger ledger() {
    ShopLedger l;
    const auto kept = [this](auto work) {
      return [this, work](auto... words) -> Result<void> {
        const std::lock_guard lock(mutex_);
        work(words...);
        return {};
      };
    };
    l.read = [this]() -> Result<LocalShop> {
      const std::lock_guard lock(mutex_);
      ++turns;
      return read();
    };
    l.remember = kept([this](const ShopMark& mark) { shop_.mark = mark; });
    l.claim = [this](const ShopJob& job, const ShopMark& mark) -> Result<bool> {
      const std::lock_guard lock(mutex_);
      shop_.mark = mark;
      Known& known = jobs_[job.ticket.job];
      known.report.job = job;
      known.report.state = "claimed";
      return true;
    };
    l.confirm = kept([this](const std::string& id, std::uint64_t serial) {
      shop_.mark.serial = std::max(shop_.mark.serial, serial);
      jobs_[id].report.state = "accepted";
    });
    l.drop = kept([this](const std::string& id) { jobs_.erase(id); });
    l.arrive = [this](const ShopJob& job, const std::vector<int>&) -> Result<void> {
      const std::lock_guard lock(mutex_);
      ++taken;
      set(jobs_[job.ticket.job], "ready");
      wait(Steady::now(), kOperator);
      return {};
    };
    l.spoil = kept([this](const std::string& id, const std::string&) { jobs_.erase(id); });
    l.told = kept([this](const std::string& id, std::uint64_t version, std::uint64_t serial) {
      shop_.mark.serial = std::max(shop_.mark.serial, serial);
      Known& job = jobs_[id];
      job.told = version;
      if (job.report.state == "done" && job.told == job.report.version) jobs_.erase(id);
    });
    l.told_states = kept([this](std::uint64_t at) {
      std::erase_if(states_, [&](const ShopState& one) { return one.at <= at; });
    });
    l.overrule = kept([this](const std::string& id, const std::string&) { jobs_.erase(id); });
    l.retell = kept([] {});
    l.scratch = [] { return ::memfd_create("light", MFD_CLOEXEC); };
    l.log = [](bool bad, const std::string& text) {
      if (bad && troubles++ == 0) std::fprintf(stderr, "the first of the troubles: %s\n", text.c_str());
    };
    l.show = [this](const std::string& text) {
      if (text == "connected" && !was_connected_.exchange(true)) ++connected;
    };
    return l;
  }

  std::mutex mutex_;
  std::mt19937 random_;
  double job_seconds_;
  LocalShop shop_;
  std::map<std::string, Known> jobs_;
  std::vector<ShopState> states_;
  std::string word_;
  Steady::time_point due_{};
  bool first_ = true;
  std::atomic<bool> was_connected_{false};
  std::unique_ptr<ShopThread> thread_;
};

/// As many jobs wait as there are machines.
void submit_all(const std::string& url, std::uint64_t machines) {
  Result<PgConnection> database = PgConnection::connect(url, -1);
  if (!database) return;
  const ShopAsk ask = [&](const std::string& sql, const std::vector<PgValue>& values) {
    return database->ask(sql, values);
  };
  const int file = ::memfd_create("program", MFD_CLOEXEC);
  // As well compressed as a program is: about a fourth.
  std::mt19937_64 random(1);
  std::string text(kProgramBytes, 'x');
  for (std::size_t i = 0; i < text.size(); i += 4) text[i] = static_cast<char>(random());
  if (::write(file, text.data(), text.size()) != static_cast<ssize_t>(text.size())) return;
  while (!over) {
    if (submitted >= done + 2 * machines) {
      std::this_thread::sleep_for(kStep);
      continue;
    }
    ShopSubmission job{make_uuid(), "light", true, {}, {file}};
    job.needs.profile = "light";
    if (const auto given = submit_to_shop(ask, job)) ++submitted;
  }
  ::close(file);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return std::fprintf(stderr, "shop_growth URL MACHINES JOB_SECONDS SECONDS\n"), 2;
  const std::string url = argv[1];
  const std::uint64_t count = std::strtoull(argv[2], nullptr, 10);
  const double job_seconds = std::atof(argv[3]), seconds = std::atof(argv[4]);
  std::thread submitter(submit_all, url, count);
  while (submitted < 2 * count) std::this_thread::sleep_for(kStep);
  std::vector<std::unique_ptr<LightMachine>> machines;
  for (unsigned i = 0; i < count; ++i) {
    machines.push_back(std::make_unique<LightMachine>(url, i, job_seconds));
    if (i % 20 == 19) std::this_thread::sleep_for(kStep);  // a server takes few new connections at a time
  }
  const auto run = [&](auto until) {
    while (!until()) {
      const auto now = Steady::now();
      for (auto& machine : machines) machine->pass(now);
      std::this_thread::sleep_for(kStep);
    }
  };
  run([&] { return connected >= count && taken >= count; });
  const std::uint64_t before[] = {turns, changes, taken, done, submitted};
  std::puts("ready");
  std::fflush(stdout);
  const auto end = Steady::now() + std::chrono::duration<double>(seconds);
  run([&] { return Steady::now() > end; });
  std::printf(
      "{\"reads\": %lu, \"states\": %lu, \"taken\": %lu, \"done\": %lu, \"submitted\": %lu, \"troubles\": "
      "%lu}\n",
      turns - before[0], changes - before[1], taken - before[2], done - before[3], submitted - before[4],
      troubles.load());
  std::fflush(stdout);
  run([] {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    return ::poll(&input, 1, 0) > 0;
  });
  over = true;
  submitter.join();
  std::_Exit(0);
}
