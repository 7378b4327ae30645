// A service that is started again over a job that was running and whose journal is lost, whole or in part:
// the job is left to the operator over everything that may have been sent, and safe-stop acts.

#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "config/service_config.h"
#include "daemon/files/sha256.h"
#include "daemon/service/job_service.h"
#include "daemon/service/safe_stop.h"
#include "daemon/service/state_lock.h"
#include "tests/peers/journal_subject.h"
#include "tests/peers/simulated_disk.h"
#include "tests/peers/spool_add.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

using std::chrono::milliseconds;

/// A journal as a run of `total` blocks leaves it at some moment, with what has really left until then.
struct Moment {
  std::string file;
  std::uint64_t offered = 0, executed = 0;
};

/// A run in fast and slow stretches, with reservations of every size; looked at after each turn.
std::vector<Moment> moments_of_a_run(const RunSubject& subject) {
  const auto disk = std::make_shared<SimulatedDisk>();
  Journal journal = *Journal::open(journal_disk(disk));
  RunRecorder recorder = *RunRecorder::begin(journal, subject);
  std::vector<Moment> moments{{disk->file, 0, 0}};
  std::mt19937_64 random(4);
  SendState state;
  state.total = subject.total;
  state.boot = 5;
  Time now{0};
  std::uint64_t offered = 0, granted = 0;
  while (offered < subject.total) {
    now += milliseconds(random() % 50 == 0 ? 3000 : 20);
    for (std::uint64_t more = random() % 30; more > 0 && offered < subject.total; --more) {
      if (offered == granted) granted = *recorder.reserve(offered + 1, now);
      ++offered;
    }
    state.acknowledged = offered - std::min<std::uint64_t>(offered, random() % 9);
    state.executed =
        std::max(state.executed, state.acknowledged - std::min<std::uint64_t>(state.acknowledged, 5));
    EXPECT_TRUE(recorder.progress(state, now));
    moments.push_back({disk->file, offered, state.executed});
  }
  return moments;
}

/// The decision holds the truth: what it calls executed is, and what left is not beyond it.
void expect_truth(const std::string& file, const RunSubject& now, const Moment& moment, const char* what) {
  const ResumeDecision d = decide_resume(read_journal(file), now);
  ASSERT_LE(d.executed, moment.executed) << what;
  ASSERT_GE(d.may_have, moment.offered) << what << ": " << d.text;
  if (moment.offered > 0) {
    ASSERT_NE(d.way, ResumeWay::kFresh) << what;
  }
}

TEST(DecideResume, A3ALostJournalIsUncertainOverTheWholeProgram) {
  for (const LinkKind kind : {LinkKind::kGrbl, LinkKind::kModbusTcp, LinkKind::kDrip, LinkKind::kRepRap}) {
    const RunSubject now = subject_of(3000, kind);
    const std::string whole = moments_of_a_run(now)[40].file;
    const std::string first = whole.substr(0, kRecordBytes);
    for (const std::string& lost : {std::string(), std::string(whole.size(), '\0'), first,
                                    std::string("another file"), whole.substr(0, kRecordBytes / 2)}) {
      const ResumeDecision d = decide_resume(read_journal(lost), now);
      EXPECT_EQ(d.way, ResumeWay::kUncertain);
      EXPECT_EQ(d.executed, 0u);
      EXPECT_EQ(d.may_have, 3000u);
      EXPECT_NE(d.text.find("blocks 1 to 3000 may have run"), std::string::npos) << d.text;
    }
  }
}

TEST(DecideResume, A3NoDamageMakesTheRangeTooSmall) {
  const RunSubject now = subject_of(3000, LinkKind::kGrbl);
  RunSubject rebooted = now;
  rebooted.host[3] = 9;
  std::mt19937_64 random(9);
  for (const Moment& moment : moments_of_a_run(now)) {
    const std::string& file = moment.file;
    expect_truth(file, now, moment, "undamaged");
    expect_truth(file, rebooted, moment, "rebooted");
    const std::uint64_t records = read_journal(file).records;
    const std::size_t newest = (records - 1) * kRecordBytes;
    for (int i = 0; i < 30; ++i) {
      std::string damaged = file;
      damaged[newest + random() % kRecordBytes] ^= static_cast<char>(1 << random() % 8);
      expect_truth(damaged, now, moment, "newest record");
      expect_truth(file.substr(0, random() % (newest + kRecordBytes + 1)), now, moment, "cut off");
      damaged = file;  // a stretch of zeros, up to the end or not
      const std::size_t at = random() % damaged.size();
      const std::size_t count = std::min(damaged.size() - at, 1 + random() % 1000);
      damaged.replace(at, count, count, '\0');
      expect_truth(damaged, now, moment, "zeroed in part");
      damaged.replace(at, std::string::npos, damaged.size() - at, '\0');
      expect_truth(damaged, now, moment, "zeroed to the end");
    }
  }
}

