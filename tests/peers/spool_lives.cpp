#include "tests/peers/spool_lives.h"

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "config/output_file.h"
#include "daemon/files/sha256.h"
#include "tests/peers/journal_subject.h"
#include "tests/peers/spool_add.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

namespace {

std::string whole_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// What planning makes of a description.
std::string planned_text(const std::string& text) { return "G21\n(" + text + ")\nG1 X1 F600\nM2\n"; }

}  // namespace

HostBoot SpoolLives::host() const {
  HostBoot boot{};
  for (std::size_t i = 0; i < 8; ++i) boot[i] = static_cast<std::uint8_t>(boots_ >> (8 * i));
  return boot;
}

void SpoolLives::reboot() {
  ++boots_;
  for (auto& [name, known] : known_) known.executed += any(known.left - known.executed + 1);
}

std::string SpoolLives::program_of(const SpooledJob& job) const {
  const KnownJob& known = known_.at(job.name);
  return known.program ? known.text : planned_text(known.text);
}

// ---- what is left
// -------------------------------------------------------------------------------------------

void SpoolLives::look(const std::string& folder) {
  const Result<Spool> spool = Spool::open(folder);
  if (!spool) return complain("cannot be opened: " + spool.error().message);
  const auto rows = spool->list();
  if (!rows) return complain("cannot be listed: " + rows.error().message);
  std::set<std::string> seen;
  for (const SpooledJob& row : *rows) {
    if (!known_.contains(row.name)) return complain("nobody submitted " + row.name);
    if (!seen.insert(row.name).second) complain(row.name + " is there twice");
    judge(row, *spool);
  }
  std::set<std::string> folders;
  for (const SpooledJob& row : *rows) folders.insert(std::to_string(row.id));
  for (const auto& entry : std::filesystem::directory_iterator(folder + "/jobs"))
    if (!folders.contains(entry.path().filename().string()))
      complain(entry.path().string() + " is of no job");
  for (const auto& [name, known] : known_)
    if (known.answered && !known.leaving && !seen.contains(name)) complain(name + " was taken and is lost");
}

void SpoolLives::judge(const SpooledJob& row, const Spool& spool) {
  const KnownJob& known = known_.at(row.name);
  const std::string what = row.name + " (" + state_name(row.state) + ")";
  if (known.gone) complain(what + " was removed and is back");
  if (!known.answered && row.state == JobState::kFailed) return;  // nobody counts on it
  if (!known.states.contains(row.state)) complain(what + " was never told to be that");
  const auto is = [&](const char* name, const std::string& text) {
    if (whole_text(spool.file(row.id, name)) != text) complain(what + " has another " + name);
  };
  is(known.program ? "program.nc" : "job.yaml", known.text);
  if (!known.program) is("part.stl", known.text);
  if (row.state == JobState::kReceived) return;
  is("program.nc", program_of(row));
  if (row.hash != hex(sha256(program_of(row)))) complain(what + " has another hash");
  judge_run(known, row, spool);
}

ResumeDecision SpoolLives::decision_of(const KnownJob& known, std::uint64_t id, const Spool& spool) const {
  RunSubject now = known.run;
  now.host = host();
  const Result<JournalContent> journal = read_journal_file(spool.file(id, "journal"));
  return decide_resume(journal ? *journal : JournalContent{}, now);
}

/// What the journal says against what left and what was executed.
void SpoolLives::judge_run(const KnownJob& known, const SpooledJob& row, const Spool& spool) {
  if (row.state == JobState::kReady && known.left > 0) complain(row.name + " ran and would begin again");
  if (row.state == JobState::kReady || row.state == JobState::kDone) return;
  const Result<JournalContent> journal = read_journal_file(spool.file(row.id, "journal"));
  if (!journal || !journal->last || journal->last->session_id != known.run.session_id)
    complain(row.name + " (" + state_name(row.state) + ") has lost the records of its run");
  const ResumeDecision now = decision_of(known, row.id, spool);
  const auto told = [&](const char* what) {
    complain(row.name + " (" + state_name(row.state) + ") " + what + ": " + now.text + "; in truth " +
             std::to_string(known.left) + " left, " + std::to_string(known.executed) + " were executed");
  };
  if (row.executed > known.executed) told("shows more than was executed");
  if (now.executed > known.executed) told("claims more than was executed");
  if (now.may_have < known.left) told("says less than left");
  if (now.way == ResumeWay::kFresh && known.left > 0) told("would begin again");
  if (now.way == ResumeWay::kFinished && known.executed < known.run.total) told("is not finished");
  if (now.way == ResumeWay::kContinue && now.ring.accepted > known.left) told("would leave blocks out");
}

