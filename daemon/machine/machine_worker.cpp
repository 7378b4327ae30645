#include "daemon/machine/machine_worker.h"

#include "daemon/wire/open_link.h"

namespace tiltfeed::daemon {

namespace {

class RealClock : public Clock {
 public:
  Time now() override { return std::chrono::steady_clock::now().time_since_epoch(); }
};

}  // namespace

MachineWorker::~MachineWorker() {
  stop();
  if (thread_.joinable()) thread_.join();
}

std::uint64_t MachineWorker::start(const config::MachineProfile& machine, const LinkSpec& link,
                                   const std::string& name, const std::vector<std::string>& words,
                                   const std::function<void()>& ended) {
  if (thread_.joinable()) thread_.join();
  stopped_ = false;
  working_ = true;
  name_ = name;
  {
    const std::lock_guard lock(mutex_);
    end_.reset();
  }
  renew();
  thread_ = std::thread([this, machine, link, name, words, ended] {
    Result<MachineAnswer> answer = work(machine, link, name, words);
    if (ended) ended();
    const std::lock_guard lock(mutex_);
    end_ = std::move(answer);
    working_ = false;  // the wire is closed before anybody is told
  });
  return ++number_;
}

void MachineWorker::renew() { renewed_ = RealClock().now().count(); }

std::optional<Result<MachineAnswer>> MachineWorker::end() const {
  const std::lock_guard lock(mutex_);
  return end_;
}

Result<MachineAnswer> MachineWorker::work(const config::MachineProfile& machine, const LinkSpec& link,
                                          const std::string& name, const std::vector<std::string>& words) {
  const Result<std::unique_ptr<Link>> wire = open_link(link);
  if (!wire) return tl::unexpected<Error>(wire.error());
  RealClock clock;
  MachineBench bench{machine, link, **wire, clock};
  bench.stopped = [this] { return stopped_.load(); };
  bench.held = [&] { return clock.now() - Time(renewed_.load()) < Time(kPatience); };
  return perform_order(bench, name, words);
}

}  // namespace tiltfeed::daemon
