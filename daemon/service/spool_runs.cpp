// The runs of a spool's jobs.

#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "daemon/service/spool.h"
#include "daemon/service/spool_table.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

constexpr const char* kLostOutcome = "unknown";
constexpr const char* kLostNote = "the service ended before it wrote how the run did";
constexpr const char* kRunColumns =
    "id, job, name, hash, link, user, began, ended, first, blocks, executed, outcome, note, sent, resends, "
    "seconds, holds, held_seconds, slowest_hold, feed_least, feed_most, starved_seconds";

/// Of the files that can be looked at.
std::uint64_t bytes_in(const std::string& folder) {
  std::uint64_t bytes = 0;
  std::error_code failed, none;
  for (std::filesystem::directory_iterator at(folder, failed), end; !failed && at != end;
       at.increment(failed))
    if (at->is_regular_file(none)) bytes += at->file_size(none);
  return bytes;
}

}  // namespace

Result<std::uint64_t> Spool::begin_run(const RunReport& run) {
  // An end that is written later would end this run, too.
  save_run_ends();
  if (!unsaved_ends_.empty()) return tl::unexpected<Error>(table_->error(folder_));
  SpoolStatement insert;
  if (!table_->prepare(
          insert,
          "INSERT INTO runs (job, name, hash, link, user, began, first, blocks, executed) VALUES (?, "
          "?, ?, ?, ?, ?, ?, ?, ?)"))
    return tl::unexpected<Error>(table_->error(folder_));
  insert.bind(1, run.job);
  insert.bind(2, run.name);
  insert.bind(3, run.hash);
  insert.bind(4, valid_text(run.link));
  insert.bind(5, run.user);
  insert.bind(6, static_cast<std::uint64_t>(run.began));
  insert.bind(7, run.first);
  insert.bind(8, run.blocks);
  insert.bind(9, run.executed);
  if (sqlite3_step(insert.s) != SQLITE_DONE) return tl::unexpected<Error>(table_->error(folder_));
  return static_cast<std::uint64_t>(sqlite3_last_insert_rowid(table_->db));
}

void Spool::end_run(const RunReport& end) {
  if (!write_run_end(end)) unsaved_ends_.push_back(end);
}

bool Spool::write_run_end(const RunReport& end) {
  SpoolStatement change;
  const bool prepared = table_->prepare(
      change,
      "UPDATE runs SET ended = ?, executed = ?, outcome = ?, note = ?, sent = ?, resends = ?, seconds = ?, "
      "holds = ?, held_seconds = ?, slowest_hold = ?, feed_least = ?, feed_most = ?, starved_seconds = ? "
      "WHERE job = ? AND outcome = '' AND id > ?");
  if (!prepared) return false;
  change.bind(1, end.ended);
  change.bind(2, end.executed);
  change.bind(3, end.outcome);
  change.bind(4, valid_text(end.note));
  if (end.figures) {
    const RunReport::Figures& f = *end.figures;
    change.bind(5, f.sent);
    change.bind(6, f.resends);
    change.bind(7, f.seconds);
    change.bind(8, static_cast<std::uint64_t>(f.holds));
    change.bind(9, f.held_seconds);
    change.bind(10, f.slowest_hold);
    if (f.feed_override) change.bind(11, static_cast<std::uint64_t>(f.feed_override->least));
    if (f.feed_override) change.bind(12, static_cast<std::uint64_t>(f.feed_override->most));
    change.bind(13, f.starved_seconds);
  }
  change.bind(14, end.job);
  change.bind(15, lost_until_);
  return sqlite3_step(change.s) == SQLITE_DONE;
}

Result<void> Spool::end_lost_runs() {
  SpoolStatement newest;
  if (!table_->prepare(newest, "SELECT coalesce(max(id), 0) FROM runs WHERE outcome = ''") ||
      sqlite3_step(newest.s) != SQLITE_ROW)
    return tl::unexpected<Error>(table_->error(folder_));
  lost_until_ = newest.number(0);
  sqlite3_reset(newest.s);  // a reading that is still open would let no writer wait for its turn
  save_run_ends();
  return {};
}

void Spool::save_run_ends() {
  if (lost_until_ > 0) {
    SpoolStatement change;
    if (!table_->prepare(change, "UPDATE runs SET outcome = ?, note = ? WHERE outcome = '' AND id <= ?"))
      return;
    change.bind(1, std::string(kLostOutcome));
    change.bind(2, std::string(kLostNote));
    change.bind(3, lost_until_);
    if (sqlite3_step(change.s) != SQLITE_DONE) return;
    lost_until_ = 0;
  }
  while (!unsaved_ends_.empty() && write_run_end(unsaved_ends_.front()))
    unsaved_ends_.erase(unsaved_ends_.begin());
}

