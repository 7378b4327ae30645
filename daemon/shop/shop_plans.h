#pragma once
// Orders of planning: a machine that has no processor for its jobs lets idle ones plan them. Both sides, one
// turn at a time.

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/shop/pg_connection.h"

namespace tiltfeed::daemon {

/// What a plan is made from: job, part, profile; and what is made: program, map, CL file, report.
inline constexpr std::size_t kPlanInputs = 3, kPlanOutputs = 4;

/// An order of this machine's: it stands in the database as long as it is among these.
struct PlanAsk {
  std::string id;    ///< UUID; another for each asking
  std::string name;  ///< the job's, for people
  std::array<std::string, kPlanInputs> files;
};

enum class PlanState : std::uint8_t { kOpen, kTaken, kDone, kFailed };

/// How an order stands.
struct PlanStanding {
  PlanState state = PlanState::kOpen;
  std::string helper;  ///< the machine that plans it, for people
  int percent = 0;
  std::string stage, note;
  bool operator==(const PlanStanding&) const = default;
};

/// An order of another machine's.
struct PlanTaken {
  std::string id;
  std::uint64_t token = 0;
  std::string name, asker;  ///< for people
  std::string from;         ///< the digests of its files, as planned_from has them
};

enum class HelpState : std::uint8_t {
  kPlanning,
  kDone,      ///< its files are there
  kFailed,    ///< `note` says why
  kGivenBack  ///< this machine needs its processors itself
};

/// What this machine plans for another.
struct PlanHelp {
  PlanTaken order;
  HelpState state = HelpState::kPlanning;
  int percent = 0;
  std::string stage, note;
  std::array<std::string, kPlanOutputs> files;  ///< of kDone
};

/// The service's side, as of one moment.
struct LocalPlans {
  std::string version;
  bool offers = false;  ///< it would plan for another now, or does
  std::vector<PlanAsk> asks;
  std::optional<PlanHelp> help;
};

/// Called by the shop's thread. Empty functions: a service that neither asks nor helps.
struct PlanLedger {
  std::function<Result<LocalPlans>()> read;
  std::function<Result<void>(const std::string& id, const PlanStanding&)> told;
  /// Called while it asks, after `told`: whether a machine that has no order would take one of these.
  std::function<Result<void>(bool idle)> helpers;
  /// Made: program, map, CL file, report, synced; the descriptors stay the caller's. `from`: the digests that
  /// the files of the order had.
  std::function<Result<void>(const std::string& id, const std::string& helper, const std::string& from,
                             const std::vector<int>& files)>
      returned;
  /// False: not now. The descriptors stay the caller's.
  std::function<Result<bool>(const PlanTaken&, const std::vector<int>& files)> take;
  /// The database has what became of it; or it is this machine's no more, and nobody waits for it.
  std::function<Result<void>(const std::string& id)> settled;
};

/// Properties: 1 What comes back is given to the service only whole, with the digests that are stated of it,
/// by a machine of this version, from the files that were sent. Else the order has failed. 2 An order that
/// the service does not have any more is taken out of the database. 3 A help that is not this machine's any
/// more is settled. 4 What the database says is bounded and checked. 5 An error at any place leaves both
/// sides so that the next turn goes on.
class ShopPlans {
 public:
  /// As of ShopClient: a file without a name, for what comes.
  using Scratch = std::function<int()>;
  ShopPlans(PlanLedger ledger, Scratch scratch) : ledger_(std::move(ledger)), scratch_(std::move(scratch)) {}
  /// Errors: those of `ask` and of the ledger.
  Result<void> turn(const ShopAsk& ask, const std::string& machine);

 private:
  Result<void> put(const ShopAsk& ask, const std::string& machine, const LocalPlans& local,
                   const PlanAsk& order);
  Result<void> look_after(const ShopAsk& ask, const std::string& machine, const LocalPlans& local);
  Result<void> hear(const ShopAsk& ask, const PgRow& row, const LocalPlans& local);
  Result<void> bring_back(const ShopAsk& ask, const PgRow& row, const LocalPlans& local);
  Result<void> help(const ShopAsk& ask, const std::string& machine, const PlanHelp& help,
                    const std::string& version);
  Result<void> give(const ShopAsk& ask, const std::string& machine, const PlanHelp& help,
                    const std::string& version);
  Result<void> take(const ShopAsk& ask, const std::string& machine, const std::string& version);
  Result<std::vector<int>> fetch(const ShopAsk& ask, const std::string& id, std::uint64_t token,
                                 std::size_t first, std::size_t count, std::string* from);

  PlanLedger ledger_;
  Scratch scratch_;
  std::map<std::string, std::string> sent_;  ///< by order: the digests of its files
  bool offered_ = false;
  unsigned looks_ = 0;
};

/// Of an order, for people.
struct ShopPlan {
  std::string id, name, asker, helper, state, stage;
  int percent = 0;
  std::int64_t asked = 0;  ///< when, by the database's clock, seconds since 1970
};
/// The oldest first, 200 at most.
Result<std::vector<ShopPlan>> view_plans(const ShopAsk& ask);

}  // namespace tiltfeed::daemon
