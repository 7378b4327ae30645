#pragma once
// What a spool keeps of the shop's jobs: under which claim each was taken, what became of it, and how much of
// that the shop's database has. Nothing here is ever removed: it is why no job comes twice.

#include <cstdint>
#include <string>

#include "daemon/shop/shop_record.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

struct SpoolTable;

/// Each call is one transaction, durable when it returns. Errors: kIo.
class SpoolShop {
 public:
  SpoolShop(const SpoolTable& table, const std::string& folder) : table_(table), folder_(folder) {}

  /// Without `offer` and `status`. At most 100 reports. `wants`: fewer than `ahead` jobs wait. The identity
  /// of the machine is made when there is none.
  Result<LocalShop> read(int ahead);
  Result<void> remember(const ShopMark& mark);
  /// As of ShopLedger.
  Result<bool> claim(const ShopJob& job, const ShopMark& mark);
  Result<void> confirm(const std::string& job, std::uint64_t serial);
  Result<void> drop(const std::string& job);
  Result<void> spoil(const std::string& job, const std::string& why);
  Result<void> told(const std::string& job, std::uint64_t version, std::uint64_t serial);
  Result<void> overrule(const std::string& job);
  Result<void> retell();
  /// Its state in this record; empty: not known.
  Result<std::string> state(const std::string& job);
  /// Something is not told yet.
  bool has_news();

 private:
  Result<void> transaction(const std::function<Result<void>()>& work);
  Result<void> raise_serial(std::uint64_t serial);
  Result<void> insert(const ShopJob& job);
  Result<std::vector<ShopReport>> select(const std::string& which);

  const SpoolTable& table_;
  const std::string& folder_;
};

}  // namespace tiltfeed::daemon
