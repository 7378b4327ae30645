#pragma once
// Asks the service's run history again and again, and makes messages of what has ended.

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "desk/service/service_link.h"
#include "desk/webhooks/delivery_store.h"
#include "desk/webhooks/run_cursor.h"

namespace tiltfeed::desk {

struct EventCalls {
  /// Writes down what is known now, and the messages with it. False: it cannot; they come again.
  std::function<bool(const KnownService&, const std::vector<HookMessage>&)> keep;
  std::function<void(const std::string&)> log;
};

/// Properties: what was kept is made no second time; a service that was seen once and then has not answered
/// for kLostAfter is a fault, told once until it answers again.
class EventWatch {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::milliseconds kPeriod{1000}, kSilence{3000}, kLostAfter{10'000};

  EventWatch(std::string socket, KnownService known, EventCalls calls);
  EventWatch(EventWatch&&) = delete;

  /// Asks what is due. `wall`: seconds since 1970.
  void look(Time now, std::int64_t wall);
  std::vector<int> descriptors() const { return link_.descriptors(); }
  void hear(int descriptor) { (void)link_.hear(descriptor); }
  /// Until look() is due.
  std::chrono::milliseconds patience(Time now) const;

 private:
  void ask();
  void take(const Result<std::string>& reply);
  void take_machine(const std::string& reply);
  void take_page(const HistoryPage& page);
  void miss(const std::string& why);
  void find();
  void tell_lost();
  bool keep(const KnownService& known, const std::vector<HookMessage>& messages);
  void say(const std::string& text);

  EventCalls calls_;
  KnownService known_;  // as it is kept
  RunCursor cursor_;
  std::string machine_;  // empty: the service is to be asked
  Time now_, next_, asked_;
  std::int64_t wall_ = 0;
  bool asking_ = false, silent_ = false;
  struct Lost {
    std::int64_t since;
    Time due;
    std::string why;
  };
  std::optional<Lost> lost_;
  std::string said_;  // last in the log
  ServiceLink link_;
};

}  // namespace tiltfeed::desk
