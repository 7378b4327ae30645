#include "daemon/service.h"

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <chrono>

#include "daemon/api_socket.h"
#include "daemon/job_desk.h"

namespace tiltfeed {

namespace {

using std::chrono::steady_clock;

constexpr int kTickMs = 100;
constexpr std::chrono::seconds kStatusInterval{1};
/// A machine that is told to hold stands long before; then the wire is let go of all the same.
constexpr std::chrono::seconds kLeaveLimit{15};

struct Signals {
  int fd = -1;
  Signals() {
    sigset_t set;
    sigemptyset(&set);
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, number);
    sigprocmask(SIG_BLOCK, &set, nullptr);
    fd = ::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
  }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;
  ~Signals() { ::close(fd); }
  /// 0: none.
  int next() const {
    signalfd_siginfo info{};
    return ::read(fd, &info, sizeof info) == sizeof info ? static_cast<int>(info.ssi_signo) : 0;
  }
};

/// WATCHDOG=1 at a third of the time that systemd grants, whoever calls.
class Watchdog {
 public:
  Watchdog() : interval_(watchdog_us() / 3) {}
  void feed() {
    if (interval_.count() == 0) return;
    const auto now = steady_clock::now().time_since_epoch().count();
    auto last = fed_.load();
    const auto due = last + std::chrono::duration_cast<steady_clock::duration>(interval_).count();
    if (now >= due && fed_.compare_exchange_strong(last, now)) notify("WATCHDOG=1");
  }

 private:
  std::chrono::microseconds interval_;
  std::atomic<steady_clock::rep> fed_{0};
};

std::string monotonic_us() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::to_string(now.tv_sec * 1000000LL + now.tv_nsec / 1000);
}

void reload(const std::string& path, JobDesk& desk) {
  notify("RELOADING=1\nMONOTONIC_USEC=" + monotonic_us());
  const Result<ServiceConfig> config = load_service_config(path);
  const Result<void> taken = config ? desk.reload(*config) : tl::unexpected<Error>(config.error());
  write_log(taken ? Severity::kInfo : Severity::kError,
            taken ? path + ": read again" : taken.error().message + "; the configuration stays as it was",
            {});
  notify("READY=1");
}

void wait_for_the_machine(JobDesk& desk, Watchdog& watchdog) {
  notify("STOPPING=1\nSTATUS=holding the machine");
  desk.leave();
  const auto limit = steady_clock::now() + kLeaveLimit;
  while (desk.busy() && steady_clock::now() < limit) {
    ::poll(nullptr, 0, kTickMs);
    watchdog.feed();
    desk.tick();
  }
}

}  // namespace

Result<void> serve(const std::string& config_path) {
  const Result<ServiceConfig> config = load_service_config(config_path);
  if (!config) return tl::unexpected<Error>(config.error());
  const Signals signals;  // before any thread is started, so that all of them leave signals to this one
  Watchdog watchdog;
  Result<JobDesk> desk = JobDesk::open(*config, [&watchdog] { watchdog.feed(); });
  if (!desk) return tl::unexpected<Error>(desk.error());
  Result<ApiSocket> socket = ApiSocket::open(config->socket);
  if (!socket) return tl::unexpected<Error>(socket.error());
  const ApiAnswer answer = [&](const std::string& line, std::uint32_t user, const std::vector<int>& files) {
    const Result<ApiRequest> request = parse_request(line);
    return request ? desk->answer(*request, user, files) : write_refusal(request.error());
  };
  notify("READY=1\nSTATUS=idle");
  auto told = steady_clock::now();
  for (;;) {
    std::vector<pollfd> polled{{signals.fd, POLLIN, 0}};
    socket->add_to(polled);
    ::poll(polled.data(), polled.size(), kTickMs);
    const int signal = signals.next();
    if (signal == SIGTERM || signal == SIGINT) break;
    if (signal == SIGHUP) reload(config_path, *desk);
    socket->serve(polled, answer);
    desk->tick();
    if (!desk->streaming()) watchdog.feed();
    if (steady_clock::now() - told < kStatusInterval) continue;
    told = steady_clock::now();
    notify("STATUS=" + desk->status());
  }
  wait_for_the_machine(*desk, watchdog);
  return {};
}

}  // namespace tiltfeed
