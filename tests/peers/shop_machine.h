#pragma once
// A machine of a shop without its service: a real spool and its record, an operator, and a client that dies
// at any call.

#include <fcntl.h>
#include <unistd.h>

#include "daemon/service/spool.h"
#include "daemon/service/spool_shop.h"
#include "daemon/service/spool_states.h"
#include "daemon/shop/shop_client.h"
#include "tests/peers/shop_database.h"
#include "tests/texts/folder.h"

namespace tiltfeed {

class ShopMachine {
 public:
  ShopMachine(const std::string& folder, std::mt19937& random) : folder_(folder), random_(random) { start(); }

  /// As after a kill: what was not in the table is gone.
  void start() {
    client_.reset();
    spool_.reset();
    auto spool = daemon::Spool::open(folder_);
    if (!spool) throw std::runtime_error(spool.error().message);
    spool_ = std::make_unique<daemon::Spool>(std::move(*spool));
    client_ = std::make_unique<daemon::ShopClient>(ledger());
  }
  /// `dies`: how often a call of the ledger is the process's last, in a thousand.
  void turn(ShopDatabase& database, int lost, int dies) {
    dies_ = dies;
    dead_ = false;
    last_ = client_->turn(database.asked(random_, lost));
    if (dead_) start();
  }
  /// A database that answers as it likes.
  Result<void> turn_with(const daemon::ShopAsk& ask) {
    dies_ = 0;
    dead_ = false;
    return last_ = client_->turn(ask);
  }
  /// Starts one job that is ready, and cuts it to its end; what was cut.
  std::vector<std::string> operate() {
    std::vector<std::string> cut;
    const auto jobs = spool_->list();
    for (daemon::SpooledJob job : *jobs) {
      if (job.state == daemon::JobState::kReceived) {
        job.state = daemon::JobState::kReady;
        (void)spool_->update(job);
      } else if (job.state == daemon::JobState::kReady) {
        job.state = daemon::JobState::kRunning;
        (void)spool_->update(job);
        cut.push_back(job.shop);
        job.state = daemon::JobState::kDone;
        (void)spool_->update(job);
        break;
      }
    }
    return cut;
  }
  daemon::Spool& spool() { return *spool_; }
  const Result<void>& last() const { return last_; }
  const std::string& shown() const { return shown_; }
  std::string identity() { return spool_->shop().read(1)->machine; }

 private:
  /// A call that is never made, since the process is dead; or that is its last.
  bool gone(bool before) {
    if (before && !dead_ && static_cast<int>(random_() % 1000) < dies_) dead_ = true;
    return dead_;
  }
  template <class T>
  Result<T> unless_dead(const std::function<Result<T>()>& work) {
    const bool half = random_() % 2 == 0;
    const Result<void> none = fail(Code::kCancelled, "dead");
    if (dead_ || (half && gone(true))) return tl::unexpected<Error>(none.error());
    Result<T> done = work();
    if (!half && gone(true)) return tl::unexpected<Error>(none.error());
    return done;
  }
  Result<void> arrive(const daemon::ShopJob& job, const std::vector<int>& files) {
    if (*spool_->shop().state(job.ticket.job) != "accepted") return {};
    if (const auto before = *spool_->find_shop(job.ticket.job)) (void)spool_->remove(before->id);
    daemon::SpooledJob taken;
    taken.name = job.name;
    taken.program = true;
    taken.shop = job.ticket.job;
    const auto id = spool_->begin(taken);
    if (!id) return tl::unexpected<Error>(id.error());
    if (gone(true)) return fail(Code::kCancelled, "dead in the middle of the files");
    taken.id = *id;
    std::string text(job.files[0].bytes, '\0');
    const ssize_t read = ::pread(files[0], text.data(), text.size(), 0);
    std::ofstream(spool_->file(*id, "program.nc")) << text.substr(0, static_cast<std::size_t>(read));
    return spool_->finish(taken);
  }
  daemon::ShopLedger ledger() {
    daemon::ShopLedger l;
    using R = Result<void>;
    l.read = [this] {
      return unless_dead<daemon::LocalShop>([&] {
        auto local = spool_->shop().read(ahead_);
        if (!local) return local;
        local->offer.profile = "wide";
        if (auto states = spool_->shop_states().untold()) local->states = *states;
        return local;
      });
    };
    l.remember = [this](const daemon::ShopMark& m) {
      return unless_dead<void>([&] { return spool_->shop().remember(m); });
    };
    l.claim = [this](const daemon::ShopJob& j, const daemon::ShopMark& m) {
      return unless_dead<bool>([&] { return spool_->shop().claim(j, m); });
    };
    l.confirm = [this](const std::string& j, std::uint64_t s) -> R {
      return unless_dead<void>([&] { return spool_->shop().confirm(j, s); });
    };
    l.drop = [this](const std::string& j) -> R {
      return unless_dead<void>([&] { return spool_->shop().drop(j); });
    };
    l.arrive = [this](const daemon::ShopJob& j, const std::vector<int>& f) -> R {
      return unless_dead<void>([&] { return arrive(j, f); });
    };
    l.spoil = [this](const std::string& j, const std::string& why) -> R {
      return unless_dead<void>([&] { return spool_->shop().spoil(j, why); });
    };
    l.told = [this](const std::string& j, std::uint64_t v, std::uint64_t s) -> R {
      return unless_dead<void>([&] { return spool_->shop().told(j, v, s); });
    };
    l.overrule = [this](const std::string& j, const std::string&) -> R {
      return unless_dead<void>([&]() -> R {
        (void)spool_->shop().overrule(j);
        if (auto job = *spool_->find_shop(j); job && job->state < daemon::JobState::kRunning) {
          job->state = daemon::JobState::kFailed;
          (void)spool_->update(*job);
        }
        return {};
      });
    };
    l.told_states = [this](std::uint64_t at) -> R {
      return unless_dead<void>([&] { return spool_->shop_states().told(at); });
    };
    l.retell = [this]() -> R {
      return unless_dead<void>([&]() -> R {
        (void)spool_->shop_states().retell();
        return spool_->shop().retell();
      });
    };
    l.scratch = [this] { return ::open(folder_.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600); };
    l.log = [](bool, const std::string&) {};
    l.show = [this](const std::string& text) { shown_ = text; };
    return l;
  }

  std::string folder_, shown_;
  std::mt19937& random_;
  std::unique_ptr<daemon::Spool> spool_;
  std::unique_ptr<daemon::ShopClient> client_;
  Result<void> last_;
  int dies_ = 0, ahead_ = 2;
  bool dead_ = false;
};

}  // namespace tiltfeed
