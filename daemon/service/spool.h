#pragma once
// The jobs of one machine: a table (SQLite) and a folder for each job. File names are made here; nothing that
// a user typed becomes part of a path.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/service/retention.h"
#include "daemon/service/run_report.h"
#include "daemon/service/state_lock.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

struct SpoolTable;
class SpoolShop;
class SpoolStates;

enum class JobState : std::uint8_t {
  kReceived,     ///< to be planned
  kPlanning,     ///< in a process of its own
  kReady,        ///< waits for an operator's start
  kRunning,      ///< on the wire, held included
  kInterrupted,  ///< cut off; the controller can prove what it executed: resume goes on
  kUncertain,    ///< cut off; nothing can be proved: resume --from BLOCK, after a look at the machine
  kDone,
  kStopped,     ///< by an operator; as kUncertain
  kFailed,      ///< planning failed
  kToolChange,  ///< stands before a tool change that the operator makes: all before it is executed
};
/// "job 3".
std::string name_of(std::uint64_t job);
const char* state_name(JobState state);
std::optional<JobState> state_of(const std::string& name);

struct SpooledJob {
  std::uint64_t id = 0;
  std::string name;      ///< for people: [A-Za-z0-9 ._-], at most 40
  bool program = false;  ///< came as a program, not as a job to plan
  JobState state = JobState::kReceived;
  std::string note;  ///< why it is in this state
  std::uint64_t total = 0, executed = 0;
  std::string hash;          ///< of the program, hexadecimal; pinned when it became ready
  std::uint32_t user = 0;    ///< who submitted it
  std::int64_t created = 0;  ///< seconds since 1970
  /// Among the jobs that wait for their turn on the machine, the lowest first; 0: waits for none.
  std::uint64_t place = 0;
  std::string shop = {};     ///< id in the shop's queue that it came from; empty: it was submitted here
  std::string unsaved = {};  ///< why the table does not have all this yet; empty: it does
};
/// Done, stopped or failed, and it waits for no turn: nothing is left to do with it.
bool has_ended(const SpooledJob& job);
/// What people and clients are told: "queued" where only the machine is waited for, else the state's name.
const char* shown_state(const SpooledJob& job);

/// Largest files that a submission may bring, bytes.
inline constexpr std::uint64_t kMaxPartBytes = 512ull << 20, kMaxProgramBytes = 2048ull << 20,
                               kMaxJobBytes = 1u << 20;
/// Jobs that a spool holds, done ones included.
inline constexpr std::size_t kMaxJobs = 10000;

/// Letters of any alphabet, digits and " ._-", whole ones, in at most so many bytes of UTF-8; "job" when
/// nothing is left.
std::string plain_name(const std::string& text, std::size_t most = 40);

class Spool {
 public:
  /// Makes the folder and its table where they are not there; a table of an earlier version is brought up to
  /// date. Errors: kIo; kUsage where another process has it open, of which nothing is read or changed then.
  static Result<Spool> open(const std::string& folder);
  Spool(Spool&&) noexcept;
  Spool& operator=(Spool&&) = delete;
  ~Spool();

  /// A new job whose files are still to come, with its folder: failed, should nothing more be heard of it.
  /// Errors: kLimit (too many jobs), kIo.
  Result<std::uint64_t> begin(const SpooledJob& job);
  /// Its files are there: they are made durable, then the job is what `job` says. Errors: kIo.
  Result<void> finish(const SpooledJob& job);
  /// In the order of submission. Errors: kIo.
  Result<std::vector<SpooledJob>> list() const;
  /// So many at most, those that were submitted after job `after`. Errors: kIo.
  Result<std::vector<SpooledJob>> page(std::uint64_t after, std::size_t most) const;
  /// Those that nobody has planned or checked yet. Errors: kIo.
  Result<std::vector<SpooledJob>> received() const;
  /// Those that wait for their turn, the next first. Errors: kIo.
  Result<std::vector<SpooledJob>> queue() const;
  /// Errors: kUsage when there is none; kIo.
  Result<SpooledJob> find(std::uint64_t id) const;
  /// The job that came from the shop's queue under this id; nothing: none is here. Errors: kIo.
  Result<std::optional<SpooledJob>> find_shop(const std::string& id) const;
  /// State, note, counts, hash and place, all or nothing. Errors: kIo.
  Result<void> update(const SpooledJob& job);
  /// What is so although the table could not take it (a full disk): told in its place until it can be
  /// written.
  void remember(const SpooledJob& job) { remembered_[job.id] = job; }
  /// Tries again to write what is remembered.
  void save_remembered();
  /// With its files; what stays of them goes when the spool is opened again. On a disk without room the files
  /// go first. Errors: kIo; where the files are gone and the table could not take it, the job is told as
  /// failed.
  Result<void> remove(std::uint64_t id);

  /// A run goes on from now; its number. Errors: kIo.
  Result<std::uint64_t> begin_run(const RunReport& run);
  /// Of the run of job `end.job` that goes on: when and how it ended; nothing where none does. What cannot be
  /// written now is tried again by `save_remembered`.
  void end_run(const RunReport& end);
  /// No run goes on: of one that seems to, nobody wrote the end. What cannot be written now is told all the
  /// same, and tried again by `save_remembered`. Errors: kIo.
  Result<void> end_lost_runs();
  /// So many at most, those after run `after`, the oldest first; of one job, or of all (0). They stay when
  /// their job is removed. Errors: kIo.
  Result<std::vector<RunReport>> runs(std::uint64_t after, std::uint64_t job, std::size_t most) const;

  /// Those that ended before `when` and whose job is removed, forgotten: how many. Errors: kIo.
  Result<int> forget_runs(std::int64_t when);
  /// All jobs, with the bytes of their files. Errors: kIo.
  Result<std::vector<KeptJob>> kept() const;

  /// What is kept of the shop's jobs. Requires: not used longer than the spool.
  SpoolShop shop() const;
  SpoolStates shop_states() const;

  /// FOLDER/jobs/ID, and files in it: job.yaml part.stl program.nc report.json block.map journal ...
  std::string folder_of(std::uint64_t id) const;
  std::string file(std::uint64_t id, const char* name) const { return folder_of(id) + "/" + name; }

 private:
  Spool(std::string folder, StateLock lock, std::unique_ptr<SpoolTable> table);
  Result<void> heal();
  Result<void> sweep();
  Result<void> erase_row(std::uint64_t id);
  void forget_files(std::uint64_t id);
  void save_run_ends();
  bool write_run_end(const RunReport& end);
  void tell_end(RunReport& run) const;
  Result<std::vector<SpooledJob>> select(const std::string& which) const;

  std::string folder_;
  StateLock lock_;
  std::unique_ptr<SpoolTable> table_;
  std::map<std::uint64_t, SpooledJob> remembered_;
  std::vector<RunReport> unsaved_ends_;
  /// Runs up to this one have no end that anybody will write; 0: the table says so.
  std::uint64_t lost_until_ = 0;
};

}  // namespace tiltfeed::daemon
