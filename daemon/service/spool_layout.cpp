#include "daemon/service/spool_layout.h"

#include <sqlite3.h>

namespace tiltfeed::daemon {

namespace {

/// Version 1 is the layout of before versions were kept: what it has is never changed here, later versions
/// add to it.
constexpr const char* kTable =
    "CREATE TABLE IF NOT EXISTS jobs (id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL, program "
    "INTEGER NOT NULL,"
    " state TEXT NOT NULL, note TEXT NOT NULL, total INTEGER NOT NULL, executed INTEGER NOT NULL, hash TEXT "
    "NOT NULL,"
    " user INTEGER NOT NULL, created INTEGER NOT NULL)";
/// Version 2: jobs can wait for their turn. Some tables without a version have it.
constexpr const char* kPlace = "ALTER TABLE jobs ADD COLUMN place INTEGER NOT NULL DEFAULT 0";

/// Version 3: a job can stand before a tool change, which earlier versions have no word for.
/// Version 4: every run is on record. No `ended`: it goes on, or nobody saw its end; no `outcome`: it goes
/// on.
constexpr const char* kRuns =
    "CREATE TABLE IF NOT EXISTS runs (id INTEGER PRIMARY KEY AUTOINCREMENT, job INTEGER NOT NULL, name TEXT "
    "NOT "
    "NULL, hash TEXT NOT NULL, link TEXT NOT NULL, user INTEGER, began INTEGER NOT NULL, ended INTEGER,"
    " first INTEGER NOT NULL, blocks INTEGER NOT NULL, executed INTEGER NOT NULL, outcome TEXT NOT NULL "
    "DEFAULT "
    "'', note TEXT NOT NULL DEFAULT '',"
    " sent INTEGER, resends INTEGER, seconds REAL, holds INTEGER, held_seconds REAL, slowest_hold REAL,"
    " feed_least INTEGER, feed_most INTEGER);"
    "CREATE INDEX IF NOT EXISTS runs_on ON runs (job) WHERE outcome = ''";

/// Version 5: of a run how long its controller starved.
constexpr const char* kStarved = "ALTER TABLE runs ADD COLUMN starved_seconds REAL";

/// Version 6: jobs of the shop's queue, kept for ever under their ids, so that none comes twice. `changed`
/// counts what became of one here, `told` is how much of that the shop's database has. States before the
/// job is in the spool: claimed, accepted; dropped: it went elsewhere; spoiled: its files could not be had.
/// overruled: it must not begin here.
/// The triggers count in the transaction that changes the job itself.
constexpr const char* kShopColumn = "ALTER TABLE jobs ADD COLUMN shop TEXT NOT NULL DEFAULT ''";
constexpr const char* kShop =
    "CREATE UNIQUE INDEX IF NOT EXISTS jobs_shop ON jobs (shop) WHERE shop <> '';"
    "CREATE TABLE IF NOT EXISTS shop_self (one INTEGER PRIMARY KEY CHECK (one = 1), machine TEXT NOT NULL, "
    "shop TEXT NOT NULL DEFAULT '', epoch INTEGER NOT NULL DEFAULT 0, epoch_id TEXT NOT NULL DEFAULT '', "
    "token INTEGER NOT NULL DEFAULT 0, serial INTEGER NOT NULL DEFAULT 0);"
    "CREATE TABLE IF NOT EXISTS shop_jobs (uuid TEXT PRIMARY KEY, epoch INTEGER NOT NULL, token INTEGER NOT "
    "NULL, number INTEGER NOT NULL, name TEXT NOT NULL, program INTEGER NOT NULL, hash TEXT NOT NULL, bytes "
    "INTEGER NOT NULL, part_hash TEXT NOT NULL, part_bytes INTEGER NOT NULL, state TEXT NOT NULL, note TEXT "
    "NOT NULL DEFAULT '', blocks INTEGER NOT NULL DEFAULT 0, executed INTEGER NOT NULL DEFAULT 0, changed "
    "INTEGER NOT NULL DEFAULT 0, told INTEGER NOT NULL DEFAULT 0);"
    "CREATE INDEX IF NOT EXISTS shop_untold ON shop_jobs (uuid) WHERE changed > told;"
    "CREATE INDEX IF NOT EXISTS shop_waiting ON shop_jobs (state) WHERE state IN ('claimed', 'accepted', "
    "'received', 'planning', 'ready');"
    "CREATE TRIGGER IF NOT EXISTS shop_changed AFTER UPDATE OF state ON jobs WHEN NEW.shop <> '' BEGIN "
    "UPDATE shop_jobs SET state = NEW.state, note = NEW.note, blocks = NEW.total, executed = NEW.executed, "
    "changed = changed + 1 WHERE uuid = NEW.shop AND state <> 'overruled'; END;"
    "CREATE TRIGGER IF NOT EXISTS shop_removed AFTER DELETE ON jobs WHEN OLD.shop <> '' BEGIN "
    "UPDATE shop_jobs SET state = 'removed', note = 'removed at the machine', changed = changed + 1 WHERE "
    "uuid = OLD.shop AND state IN ('received', 'planning', 'ready'); END";

/// Version 7: what the machine was from when on, for the shop's page, and when its service was last alive.
constexpr const char* kStates =
    "CREATE TABLE IF NOT EXISTS shop_states (at INTEGER PRIMARY KEY, state TEXT NOT NULL, told INTEGER NOT "
    "NULL DEFAULT 0);"
    "CREATE INDEX IF NOT EXISTS states_untold ON shop_states (at) WHERE told = 0;"
    "CREATE TABLE IF NOT EXISTS shop_alive (one INTEGER PRIMARY KEY CHECK (one = 1), at INTEGER NOT NULL)";

tl::unexpected<Error> failed(sqlite3* db, const std::string& path) {
  return fail(Code::kIo, path + ": " + sqlite3_errmsg(db));
}

Result<int> version_of(sqlite3* db, const std::string& path) {
  int version = 0;
  const auto take = [](void* to, int, char** values, char**) {
    *static_cast<int*>(to) = std::atoi(values[0]);
    return 0;
  };
  if (sqlite3_exec(db, "PRAGMA user_version", take, &version, nullptr) != SQLITE_OK) return failed(db, path);
  return version;
}

bool answers(sqlite3* db, const char* query) {
  sqlite3_stmt* found = nullptr;
  const bool has = sqlite3_prepare_v2(db, query, -1, &found, nullptr) == SQLITE_OK;
  sqlite3_finalize(found);
  return has;
}

/// Within a transaction.
Result<void> change(sqlite3* db, const std::string& path) {
  const Result<int> version = version_of(db, path);
  if (!version) return tl::unexpected<Error>(version.error());
  if (*version > kSpoolVersion)
    return fail(Code::kUsage, path + ": was written by a later tiltfeed (layout " + std::to_string(*version) +
                                  ", this one knows " + std::to_string(kSpoolVersion) +
                                  "); install that one again, or restore a backup");
  if (*version == kSpoolVersion) return {};
  if (sqlite3_exec(db, kTable, nullptr, nullptr, nullptr) != SQLITE_OK) return failed(db, path);
  if (!answers(db, "SELECT place FROM jobs") &&
      sqlite3_exec(db, kPlace, nullptr, nullptr, nullptr) != SQLITE_OK)
    return failed(db, path);
  if (sqlite3_exec(db, kRuns, nullptr, nullptr, nullptr) != SQLITE_OK) return failed(db, path);
  if (!answers(db, "SELECT starved_seconds FROM runs") &&
      sqlite3_exec(db, kStarved, nullptr, nullptr, nullptr) != SQLITE_OK)
    return failed(db, path);
  if (!answers(db, "SELECT shop FROM jobs") &&
      sqlite3_exec(db, kShopColumn, nullptr, nullptr, nullptr) != SQLITE_OK)
    return failed(db, path);
  if (sqlite3_exec(db, kShop, nullptr, nullptr, nullptr) != SQLITE_OK) return failed(db, path);
  if (sqlite3_exec(db, kStates, nullptr, nullptr, nullptr) != SQLITE_OK) return failed(db, path);
  const std::string mark = "PRAGMA user_version = " + std::to_string(kSpoolVersion);
  if (sqlite3_exec(db, mark.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return failed(db, path);
  return {};
}

}  // namespace

Result<void> bring_up_to_date(sqlite3* db, const std::string& path) {
  // A table of a later version is not even put into another journal mode.
  const Result<int> version = version_of(db, path);
  if (!version) return tl::unexpected<Error>(version.error());
  const char* const modes = "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL";
  if (*version <= kSpoolVersion && sqlite3_exec(db, modes, nullptr, nullptr, nullptr) != SQLITE_OK)
    return failed(db, path);
  if (sqlite3_exec(db, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr) != SQLITE_OK) return failed(db, path);
  Result<void> changed = change(db, path);
  if (changed && sqlite3_exec(db, "COMMIT", nullptr, nullptr, nullptr) != SQLITE_OK)
    changed = failed(db, path);
  if (!changed) sqlite3_exec(db, "ROLLBACK", nullptr, nullptr, nullptr);
  return changed;
}

}  // namespace tiltfeed::daemon
