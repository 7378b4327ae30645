// A spool of every earlier layout is brought up to date whole or not at all; a copy of a spool is one.

#include "daemon/service/spool_layout.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include "daemon/files/sha256.h"
#include "daemon/journal/program_run.h"
#include "daemon/service/spool_backup.h"
#include "tests/peers/spool_add.h"
#include "tests/shapes/wide_machine.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

/// The first layout, as the first service wrote it.
constexpr const char* kFirst =
    "PRAGMA journal_mode=WAL;"
    "CREATE TABLE jobs (id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL, program INTEGER NOT NULL,"
    " state TEXT NOT NULL, note TEXT NOT NULL, total INTEGER NOT NULL, executed INTEGER NOT NULL, hash TEXT "
    "NOT NULL,"
    " user INTEGER NOT NULL, created INTEGER NOT NULL);"
    "INSERT INTO jobs VALUES (3, 'old', 1, 'done', 'every block is executed', 70, 70, 'ab', 1000, "
    "1700000000);"
    "INSERT INTO jobs VALUES (9, 'new', 0, 'ready', '', 12, 0, 'cd', 1001, 1700000001);";
/// As of when jobs could wait, and no version was kept.
constexpr const char* kPlaced =
    "ALTER TABLE jobs ADD COLUMN place INTEGER NOT NULL DEFAULT 0; UPDATE jobs SET place = 4 WHERE id = 9;";

/// Layout 4, which has runs.
constexpr const char* kRuns =
    "CREATE TABLE runs (id INTEGER PRIMARY KEY AUTOINCREMENT, job INTEGER NOT NULL, name TEXT NOT NULL, hash "
    "TEXT "
    "NOT NULL, link TEXT NOT NULL, user INTEGER, began INTEGER NOT NULL, ended INTEGER, first INTEGER NOT "
    "NULL,"
    " blocks INTEGER NOT NULL, executed INTEGER NOT NULL, outcome TEXT NOT NULL DEFAULT '', note TEXT NOT "
    "NULL "
    "DEFAULT '', sent INTEGER, resends INTEGER, seconds REAL, holds INTEGER, held_seconds REAL, slowest_hold "
    "REAL, feed_least INTEGER, feed_most INTEGER);"
    "CREATE INDEX runs_on ON runs (job) WHERE outcome = '';"
    "INSERT INTO runs (job, name, hash, link, began, ended, first, blocks, executed, outcome, sent, resends, "
    "seconds, holds, held_seconds) VALUES (3, 'old', 'ab', 'grbl:/dev/x', 1700000002, 1700000009, 1, 70, 70, "
    "'done', 70, 2, 7.5, 1, 0.5);"
    "PRAGMA user_version = 4;";

