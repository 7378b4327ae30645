#pragma once
// What people ask of the shop's queue: to make it, to see it, to put a job into it, to decide where no
// machine may.

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/shop/shop_fit.h"
#include "daemon/shop/shop_live.h"
#include "daemon/shop/shop_plans.h"

namespace tiltfeed::daemon {

/// Makes the tables (true), or brings those of an earlier layout up to date (false). Errors: kUsage: they are
/// there as this version has them, or of a later one.
Result<bool> init_shop(const ShopAsk& ask);

struct ShopSubmission {
  std::string id;  ///< UUID; the same one never makes a second job
  std::string name;
  bool program = false;
  ShopNeeds needs;
  std::vector<int> files;  ///< open, regular; program; or job, part
};
/// All or nothing; its number. Files that the database has lost of a job that still needs them are put back.
/// Errors: kInput: a file is empty, too large (kMostShopBytes) or changes
/// meanwhile; kUsage: the id is another job's.
Result<std::uint64_t> submit_to_shop(const ShopAsk& ask, const ShopSubmission& job);

struct ShopMachine {
  std::string id, name, status;
  ShopOffer offer;
  double silent_seconds = 0.0;
  std::int64_t seen = 0;  ///< when it was heard last, by the database's clock, seconds since 1970
  ShopLive live;          ///< what it was at then
  bool back = true;       ///< it has told its part since the server's start, or left in order
  bool away = false;      ///< it left in order
  std::vector<ShopUsage> usage = {};

  /// What `live` says holds: it was heard lately, and has not left.
  bool is_heard() const { return !away && silent_seconds <= kShopSilent; }
};
struct ShopEntry {
  std::uint64_t number = 0;
  std::string id, name, state, note, machine;
  bool program = false;
  std::string needs;  ///< for people
  std::uint64_t blocks = 0, executed = 0;
  std::int64_t submitted = 0, changed = 0;  ///< seconds since 1970
  bool fits_one = true;                     ///< of an open job: a machine that is known could have it
  std::string why_not;                      ///< else: each machine's reason
};
struct ShopView {
  std::int64_t now = 0;  ///< of the database, seconds since 1970
  std::uint64_t epoch = 0;
  std::string halted;
  std::vector<ShopMachine> machines;
  std::vector<ShopEntry> jobs;  ///< the newest first, 1,000 at most
  std::vector<ShopPlan> plans;
};
/// Which jobs: those that are neither done nor withdrawn; with those of the last day, behind them; or all.
enum class ShopPick : std::uint8_t { kOpen, kLastDay, kAll };
/// Without `usage`.
Result<ShopView> view_shop(const ShopAsk& ask, ShopPick pick);
/// Of one that waits: whether a machine could have it, with each one's reason. Pure.
void judge_fit(const ShopNeeds& needs, const std::vector<ShopMachine>& machines, ShopEntry& entry);

/// A job that has begun nowhere: offered again (`open`), or withdrawn. The machine that has it gives it up
/// when it hears of that. What is said of it. Errors: kUsage: no such job, or it has begun.
Result<std::string> take_back(const ShopAsk& ask, std::uint64_t number, bool open);

/// A new epoch: the queue goes on as the database has it now.
Result<std::uint64_t> raise_epoch(const ShopAsk& ask);

}  // namespace tiltfeed::daemon
