#pragma once
// A connection of a command to the shop's queue.

#include <functional>
#include <string>

#include "daemon/shop/shop_client.h"

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Where the queue is: --shop URL, else `queue` of a service's file, else $TILTFEED_SHOP.
struct ShopPlace {
  std::string url, config;
  void add_options(CLI::App& command);
  /// Errors: kUsage: nowhere said; kInput; those of the file.
  Result<std::string> find() const;
};

/// `work` on a connection. `again`: where the connection is lost in it, once more on another. Errors: those
/// of the connection and of `work`.
Result<void> in_shop(const ShopPlace& place, bool again,
                     const std::function<Result<void>(const ShopAsk&)>& work);

}  // namespace tiltfeed::daemon
