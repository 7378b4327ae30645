// The shop's thread beside the job service: calls from both sides, a server that is not there or says
// nothing, and ends at any moment. Runs under the thread sanitizer, too.

#include "daemon/shop/shop_thread.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>

#include "daemon/service/shop_gate.h"
#include "tests/peers/served_jobs.h"
#include "tests/shapes/wide_machine.h"

namespace tiltfeed {
namespace {

class ShopThreadTest : public testing::Test, protected ServedJobs {
 protected:
  ShopThreadTest() : ServedJobs("shopthread", std::chrono::seconds(120)) {}
  void SetUp() override {
    open(wide_machine(), "grbl:" + folder_.path + "/absent");
    jobs_->on_shop_news([] {});
    gate_ = std::make_unique<ShopGate>(folder_.path, "wide");
    thread_ = std::make_unique<JobServiceThread>(*jobs_, [] {});
    gate_->open(*thread_);
  }
  void TearDown() override {
    gate_->close();
    thread_.reset();
  }
  /// What it says of the database, from the job service's own loop.
  ShopLedger ledger() {
    ShopLedger all = gate_->ledger();
    all.show = [this](const std::string& text) {
      const std::lock_guard lock(mutex_);
      shown_ = text;
    };
    all.log = [](bool, const std::string&) {};
    return all;
  }
  bool says(const std::string& words) {
    const std::lock_guard lock(mutex_);
    return shown_.find(words) != std::string::npos;
  }
  template <class Condition>
  static void wait_for(Condition condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(120);
    while (!condition() && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    ASSERT_TRUE(condition());
  }

  std::unique_ptr<ShopGate> gate_;
  std::unique_ptr<JobServiceThread> thread_;
  std::mutex mutex_;
  std::string shown_;
};

TEST_F(ShopThreadTest, ADatabaseThatIsNotThereIsToldAndTriedAgain) {
  ShopThread shop("postgresql:///none?host=" + folder_.path, ledger());
  for (int i = 0; i < 100; ++i) shop.wake();
  wait_for([&] { return says("not connected"); });
  shop.end();
}

TEST_F(ShopThreadTest, AServerThatSaysNothingKeepsNobodyFromTheEnd) {
  const int server = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof at;
  ASSERT_EQ(::bind(server, reinterpret_cast<sockaddr*>(&at), size), 0);
  ASSERT_EQ(::listen(server, 4), 0);
  ASSERT_EQ(::getsockname(server, reinterpret_cast<sockaddr*>(&at), &size), 0);
  std::atomic<bool> read{false};
  ShopLedger all = ledger();
  all.read = [&]() -> Result<LocalShop> {
    read = true;
    return fail(Code::kIo, "it has no connection");
  };
  {
    ShopThread shop("postgresql://shop@127.0.0.1:" + std::to_string(ntohs(at.sin_port)) + "/x", all);
    const int client = ::accept(server, nullptr, nullptr);
    EXPECT_GE(client, 0);
    shop.end();
    ::close(client);
  }
  EXPECT_FALSE(read) << "the spool is asked without a database";
  ::close(server);
}

TEST_F(ShopThreadTest, ManyCallsFromOtherThreadsAndAGateThatCloses) {
  constexpr int kCallers = 3, kCalls = 150;
  std::atomic<int> good{0}, cancelled{0}, other{0};
  std::vector<std::thread> callers;
  for (int caller = 0; caller < kCallers; ++caller)
    callers.emplace_back([this, caller, &good, &cancelled, &other] {
      const ShopLedger ledger = gate_->ledger();
      const auto count = [&](const auto& answer) {
        ++(answer ? good : answer.error().code == Code::kCancelled ? cancelled : other);
      };
      for (int call = 0; call < kCalls; ++call) {
        const auto id = static_cast<unsigned>(caller * kCalls + call);
        char uuid[40];
        std::snprintf(uuid, sizeof uuid, "00000000-0000-4000-8000-%012u", id);
        const ShopJob job{{uuid, 1, id + 1}, id, "part", true, {{std::string(64, 'a'), 20}}};
        count(ledger.read());
        count(ledger.claim(job, {"00000000-0000-4000-8000-00000000000f", 1, "", id + 1, 0}));
        count(ledger.drop(uuid));
        count(ledger.told_states(id));
        ledger.show("connected");
      }
    });
  wait_for([&] { return good > kCallers * kCalls; });
  gate_->close();
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(good + cancelled, kCallers * kCalls * 4);
  EXPECT_EQ(other, 0);
  EXPECT_GT(cancelled, 0);
}

}  // namespace
}  // namespace tiltfeed
