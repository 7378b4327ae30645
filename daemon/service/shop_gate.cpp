#include "daemon/service/shop_gate.h"

#include <fcntl.h>
#include <unistd.h>

#include <condition_variable>
#include <mutex>
#include <optional>

namespace tiltfeed::daemon {

namespace {

tl::unexpected<Error> over() { return fail(Code::kCancelled, "the service is ending"); }

/// One answer, from another thread; when nobody holds its other end any more there will be none.
template <class T>
class Awaited {
 public:
  void give(Result<T> answer) {
    const std::lock_guard lock(mutex_);
    if (!answer_) answer_ = std::move(answer);
    given_.notify_all();
  }
  Result<T> wait() {
    std::unique_lock lock(mutex_);
    given_.wait(lock, [this] { return answer_.has_value(); });
    return std::move(*answer_);
  }

 private:
  std::mutex mutex_;
  std::condition_variable given_;
  std::optional<Result<T>> answer_;
};

/// The end that is held by who is to answer.
template <class T>
class Owed {
 public:
  explicit Owed(std::shared_ptr<Awaited<T>> awaited) : awaited_(std::move(awaited)) {}
  Owed(const Owed&) = delete;
  Owed& operator=(const Owed&) = delete;
  ~Owed() { awaited_->give(over()); }
  void give(Result<T> answer) { awaited_->give(std::move(answer)); }

 private:
  std::shared_ptr<Awaited<T>> awaited_;
};

}  // namespace

struct ShopGate::Way {
  std::mutex mutex;
  JobServiceThread* thread = nullptr;  ///< none: closed
  std::string spool, machine;