// ---- what a service does
// ------------------------------------------------------------------------------------

bool SpoolLives::set(Spool& spool, SpooledJob row, JobState state) {
  KnownJob& known = known_.at(row.name);
  known.states.insert(state);
  row.state = state;
  if (state == JobState::kDone && known.executed < known.run.total) complain(row.name + " is called done");
  if (!spool.update(row)) return false;
  known.states = {state};
  return true;
}

/// As JobService::settle.
void SpoolLives::settle(Spool& spool) {
  const auto rows = spool.list();
  if (!rows) return;
  for (SpooledJob row : *rows) {
    if (row.state != JobState::kRunning) continue;
    const ResumeDecision decision = decision_of(known_.at(row.name), row.id, spool);
    row.executed = decision.executed;
    set(spool, row,
        decision.way == ResumeWay::kFresh      ? JobState::kReady
        : decision.way == ResumeWay::kContinue ? JobState::kInterrupted
        : decision.way == ResumeWay::kFinished ? JobState::kDone
                                               : JobState::kUncertain);
  }
}

std::string SpoolLives::submit(Spool& spool, bool program, std::size_t size) {
  SpooledJob job;
  job.name = "submission " + std::to_string(++submitted_);
  job.program = program;
  job.state = JobState::kReceived;
  KnownJob& known = known_[job.name];
  known.program = program;
  known.text = "G21\n(" + job.name + ")\n" + std::string(size, ';') + "\nM2\n";
  known.states = {JobState::kReceived};
  const int fd = ::memfd_create("handed", MFD_CLOEXEC);
  if (::write(fd, known.text.data(), known.text.size()) != static_cast<ssize_t>(known.text.size()))
    complain("no memory for a file");
  // Written long ago: whoever copies it need not wait until the clock of file times has gone on.
  const timespec long_ago[2] = {{1'000'000'000, 0}, {1'000'000'000, 0}};
  if (::futimens(fd, long_ago) != 0) complain("no other time for a file");
  known.answered = add_job(spool, job, std::vector<int>(program ? 1 : 2, fd)).has_value();
  ::close(fd);
  return job.name;
}

/// The planner's program, and the check.
void SpoolLives::plan(Spool& spool, SpooledJob row) {
  const KnownJob& known = known_.at(row.name);
  if (!known.program && !write_file(spool.file(row.id, "program.nc"), planned_text(known.text))) return;
  row.hash = hex(sha256(program_of(row)));
  set(spool, row, JobState::kReady);
}

/// As JobService::begin and run: another workpiece has a journal of its own. The machine gets blocks to
/// `until`.
void SpoolLives::start(Spool& spool, SpooledJob row, LinkKind kind, std::uint64_t total,
                       std::uint64_t until) {
  KnownJob& known = known_.at(row.name);
  RunSubject run = subject_of(total, kind);
  run.program = sha256(program_of(row));
  run.host = host();
  run.session_id = static_cast<std::uint16_t>(++runs_ % 60000 + 1);
  std::error_code gone;
  std::filesystem::remove(spool.file(row.id, "journal"), gone);
  if (gone || !begin_journal(spool.file(row.id, "journal"), run)) return;
  known.run = run;
  known.left = known.executed = row.executed = 0;
  if (!set(spool, row, JobState::kRunning)) return;
  row.state = JobState::kRunning;
  ResumeDecision fresh;
  fresh.way = ResumeWay::kFresh;
  stream(spool, row, fresh, until);
}

/// As run_job; the machine takes every block that may leave. False when the disk said no.
bool SpoolLives::send(KnownJob& known, RunRecorder& recorder, std::uint64_t until) {
  SendState state;
  state.boot = 7;
  state.total = known.run.total;
  Time now{0};
  while (known.left < until) {
    const Result<std::uint64_t> upto = recorder.reserve(known.left + 1, now);
    if (!upto) return false;
    known.left = *upto;
    known.executed += any(known.left - known.executed + 1);
    if (known.left == known.run.total && until == known.left) known.executed = known.left;
    now += std::chrono::milliseconds(any(3000));
    state.executed = known.executed;
    state.acknowledged = known.executed + any(known.left - known.executed + 1);
    if (!recorder.progress(state, now)) return false;
  }
  const bool done = known.executed == known.run.total;
  return recorder.end(done ? RunEvent::kExecuted : RunEvent::kFault, state).has_value();
}