TEST(DecideResume, ARunThatWentOnWithADamagedJournalKeepsTheWholeRange) {
  const RunSubject now = subject_of(3000);
  const Moment moment = moments_of_a_run(now)[60];
  const auto disk = std::make_shared<SimulatedDisk>();
  disk->file = disk->durable = moment.file;
  disk->file[(read_journal(moment.file).records - 1) * kRecordBytes + 9] ^= 4;
  Journal journal = *Journal::open(journal_disk(disk));
  const ResumeDecision d = decide_resume(journal.content(), now);
  ASSERT_EQ(d.way, ResumeWay::kContinue);
  ASSERT_TRUE(RunRecorder::go_on(journal, now, d.may_have));
  expect_truth(disk->durable, now, moment, "gone on");
}

// ---- in the service
// ----------------------------------------------------------------------------------------

constexpr std::uint64_t kBlocks = 500;

class LostJournal : public testing::Test {
 protected:
  LostJournal() {
    const std::string machine = std::string(SOURCE_DIR) + "/config/machines/generic-ac.yaml";
    std::filesystem::copy_file(machine, folder_.path + "/machine.yaml");
    config_path_ = folder_.write(
        "service.yaml", "machine: machine.yaml\nlink: " + no_device_ + "\nspool: spool\nsocket: api.sock\n");
    config_ = *load_service_config(config_path_);
    std::string program = "G21 G90 G94\n";
    for (std::uint64_t i = 1; i < kBlocks; ++i) program += "G1 X" + std::to_string(i % 9) + " F600\n";
    const int fd = ::open(folder_.write("program.nc", program).c_str(), O_RDONLY);
    Spool spool = *Spool::open(config_.spool);
    SpooledJob job;
    job.program = true;
    job.state = JobState::kRunning;
    job.id = *add_job(spool, job, {fd});
    ::close(fd);
    const ProgramRun run = *prepare_run(spool.file(job.id, "program.nc"), *parse_link(no_device_), job.id);
    job.total = run.subject.total;
    job.hash = hex(run.subject.program);
    EXPECT_TRUE(spool.update(job));
    job_ = job;
    journal_ = spool.file(job.id, "journal");
    EXPECT_TRUE(begin_journal(journal_, run.subject));
    begun_ = read();
    Journal journal = *Journal::open(*journal_file(journal_));
    RunRecorder recorder = *RunRecorder::go_on(journal, run.subject, 0);
    EXPECT_TRUE(recorder.reserve(1, Time{0}));
    EXPECT_TRUE(recorder.reserve(65, Time{0}));
    streamed_ = read();
  }

