#pragma once
// Receivers of the shop are told when a run is done and when it ends in a fault.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "config/webhook_keys.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

struct WebhookOptions {
  std::vector<config::Webhook> hooks;
  std::string state;   ///< folder where deliveries wait
  std::string socket;  ///< of the machine's service
};

/// Property: works on a thread of its own, which shares nothing with the page and its watch.
class Webhooks {
 public:
  /// `log`: is called from that thread, a line at a time. Errors: kIo: the state folder; kUsage: there is no
  /// service to ask.
  static Result<std::unique_ptr<Webhooks>> start(const WebhookOptions& options,
                                                 std::function<void(const std::string&)> log);
  Webhooks(Webhooks&&) = delete;
  /// Ends at once: what is on its way is sent again by the next desk, under the same id.
  ~Webhooks();

 private:
  struct Work;
  explicit Webhooks(std::unique_ptr<Work> work);
  std::unique_ptr<Work> work_;
};

}  // namespace tiltfeed::desk
