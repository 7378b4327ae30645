// What a spool keeps of the shop's jobs, over restarts, and how the job service takes them: as submissions
// that nobody starts.

#include "daemon/service/spool_shop.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include "tests/peers/served_jobs.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
namespace {

const std::string kId = "00000000-0000-4000-8000-000000000001", kDigest(64, 'a');
ShopJob job_of(const std::string& id, std::uint64_t token = 5) {
  return {{id, 1, token}, 17, "seat rail", true, {{kDigest, 20}}};
}
const ShopMark kMark{"00000000-0000-4000-8000-00000000000f", 1, "00000000-0000-4000-8000-00000000000e", 5, 0};

class SpoolShopTest : public testing::Test, protected ServedJobs {
 protected:
  SpoolShopTest() : ServedJobs("spoolshop", std::chrono::seconds(120)) {}
  void serve() { open(wide_machine(), "grbl:" + folder_.path + "/absent"); }
  /// The job of the shop is claimed, confirmed and brought in; its number here.
  std::uint64_t take(const std::string& id, const std::string& text = "G21 G90 G94\nG0 X1\nM2\n") {
    EXPECT_TRUE(*jobs_->shop_record().claim(job_of(id), kMark));
    EXPECT_TRUE(jobs_->shop_record().confirm(id, 1));
    bring(id, text);
    return *number(id);
  }
  void bring(const std::string& id, const std::string& text) {
    std::optional<bool> good;
    HandedFiles files;
    files.add(::open(folder_.write("shop.nc", text).c_str(), O_RDONLY | O_CLOEXEC));
    jobs_->take_from_shop(job_of(id), std::move(files),
                          [&](const Result<std::string>& done) { good = done.has_value(); });
    until([&] { return good.has_value(); });
    EXPECT_TRUE(*good);
  }
  std::optional<std::uint64_t> number(const std::string& id) {
    const nlohmann::json listed = ask(ApiOp::kList);
    for (const auto& one : listed["jobs"])
      if (one.value("shop", "") == id) return one.value("job", std::uint64_t{0});
    return std::nullopt;
  }
  LocalShop read() { return *jobs_->read_shop(); }
  std::string sql(const std::string& text) const {
    sqlite3* db = nullptr;
    sqlite3_open((folder_.path + "/spool/jobs.db").c_str(), &db);
    std::string value;
    const auto take_value = [](void* to, int, char** values, char**) {
      return *static_cast<std::string*>(to) = values[0] != nullptr ? values[0] : "", 0;
    };
    EXPECT_EQ(sqlite3_exec(db, text.c_str(), take_value, &value, nullptr), SQLITE_OK) << sqlite3_errmsg(db);
    sqlite3_close(db);
    return value;
  }
};

TEST_F(SpoolShopTest, AJobComesAsASubmissionAndWaitsForItsStart) {
  serve();
  const std::uint64_t job = take(kId);
  until([&] { return state(job) == "ready"; });
  for (int turn = 0; turn < 20; ++turn) jobs_->tick();
  EXPECT_EQ(state(job), "ready") << "started by itself";
  EXPECT_EQ(ask(ApiOp::kShow, job)["shop"], kId);
  EXPECT_EQ(ask(ApiOp::kShow, job)["name"], "seat rail");
  const LocalShop local = read();
  ASSERT_EQ(local.reports.size(), 1u);
  EXPECT_EQ(local.reports[0].state, "ready");
  EXPECT_EQ(local.reports[0].blocks, 3u);
  EXPECT_EQ(local.waiting, std::vector<std::string>{kId});
  EXPECT_FALSE(local.wants) << "one waits already";
  EXPECT_EQ(local.offer.profile, wide_machine().name);
}

TEST_F(SpoolShopTest, TheRecordOutlivesTheService) {
  serve();
  EXPECT_TRUE(is_uuid(read().machine));
  const std::string machine = read().machine;
  ASSERT_TRUE(*jobs_->shop_record().claim(job_of(kId), kMark));
  jobs_.reset();
  serve();
  LocalShop local = read();
  EXPECT_EQ(local.machine, machine);
  EXPECT_EQ(local.mark, kMark);
  ASSERT_EQ(local.claimed.size(), 1u);
  EXPECT_EQ(local.claimed[0], job_of(kId));
  ASSERT_TRUE(jobs_->shop_record().confirm(kId, 9));
  jobs_.reset();
  serve();
  local = read();
  EXPECT_TRUE(local.claimed.empty());
  ASSERT_EQ(local.accepted.size(), 1u);
  EXPECT_EQ(local.mark.serial, 9u);
  EXPECT_TRUE(local.reports.empty()) << "the database knows of the acceptance";
  // Its files were on their way when the service ended.
  sql("INSERT INTO jobs (name, program, state, note, total, executed, hash, user, created, shop) VALUES "
      "('cut off', 1, "
      "'failed', 'not received whole', 0, 0, '', 1, 2, '" +
      kId + "')");
  bring(kId, "G21 G90 G94\nG0 X1\nM2\n");
  const auto job = number(kId);
  ASSERT_TRUE(job);
  until([&] { return state(*job) == "ready"; });
  EXPECT_EQ(ask(ApiOp::kList)["jobs"].size(), 1u);
  bring(kId, "G21 G90 G94\nG0 X2\nM2\n");
  EXPECT_EQ(ask(ApiOp::kList)["jobs"].size(), 1u) << "it came twice";
}

TEST_F(SpoolShopTest, AJobThatWasHereIsKnownForEver) {
  serve();
  const std::uint64_t job = take(kId);
  until([&] { return state(job) == "ready"; });
  ASSERT_TRUE(good(ask(ApiOp::kRemove, job)));
  EXPECT_EQ(read().reports.at(0).state, "removed");
  EXPECT_FALSE(*jobs_->shop_record().claim(job_of(kId, 8), kMark)) << "offered again";
  EXPECT_EQ(read().reports.at(0).job.ticket.token, 8u) << "told under the new claim";
  bring(kId, "G21 G90 G94\nG0 X1\nM2\n");
  EXPECT_FALSE(number(kId));
  // One that was claimed and given up never was here.
  const std::string other = "00000000-0000-4000-8000-000000000002";
  ASSERT_TRUE(*jobs_->shop_record().claim(job_of(other), kMark));
  ASSERT_TRUE(jobs_->shop_record().drop(other));
  EXPECT_TRUE(*jobs_->shop_record().claim(job_of(other, 9), kMark));
}

TEST_F(SpoolShopTest, EachChangeIsToldUntilTheDatabaseHasIt) {
  serve();
  const std::uint64_t job = take(kId);
  until([&] { return state(job) == "ready"; });
  const ShopReport ready = read().reports.at(0);
  ASSERT_TRUE(jobs_->shop_record().told(kId, ready.version - 1, 3));
  EXPECT_EQ(read().reports.size(), 1u) << "what was told is of before";
  ASSERT_TRUE(jobs_->shop_record().told(kId, ready.version, 4));
  EXPECT_TRUE(read().reports.empty());
  EXPECT_FALSE(jobs_->shop_record().has_news());
  ASSERT_TRUE(jobs_->shop_record().told(kId, ready.version, 2));
  EXPECT_EQ(read().mark.serial, 4u) << "an answer that came late";
  ASSERT_TRUE(jobs_->shop_record().retell());
  ASSERT_EQ(read().reports.size(), 1u);
  EXPECT_EQ(read().reports[0].version, ready.version) << "nothing has changed by that";
}

TEST_F(SpoolShopTest, AJobThatIsAnothersNowDoesNotBegin) {
  serve();
  const std::uint64_t job = take(kId);
  until([&] { return state(job) == "ready"; });
  ASSERT_TRUE(jobs_->overrule(kId, "it is ready at another"));
  EXPECT_EQ(state(job), "failed");
  EXPECT_NE(field(job, "note").find("ready at another"), std::string::npos) << field(job, "note");
  EXPECT_FALSE(good(ask(ApiOp::kStart, job)));
  EXPECT_TRUE(read().reports.empty());
  EXPECT_TRUE(read().wants);
  // While it is checked: the end of that does not make it ready again.
  const std::string other = "00000000-0000-4000-8000-000000000003";
  std::string text = "G21 G90 G94\n";
  for (int i = 0; i < 50000; ++i) text += "G0 X" + std::to_string(i % 9) + "\n";
  const std::uint64_t checked = take(other, text + "M2\n");
  ASSERT_TRUE(jobs_->overrule(other, "gone"));
  for (int turn = 0; turn < 200; ++turn) {
    jobs_->tick();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(state(checked), "failed");
}

TEST_F(SpoolShopTest, JobsOfThisServiceAreNotTheShops) {
  serve();
  const std::uint64_t job = submit_text("G21 G90 G94\nG0 X1\nM2\n").at("job");
  until([&] { return state(job) == "ready"; });
  EXPECT_FALSE(ask(ApiOp::kShow, job).contains("shop"));
  EXPECT_TRUE(read().reports.empty());
  EXPECT_TRUE(read().wants);
  EXPECT_FALSE(ask(ApiOp::kList).contains("shop")) << "no queue is configured";
}

std::vector<std::string> words_of(const std::vector<ShopState>& states) {
  std::vector<std::string> words;
  for (const ShopState& one : states) words.push_back(one.state);
  return words;
}

TEST_F(SpoolShopTest, WhatTheMachineIsAtIsOnRecordOverAnOrderlyEndAndADeath) {
  using Words = std::vector<std::string>;
  const auto begin = [&] {
    serve();
    jobs_->on_shop_news([] {});
  };
  begin();
  jobs_->tick();
  jobs_->tick();
  EXPECT_EQ(words_of(read().states), Words{"idle"});
  EXPECT_EQ(parse_live(read().live).state, "idle");
  jobs_->leave();
  jobs_->leave_shop();
  EXPECT_EQ(words_of(read().states), (Words{"idle", "off"}));
  jobs_.reset();
  begin();
  jobs_->tick();
  jobs_.reset();  // as killed
  begin();
  jobs_->tick();
  const auto states = read().states;
  EXPECT_EQ(words_of(states), (Words{"idle", "off", "idle", "unknown", "idle"}));
  for (std::size_t i = 1; i < states.size(); ++i) EXPECT_GT(states[i].at, states[i - 1].at);
  ASSERT_TRUE(jobs_->shop_states().told(states[3].at));
  EXPECT_EQ(read().states, std::vector<ShopState>{states[4]});
}

TEST_F(SpoolShopTest, AJobThatWasCutOffIsAFaultUntilAPersonSettlesIt) {
  serve();
  const std::uint64_t job = submit_text("G21 G90 G94\nG0 X1\nM2\n").at("job");
  until([&] { return state(job) == "ready"; });
  jobs_.reset();
  sql("UPDATE jobs SET state = 'uncertain', note = 'the wire was cut'");
  serve();
  jobs_->on_shop_news([] {});
  jobs_->tick();
  const ShopLive live = parse_live(read().live);
  EXPECT_EQ(live.state, "fault");
  EXPECT_NE(live.alarm.find("the wire was cut"), std::string::npos) << live.alarm;
  ASSERT_TRUE(good(ask(ApiOp::kRemove, job)));
  EXPECT_EQ(parse_live(read().live).state, "idle");
  EXPECT_EQ(parse_live(read().live).alarm, "");
}

}  // namespace
}  // namespace tiltfeed