  bool post(std::function<void(JobService&)> task) {
    const std::lock_guard lock(mutex);
    if (thread == nullptr) return false;
    thread->post(std::move(task));
    return true;
  }
  /// `work` gives its answer to what it is handed, at once or later.
  template <class T>
  Result<T> ask(std::function<void(JobService&, std::shared_ptr<Owed<T>>)> work) {
    const auto awaited = std::make_shared<Awaited<T>>();
    {
      auto owed = std::make_shared<Owed<T>>(awaited);
      if (!post([work = std::move(work), owed = std::move(owed)](JobService& jobs) { work(jobs, owed); }))
        return over();
    }
    return awaited->wait();
  }
  template <class T>
  Result<T> ask_now(std::function<Result<T>(JobService&)> work) {
    return ask<T>([work = std::move(work)](JobService& jobs, const std::shared_ptr<Owed<T>>& owed) {
      owed->give(work(jobs));
    });
  }
  Result<void> keep(std::function<Result<void>(SpoolShop)> work) {
    return ask_now<void>([work = std::move(work)](JobService& jobs) { return work(jobs.shop_record()); });
  }
  Result<void> arrive(const ShopJob& job, const std::vector<int>& files) {
    HandedFiles own;
    for (const int file : files) {
      const int copy = ::fcntl(file, F_DUPFD_CLOEXEC, 0);
      if (copy < 0) return fail(Code::kIo, "no descriptor is left for a file of the shop");
      own.add(copy);
    }
    const auto handed = std::make_shared<HandedFiles>(std::move(own));
    const Result<std::string> arrived =
        ask<std::string>([job, handed](JobService& jobs, const std::shared_ptr<Owed<std::string>>& owed) {
          jobs.take_from_shop(job, std::move(*handed),
                              [owed](Result<std::string> answer) { owed->give(std::move(answer)); });
        });
    if (!arrived) return tl::unexpected<Error>(arrived.error());
    return {};
  }
};

ShopGate::ShopGate(const std::string& spool, const std::string& machine) : way_(std::make_shared<Way>()) {
  way_->spool = spool;
  way_->machine = machine;
}

void ShopGate::open(JobServiceThread& thread) {
  const std::lock_guard lock(way_->mutex);
  way_->thread = &thread;
}

void ShopGate::close() {
  const std::lock_guard lock(way_->mutex);
  way_->thread = nullptr;
}

ShopLedger ShopGate::ledger() const {
  ShopLedger ledger;
  const auto way = way_;
  ledger.read = [way] { return way->ask_now<LocalShop>([](JobService& jobs) { return jobs.read_shop(); }); };
  ledger.remember = [way](const ShopMark& mark) {
    return way->keep([mark](SpoolShop record) { return record.remember(mark); });
  };
  ledger.claim = [way](const ShopJob& job, const ShopMark& mark) {
    return way->ask_now<bool>([job, mark](JobService& jobs) { return jobs.shop_record().claim(job, mark); });
  };
  ledger.confirm = [way](const std::string& job, std::uint64_t serial) {
    return way->keep([job, serial](SpoolShop record) { return record.confirm(job, serial); });
  };
  ledger.drop = [way](const std::string& job) {
    return way->keep([job](SpoolShop record) { return record.drop(job); });
  };
  ledger.spoil = [way](const std::string& job, const std::string& why) {
    return way->keep([job, why](SpoolShop record) { return record.spoil(job, why); });
  };
  ledger.told = [way](const std::string& job, std::uint64_t version, std::uint64_t serial) {
    return way->keep([=](SpoolShop record) { return record.told(job, version, serial); });
  };
  ledger.told_states = [way](std::uint64_t at) {
    return way->ask_now<void>([at](JobService& jobs) { return jobs.shop_states().told(at); });
  };
  ledger.retell = [way] {
    return way->ask_now<void>([](JobService& jobs) {
      Result<void> again = jobs.shop_record().retell();
      return again ? jobs.shop_states().retell() : again;
    });
  };
  ledger.overrule = [way](const std::string& job, const std::string& why) {
    return way->ask_now<void>([job, why](JobService& jobs) { return jobs.overrule(job, why); });
  };
  ledger.arrive = [way](const ShopJob& job, const std::vector<int>& files) {
    return way->arrive(job, files);
  };
  ledger.scratch = [way] {
    constexpr mode_t kOwner = 0600;
    return ::open(way->spool.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, kOwner);
  };
  ledger.log = [way](bool bad, const std::string& text) {
    LogFields fields;
    fields.machine = way->machine;
    write_log(bad ? Severity::kWarning : Severity::kInfo, text, fields);
  };
  ledger.show = [way](const std::string& text) {
    way->post([text](JobService& jobs) { jobs.show_shop(text); });
  };
  return ledger;
}

PlanLedger ShopGate::plans(const std::string& version) const {
  PlanLedger plans;
  const auto way = way_;
  plans.read = [way, version] {
    Result<LocalPlans> local = way->ask_now<LocalPlans>([](JobService& jobs) { return jobs.read_plans(); });
    if (local) local->version = version;
    return local;
  };
  plans.told = [way](const std::string& id, const PlanStanding& standing) {
    return way->ask_now<void>([id, standing](JobService& jobs) { return jobs.plan_told(id, standing); });
  };
  plans.helpers = [way](bool idle) {
    return way->ask_now<void>([idle](JobService& jobs) { return jobs.plan_helpers(idle); });
  };
  // The descriptors stay open until the job service has answered, or never will.
  plans.returned = [way](const std::string& id, const std::string& helper, const std::string& from,
                         const std::vector<int>& files) {
    return way->ask_now<void>([=](JobService& jobs) { return jobs.plan_returned(id, helper, from, files); });
  };
  plans.take = [way](const PlanTaken& order, const std::vector<int>& files) {
    return way->ask_now<bool>([order, files](JobService& jobs) { return jobs.plan_take(order, files); });
  };
  plans.settled = [way](const std::string& id) {
    return way->ask_now<void>([id](JobService& jobs) { return jobs.plan_settled(id), Result<void>(); });
  };
  return plans;
}

}  // namespace tiltfeed::daemon
