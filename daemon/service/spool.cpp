#include "daemon/service/spool.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <set>
#include <utility>

#include "daemon/files/durable.h"
#include "daemon/service/spool_layout.h"
#include "daemon/service/spool_table.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

constexpr const char* kStateNames[] = {"received",  "planning", "ready",   "running", "interrupted",
                                       "uncertain", "done",     "stopped", "failed",  "tool change"};
constexpr int kBusyWaitMs = 2000;  // somebody looks into the table with another program

constexpr const char* kJobColumns =
    "id, name, program, state, note, total, executed, hash, user, created, place, shop";

struct Descriptor {
  int fd = -1;
  explicit Descriptor(int number) : fd(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

Result<void> keep_names(const std::string& folder) {
  if (const int synced = sync_folder(folder); synced < 0)
    return fail(Code::kIo, folder + ": cannot be made durable: " + std::strerror(-synced));
  return {};
}

}  // namespace

std::string name_of(std::uint64_t job) { return "job " + std::to_string(job); }

const char* state_name(JobState state) { return kStateNames[static_cast<std::size_t>(state)]; }

std::optional<JobState> state_of(const std::string& name) {
  for (std::size_t i = 0; i < std::size(kStateNames); ++i)
    if (name == kStateNames[i]) return static_cast<JobState>(i);
  return std::nullopt;
}

bool has_ended(const SpooledJob& job) {
  return job.place == 0 &&
         (job.state == JobState::kDone || job.state == JobState::kStopped || job.state == JobState::kFailed);
}

const char* shown_state(const SpooledJob& job) {
  const bool planned = job.state == JobState::kReady || job.state == JobState::kDone;
  return planned && job.place > 0 ? "queued" : state_name(job.state);
}

std::string plain_name(const std::string& text, std::size_t most) {
  const std::string whole = valid_text(text);
  std::string kept;
  for (std::size_t at = 0, next = 0; at < whole.size(); at = next) {
    const auto first = static_cast<unsigned char>(whole[at]);
    next = at + (first < 0xC0 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4);
    const bool plain = (first >= 'A' && first <= 'Z') || (first >= 'a' && first <= 'z') ||
                       (first >= '0' && first <= '9') ||
                       std::string_view(" ._-").find(whole[at]) != std::string::npos;
    // Letters of other alphabets, from U+00C0; of general punctuation (U+2000 to U+2FFF) some turn the line.
    const bool letter = first >= 0xC3 && first != 0xE2;
    if (!plain && !letter) continue;
    if (kept.size() + (next - at) > most) break;
    kept += whole.substr(at, next - at);
  }
  return kept.empty() ? "job" : kept;
}

Spool::Spool(std::string folder, StateLock lock, std::unique_ptr<SpoolTable> table)
    : folder_(std::move(folder)), lock_(std::move(lock)), table_(std::move(table)) {}
Spool::Spool(Spool&&) noexcept = default;
Spool::~Spool() = default;

Result<Spool> Spool::open(const std::string& folder) {
  if (const int made = make_folders(folder); made < 0)
    return fail(Code::kIo, folder + ": cannot be made: " + std::strerror(-made));
  Result<StateLock> lock = StateLock::take(folder);
  if (!lock) return tl::unexpected<Error>(lock.error());
  std::error_code made;
  std::filesystem::create_directories(folder + "/jobs", made);
  if (made) return fail(Code::kIo, folder + "/jobs: cannot be made: " + made.message());
  ::chmod((folder + "/jobs").c_str(), S_IRWXU);
  auto table = std::make_unique<SpoolTable>();
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOFOLLOW;
  if (sqlite3_open_v2(table_path(folder).c_str(), &table->db, flags, nullptr) != SQLITE_OK)
    return tl::unexpected<Error>(table->error(folder));
  sqlite3_busy_timeout(table->db, kBusyWaitMs);
  table->keep_files();
  if (const Result<void> made_new = bring_up_to_date(table->db, folder + "/jobs.db"); !made_new)
    return tl::unexpected<Error>(made_new.error());
  // With the names of the table's own files: SQLite syncs them, and says nothing when that fails.
  if (const Result<void> kept = keep_names(folder); !kept) return tl::unexpected<Error>(kept.error());
  Spool spool(folder, std::move(*lock), std::move(table));
  if (Result<void> healed = spool.heal(); !healed) return tl::unexpected<Error>(healed.error());
  if (Result<void> swept = spool.sweep(); !swept) return tl::unexpected<Error>(swept.error());
  return spool;
}

/// Bytes of a wire that an earlier version has let in as they came are written anew as text.
Result<void> Spool::heal() {
  std::vector<std::uint64_t> damaged;
  {
    SpoolStatement rows;
    if (!table_->prepare(rows, "SELECT id, note FROM jobs"))
      return tl::unexpected<Error>(table_->error(folder_));
    while (sqlite3_step(rows.s) == SQLITE_ROW)
      if (const std::string note = rows.text(1); valid_text(note) != note) damaged.push_back(rows.number(0));
  }
  for (const std::uint64_t id : damaged) {
    const Result<SpooledJob> job = find(id);
    if (!job) return tl::unexpected<Error>(job.error());
    if (Result<void> healed = update(*job); !healed) return healed;
  }
  return {};
}

std::string Spool::folder_of(std::uint64_t id) const { return folder_ + "/jobs/" + std::to_string(id); }

Result<std::uint64_t> Spool::begin(const SpooledJob& job) {
  {  // a reading that is still open would let no writer wait for its turn
    SpoolStatement count;
    if (!table_->prepare(count, "SELECT count(*) FROM jobs") || sqlite3_step(count.s) != SQLITE_ROW)
      return tl::unexpected<Error>(table_->error(folder_));
    if (count.number(0) >= kMaxJobs)
      return fail(Code::kLimit, "the spool holds " + std::to_string(kMaxJobs) + " jobs; remove some");
  }
  SpoolStatement insert;
  if (!table_->prepare(insert,
                       "INSERT INTO jobs (name, program, state, note, total, executed, hash, user, created, "
                       "shop) VALUES (?, ?, 'failed', 'not received whole', 0, 0, '', ?, ?, ?)"))
    return tl::unexpected<Error>(table_->error(folder_));
  insert.bind(1, plain_name(job.name));
  insert.bind(2, std::uint64_t{job.program});
  insert.bind(3, std::uint64_t{job.user});
  insert.bind(4, static_cast<std::uint64_t>(std::time(nullptr)));
  insert.bind(5, job.shop);
  if (sqlite3_step(insert.s) != SQLITE_DONE) return tl::unexpected<Error>(table_->error(folder_));
  const auto id = static_cast<std::uint64_t>(sqlite3_last_insert_rowid(table_->db));
  std::error_code made;
  // A power loss may have kept the folder of a number that the table has forgotten.
  std::filesystem::remove_all(folder_of(id), made);
  if (!made) std::filesystem::create_directory(folder_of(id), made);
  if (!made) return id;
  static_cast<void>(remove(id));
  return fail(Code::kIo, folder_of(id) + ": " + made.message());
}

Result<void> Spool::finish(const SpooledJob& job) {
  const char* const names[] = {job.program ? "program.nc" : "job.yaml", "part.stl"};
  for (const char* name : {names[0], names[1]}) {
    if (name == names[1] && job.program) break;
    const Descriptor copy(::open(file(job.id, name).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
    if (copy.fd < 0 || ::fsync(copy.fd) != 0)
      return fail(Code::kIo, file(job.id, name) + ": " + std::strerror(errno));
  }
  if (const Result<void> kept = keep_names(folder_of(job.id)); !kept) return kept;
  if (const Result<void> kept = keep_names(folder_ + "/jobs"); !kept) return kept;
  return update(job);
}

Result<std::vector<SpooledJob>> Spool::list() const { return select("ORDER BY id"); }

Result<std::vector<SpooledJob>> Spool::page(std::uint64_t after, std::size_t most) const {
  return select("WHERE id > " + std::to_string(after) + " ORDER BY id LIMIT " + std::to_string(most));
}

Result<std::vector<SpooledJob>> Spool::received() const {
  auto jobs = select("WHERE state = 'received' ORDER BY id");
  if (jobs) std::erase_if(*jobs, [](const SpooledJob& job) { return job.state != JobState::kReceived; });
  return jobs;
}

Result<std::vector<SpooledJob>> Spool::queue() const {
  auto jobs = select("WHERE place > 0 ORDER BY place");
  if (jobs) std::erase_if(*jobs, [](const SpooledJob& job) { return job.place == 0; });
  return jobs;
}

void Spool::save_remembered() {
  for (auto& [id, job] : std::map(remembered_))
    if (!update(job)) return;
  save_run_ends();
}

Result<std::vector<SpooledJob>> Spool::select(const std::string& which) const {
  SpoolStatement rows;
  std::string query("SELECT ");
  query.append(kJobColumns).append(" FROM jobs ").append(which);
  if (!table_->prepare(rows, query)) return tl::unexpected<Error>(table_->error(folder_));
  std::vector<SpooledJob> jobs;
  int step = 0;
  while ((step = sqlite3_step(rows.s)) == SQLITE_ROW) {
    SpooledJob job;
    job.id = rows.number(0);
    job.name = rows.text(1);
    job.program = rows.number(2) != 0;
    job.state = state_of(rows.text(3)).value_or(JobState::kFailed);
    job.note = valid_text(rows.text(4));
    job.total = rows.number(5);
    job.executed = rows.number(6);
    job.hash = rows.text(7);
    job.user = static_cast<std::uint32_t>(rows.number(8));
    job.created = static_cast<std::int64_t>(rows.number(9));
    job.place = rows.number(10);
    job.shop = rows.text(11);
    if (const auto newer = remembered_.find(job.id); newer != remembered_.end()) job = newer->second;
    jobs.push_back(std::move(job));
  }
  if (step != SQLITE_DONE) return tl::unexpected<Error>(table_->error(folder_));
  return jobs;
}

Result<SpooledJob> Spool::find(std::uint64_t id) const {
  auto jobs = select("WHERE id = " + std::to_string(id));
  if (!jobs) return tl::unexpected<Error>(jobs.error());
  if (!jobs->empty()) return std::move(jobs->front());
  return fail(Code::kUsage, "there is no job " + std::to_string(id) + "; `tiltfeed list` shows them");
}

Result<void> Spool::update(const SpooledJob& job) {
  SpoolStatement change;
  if (!table_->prepare(
          change,
          "UPDATE jobs SET state = ?, note = ?, total = ?, executed = ?, hash = ?, place = ? WHERE id = ?"))
    return tl::unexpected<Error>(table_->error(folder_));
  change.bind(1, std::string(state_name(job.state)));
  change.bind(2, valid_text(job.note));
  change.bind(3, job.total);
  change.bind(4, job.executed);
  change.bind(5, job.hash);
  change.bind(6, job.place);
  change.bind(7, job.id);
  if (sqlite3_step(change.s) != SQLITE_DONE) return tl::unexpected<Error>(table_->error(folder_));
  remembered_.erase(job.id);
  return {};
}

Result<void> Spool::remove(std::uint64_t id) {
  // The row first: what is listed has its files, whatever fails. Only a disk without room for that is given
  // room by the files.
  Result<void> erased = erase_row(id);
  const bool no_room = !erased && table_->lacks_room(folder_);
  if (!erased && !no_room) return erased;
  std::error_code gone;
  std::filesystem::remove_all(folder_of(id), gone);
  if (no_room && !gone) erased = erase_row(id);
  if (!erased) {
    forget_files(id);
    return erased;
  }
  if (gone) return fail(Code::kIo, folder_of(id) + ": is no job any more, but stays: " + gone.message());
  return {};
}

Result<void> Spool::erase_row(std::uint64_t id) {
  SpoolStatement erase;
  if (!table_->prepare(erase, "DELETE FROM jobs WHERE id = ?"))
    return tl::unexpected<Error>(table_->error(folder_));
  erase.bind(1, id);
  if (sqlite3_step(erase.s) != SQLITE_DONE) return tl::unexpected<Error>(table_->error(folder_));
  remembered_.erase(id);
  return {};
}

/// Of a job that is still listed.
void Spool::forget_files(std::uint64_t id) {
  Result<SpooledJob> job = find(id);
  if (!job) return;
  job->state = JobState::kFailed;
  job->note = "was to be removed; its files are gone";
  job->place = 0;
  remember(*job);
}

/// Folders of jobs that were removed, and that a failure or a power loss has left. The table gives no number
/// twice. One that has never given a number is not the table of jobs that are there: it was lost.
Result<void> Spool::sweep() {
  SpoolStatement newest, rows;
  // Without numbers that are given once nothing is taken for a leftover.
  if (!table_->prepare(newest, "SELECT seq FROM sqlite_sequence WHERE name = 'jobs'")) return {};
  if (sqlite3_step(newest.s) != SQLITE_ROW) {
    std::error_code none;
    if (std::filesystem::is_empty(folder_ + "/jobs", none) || none) return {};
    return fail(Code::kIo,
                folder_ +
                    "/jobs.db has no job, but jobs/ has files: the table was lost. Restore a backup, "
                    "or move jobs/ away; look at the machine first");
  }
  if (!table_->prepare(rows, "SELECT id FROM jobs")) return tl::unexpected<Error>(table_->error(folder_));
  std::set<std::string> kept;
  int step = 0;
  while ((step = sqlite3_step(rows.s)) == SQLITE_ROW) kept.insert(rows.text(0));
  if (step != SQLITE_DONE) return tl::unexpected<Error>(table_->error(folder_));
  std::error_code failed;
  std::vector<std::filesystem::path> left;
  for (std::filesystem::directory_iterator at(folder_ + "/jobs", failed), end; !failed && at != end;
       at.increment(failed)) {
    const std::string name = at->path().filename().string();
    std::uint64_t id = 0;
    const auto read = std::from_chars(name.data(), name.data() + name.size(), id);
    const bool number = read.ec == std::errc() && read.ptr == name.data() + name.size();
    if (number && id <= newest.number(0) && !kept.contains(name)) left.push_back(at->path());
  }
  // What cannot go today goes another time.
  for (const auto& path : left) std::filesystem::remove_all(path, failed);
  return {};
}

}  // namespace tiltfeed::daemon
