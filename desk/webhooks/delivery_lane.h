#pragma once
// One receiver: what waits for it goes out in order, one at a time, until it is taken, refused or given up.

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/webhook_keys.h"
#include "desk/webhooks/delivery_store.h"
#include "desk/webhooks/http_posts.h"

namespace tiltfeed::desk {

struct LaneCounts {
  std::uint64_t taken = 0, in_vain = 0, refused = 0, given_up = 0;  ///< in_vain: tries
};

/// Properties: a message goes out only when none before it waits; holds one message in memory; the log has
/// neither the secret nor more of the URL than its host.
class DeliveryLane {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Log = std::function<void(const std::string&)>;

  /// `store` outlives it.
  DeliveryLane(config::Webhook hook, DeliveryStore& store, Log log);

  const config::Webhook& hook() const { return hook_; }
  /// There may be more in the table.
  void wake() { stale_ = true; }
  /// Looks into the table where that is due. True: the message is to go out now.
  bool look(Time now, std::int64_t wall);
  struct Request {
    std::vector<std::string> headers;
    std::string body;
  };
  /// Requires: look() was true. `wall`: seconds since 1970.
  Request begin(std::int64_t wall);
  /// What came of it. `chance`: as in pause_after().
  void end(const PostAnswer& answer, double chance, Time now, std::int64_t wall);
  /// Until look() is due; at most `most`.
  std::chrono::milliseconds patience(Time now, std::chrono::milliseconds most) const;
  const LaneCounts& counts() const { return counts_; }

 private:
  void load(Time now, std::int64_t wall);
  void let_go(Time now);
  void put_off(const PostAnswer& answer, double chance, Time now, std::int64_t wall);
  std::string answered(const PostAnswer& answer) const;
  void say(const std::string& text);

  config::Webhook hook_;
  DeliveryStore& store_;
  Log log_;
  std::optional<Delivery> head_;
  bool stale_ = true, sending_ = false;
  bool over_ = false;  // the head is settled, and could not be taken out of the table
  Time due_;
  std::string said_;  // last in the log about a receiver that does not take, or about the table
  LaneCounts counts_;
};

}  // namespace tiltfeed::desk