  std::string read() const {
    std::ifstream in(journal_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void put(const std::optional<std::string>& bytes) const {
    std::filesystem::remove_all(journal_);
    if (bytes) std::ofstream(journal_, std::ios::binary) << *bytes;
  }
  /// State and note after a start of the service.
  SpooledJob settled() {
    {
      Spool spool = *Spool::open(config_.spool);
      EXPECT_TRUE(spool.update(job_));
    }
    EXPECT_TRUE(JobService::open(config_, [] {}));
    return *Spool::open(config_.spool)->find(job_.id);
  }
  /// What safe-stop says, with the service dead.
  std::string stopped() {
    EXPECT_TRUE(Spool::open(config_.spool)->update(job_));
    const Result<SafeStop> stop = safe_stop(config_path_, {"signal", "killed", "KILL"});
    return stop ? stop->text : stop.error().message;
  }

  const Folder folder_{"lost_journal"};
  /// Nothing can be opened there, so safe-stop says by its failure that it would have acted.
  const std::string no_device_ = "grbl:" + folder_.path + "/no_such_device@115200";
  std::string config_path_, journal_, begun_, streamed_;
  ServiceConfig config_;
  SpooledJob job_;
};

TEST_F(LostJournal, A3TheWholeProgramIsUncertainAndSafeStopActs) {
  ASSERT_EQ(job_.total, kBlocks);
  const std::vector<std::optional<std::string>> lost = {
      std::nullopt,
      "",
      std::string(streamed_.size(), '\0'),
      streamed_.substr(0, kRecordBytes),
      begun_.substr(0, kRecordBytes),
      streamed_.substr(0, 3 * kRecordBytes),
      "not a journal",
  };
  for (std::size_t i = 0; i < lost.size(); ++i) {
    put(lost[i]);
    EXPECT_NE(stopped().find("job 1, grbl"), std::string::npos) << i << ": " << stopped();
    const SpooledJob job = settled();
    EXPECT_EQ(job.state, JobState::kUncertain) << i << ": " << state_name(job.state);
    EXPECT_NE(job.note.find("blocks 1 to 500 may have run"), std::string::npos) << i << ": " << job.note;
  }
  // A folder in its place.
  put(std::nullopt);
  std::filesystem::create_directory(journal_);
  EXPECT_NE(stopped().find("job 1, grbl"), std::string::npos) << stopped();
  EXPECT_EQ(settled().state, JobState::kUncertain);
}

TEST_F(LostJournal, A3ADamagedNewestRecordWidensTheRange) {
  put(streamed_);
  EXPECT_NE(settled().note.find("blocks 1 to 65 may have run"), std::string::npos) << settled().note;
  std::string damaged = streamed_;
  damaged[(read_journal(streamed_).records - 1) * kRecordBytes + 70] ^= 1;
  put(damaged);
  EXPECT_NE(settled().note.find("blocks 1 to 500 may have run"), std::string::npos) << settled().note;
}

TEST_F(LostJournal, A3ASpoolThatCannotBeReadIsNoProofThatNothingRan) {
  put(begun_);
  const auto said = [&] {
    const Result<SafeStop> stop = safe_stop(config_path_, {"signal", "killed", "KILL"});
    return stop ? stop->text : stop.error().message;
  };
  for (const char* const name : {"jobs.db", "jobs.db-wal", "jobs.db-shm"})
    std::filesystem::remove(config_.spool + "/" + name);
  EXPECT_NE(said().find("the table was lost"), std::string::npos) << said();
  EXPECT_NE(said().find("no_such_device"), std::string::npos) << "it would have stood by: " << said();
  std::filesystem::remove(config_.spool + "/jobs.db");
  folder_.write("spool/jobs.db", std::string(5000, 'x'));
  EXPECT_NE(said().find("not a database"), std::string::npos) << said();
  EXPECT_NE(said().find("no_such_device"), std::string::npos) << "it would have stood by: " << said();
  {
    MachineClaim alive;
    ASSERT_TRUE(alive.follow(*parse_link(no_device_)));
    EXPECT_NE(said().find("serves already"), std::string::npos) << said();
  }
  // Of a living service it is not.
  std::filesystem::remove(config_.spool + "/jobs.db");
  std::filesystem::rename(config_.spool + "/jobs", folder_.path + "/away");
  const Spool alive = *Spool::open(config_.spool);
  EXPECT_NE(said().find("is in use"), std::string::npos) << said();
  EXPECT_EQ(said().find("no_such_device"), std::string::npos) << said();
}

/// Before a tool change in the first line no block has left, and the machine parks or goes back all the same.
TEST_F(LostJournal, A3AMachineBesideAToolChangeIsStopped) {
  for (const std::uint64_t change : {1u, 30u}) {
    put(std::nullopt);
    RunSubject subject =
        prepare_run(Spool::open(config_.spool)->file(job_.id, "program.nc"), *parse_link(no_device_), job_.id)
            ->subject;
    subject.last = change - 1;
    {
      Journal journal = *Journal::open(*journal_file(journal_));
      RunRecorder recorder = *RunRecorder::begin(journal, subject);
      SendState state;
      state.phase = Phase::kDrain;
      state.executed = state.acknowledged = subject.last;
      for (std::uint64_t block = 1; block <= subject.last; ++block)
        EXPECT_TRUE(recorder.reserve(block, Time{0}));
      EXPECT_TRUE(recorder.progress(state, Time{1}));
    }
    EXPECT_NE(stopped().find("job 1, grbl"), std::string::npos) << change << ": it parks; " << stopped();
    EXPECT_TRUE((subject.after = change, subject.last = subject.total, begin_journal(journal_, subject)));
    EXPECT_NE(stopped().find("job 1, grbl"), std::string::npos) << change << ": it goes back; " << stopped();
  }
}

TEST_F(LostJournal, AWholeJournalThatSaysThatNothingWasSentIsBelieved) {
  put(begun_);
  EXPECT_NE(stopped().find("nothing was sent"), std::string::npos) << stopped();
  EXPECT_EQ(settled().state, JobState::kReady);
}

}  // namespace
}  // namespace tiltfeed