class Layout : public testing::Test {
 protected:
  Layout() { std::filesystem::create_directories(folder_.path + "/spool"); }
  /// Runs it on the table; of a query the first value.
  std::string sql(const std::string& text) const {
    sqlite3* db = nullptr;
    EXPECT_EQ(sqlite3_open((folder_.path + "/spool/jobs.db").c_str(), &db), SQLITE_OK);
    std::string value;
    const auto take = [](void* to, int, char** values, char**) {
      return *static_cast<std::string*>(to) = values[0] != nullptr ? values[0] : "", 0;
    };
    EXPECT_EQ(sqlite3_exec(db, text.c_str(), take, &value, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
    return value;
  }
  Result<Spool> open() const { return Spool::open(folder_.path + "/spool"); }
  const Folder folder_{"layout"};
};

TEST_F(Layout, C19EveryEarlierLayoutIsBroughtUpToDate) {
  for (const int layout : {1, 2, 4}) {
    const bool placed = layout > 1, runs = layout > 3;
    std::filesystem::remove(folder_.path + "/spool/jobs.db");
    sql(kFirst);
    if (placed) sql(kPlaced);
    if (runs) sql(kRuns);
    for (int time = 0; time < 2; ++time) {
      const auto spool = open();
      ASSERT_TRUE(spool) << spool.error().message;
      const auto jobs = *spool->list();
      ASSERT_EQ(jobs.size(), 2u);
      EXPECT_EQ(jobs[0].id, 3u);
      EXPECT_EQ(jobs[0].name, "old");
      EXPECT_EQ(jobs[0].state, JobState::kDone);
      EXPECT_EQ(jobs[0].note, "every block is executed");
      EXPECT_EQ(jobs[0].executed, 70u);
      EXPECT_EQ(jobs[0].created, 1700000000);
      EXPECT_EQ(jobs[1].hash, "cd");
      EXPECT_EQ(jobs[1].place, placed ? 4u : 0u);
      const auto past = *spool->runs(0, 0, 9);
      ASSERT_EQ(past.size(), runs ? 1u : 0u);
      if (!runs) continue;
      EXPECT_EQ(past[0].ended, 1700000009);
      ASSERT_TRUE(past[0].figures);
      EXPECT_EQ(past[0].figures->resends, 2u);
      EXPECT_EQ(past[0].figures->held_seconds, 0.5);
      EXPECT_FALSE(past[0].figures->starved_seconds);
    }
    EXPECT_EQ(sql("PRAGMA user_version"), std::to_string(kSpoolVersion));
  }
}

TEST_F(Layout, C19AStepThatFailsLeavesTheTableAsItWas) {
  sql(kFirst);
  const std::string before = sql("SELECT group_concat(sql) FROM sqlite_master");
  // Each step in its turn is refused by SQLite, and none before it stays.
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder_.path + "/spool/jobs.db").c_str(), &db), SQLITE_OK);
  int refused = 0;
  for (int allowed = 0; allowed < 200; ++allowed) {
    struct Steps {
      int left;
    } steps{allowed};
    sqlite3_set_authorizer(
        db,
        [](void* s, int, const char*, const char*, const char*, const char*) {
          return static_cast<Steps*>(s)->left-- > 0 ? SQLITE_OK : SQLITE_DENY;
        },
        &steps);
    const auto made = bring_up_to_date(db, "jobs.db");
    sqlite3_set_authorizer(db, nullptr, nullptr);
    if (sqlite3_get_autocommit(db) == 0) sqlite3_exec(db, "ROLLBACK", nullptr, nullptr, nullptr);
    if (made) break;
    ++refused;
    ASSERT_EQ(sql("SELECT group_concat(sql) FROM sqlite_master"), before) << allowed;
    ASSERT_EQ(sql("PRAGMA user_version"), "0") << allowed;
  }
  sqlite3_close(db);
  EXPECT_GT(refused, 5);
  EXPECT_EQ(sql("PRAGMA user_version"), std::to_string(kSpoolVersion));
}

TEST_F(Layout, C19ALaterLayoutIsRefusedAndStaysAsItIs) {
  sql(std::string(kFirst) + "PRAGMA user_version = 8; ALTER TABLE jobs ADD COLUMN later TEXT");
  const auto spool = open();
  ASSERT_FALSE(spool);
  EXPECT_EQ(spool.error().code, Code::kUsage);
  EXPECT_NE(spool.error().message.find("later tiltfeed (layout 8"), std::string::npos)
      << spool.error().message;
  EXPECT_EQ(sql("SELECT count(*) FROM jobs WHERE later IS NULL"), "2");
  EXPECT_EQ(sql("PRAGMA user_version"), "8");
}

TEST_F(Layout, C18TenThousandJobsAreHeldAndListedInPages) {
  ASSERT_TRUE(open());
  sql("WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 10000) INSERT INTO jobs "
      "(name, program, "
      "state, note, total, executed, hash, user, created) SELECT 'part ' || i, 1, 'ready', "
      "printf('%.600c', 'x'), 7, 0, 'ab', 1, 2 FROM n");
  ServiceConfig config;
  config.machine.model = wide_machine();
  config.link = "grbl:" + folder_.path + "/absent";
  config.spool = folder_.path + "/spool";
  {
    auto jobs = JobService::open(config, [] {});
    ASSERT_TRUE(jobs) << jobs.error().message;
    ApiRequest list;
    std::uint64_t listed = 0;
    for (bool more = true; more;) {
      const std::string page = answer_of(*jobs, list);
      ASSERT_LT(page.size(), 4u << 20) << "what a client takes";
      for (std::size_t at = 0; (at = page.find("{\"job\":", at)) != std::string::npos; ++at) {
        ASSERT_EQ(std::stoull(page.substr(at + 7)), listed + 1);
        list.job = ++listed;
      }
      more = page.find("\"more\":true") != std::string::npos;
    }
    EXPECT_EQ(listed, 10000u);
  }
  auto spool = open();
  EXPECT_EQ(spool->begin({}).error().code, Code::kLimit);
  ASSERT_TRUE(spool->remove(17));
  EXPECT_EQ(*spool->begin({}), 10001u);
}

