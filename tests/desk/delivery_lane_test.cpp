// One receiver: order, tries, what is given up, what the log says; with a clock of our own.
#include "desk/webhooks/delivery_lane.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "desk/webhooks/retry_schedule.h"

namespace tiltfeed::desk {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr char kUrl[] = "https://hooks.example/in/path-of-a-stranger", kKey[] = "0123456789abcdef0123";

struct Shop {
  std::string folder = testing::TempDir() + "delivery_lane_" + std::to_string(::getpid());
  std::optional<DeliveryStore> store;
  std::optional<DeliveryLane> lane;
  std::vector<std::string> log;
  DeliveryLane::Time now;
  std::int64_t wall = 1'700'000'000;

  Shop() {
    std::filesystem::remove_all(folder);
    restart();
  }
  Shop(const Shop&) = delete;
  ~Shop() { std::filesystem::remove_all(folder); }
  void restart() {
    lane.reset();
    store.reset();
    store.emplace(*DeliveryStore::open(folder));
    config::Webhook hook{kUrl, "hooks.example", "/etc/secret", kKey};
    lane.emplace(hook, *store, [this](const std::string& text) { log.push_back(text); });
  }
  void put(const std::vector<std::string>& ids) {
    std::vector<Addressed> all;
    for (const std::string& id : ids) all.push_back({kUrl, {id, false, "{\"id\":\"" + id + "\"}"}});
    ASSERT_TRUE(store->keep("/s", {"ac5", RunMark{1, 1}, {}}, all, wall));
    lane->wake();
  }
  void pass(milliseconds time) {
    now += time;
    wall += std::chrono::duration_cast<seconds>(time).count();
  }
  /// The body that goes out now, and what the receiver says to it; empty: none is due.
  std::string send(int status, std::optional<std::int64_t> wish = {}, const std::string& said = "") {
    if (!lane->look(now, wall)) return "";
    const std::string body = lane->begin(wall).body;
    EXPECT_FALSE(lane->look(now, wall)) << "one at a time";
    lane->end({status, status == 0 ? "refused" : "", said, wish}, 1.0, now, wall);
    return body;
  }
  bool logged(const std::string& text) const {
    return std::any_of(log.begin(), log.end(),
                       [&](const std::string& line) { return line.find(text) != std::string::npos; });
  }
};

TEST(DeliveryLane, keeps_the_order_while_the_first_is_tried_again) {
  Shop shop;
  shop.put({"a", "b"});
  EXPECT_EQ(shop.send(500), "{\"id\":\"a\"}");
  EXPECT_EQ(shop.send(200), "") << "it waits";
  EXPECT_EQ(shop.lane->patience(shop.now, std::chrono::hours(1)), kFirstPause);
  shop.pass(kFirstPause - milliseconds(1));
  EXPECT_EQ(shop.send(200), "");
  shop.pass(milliseconds(1));
  EXPECT_EQ(shop.send(0), "{\"id\":\"a\"}");
  shop.pass(2 * kFirstPause);
  EXPECT_EQ(shop.send(200), "{\"id\":\"a\"}");
  EXPECT_TRUE(shop.logged("took a at try 3"));
  EXPECT_EQ(shop.send(204), "{\"id\":\"b\"}");
  EXPECT_EQ(shop.send(200), "");
  EXPECT_EQ(shop.lane->patience(shop.now, std::chrono::hours(1)), std::chrono::hours(1));
  EXPECT_EQ(shop.lane->counts().taken, 2u);
  EXPECT_EQ(shop.lane->counts().in_vain, 2u);
}

TEST(DeliveryLane, the_receivers_wish_and_the_tries_outlive_a_restart) {
  Shop shop;
  shop.put({"a"});
  EXPECT_NE(shop.send(429, 120), "");
  shop.restart();
  EXPECT_EQ(shop.send(200), "") << "not before the receiver wants it";
  shop.pass(seconds(119));
  EXPECT_EQ(shop.send(200), "");
  shop.pass(seconds(1));
  EXPECT_EQ(shop.send(200), "{\"id\":\"a\"}");
  EXPECT_TRUE(shop.logged("took a at try 2")) << shop.log.back();
  shop.restart();
  EXPECT_EQ(shop.send(200), "") << "taken once";
}

TEST(DeliveryLane, a_clock_that_was_set_back_delays_an_hour_at_most) {
  Shop shop;
  shop.put({"a"});
  EXPECT_NE(shop.send(500), "");
  shop.wall -= 365 * 24 * 3600;
  shop.restart();
  EXPECT_EQ(shop.send(200), "");
  shop.pass(kLongestWish);
  EXPECT_EQ(shop.send(200), "{\"id\":\"a\"}");
}

TEST(DeliveryLane, what_is_refused_is_not_sent_again_and_the_log_says_what_to_do) {
  const std::pair<int, const char*> cases[] = {{401, "compare the secrets"},
                                               {403, "compare the secrets"},
                                               {404, "look at the URL"},
                                               {400, "receiver's log"},
                                               {301, "state the URL that it"}};
  for (const auto& [status, remedy] : cases) {
    Shop shop;
    shop.put({"a", "b"});
    EXPECT_EQ(shop.send(status, {}, "no such hook"), "{\"id\":\"a\"}");
    EXPECT_TRUE(shop.logged("answers " + std::to_string(status) + " 'no such hook' to a")) << shop.log.back();
    EXPECT_TRUE(shop.logged(remedy)) << shop.log.back();
    EXPECT_EQ(shop.send(200), "{\"id\":\"b\"}") << "at once";
  }
}

TEST(DeliveryLane, gives_up_after_the_stated_time) {
  Shop shop;
  shop.put({"a", "b"});
  const std::int64_t begun = shop.wall;
  int tries = 0;
  while (!shop.logged("it is given up")) {
    ASSERT_LT(++tries, 10'000);
    EXPECT_EQ(shop.send(503), "{\"id\":\"a\"}");
    if (!shop.logged("it is given up")) shop.pass(shop.lane->patience(shop.now, std::chrono::hours(2)));
  }
  EXPECT_GE(shop.wall - begun, kGiveUpSeconds);
  EXPECT_LE(shop.wall - begun, kGiveUpSeconds + 600);
  EXPECT_EQ(shop.log.size(), 2u) << "the same failure is logged once, and the end";
  EXPECT_EQ(shop.lane->counts().given_up, 1u);
  EXPECT_EQ(shop.send(200), "{\"id\":\"b\"}") << "tried at least once";
}

TEST(DeliveryLane, the_log_has_neither_secret_nor_url) {
  Shop shop;
  shop.put({"a", "b", "c"});
  shop.send(500, {}, std::string("expected ") + kKey);
  shop.pass(std::chrono::hours(1));
  shop.send(404, {}, std::string("cut off ") + std::string(kKey).substr(0, 10));
  shop.send(0);
  EXPECT_EQ(shop.log.size(), 3u);
  for (const char* hidden : {"01234567", "stranger"}) EXPECT_FALSE(shop.logged(hidden));
}

TEST(DeliveryLane, each_try_is_signed_at_its_time) {
  Shop shop;
  shop.put({"a"});
  ASSERT_TRUE(shop.lane->look(shop.now, shop.wall));
  const auto signature = [&] {
    for (const std::string& header : shop.lane->begin(shop.wall).headers)
      if (header.starts_with("X-Tiltfeed-Signature: t=")) return header;
    return std::string();
  };
  const std::string first = signature();
  // hmac.new(b"0123456789abcdef0123", b'1700000000.{"id":"a"}', hashlib.sha256).hexdigest()
  EXPECT_EQ(first,
            "X-Tiltfeed-Signature: "
            "t=1700000000,v1=0c184260ac39f1dceb4828481096f99d6f902ee695765c8244d64d6f896489b6");
  shop.wall += 4;
  EXPECT_TRUE(signature().starts_with("X-Tiltfeed-Signature: t=1700000004,v1="));
}

}  // namespace
}  // namespace tiltfeed::desk
