#include "desk/webhooks/delivery_store.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace tiltfeed::desk {
namespace {

constexpr std::uint64_t kVersion = 1;
constexpr const char* kTables =
    "CREATE TABLE IF NOT EXISTS services (socket TEXT PRIMARY KEY, machine TEXT NOT NULL, run INTEGER, began "
    "INTEGER, lost INTEGER);"
    "CREATE TABLE IF NOT EXISTS deliveries (number INTEGER PRIMARY KEY AUTOINCREMENT, url TEXT NOT NULL, id "
    "TEXT NOT NULL, body TEXT NOT NULL, queued INTEGER NOT NULL, due INTEGER NOT NULL, tries INTEGER NOT "
    "NULL, "
    "UNIQUE (url, id))";

struct Statement {
  sqlite3_stmt* s = nullptr;
  Statement(sqlite3* db, const char* sql) { sqlite3_prepare_v2(db, sql, -1, &s, nullptr); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  ~Statement() { sqlite3_finalize(s); }
  Statement& with(int at, const std::string& value) {
    sqlite3_bind_text(s, at, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
    return *this;
  }
  Statement& with(int at, std::int64_t value) {
    sqlite3_bind_int64(s, at, value);
    return *this;
  }
  Statement& with(int at, const std::optional<std::int64_t>& value) {
    if (value) sqlite3_bind_int64(s, at, *value);
    return *this;
  }
  int step() { return s ? sqlite3_step(s) : SQLITE_ERROR; }
  std::string text(int column) const {
    const unsigned char* const bytes = sqlite3_column_text(s, column);
    return bytes ? reinterpret_cast<const char*>(bytes) : "";
  }
  std::int64_t number(int column) const { return sqlite3_column_int64(s, column); }
  std::optional<std::int64_t> known(int column) const {
    if (sqlite3_column_type(s, column) == SQLITE_NULL) return std::nullopt;
    return number(column);
  }
};

}  // namespace

struct DeliveryStore::Table {
  std::string file;
  sqlite3* db = nullptr;
  explicit Table(std::string its_file) : file(std::move(its_file)) {}
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;
  ~Table() { sqlite3_close(db); }

