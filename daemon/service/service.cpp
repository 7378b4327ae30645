#include "daemon/service/service.h"

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <chrono>

#include "daemon/service/api_socket.h"
#include "daemon/service/job_service_thread.h"
#include "daemon/service/shop_gate.h"
#include "daemon/shop/pg_connection.h"
#include "daemon/shop/shop_thread.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::steady_clock;

constexpr int kTickMs = 100;

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

void reload(const std::string& path, JobService& jobs) {
  notify("RELOADING=1\nMONOTONIC_USEC=" + monotonic_us());
  const Result<config::ServiceConfig> config = config::load_service_config(path);
  const Result<void> taken = config ? jobs.reload(*config) : tl::unexpected<Error>(config.error());
  write_log(taken ? Severity::kInfo : Severity::kError,
            taken ? path + ": read again" : taken.error().message + "; the configuration stays as it was",
            {});
  notify("READY=1");
}

/// Who is on the socket: orders to the job on the machine are answered here, the rest at the job service.
class Front {
 public:
  Front(JobService& jobs, JobServiceThread& thread, ApiSocket& socket)
      : jobs_(jobs), thread_(thread), socket_(socket) {}

  void turn(int signal_fd) {
    std::vector<pollfd> polled{{signal_fd, POLLIN, 0}, {thread_.wake_fd(), POLLIN, 0}};
    socket_.add_to(polled);
    ::poll(polled.data(), polled.size(), kTickMs);
    for (const auto& [client, line] : thread_.take_replies()) socket_.reply(client, line, take_);
    socket_.serve(polled, take_);
  }

 private:
  void take(Asked asked) {
    const Result<ApiRequest> request = parse_request(asked.line);
    if (!request) return socket_.reply(asked.client, write_refusal(request.error()), take_);
    if (const std::optional<std::string> done = jobs_.order(*request)) {
      socket_.reply(asked.client, *done, take_);
      return thread_.post(
          [request = *request, user = asked.user](JobService& jobs) { jobs.note_request(request, user); });
    }
    if (socket_.waiting() > ApiSocket::kWaiting)
      return socket_.reply(asked.client, write_refusal({Code::kLimit, "the service is busy; ask again"}),
                           take_);
    const auto whole = std::make_shared<Asked>(std::move(asked));
    thread_.post([request = *request, whole, &thread = thread_](JobService& jobs) {
      jobs.ask(
          request, whole->user, std::move(whole->files),
          [&thread, client = whole->client](std::string line) { thread.reply(client, std::move(line)); });
    });
  }

  JobService& jobs_;
  JobServiceThread& thread_;
  ApiSocket& socket_;
  const ApiTaker take_ = [this](Asked asked) { take(std::move(asked)); };
};

}  // namespace

Result<void> serve(const std::string& config_path, const std::string& version) {
  // Whoever may write into the spool decides what the machine is given.
  ::umask(::umask(0) | S_IWGRP | S_IRWXO);
  const Result<config::ServiceConfig> config = config::load_service_config(config_path);
  if (!config) return tl::unexpected<Error>(config.error());
  if (!config->queue.url.empty())
    if (const Result<void> good = check_pg_url(config->queue.url); !good)
      return fail(good.error().code, config_path + ": queue: " + good.error().message);
  const Signals signals;  // before any thread is started, so that all of them leave signals to this one
  Watchdog watchdog;
  Result<JobService> jobs = JobService::open(*config, [&watchdog] { watchdog.feed(); });
  if (!jobs) return tl::unexpected<Error>(jobs.error());
  Result<ApiSocket> socket = ApiSocket::open(config->socket);
  if (!socket) return tl::unexpected<Error>(socket.error());
  // Before the job service's thread, so that the machine is held first when the service ends.
  ShopGate gate(config->spool, config->machine.model.name);
  std::optional<ShopThread> shop;
  if (!config->queue.url.empty())
    jobs->on_shop_news([&shop] {
      if (shop) shop->wake();
    });
  JobServiceThread thread(*jobs, [&watchdog] { watchdog.feed(); });
  gate.open(thread);
  if (!config->queue.url.empty())
    thread.post([&](JobService&) { shop.emplace(config->queue.url, gate.ledger(), gate.plans(version)); });
  Front front(*jobs, thread, *socket);
  notify("READY=1\nSTATUS=idle");
  for (;;) {
    front.turn(signals.fd);
    const int signal = signals.next();
    if (signal == SIGTERM || signal == SIGINT) {
      thread.post([&shop](JobService&) {
        if (shop) shop->end();
      });
      gate.close();
      return {};
    }
    if (signal == SIGHUP) thread.post([&](JobService& at) { reload(config_path, at); });
  }
}

}  // namespace tiltfeed::daemon