TEST_F(Layout, C19ACopyOfASpoolIsOneAndUnderstatesNothing) {
  const std::string text = "G21\nG1 X1 F600\nX2\nX3\nM2\n", copy = folder_.path + "/copy";
  ServiceConfig config;
  config.machine.model = wide_machine();
  config.link = "grbl:" + folder_.path + "/absent";
  config.spool = copy;
  {
    auto spool = open();
    ASSERT_TRUE(spool) << spool.error().message;
    const int fd = ::open(folder_.write("p.nc", text).c_str(), O_RDONLY);
    for (const JobState state : {JobState::kReady, JobState::kRunning}) {
      SpooledJob job;
      job.program = true;
      job.state = state;
      job.id = *add_job(*spool, job, {fd});
      const ProgramRun run =
          *prepare_run(spool->file(job.id, "program.nc"), *parse_link(config.link), job.id);
      job.total = run.subject.total;
      job.hash = hex(run.subject.program);
      ASSERT_TRUE(spool->update(job));
      // The journal says at that time that nothing was sent.
      ASSERT_TRUE(begin_journal(spool->file(job.id, "journal"), run.subject));
    }
    ::close(fd);
    // Somebody's folder, or another backup's that is at work.
    std::filesystem::create_directory(copy + ".partial");
    folder_.write("copy.partial/kept", "mine");
    EXPECT_EQ(back_up(folder_.path + "/spool", copy).error().code, Code::kUsage);
    ASSERT_EQ(file_text(copy + ".partial/kept"), "mine");
    std::filesystem::remove_all(copy + ".partial");
    const auto jobs = back_up(folder_.path + "/spool", copy);  // with the service at work
    ASSERT_TRUE(jobs) << jobs.error().message;
    EXPECT_EQ(*jobs, 2u);
    EXPECT_EQ(back_up(folder_.path + "/spool", copy).error().code, Code::kUsage);
  }
  auto jobs = JobService::open(config, [] {});
  ASSERT_TRUE(jobs) << jobs.error().message;
  ASSERT_FALSE(std::filesystem::exists(copy + ".partial"));
  std::ifstream in(copy + "/jobs/2/program.nc");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), text);
  EXPECT_FALSE(std::filesystem::exists(copy + "/jobs/2/journal"));
  ApiRequest show;
  show.op = ApiOp::kShow;
  show.job = 1;
  EXPECT_NE(answer_of(*jobs, show).find("\"state\":\"ready\""), std::string::npos);
  show.job = 2;
  const std::string begun = answer_of(*jobs, show);
  EXPECT_NE(begun.find("\"state\":\"uncertain\""), std::string::npos) << begun;
  EXPECT_NE(begun.find("blocks 1 to 5 may have run"), std::string::npos) << begun;
}

/// Who may read the spool, and not write it.
TEST_F(Layout, C19ABackupThatCannotReadTheSpoolSaysWhy) {
  const std::string spool = folder_.path + "/spool", copies = folder_.path + "/copies";
  ASSERT_TRUE(open());
  std::filesystem::create_directory(copies);
  std::filesystem::permissions(copies, std::filesystem::perms::all);
  ASSERT_EQ(::chmod(spool.c_str(), 0555), 0);
  ASSERT_EQ(::chmod((spool + "/jobs.db").c_str(), 0444), 0);
  const bool root = ::geteuid() == 0;
  constexpr uid_t kNobody = 65534;
  ASSERT_EQ(root ? ::seteuid(kNobody) : 0, 0);
  const auto copied = back_up(spool, copies + "/copy");
  const auto none = back_up(folder_.path + "/elsewhere", copies + "/copy");
  ASSERT_EQ(root ? ::seteuid(0) : 0, 0);
  ASSERT_EQ(::chmod(spool.c_str(), 0755), 0);
  ASSERT_FALSE(copied);
  EXPECT_TRUE(copied.error().message.starts_with(spool)) << copied.error().message;
  EXPECT_NE(copied.error().message.find("run it as the user of the service"), std::string::npos)
      << copied.error().message;
  EXPECT_EQ(copied.error().code, Code::kUsage);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("no spool"), std::string::npos) << none.error().message;
  EXPECT_TRUE(std::filesystem::is_empty(copies));
  folder_.write("spool/jobs.db", std::string(5000, 'x'));
  const auto damaged = back_up(spool, copies + "/copy");
  ASSERT_FALSE(damaged);
  EXPECT_TRUE(damaged.error().message.starts_with(spool)) << damaged.error().message;
}

}  // namespace
}  // namespace tiltfeed
