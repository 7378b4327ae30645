// The address of a shop's queue: what is taken, and that no message repeats one that has a password.

#include "config/queue_key.h"

#include <gtest/gtest.h>

#include "config/desk_access.h"
#include "config/service_config.h"
#include "config/yaml_tree.h"

namespace tiltfeed {
using namespace config;
namespace {

constexpr const char* kSecret = "geheim";

TEST(QueueKey, AddressesThatAreTaken) {
  for (const char* good :
       {"postgresql://shop@db.example/shop", "postgres://shop@db:5432/shop?sslmode=verify-full",
        "postgresql:///shop?host=/run/postgresql", "postgresql://shop@a,b/shop?passfile=/etc/tiltfeed/pgpass",
        "postgresql://db/shop?user=x@y", "postgresql://a%40b@db/shop?options=-c%20x%3D1&sslmode=require",
        "postgresql://db:5432/shop?user=x@y", "postgresql://a:1,b:2/shop?user=x@y", "postgresql://db/sh@op",
        "postgresql://[fe80::1]:5432/shop?user=x@y", "postgresql://[fe80::1]/shop?user=x@y",
        "postgresql://shop@[::1]:5432/shop"})
    EXPECT_TRUE(check_queue_url(good)) << good;
}

TEST(QueueKey, APasswordIsRefusedAndNeverRepeated) {
  for (const std::string bad :
       {"postgresql://shop:geheim@db/shop", "postgresql://:geheim@db/shop",
        "postgresql://shop:gehe?imgeheim@db/shop", "postgresql://shop:a/geheim@db/shop",
        "postgresql://shop:12/geheim@db/shop", "postgresql://shop:a/b?geheim@db/shop",
        "postgresql://shop:a/b@c/geheim@db/shop", "postgresql://shop:a,b:1/geheim@db/shop",
        "postgresql://shop@db/shop?password=geheim",
        "postgresql://shop@db/shop?sslmode=require&sslpassword=geheim",
        "postgresql://shop@db/shop?pass%77ord=geheim",
        "postgresql://shop@db/shop?sslmode=require&%70assword=geheim",
        "postgresql://shop:@db/shop?password=geheim&password=geheim", "mysql://shop:geheim@db/shop",
        "postgresql://shop:geheim@db/sh op"}) {
    const auto checked = check_queue_url(bad);
    ASSERT_FALSE(checked) << bad;
    EXPECT_EQ(checked.error().code, Code::kInput);
    EXPECT_EQ(checked.error().message.find(kSecret), std::string::npos) << checked.error().message;
    if (bad.starts_with("postgres")) {
      EXPECT_EQ(shown_queue(bad).find(kSecret), std::string::npos) << shown_queue(bad);
    }
  }
  EXPECT_EQ(shown_queue("postgresql://shop:geheim@db/shop?x=1"), "postgresql://shop:***@db/shop?x=1");
  EXPECT_EQ(shown_queue("postgresql://shop@db/shop"), "postgresql://shop@db/shop");
}

TEST(QueueKey, TheFileOfTheDesk) {
  const std::string begin = "listen: 127.0.0.1:0\n";
  EXPECT_EQ(parse_desk_access(begin, "d.yaml")->queue, "");
  const auto named = parse_desk_access(begin + "queue: postgresql://shop@db/shop\n", "d.yaml");
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_EQ(named->queue, "postgresql://shop@db/shop");
  const auto refused = parse_desk_access(begin + "queue: postgresql://shop:geheim@db/shop\n", "d.yaml");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message.rfind("d.yaml:2:8: queue:", 0), 0u) << refused.error().message;
  EXPECT_EQ(refused.error().message.find(kSecret), std::string::npos);
  const std::string path = std::string(SOURCE_DIR) + "/config/desk.yaml";
  EXPECT_NE(parse_desk_access(*read_config_text(path), path)->queue, "") << "the example has it";
}

TEST(QueueKey, TheServicesFile) {
  const std::string machine = std::string("machine: ") + SOURCE_DIR +
                              "/config/machines/generic-ac.yaml\nlink: modbus-tcp:h:1\nspool: s\nsocket: a\n";
  const auto none = parse_service_config(machine, "/etc/tiltfeed/m.yaml");
  ASSERT_TRUE(none) << none.error().message;
  EXPECT_EQ(none->queue.url, "");
  const auto good =
      parse_service_config(machine + "queue: postgresql://shop@db/shop\nqueue_ahead: 3\n", "/m.yaml");
  ASSERT_TRUE(good) << good.error().message;
  EXPECT_EQ(good->queue.url, "postgresql://shop@db/shop");
  EXPECT_EQ(good->queue.ahead, 3);
  EXPECT_TRUE(good->queue.plans);
  const auto off =
      parse_service_config(machine + "queue: postgresql://d/s\nplan_for_others: false\n", "/m.yaml");
  ASSERT_TRUE(off) << off.error().message;
  EXPECT_FALSE(off->queue.plans);
  EXPECT_FALSE(parse_service_config(machine + "plan_for_others: perhaps\n", "/m.yaml"));
  const auto secret = parse_service_config(machine + "queue: postgresql://shop:geheim@db/shop\n", "/m.yaml");
  ASSERT_FALSE(secret);
  EXPECT_NE(secret.error().message.find("/m.yaml:5:8"), std::string::npos) << secret.error().message;
  EXPECT_NE(secret.error().message.find("passfile"), std::string::npos) << secret.error().message;
  EXPECT_EQ(secret.error().message.find(kSecret), std::string::npos) << secret.error().message;
  for (const char* ahead : {"0", "101", "many"})
    EXPECT_FALSE(
        parse_service_config(machine + "queue: postgresql://d/s\nqueue_ahead: " + ahead + "\n", "/m.yaml"))
        << ahead;
}

}  // namespace
}  // namespace tiltfeed
