#include "daemon/service/spool_backup.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

#include "daemon/files/durable.h"
#include "daemon/service/spool_table.h"

namespace tiltfeed::daemon {

namespace {

namespace fs = std::filesystem;

constexpr int kBackupWaitMs = 10000;
constexpr const char* kJournal = "journal";

struct CloseDb {
  void operator()(sqlite3* db) const { sqlite3_close(db); }
};
using Db = std::unique_ptr<sqlite3, CloseDb>;

Result<Db> open_db(const std::string& path, int flags) {
  sqlite3* db = nullptr;
  const int opened = sqlite3_open_v2(path.c_str(), &db, flags | SQLITE_OPEN_NOFOLLOW, nullptr);
  Db owned(db);
  if (opened != SQLITE_OK)
    return fail(Code::kIo, path + ": " + (db != nullptr ? sqlite3_errmsg(db) : "out of memory"));
  sqlite3_busy_timeout(db, kBackupWaitMs);
  return owned;
}

/// A table that others may write meanwhile is read as of one moment, for which SQLite writes beside it: who
/// may only read the spool is told that, and not that a file of the copy failed.
Result<void> check_source(const fs::path& spool) {
  const std::string table = table_path(spool.string());
  if (::faccessat(AT_FDCWD, table.c_str(), F_OK, AT_EACCESS) != 0 && errno == ENOENT)
    return fail(Code::kUsage, table + ": is not there: this folder is no spool");
  for (const std::string& path : {spool.string(), table, table + "-wal", table + "-shm"}) {
    if (::faccessat(AT_FDCWD, path.c_str(), R_OK | W_OK, AT_EACCESS) == 0 || errno == ENOENT) continue;
    const std::string what = path + ": cannot be read and written (" + std::strerror(errno) + "), ";
    if (errno == EROFS)
      return fail(Code::kIo,
                  what +
                      "so that nothing keeps a copy to one moment: stop the service, then copy the "
                      "folder itself (cp -a " +
                      spool.string() + ")");
    return fail(Code::kUsage, what + "as a backup has to: run it as the user of the service, or as root");
  }
  return {};
}

/// As of one moment, whoever writes meanwhile.
Result<void> copy_table(const std::string& from, const std::string& to) {
  const Result<Db> source = open_db(from, SQLITE_OPEN_READWRITE);
  if (!source) return tl::unexpected<Error>(source.error());
  // What is wrong with the source would be told of the copy.
  if (sqlite3_exec(source->get(), "SELECT count(*) FROM sqlite_master", nullptr, nullptr, nullptr) !=
      SQLITE_OK)
    return fail(Code::kIo, from + ": " + sqlite3_errmsg(source->get()));
  const Result<Db> copy = open_db(to, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  if (!copy) return tl::unexpected<Error>(copy.error());
  sqlite3_backup* const work = sqlite3_backup_init(copy->get(), "main", source->get(), "main");
  const int copied = work == nullptr ? SQLITE_ERROR : sqlite3_backup_step(work, -1);
  if (sqlite3_backup_finish(work) != SQLITE_OK || copied != SQLITE_DONE)
    return fail(Code::kIo, to + ": " + sqlite3_errmsg(copy->get()));
  return {};
}

Result<void> sync_file(const fs::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  const bool synced = fd >= 0 && ::fsync(fd) == 0;
  const int why = errno;
  if (fd >= 0) ::close(fd);
  if (!synced) return fail(Code::kIo, path.string() + ": " + std::strerror(why));
  return {};
}

Result<void> sync_names(const fs::path& folder) {
  if (const int synced = sync_folder(folder.string()); synced < 0)
    return fail(Code::kIo, folder.string() + ": " + std::strerror(-synced));
  return {};
}

Result<void> copy_job(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::create_directory(to, failed);
  for (fs::directory_iterator at(from, failed), end; !failed && at != end; at.increment(failed)) {
    if (at->path().filename() == kJournal || !at->is_regular_file(failed) || at->is_symlink(failed)) continue;
    const fs::path copy = to / at->path().filename();
    fs::copy_file(at->path(), copy, failed);
    if (failed == std::errc::no_such_file_or_directory) failed.clear();  // gone meanwhile
    if (failed || !fs::exists(copy, failed)) continue;
    if (const Result<void> synced = sync_file(copy); !synced) return synced;
  }
  if (failed) return fail(Code::kIo, from.string() + ": cannot be copied: " + failed.message());
  return sync_names(to);
}

/// A folder that nobody else fills: what is there of that name may be somebody's.
Result<void> make_own(const fs::path& folder) {
  if (const int made = make_folders(folder.parent_path().string()); made < 0)
    return fail(Code::kIo, folder.parent_path().string() + ": cannot be made: " + std::strerror(-made));
  if (::mkdir(folder.c_str(), S_IRWXU) == 0) return {};
  if (errno == EEXIST)
    return fail(
        Code::kUsage,
        folder.string() + ": is there: another backup is at work, or one was cut off; then remove it");
  return fail(Code::kIo, folder.string() + ": cannot be made: " + std::strerror(errno));
}

Result<std::uint64_t> copy_all(const fs::path& spool, const fs::path& to) {
  std::error_code failed;
  fs::create_directory(to / "jobs", failed);
  if (failed) return fail(Code::kIo, to.string() + ": cannot be made: " + failed.message());
  if (const auto table = copy_table(table_path(spool), table_path(to)); !table)
    return tl::unexpected<Error>(table.error());
  std::uint64_t jobs = 0;
  for (fs::directory_iterator at(spool / "jobs", failed), end; !failed && at != end;
       at.increment(failed), ++jobs)
    if (const auto copied = copy_job(at->path(), to / "jobs" / at->path().filename()); !copied)
      return tl::unexpected<Error>(copied.error());
  if (failed) return fail(Code::kIo, spool.string() + "/jobs: " + failed.message());
  for (const fs::path& folder : {to / "jobs", to})
    if (const Result<void> synced = sync_names(folder); !synced) return tl::unexpected<Error>(synced.error());
  return jobs;
}

}  // namespace

Result<std::uint64_t> back_up(const std::string& spool, const std::string& to) {
  if (to.empty()) return fail(Code::kUsage, "the name of the folder for the copy is empty");
  std::error_code failed;
  const fs::path whole = fs::path(to + "/").parent_path(), part = whole.string() + ".partial";
  if (fs::exists(whole, failed))
    return fail(Code::kUsage, to + ": is there already; name a folder that is not");
  const std::string own = fs::weakly_canonical(spool, failed).string() + "/";
  if (fs::weakly_canonical(whole, failed).string().starts_with(own))
    return fail(Code::kUsage, to + ": is in the spool itself, and is lost with it; name another folder");
  if (const Result<void> checked = check_source(spool); !checked)
    return tl::unexpected<Error>(checked.error());
  if (const Result<void> made = make_own(part); !made) return tl::unexpected<Error>(made.error());
  const Result<std::uint64_t> jobs = copy_all(spool, part);
  if (!jobs) {
    fs::remove_all(part, failed);
    return jobs;
  }
  fs::rename(part, whole, failed);
  if (failed) return fail(Code::kIo, to + ": cannot be made: " + failed.message());
  const fs::path parent = whole.has_parent_path() ? whole.parent_path() : fs::path(".");
  if (const Result<void> synced = sync_names(parent); !synced) return tl::unexpected<Error>(synced.error());
  return jobs;
}

}  // namespace tiltfeed::daemon