/// Of a run that goes on as the table has it.
void Spool::tell_end(RunReport& run) const {
  if (run.id <= lost_until_) {
    run.outcome = kLostOutcome;
    run.note = kLostNote;
    return;
  }
  for (const RunReport& end : unsaved_ends_) {
    if (end.job != run.job) continue;
    run.ended = end.ended;
    run.executed = end.executed;
    run.outcome = end.outcome;
    run.note = valid_text(end.note);
    run.figures = end.figures;
  }
}

Result<std::vector<RunReport>> Spool::runs(std::uint64_t after, std::uint64_t job, std::size_t most) const {
  SpoolStatement rows;
  const std::string of_job = job == 0 ? "" : " AND job = " + std::to_string(job);
  if (!table_->prepare(rows, std::string("SELECT ") + kRunColumns + " FROM runs WHERE id > " +
                                 std::to_string(after) + of_job + " ORDER BY id LIMIT " +
                                 std::to_string(most)))
    return tl::unexpected<Error>(table_->error(folder_));
  std::vector<RunReport> runs;
  int step = 0;
  while ((step = sqlite3_step(rows.s)) == SQLITE_ROW) {
    RunReport run;
    run.id = rows.number(0);
    run.job = rows.number(1);
    run.name = rows.text(2);
    run.hash = rows.text(3);
    run.link = rows.text(4);
    if (rows.known(5)) run.user = static_cast<std::uint32_t>(rows.number(5));
    run.began = static_cast<std::int64_t>(rows.number(6));
    if (rows.known(7)) run.ended = static_cast<std::int64_t>(rows.number(7));
    run.first = rows.number(8);
    run.blocks = rows.number(9);
    run.executed = rows.number(10);
    run.outcome = rows.text(11);
    run.note = valid_text(rows.text(12));
    if (rows.known(15)) {
      RunReport::Figures f{rows.number(13),
                           rows.number(14),
                           rows.real(15),
                           static_cast<int>(rows.number(16)),
                           rows.real(17),
                           {},
                           {},
                           {}};
      if (rows.known(18)) f.slowest_hold = rows.real(18);
      if (rows.known(19))
        f.feed_override = {static_cast<int>(rows.number(19)), static_cast<int>(rows.number(20))};
      if (rows.known(21)) f.starved_seconds = rows.real(21);
      run.figures = f;
    }
    if (run.outcome.empty()) tell_end(run);
    runs.push_back(std::move(run));
  }
  if (step != SQLITE_DONE) return tl::unexpected<Error>(table_->error(folder_));
  return runs;
}

Result<int> Spool::forget_runs(std::int64_t when) {
  SpoolStatement erase;
  if (!table_->prepare(erase,
                       "DELETE FROM runs WHERE outcome <> '' AND coalesce(ended, began) < ? AND job NOT IN "
                       "(SELECT id FROM jobs)"))
    return tl::unexpected<Error>(table_->error(folder_));
  erase.bind(1, static_cast<std::uint64_t>(std::max<std::int64_t>(when, 0)));
  if (sqlite3_step(erase.s) != SQLITE_DONE) return tl::unexpected<Error>(table_->error(folder_));
  return sqlite3_changes(table_->db);
}

Result<std::vector<KeptJob>> Spool::kept() const {
  const auto jobs = list();
  if (!jobs) return tl::unexpected<Error>(jobs.error());
  SpoolStatement rows;
  if (!table_->prepare(rows, "SELECT job, max(coalesce(ended, began)) FROM runs GROUP BY job"))
    return tl::unexpected<Error>(table_->error(folder_));
  std::map<std::uint64_t, std::int64_t> last;
  int step = 0;
  while ((step = sqlite3_step(rows.s)) == SQLITE_ROW)
    last[rows.number(0)] = static_cast<std::int64_t>(rows.number(1));
  if (step != SQLITE_DONE) return tl::unexpected<Error>(table_->error(folder_));
  std::vector<KeptJob> kept;
  for (const SpooledJob& job : *jobs)
    kept.push_back(
        {job.id, has_ended(job), std::max(job.created, last[job.id]), bytes_in(folder_of(job.id))});
  return kept;
}

}  // namespace tiltfeed::daemon
