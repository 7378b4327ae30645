#include "daemon/service/spool_states.h"

#include <sqlite3.h>

#include <algorithm>

#include "daemon/service/spool.h"
#include "daemon/service/spool_table.h"
#include "daemon/shop/shop_live.h"

namespace tiltfeed::daemon {

SpoolStates Spool::shop_states() const { return SpoolStates(*table_, folder_); }

tl::unexpected<Error> SpoolStates::error() const { return tl::unexpected<Error>(table_.error(folder_)); }

Result<std::optional<ShopState>> SpoolStates::last() {
  SpoolStatement row;
  if (!table_.prepare(row, "SELECT at, state FROM shop_states ORDER BY at DESC LIMIT 1")) return error();
  const int step = sqlite3_step(row.s);
  if (step == SQLITE_ROW) return ShopState{row.number(0), row.text(1)};
  if (step == SQLITE_DONE) return std::nullopt;
  return error();
}

/// One statement adds, one takes out what is too old: the second may fail without harm.
Result<void> SpoolStates::insert(std::uint64_t at, const std::string& state) {
  if (!table_.run("INSERT INTO shop_states (at, state) VALUES (?, ?)", at, state)) return error();
  static_cast<void>(table_.run(
      "DELETE FROM shop_states WHERE (told = 1 AND at < ?) OR at <= (SELECT at FROM shop_states ORDER BY at "
      "DESC LIMIT 1 OFFSET ?)",
      at - std::min(at, kKeptMs), kMost));
  return {};
}

Result<void> SpoolStates::begin(std::uint64_t at) {
  const auto before = last();
  if (!before) return tl::unexpected<Error>(before.error());
  if (*before && (*before)->state != kShopOff && (*before)->state != kShopUnknown) {
    SpoolStatement row;
    if (!table_.prepare(row, "SELECT at FROM shop_alive")) return error();
    const int step = sqlite3_step(row.s);
    if (step != SQLITE_ROW && step != SQLITE_DONE) return error();
    const std::uint64_t seen = step == SQLITE_ROW ? row.number(0) : 0;
    sqlite3_reset(row.s);
    if (Result<void> kept = insert(std::max((*before)->at + 1, std::min(seen, at)), kShopUnknown); !kept)
      return kept;
  }
  return live(at);
}

Result<void> SpoolStates::note(std::uint64_t at, const std::string& state) {
  const auto before = last();
  if (!before) return tl::unexpected<Error>(before.error());
  if (!*before) return insert(at, state);
  if ((*before)->state == state) return {};
  return insert(std::max(at, (*before)->at + 1), state);
}

Result<void> SpoolStates::live(std::uint64_t at) {
  if (table_.run("INSERT INTO shop_alive (one, at) VALUES (1, ?) ON CONFLICT (one) DO UPDATE SET at = "
                 "excluded.at",
                 at))
    return {};
  return error();
}

Result<std::vector<ShopState>> SpoolStates::untold() {
  SpoolStatement rows;
  if (!table_.prepare(rows, "SELECT at, state FROM shop_states WHERE told = 0 ORDER BY at LIMIT ?"))
    return error();
  rows.bind(1, std::uint64_t{kBatch});
  std::vector<ShopState> found;
  int step = 0;
  while ((step = sqlite3_step(rows.s)) == SQLITE_ROW) found.push_back({rows.number(0), rows.text(1)});
  if (step != SQLITE_DONE) return error();
  return found;
}

Result<void> SpoolStates::told(std::uint64_t at) {
  if (table_.run("UPDATE shop_states SET told = 1 WHERE told = 0 AND at <= ?", at)) return {};
  return error();
}

Result<void> SpoolStates::retell() {
  if (table_.run("UPDATE shop_states SET told = 0")) return {};
  return error();
}

}  // namespace tiltfeed::daemon
