#include "daemon/service/spool_table.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

namespace tiltfeed::daemon {

SpoolStatement::~SpoolStatement() { sqlite3_finalize(s); }

std::string SpoolStatement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(s, column));
  return bytes != nullptr ? bytes : "";
}

std::uint64_t SpoolStatement::number(int column) const {
  return static_cast<std::uint64_t>(sqlite3_column_int64(s, column));
}

double SpoolStatement::real(int column) const { return sqlite3_column_double(s, column); }

bool SpoolStatement::known(int column) const { return sqlite3_column_type(s, column) != SQLITE_NULL; }

void SpoolStatement::bind(int at, const std::string& value) {
  sqlite3_bind_text(s, at, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
}

void SpoolStatement::bind(int at, std::uint64_t value) {
  sqlite3_bind_int64(s, at, static_cast<sqlite3_int64>(value));
}

void SpoolStatement::bind(int at, double value) { sqlite3_bind_double(s, at, value); }

std::string table_path(const std::string& folder) {
  std::error_code none;
  const std::filesystem::path own = std::filesystem::canonical(folder, none);
  return (none ? folder : own.string()) + "/jobs.db";
}

namespace {

/// As much as the table grows by at once.
constexpr std::size_t kTableRoom = 65536;

/// False only where a file without a name finds none in the folder.
bool has_room(const std::string& folder) {
  const std::string page(kTableRoom, '\0');
  const int file = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
  if (file < 0) return true;
  const ssize_t written = ::write(file, page.data(), page.size());
  const int why = written < 0 ? errno : 0;
  ::close(file);
  return written < 0 ? why != ENOSPC && why != EDQUOT : static_cast<std::size_t>(written) == page.size();
}

}  // namespace

SpoolTable::~SpoolTable() {
  // Nothing of a log that stays beside may belong to another table that is put in this one's place.
  if (keeps_files) sqlite3_exec(db, "PRAGMA journal_size_limit=0", nullptr, nullptr, nullptr);
  sqlite3_close(db);
}

void SpoolTable::keep_files() {
  int on = 1;
  keeps_files = sqlite3_file_control(db, "main", SQLITE_FCNTL_PERSIST_WAL, &on) == SQLITE_OK;
}

Error SpoolTable::error(const std::string& folder) const {
  return {Code::kIo, folder + "/jobs.db: " + (db != nullptr ? sqlite3_errmsg(db) : "out of memory") +
                         (lacks_room(folder) ? "; make room, `tiltfeed remove` of a job does" : "")};
}

bool SpoolTable::lacks_room(const std::string& folder) const {
  const int code = db != nullptr ? sqlite3_errcode(db) : SQLITE_NOMEM;
  // A quota that is used up comes as an error of the disk, and SQLite does not keep which.
  return code == SQLITE_FULL || (code == SQLITE_IOERR && !has_room(folder));
}

bool SpoolStatement::finish() { return sqlite3_step(s) == SQLITE_DONE; }

bool SpoolTable::prepare(SpoolStatement& statement, const std::string& sql) const {
  return sqlite3_prepare_v2(db, sql.c_str(), -1, &statement.s, nullptr) == SQLITE_OK;
}

}  // namespace tiltfeed::daemon
