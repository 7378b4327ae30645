#pragma once
// Deliveries that wait, and what has been told: a table in the desk's state folder, which outlives the desk.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "desk/webhooks/hook_message.h"
#include "desk/webhooks/run_cursor.h"

namespace tiltfeed::desk {

/// What is known of a service from before.
struct KnownService {
  std::string machine;
  std::optional<RunMark> mark;             ///< nothing: never seen
  std::optional<std::int64_t> lost_since;  ///< it is told that it does not answer
};

struct Delivery {
  std::int64_t number = 0;
  std::string id, body;
  std::int64_t queued = 0, due = 0;  ///< seconds since 1970
  int tries = 0;
};

/// For one URL.
struct Addressed {
  std::string url;
  HookMessage message;
};

/// Properties: messages and the mark behind them are written together, or neither; a message waits once for
/// a URL; of more than kMostWaiting for one the oldest go; the file is open in one desk only.
class DeliveryStore {
 public:
  static constexpr std::size_t kMostWaiting = 1000;

  /// Makes the folder, for its owner alone, where it is not there. Errors: kIo with what to do.
  static Result<DeliveryStore> open(const std::string& folder);
  DeliveryStore(DeliveryStore&& other) noexcept;
  DeliveryStore& operator=(DeliveryStore&&) = delete;
  ~DeliveryStore();

  Result<KnownService> known(const std::string& socket) const;
  /// How many were dropped for room.
  Result<std::uint64_t> keep(const std::string& socket, const KnownService& known,
                             const std::vector<Addressed>& messages, std::int64_t now);
  /// The oldest that waits for a URL.
  Result<std::optional<Delivery>> first(const std::string& url) const;
  Result<void> put_off(std::int64_t number, int tries, std::int64_t due);
  Result<void> remove(std::int64_t number);
  Result<std::uint64_t> waiting(const std::string& url) const;
  /// Those for URLs that are not named any more; how many.
  Result<std::uint64_t> drop_others(const std::vector<std::string>& urls);

 private:
  struct Table;
  explicit DeliveryStore(std::unique_ptr<Table> table);
  std::unique_ptr<Table> table_;
};

}  // namespace tiltfeed::desk
