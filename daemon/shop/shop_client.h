#pragma once
// The machine's side of the shop's queue: what is asked of the database in one turn, and what is kept of the
// answers. It knows neither sockets nor clocks.

#include <functional>
#include <string>
#include <vector>

#include "daemon/shop/pg_connection.h"
#include "daemon/shop/shop_plans.h"
#include "daemon/shop/shop_record.h"

namespace tiltfeed::daemon {

/// Properties: 1 A job is recorded as claimed before the database is told that it is accepted, and comes into
/// the spool only after the database has confirmed that. 2 A job that was recorded once never comes into the
/// spool again. 3 Where the database is behind the mark, or says that it is halted, reports are sent, and
/// nothing is claimed or accepted. 4 What the database says is bounded and checked before it is used. 5 An
/// error at any place leaves a record from which the next turn goes on. 6 A job that has not begun here, and
/// that the database has given to another or taken back, is overruled.
class ShopClient {
 public:
  /// `plans`: orders of planning, behind all else; what is wrong with them alone is logged.
  explicit ShopClient(ShopLedger ledger, PlanLedger plans = {})
      : ledger_(std::move(ledger)), plans_(std::move(plans), ledger_.scratch) {}
  /// All that can be done now. Errors: those of `ask` and of the ledger.
  Result<void> turn(const ShopAsk& ask);
  /// This machine's identity; empty before the first turn.
  const std::string& machine() const { return machine_; }
  ShopLedger& ledger() { return ledger_; }
  /// There was room for one more at the end of the last turn.
  bool has_room() const { return room_; }

 private:
  struct Found;
  Result<Found> hello(const ShopAsk& ask, const LocalShop& local);
  Result<void> trust(const Found& found, LocalShop& local);
  Result<void> give_back(const ShopAsk& ask, const LocalShop& local);
  Result<void> send_reports(const ShopAsk& ask, LocalShop& local);
  Result<void> send_states(const ShopAsk& ask, LocalShop& local);
  Result<void> report(const ShopAsk& ask, const std::string& machine, const ShopReport& one);
  Result<bool> accept(const ShopAsk& ask, const std::string& machine, const ShopJob& job);
  Result<void> bring(const ShopAsk& ask, const ShopJob& job);
  Result<void> take_more(const ShopAsk& ask, const Found& found);
  Result<std::vector<std::string>> fitting(const ShopAsk& ask, const ShopOffer& offer);
  Result<std::optional<ShopJob>> claim(const ShopAsk& ask, const LocalShop& local, const Found& found,
                                       const std::vector<std::string>& fits);
  void show(const std::string& text);

  Result<void> turn_plans(const ShopAsk& ask);

  ShopLedger ledger_;
  ShopPlans plans_;
  std::string plan_trouble_;  ///< in the log already
  std::string machine_, shown_;
  bool room_ = true;
  std::string retold_;  ///< the state of the database in which all was reported again
};

/// A row of kShopClaim. Errors: kInput with what is wrong with it.
Result<ShopJob> read_claim(const PgRow& row);

}  // namespace tiltfeed::daemon
