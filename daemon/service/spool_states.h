#pragma once
// What a spool keeps of its machine's states for the shop's page, until the shop's database has them.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/shop/shop_record.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

struct SpoolTable;

/// Each call is one transaction, durable when it returns. Errors: kIo; nothing has changed then.
/// Properties: 1 Times grow, also where the clock is set back. 2 A state that equals the one before is not
/// kept. 3 Of a service that died the time between its last sign of life and its next start is `unknown`.
/// 4 What is told stays for eight days, so that a database that was restored can have it again; of all there
/// are kMost at most, the newest.
class SpoolStates {
 public:
  static constexpr std::uint64_t kMost = 20000, kKeptMs = 8ull * 24 * 3600 * 1000;
  static constexpr std::size_t kBatch = 500;

  SpoolStates(const SpoolTable& table, const std::string& folder) : table_(table), folder_(folder) {}

  /// The service begins at `at`, ms since 1970.
  Result<void> begin(std::uint64_t at);
  Result<void> note(std::uint64_t at, const std::string& state);
  /// A sign of life.
  Result<void> live(std::uint64_t at);
  /// The oldest that are not told, kBatch at most.
  Result<std::vector<ShopState>> untold();
  Result<void> told(std::uint64_t at);
  Result<void> retell();

 private:
  Result<std::optional<ShopState>> last();
  Result<void> insert(std::uint64_t at, const std::string& state);
  tl::unexpected<Error> error() const;

  const SpoolTable& table_;
  const std::string& folder_;
};

}  // namespace tiltfeed::daemon
