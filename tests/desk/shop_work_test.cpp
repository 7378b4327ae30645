// The shop on the desk over a `tiltfeed` that is a shell script: what it says is told, its end is no end, and
// orders are answered one by one.

#include "desk/api/shop_work.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>

#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace desk;
using nlohmann::json;
namespace {

/// `watch` does what the file `script` says.
constexpr const char* kProgram = R"(#!/bin/sh
here=$(dirname "$0")
if [ "$2" = watch ]; then
  echo "$*" >"$here/watched"
  into=$6
  . "$here/script"
  exit
fi
echo "$*" >>"$here/asked"
if [ "$6" = 7 ]; then echo '{"ok":true,"job":7,"text":"job 7 is open again"}'; exit 0; fi
if [ "$2" = raise ]; then echo 'not halted' >&2; echo '{"ok":true,"epoch":4}'; exit 0; fi
echo 'tiltfeed: there is no job' >&2
exit 2
)";

class ShopWorkTest : public testing::Test {
 protected:
  void begin(const std::string& script) {
    folder_.write("script", script);
    const std::string program = folder_.write("tiltfeed", kProgram);
    ::chmod(program.c_str(), 0755);
    work_ = std::make_unique<ShopWork>(
        ShopOptions{"postgresql://db/shop", program, folder_.path},
        [this](const std::string& event, const std::string& data) {
          EXPECT_EQ(event, "shop");
          told_.push_back(json::parse(data));
        },
        [this](std::uint64_t ticket, const Reply& reply) { replies_[ticket] = reply; });
    work_->look(now_);
  }
  template <class Condition>
  void until(Condition condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
    while (!condition()) {
      ASSERT_LT(std::chrono::steady_clock::now(), end);
      std::vector<pollfd> polled;
      for (const int fd : work_->descriptors()) polled.push_back({fd, POLLIN, 0});
      ::poll(polled.data(), polled.size(), 20);
      for (const pollfd& one : polled)
        if (one.revents != 0) {
          EXPECT_TRUE(work_->hear(one.fd, now_));
        }
    }
  }
  bool is(const std::string& state) const { return !told_.empty() && told_.back()["state"] == state; }
  json view() const { return json::parse(work_->view(now_).body); }
  std::string asked() const { return file_text(folder_.path + "/asked"); }

  const Folder folder_{"shopwork"};
  ShopWork::Time now_ = std::chrono::steady_clock::now();
  std::vector<json> told_;
  std::map<std::uint64_t, Reply> replies_;
  std::unique_ptr<ShopWork> work_;
};

TEST_F(ShopWorkTest, WhatIsSeenIsToldAndWhatIsLostStaysWithItsAge) {
  begin(
      "echo '{\"epoch\":2}' >$into\n"
      "echo '{\"version\":1,\"state\":\"up\",\"error\":\"\",\"now\":1000}'\n"
      "echo '{\"version\":1,\"state\":\"up\",\"error\":\"\",\"now\":1003}'\n"
      "echo 'no JSON at all'\n"
      "echo '{\"version\":1,\"state\":\"lost\",\"error\":\"no route\",\"now\":1003}'\n"
      "exec sleep 1000\n");
  EXPECT_EQ(json::parse(work_->describe())["state"], "asked");
  EXPECT_TRUE(view()["shop"].is_null());
  until([&] { return is("lost"); });
  ASSERT_EQ(told_.size(), 2u) << "the same once more is no news";
  EXPECT_EQ(told_[0]["state"], "up");
  EXPECT_EQ(told_[1]["error"], "no route");
  now_ += std::chrono::seconds(40);
  const json seen = view();
  EXPECT_EQ(seen["shop"]["epoch"], 2);
  EXPECT_EQ(seen["now"], 1003);
  EXPECT_EQ(seen["age"], 40.0);
  EXPECT_EQ(file_text(folder_.path + "/watched"),
            "shop watch --shop postgresql://db/shop --into " + folder_.path + "/shop.json\n");
}

TEST_F(ShopWorkTest, AProcessThatEndsIsStartedAgainAndASilentOneIsLost) {
  begin("echo 'tiltfeed: the address is wrong' >&2\nexit 2\n");
  until([&] { return is("lost"); });
  EXPECT_EQ(told_.back()["error"], "the address is wrong");
  work_->look(now_);
  EXPECT_TRUE(work_->descriptors().empty()) << "not at once";
  EXPECT_GT(work_->patience_ms(now_), 0);
  folder_.write(
      "script",
      "echo '{\"epoch\":1}' >$into\necho '{\"version\":1,\"state\":\"up\",\"error\":\"\",\"now\":5}'\n"
      "exec sleep 1000\n");
  now_ += ShopWork::kAgain;
  work_->look(now_);
  until([&] { return is("up"); });
  now_ += ShopWork::kSilent;
  work_->look(now_);
  EXPECT_TRUE(is("up"));
  now_ += std::chrono::seconds(1);
  work_->look(now_);
  EXPECT_TRUE(is("lost"));
}

TEST_F(ShopWorkTest, OrdersAreAnsweredInTheirOrder) {
  begin("exec sleep 1000\n");
  EXPECT_TRUE(work_->order(1, "release", 7).later);
  EXPECT_TRUE(work_->order(2, "withdraw", 8).later);
  EXPECT_TRUE(work_->order(3, "raise", 0).later);
  until([&] { return replies_.size() == 3; });
  EXPECT_EQ(json::parse(replies_[1].body)["text"], "job 7 is open again");
  EXPECT_EQ(replies_[2].status, 409);
  EXPECT_EQ(json::parse(replies_[2].body)["error"], "there is no job");
  EXPECT_EQ(json::parse(replies_[3].body)["text"], "the queue goes on, in epoch 4");
  EXPECT_EQ(asked(),
            "shop release --json --shop postgresql://db/shop 7\nshop withdraw --json --shop "
            "postgresql://db/shop 8\nshop raise --json --shop postgresql://db/shop --yes\n");
  for (std::uint64_t ticket = 10; ticket < 40; ++ticket)
    if (const Reply reply = work_->order(ticket, "release", 7); !reply.later) {
      EXPECT_EQ(reply.status, 503);
      return;
    }
  FAIL() << "orders without end are taken";
}

TEST_F(ShopWorkTest, BeforeTheEpochIsRaisedItIsSaidWhoIsMissing) {
  begin(
      "echo "
      "'{\"halted\":\"behind\",\"machines\":[{\"name\":\"a\",\"back\":true},{\"name\":\"b\",\"back\":false}]}"
      "' "
      ">$into\n"
      "echo '{\"version\":1,\"state\":\"up\",\"error\":\"\",\"now\":5}'\nexec sleep 1000\n");
  until([&] { return is("up"); });
  EXPECT_NE(work_->raise_text().find("Halted: behind."), std::string::npos);
  EXPECT_NE(work_->raise_text().find("Not back yet: b."), std::string::npos) << work_->raise_text();
}

TEST_F(ShopWorkTest, ADeskWithoutAShopRefuses) {
  ShopWork none({"", "tiltfeed", folder_.path}, {}, {});
  none.look(now_);
  EXPECT_EQ(none.describe(), "null");
  EXPECT_EQ(none.view(now_).status, 409);
  EXPECT_EQ(none.order(1, "release", 1).status, 409);
  EXPECT_EQ(none.patience_ms(now_), -1);
  EXPECT_TRUE(none.descriptors().empty());
}

}  // namespace
}  // namespace tiltfeed
