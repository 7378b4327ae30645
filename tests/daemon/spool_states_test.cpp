// What a spool keeps of its machine's states, held against a plain list.

#include "daemon/service/spool_states.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <random>

#include "daemon/service/spool.h"
#include "daemon/shop/shop_live.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace daemon;
namespace {

class States : public testing::Test {
 protected:
  void SetUp() override { open(); }
  void open() {
    spool_.reset();
    auto spool = Spool::open(folder_.path + "/spool");
    ASSERT_TRUE(spool) << spool.error().message;
    spool_ = std::make_unique<Spool>(std::move(*spool));
  }
  std::vector<ShopState> all() {
    EXPECT_TRUE(spool_->shop_states().retell());
    std::vector<ShopState> found;
    for (auto some = *spool_->shop_states().untold(); !some.empty(); some = *spool_->shop_states().untold()) {
      EXPECT_LE(some.size(), SpoolStates::kBatch);
      found.insert(found.end(), some.begin(), some.end());
      EXPECT_TRUE(spool_->shop_states().told(some.back().at));
    }
    return found;
  }
  const Folder folder_{"states"};
  std::unique_ptr<Spool> spool_;
};

/// Properties 1 to 3 over random lives: deaths, orderly ends, clocks that are set back.
TEST_F(States, TheRecordIsWhatHappenedInItsOrder) {
  std::mt19937 random(7);
  const char* const words[] = {kShopIdle, kShopRunning, kShopHeld, kShopFault};
  std::vector<ShopState> model;
  std::uint64_t now = 1'700'000'000'000, alive = 0;
  const auto add = [&](std::uint64_t at, const std::string& word) {
    model.push_back({model.empty() ? at : std::max(at, model.back().at + 1), word});
  };
  for (int step = 0; step < 1500; ++step) {
    now += random() % 5000;
    if (random() % 50 == 0) now -= 60000;
    SpoolStates states = spool_->shop_states();
    const unsigned what = random() % 20;
    if (what < 14) {
      const char* const word = words[random() % 4];
      ASSERT_TRUE(states.note(now, word));
      if (model.empty() || model.back().state != word) add(now, word);
    } else if (what < 18) {
      ASSERT_TRUE(states.live(now));
      alive = now;
    } else {
      const bool orderly = random() % 2 == 0;
      if (orderly) {
        ASSERT_TRUE(states.note(now, kShopOff));
        if (model.empty() || model.back().state != kShopOff) add(now, kShopOff);
      }
      open();
      now += random() % 100000;
      ASSERT_TRUE(spool_->shop_states().begin(now));
      if (!model.empty() && model.back().state != kShopOff && model.back().state != kShopUnknown)
        add(std::min(alive, now), kShopUnknown);
      alive = now;
    }
  }
  ASSERT_GT(model.size(), 800u);
  EXPECT_EQ(all(), model);
}

TEST_F(States, WhatIsToldStaysForEightDaysAndAllOfItIsBounded) {
  constexpr std::uint64_t kDay = 86'400'000;
  SpoolStates states = spool_->shop_states();
  for (std::uint64_t day = 1; day <= 20; ++day) {
    ASSERT_TRUE(states.note(day * kDay, day % 2 == 0 ? kShopIdle : kShopRunning));
    ASSERT_TRUE(states.told(day * kDay));
  }
  auto kept = all();
  ASSERT_FALSE(kept.empty());
  EXPECT_EQ(kept.front().at, 12 * kDay);
  EXPECT_EQ(kept.back().at, 20 * kDay);
  // What nobody has fetched stays, but the oldest of very many.
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open((folder_.path + "/spool/jobs.db").c_str(), &db), SQLITE_OK);
  ASSERT_EQ(
      sqlite3_exec(db,
                   "DELETE FROM shop_states; WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n "
                   "WHERE i < 25000) INSERT INTO shop_states (at, state) SELECT i, 'idle' FROM n",
                   nullptr, nullptr, nullptr),
      SQLITE_OK);
  sqlite3_close(db);
  ASSERT_TRUE(states.note(30000, kShopRunning));
  kept = all();
  EXPECT_EQ(kept.size(), SpoolStates::kMost);
  EXPECT_EQ(kept.back().at, 30000u);
}

}  // namespace
}  // namespace tiltfeed
