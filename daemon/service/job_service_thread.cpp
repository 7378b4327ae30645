#include "daemon/service/job_service_thread.h"

#include <sys/eventfd.h>
#include <unistd.h>

namespace tiltfeed::daemon {

namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTick{100};
/// While something is in work whose end somebody waits for.
constexpr std::chrono::milliseconds kSoon{2};
constexpr std::chrono::seconds kStatusInterval{1};
/// A machine that is told to hold stands long before; then the wire is let go of all the same.
constexpr std::chrono::seconds kLeaveLimit{15};

}  // namespace

JobServiceThread::JobServiceThread(JobService& jobs, std::function<void()> turned)
    : jobs_(jobs),
      turned_(std::move(turned)),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      thread_([this] { run(); }) {}

JobServiceThread::~JobServiceThread() {
  {
    const std::lock_guard lock(mutex_);
    leaving_ = true;
  }
  posted_.notify_one();
  thread_.join();
  ::close(wake_);
}

void JobServiceThread::post(std::function<void(JobService&)> task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  posted_.notify_one();
}

void JobServiceThread::reply(std::uint64_t client, std::string line) {
  {
    const std::lock_guard lock(mutex_);
    replies_.emplace_back(client, std::move(line));
  }
  static_cast<void>(::eventfd_write(wake_, 1));
}

std::vector<std::pair<std::uint64_t, std::string>> JobServiceThread::take_replies() {
  eventfd_t count = 0;
  static_cast<void>(::eventfd_read(wake_, &count));
  const std::lock_guard lock(mutex_);
  return std::exchange(replies_, {});
}

std::vector<std::function<void(JobService&)>> JobServiceThread::wait_for_tasks() {
  std::unique_lock lock(mutex_);
  posted_.wait_for(lock, jobs_.in_work() ? kSoon : kTick, [this] { return leaving_ || !tasks_.empty(); });
  return std::exchange(tasks_, {});
}

void JobServiceThread::run() {
  auto ticked = steady_clock::now(), told = ticked;
  for (;;) {
    for (const auto& task : wait_for_tasks()) task(jobs_);
    {
      const std::lock_guard lock(mutex_);
      if (leaving_) break;
    }
    jobs_.take_ends();
    const auto now = steady_clock::now();
    if (now - ticked < kTick) continue;
    ticked = now;
    jobs_.tick();
    if (!jobs_.streaming()) turned_();
    if (now - told < kStatusInterval) continue;
    told = now;
    notify("STATUS=" + jobs_.status());
  }
  leave();
}

void JobServiceThread::leave() {
  notify("STOPPING=1\nSTATUS=holding the machine");
  jobs_.leave();
  const auto limit = steady_clock::now() + kLeaveLimit;
  while (jobs_.busy() && steady_clock::now() < limit) {
    std::this_thread::sleep_for(kTick);
    turned_();
    jobs_.tick();
  }
  jobs_.leave_shop();
}

}  // namespace tiltfeed::daemon
