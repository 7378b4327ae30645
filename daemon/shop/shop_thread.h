#pragma once
// The thread that talks with the shop's database, beside everything that the machine needs.

#include <memory>
#include <string>

#include "daemon/shop/shop_client.h"

namespace tiltfeed::daemon {

/// Connects, and connects again after a loss (1 to 10 s, at random). A turn every 5 to 10 s, at each wake(),
/// and at a notification: at once, but 1 to 3 s after the turn before, or 3 to 5 s where there is no room.
class ShopThread {
 public:
  ShopThread(const std::string& url, ShopLedger ledger, PlanLedger plans = {});
  ShopThread(const ShopThread&) = delete;
  ShopThread& operator=(const ShopThread&) = delete;
  /// Waits for the end 2 s at most: a thread that the system keeps with the name of a host ends by itself
  /// later, and touches nothing then.
  ~ShopThread();
  /// It is to end: it says goodbye to the database where it is connected. Returns at once.
  void end() const;
  /// Something is to be told, or there is room. From any thread.
  void wake() const;

 private:
  struct Work;
  std::shared_ptr<Work> work_;
};

}  // namespace tiltfeed::daemon