  tl::unexpected<Error> error() const { return fail(Code::kIo, file + ": " + sqlite3_errmsg(db)); }
  Result<void> run(const char* sql) const {
    if (sqlite3_exec(db, sql, nullptr, nullptr, nullptr) != SQLITE_OK) return error();
    return {};
  }
  Result<void> finish(Statement& statement) const {
    if (statement.step() != SQLITE_DONE) return error();
    return {};
  }
  Result<std::uint64_t> count(Statement& statement) const {
    if (statement.step() != SQLITE_ROW) return error();
    return static_cast<std::uint64_t>(statement.number(0));
  }
  Result<void> prepare();
  Result<std::uint64_t> put(const std::string& socket, const KnownService& known,
                            const std::vector<Addressed>& messages, std::int64_t now) const;
};

/// One desk has the file; its tables are there.
Result<void> DeliveryStore::Table::prepare() {
  if (sqlite3_open_v2(file.c_str(), &db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOFOLLOW, nullptr) != SQLITE_OK)
    return error();
  if (sqlite3_exec(db, "PRAGMA locking_mode = EXCLUSIVE; PRAGMA synchronous = FULL; BEGIN EXCLUSIVE; COMMIT",
                   nullptr, nullptr, nullptr) == SQLITE_BUSY)
    return fail(Code::kIo, file + ": another desk uses it; each desk has a `state` folder of its own");
  Statement version(db, "PRAGMA user_version");
  const Result<std::uint64_t> found = count(version);
  if (!found)
    return fail(Code::kIo,
                found.error().message + "; where it is damaged, move it away: what waits in it is lost");
  if (*found > kVersion)
    return fail(Code::kIo, file + ": is of a later Tiltfeed; use that one, or another `state` folder");
  sqlite3_reset(version.s);
  if (const Result<void> made = run(kTables); !made) return made;
  return run(("PRAGMA user_version = " + std::to_string(kVersion)).c_str());
}

DeliveryStore::DeliveryStore(std::unique_ptr<Table> table) : table_(std::move(table)) {}
DeliveryStore::DeliveryStore(DeliveryStore&& other) noexcept = default;
DeliveryStore::~DeliveryStore() = default;

Result<DeliveryStore> DeliveryStore::open(const std::string& folder) {
  constexpr mode_t kOwner = 0600;
  std::error_code failed;
  if (std::filesystem::create_directory(folder, failed))
    std::filesystem::permissions(folder, std::filesystem::perms::owner_all, failed);
  auto table = std::make_unique<Table>(folder + "/webhooks.db");
  const int fd = ::open(table->file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kOwner);
  if (fd < 0)
    return fail(Code::kIo, table->file + ": " + std::strerror(errno) +
                               "; `state` is a folder in which the desk may write");
  ::close(fd);
  if (const Result<void> ready = table->prepare(); !ready) return tl::unexpected<Error>(ready.error());
  return DeliveryStore(std::move(table));
}

Result<KnownService> DeliveryStore::known(const std::string& socket) const {
  Statement row(table_->db, "SELECT machine, run, began, lost FROM services WHERE socket = ?");
  const int step = row.with(1, socket).step();
  if (step == SQLITE_DONE) return KnownService{};
  if (step != SQLITE_ROW) return table_->error();
  KnownService known{row.text(0), std::nullopt, row.known(3)};
  if (row.known(1)) known.mark = RunMark{static_cast<std::uint64_t>(row.number(1)), row.number(2)};
  return known;
}

Result<std::uint64_t> DeliveryStore::Table::put(const std::string& socket, const KnownService& known,
                                                const std::vector<Addressed>& messages,
                                                std::int64_t now) const {
  for (const Addressed& one : messages) {
    Statement insert(
        db,
        "INSERT OR IGNORE INTO deliveries (url, id, body, queued, due, tries) VALUES (?1, ?2, ?3, "
        "?4, ?4, 0)");
    insert.with(1, one.url).with(2, one.message.id).with(3, one.message.body).with(4, now);
    if (const Result<void> put = finish(insert); !put) return tl::unexpected<Error>(put.error());
  }
  Statement service(db, "INSERT OR REPLACE INTO services VALUES (?, ?, ?, ?, ?)");
  service.with(1, socket).with(2, known.machine).with(5, known.lost_since);
  if (known.mark) service.with(3, static_cast<std::int64_t>(known.mark->run)).with(4, known.mark->began);
  if (const Result<void> put = finish(service); !put) return tl::unexpected<Error>(put.error());
  Statement trim(
      db,
      "DELETE FROM deliveries WHERE number IN (SELECT number FROM (SELECT number, row_number() OVER "
      "(PARTITION BY url ORDER BY number DESC) AS place FROM deliveries) WHERE place > ?)");
  trim.with(1, static_cast<std::int64_t>(kMostWaiting));
  if (const Result<void> trimmed = finish(trim); !trimmed) return tl::unexpected<Error>(trimmed.error());
  return static_cast<std::uint64_t>(sqlite3_changes(db));
}

Result<std::uint64_t> DeliveryStore::keep(const std::string& socket, const KnownService& known,
                                          const std::vector<Addressed>& messages, std::int64_t now) {
  if (const Result<void> begun = table_->run("BEGIN IMMEDIATE"); !begun)
    return tl::unexpected<Error>(begun.error());
  Result<std::uint64_t> dropped = table_->put(socket, known, messages, now);
  if (dropped)
    if (const Result<void> done = table_->run("COMMIT"); !done) dropped = tl::unexpected<Error>(done.error());
  if (!dropped) (void)table_->run("ROLLBACK");
  return dropped;
}

Result<std::optional<Delivery>> DeliveryStore::first(const std::string& url) const {
  Statement row(
      table_->db,
      "SELECT number, id, body, queued, due, tries FROM deliveries WHERE url = ? ORDER BY number LIMIT 1");
  const int step = row.with(1, url).step();
  if (step == SQLITE_DONE) return std::nullopt;
  if (step != SQLITE_ROW) return table_->error();
  return Delivery{row.number(0), row.text(1),   row.text(2),
                  row.number(3), row.number(4), static_cast<int>(row.number(5))};
}

Result<void> DeliveryStore::put_off(std::int64_t number, int tries, std::int64_t due) {
  Statement change(table_->db, "UPDATE deliveries SET tries = ?, due = ? WHERE number = ?");
  return table_->finish(change.with(1, std::int64_t{tries}).with(2, due).with(3, number));
}

Result<void> DeliveryStore::remove(std::int64_t number) {
  Statement erase(table_->db, "DELETE FROM deliveries WHERE number = ?");
  return table_->finish(erase.with(1, number));
}

Result<std::uint64_t> DeliveryStore::waiting(const std::string& url) const {
  Statement row(table_->db, "SELECT count(*) FROM deliveries WHERE url = ?");
  return table_->count(row.with(1, url));
}

Result<std::uint64_t> DeliveryStore::drop_others(const std::vector<std::string>& urls) {
  std::string marks;
  for (std::size_t i = 0; i < urls.size(); ++i) marks += i == 0 ? "?" : ", ?";
  Statement erase(table_->db, ("DELETE FROM deliveries WHERE url NOT IN (" + marks + ")").c_str());
  for (std::size_t i = 0; i < urls.size(); ++i) erase.with(static_cast<int>(i + 1), urls[i]);
  if (const Result<void> done = table_->finish(erase); !done) return tl::unexpected<Error>(done.error());
  return static_cast<std::uint64_t>(sqlite3_changes(table_->db));
}

}  // namespace tiltfeed::desk
