#include "daemon/shop/shop_thread.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <random>
#include <thread>

#include "daemon/shop/shop_layout.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPoll{5000}, kPollSpread{5000};
/// A notification goes to all machines of the shop at once: who has just looked does not look again before
/// this, or the longer one where it has no room for a job.
constexpr milliseconds kCalm{1000}, kCalmSpread{2000}, kFullCalm{3000};
constexpr milliseconds kFirstPause{1000}, kLongestPause{10000};
/// A database that is no shop's, or of another version, is looked at again.
constexpr milliseconds kWrongPause{30000};
constexpr milliseconds kGoodbye{1000};
constexpr std::chrono::seconds kEndPatience{2};

}  // namespace

struct ShopThread::Work {
  Work(std::string its_url, ShopLedger ledger, PlanLedger plans)
      : url(std::move(its_url)), client(std::move(ledger), std::move(plans)) {}
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;
  ~Work() {
    ::close(stop);
    ::close(waken);
  }

  void run();
  std::optional<Error> serve(PgConnection& database);
  void complain(const Error& error);
  bool stopped(milliseconds within) const;
  void rest(std::chrono::steady_clock::time_point until) const;
  milliseconds spread(milliseconds from, milliseconds to) {
    return milliseconds(std::uniform_int_distribution<long>(from.count(), to.count())(random));
  }

  std::string url;
  ShopClient client;
  int stop = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK), waken = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  std::mt19937_64 random{std::random_device{}()};
  std::string said;  ///< the trouble that the log has already
  std::mutex mutex;
  std::condition_variable over;
  bool ended = false;
};

/// True at the end; after that much time, false.
bool ShopThread::Work::stopped(milliseconds within) const {
  pollfd polled{stop, POLLIN, 0};
  return ::poll(&polled, 1, static_cast<int>(within.count())) > 0;
}

/// Until then, the end, or a wake.
void ShopThread::Work::rest(std::chrono::steady_clock::time_point until) const {
  const auto left = std::chrono::ceil<milliseconds>(until - std::chrono::steady_clock::now());
  pollfd polled[] = {{stop, POLLIN, 0}, {waken, POLLIN, 0}};
  if (left.count() > 0) static_cast<void>(::poll(polled, 2, static_cast<int>(left.count())));
}

void ShopThread::Work::complain(const Error& error) {
  if (error.code == Code::kCancelled) return;
  client.ledger().show("not connected: " + error.message);
  if (error.message != said)
    client.ledger().log(true, "the shop's queue: " + error.message + "; it is tried again");
  said = error.message;
}

/// Until it is lost, or the end.
std::optional<Error> ShopThread::Work::serve(PgConnection& database) {
  const ShopAsk ask = [&](const std::string& sql, const std::vector<PgValue>& values) {
    return database.ask(sql, values);
  };
  if (const auto heard = database.ask(kShopListen); !heard) return heard.error();
  while (!stopped(milliseconds(0))) {
    eventfd_t count = 0;
    static_cast<void>(::eventfd_read(waken, &count));
    const auto begun = std::chrono::steady_clock::now();
    if (const Result<void> heard = database.forget_notifications(); !heard) return heard.error();
    const Result<void> turned = client.turn(ask);
    if (!turned && (database.lost() || turned.error().code != Code::kIo)) return turned.error();
    if (!turned) complain(turned.error());  // the spool's: the connection is good
    if (turned && !said.empty()) client.ledger().log(false, "the shop's queue: connected again");
    if (turned) said.clear();
    const Result<bool> waited = database.wait(turned ? waken : -1, spread(kPoll, kPoll + kPollSpread));
    if (!waited) return waited.error();
    const milliseconds calm = client.has_room() ? kCalm : kFullCalm;
    rest(begun + spread(calm, calm + kCalmSpread));
  }
  return std::nullopt;
}

void ShopThread::Work::run() {
  milliseconds pause = kFirstPause;
  while (!stopped(milliseconds(0))) {
    Result<PgConnection> database = PgConnection::connect(url, stop);
    std::optional<Error> why;
    if (!database) {
      why = database.error();
    } else if (!stopped(milliseconds(0))) {
      why = serve(*database);
      pause = kFirstPause;
      if (!why) static_cast<void>(database->last_words(kShopBye, {client.machine()}, kGoodbye));
    }
    if (!why || why->code == Code::kCancelled || stopped(milliseconds(0))) break;
    complain(*why);
    const bool wrong = why->code == Code::kUsage;
    if (stopped(wrong ? kWrongPause : spread(pause / 2, pause))) break;
    pause = std::min(pause * 2, kLongestPause);
  }
  const std::lock_guard lock(mutex);
  ended = true;
  over.notify_all();
}

ShopThread::ShopThread(const std::string& url, ShopLedger ledger, PlanLedger plans)
    : work_(std::make_shared<Work>(url, std::move(ledger), std::move(plans))) {
  std::thread([work = work_] { work->run(); }).detach();
}

void ShopThread::end() const { static_cast<void>(::eventfd_write(work_->stop, 1)); }

ShopThread::~ShopThread() {
  end();
  std::unique_lock lock(work_->mutex);
  work_->over.wait_for(lock, kEndPatience, [this] { return work_->ended; });
}

void ShopThread::wake() const { static_cast<void>(::eventfd_write(work_->waken, 1)); }

}  // namespace tiltfeed::daemon