/// As StreamThread::stream and JobService::take_run_end.
void SpoolLives::stream(Spool& spool, SpooledJob row, const ResumeDecision& decision, std::uint64_t until) {
  KnownJob& known = known_.at(row.name);
  const auto run = [&]() -> bool {
    const Result<JournalDisk> disk = journal_file(spool.file(row.id, "journal"));
    if (!disk) return false;
    Result<Journal> journal = Journal::open(*disk);
    if (!journal) return false;
    const bool goes_on = decision.way == ResumeWay::kContinue;
    RunSubject now = known.run;
    now.host = host();
    // A journal that cannot be read is none that a run could go on with: prepared and decided anew.
    if (goes_on && !journal->content().last) return false;
    Result<RunRecorder> recorder =
        goes_on ? RunRecorder::go_on(*journal, now, decision.may_have) : RunRecorder::begin(*journal, now);
    return recorder && send(known, *recorder, until);
  };
  const bool kept = run();
  row.executed = known.executed;
  if (kept && known.executed == known.run.total) {
    set(spool, row, JobState::kDone);
    return;
  }
  const ResumeDecision now = decision_of(known, row.id, spool);
  set(spool, row,
      now.way == ResumeWay::kFresh      ? JobState::kReady
      : now.way == ResumeWay::kContinue ? JobState::kInterrupted
                                        : JobState::kUncertain);
}

void SpoolLives::remove(Spool& spool, const SpooledJob& row) {
  KnownJob& known = known_.at(row.name);
  known.leaving = true;
  known.gone = spool.remove(row.id).has_value();
}

void SpoolLives::step(Spool& spool, const SpooledJob& row) {
  const std::uint64_t total = 100 + any(4) * 700, until = any(2) == 0 ? total : any(total);
  if (row.state == JobState::kReceived) return plan(spool, row);
  if (row.state == JobState::kReady || row.state == JobState::kDone)
    return start(spool, row, any(3) == 0 ? LinkKind::kGrbl : LinkKind::kModbusTcp, total, until);
  if (row.state != JobState::kInterrupted) return remove(spool, row);
  const KnownJob& known = known_.at(row.name);
  const ResumeDecision decision = decision_of(known, row.id, spool);
  if (decision.way == ResumeWay::kContinue) return stream(spool, row, decision, known.run.total);
  set(spool, row, decision.way == ResumeWay::kFinished ? JobState::kDone : JobState::kUncertain);
}

void SpoolLives::live(int steps) {
  Result<Spool> spool = Spool::open(folder_);
  if (!spool) return;
  settle(*spool);
  for (int i = 0; i < steps; ++i) {
    const auto rows = spool->list();
    if (!rows) continue;
    if (rows->empty() || (rows->size() < 4 && any(4) == 0)) {
      submit(*spool, any(3) != 0, any(3) * 3000);
      continue;
    }
    const SpooledJob& row = (*rows)[any(rows->size())];
    if (rows->size() > 3 && any(3) == 0)
      remove(*spool, row);
    else
      step(*spool, row);
  }
}

std::optional<SpooledJob> SpoolLives::row_of(const Spool& spool, const std::string& name) const {
  const auto rows = spool.list();
  for (std::size_t i = 0; rows && i < rows->size(); ++i)
    if ((*rows)[i].name == name) return (*rows)[i];
  return std::nullopt;
}

void SpoolLives::story() {
  Result<Spool> spool = Spool::open(folder_);
  if (!spool) return;
  settle(*spool);
  const std::string first = submit(*spool, true, 0), second = submit(*spool, false, 5000);
  for (const std::string& name : {first, second})
    if (const auto row = row_of(*spool, name); row && row->state == JobState::kReceived) plan(*spool, *row);
  if (const auto row = row_of(*spool, first); row && row->state == JobState::kReady)
    start(*spool, *row, LinkKind::kModbusTcp, 200, 100);
  if (const auto row = row_of(*spool, first); row && row->state == JobState::kInterrupted) step(*spool, *row);
  if (const auto row = row_of(*spool, second); row && row->state == JobState::kReady)
    start(*spool, *row, LinkKind::kGrbl, 100, 50);
  if (const auto row = row_of(*spool, first)) remove(*spool, *row);
}

}  // namespace tiltfeed
