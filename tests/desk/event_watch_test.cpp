// The watch of a service that is made up here: what it asks, what it makes of the answers, a service that is
// gone.
#include "desk/webhooks/event_watch.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

/// A service, its watch and a clock.
struct Bench {
  std::string path = testing::TempDir() + "event_watch_" + std::to_string(::getpid());
  int fd = -1;
  json runs = json::array();
  std::vector<std::string> asked, log;
  std::vector<HookMessage> told;
  KnownService kept;
  bool keeps = true;
  std::optional<EventWatch> watch;
  EventWatch::Time now;
  std::int64_t wall = 5000;

  Bench() {
    listen();
    start();
  }
  Bench(const Bench&) = delete;
  ~Bench() { end_service(); }
  void listen() {
    fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    ::unlink(path.c_str());
    ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::listen(fd, 8);
  }
  void end_service() {
    if (fd >= 0) ::close(fd);
    fd = -1;
    ::unlink(path.c_str());
  }
  /// As a desk that starts.
  void start() {
    watch.emplace(path, kept,
                  EventCalls{[this](const KnownService& known, const std::vector<HookMessage>& messages) {
                               if (!keeps) return false;
                               kept = known;
                               told.insert(told.end(), messages.begin(), messages.end());
                               return true;
                             },
                             [this](const std::string& text) { log.push_back(text); }});
  }
  void add(std::uint64_t run, const std::string& outcome) {
    runs.push_back({{"run", run}, {"job", 1}, {"name", "p.nc"}, {"began", 1000 + run}, {"outcome", outcome}});
  }
  std::string answer_to(const std::string& line) {
    asked.push_back(line);
    const json request = json::parse(line);
    if (request["op"] == "list") return R"({"v":1,"ok":true,"machine":"ac5","jobs":[]})";
    json found = json::array();
    EXPECT_NE(request.value("from", json()), 0) << "the service refuses it";
    for (const json& run : runs)
      if (run["run"] > request.value("from", 0)) found.push_back(run);
    return json{{"v", 1}, {"ok", true}, {"runs", found}}.dump();
  }
  /// Every request that is due, with its answer.
  void turn(bool answers = true) {
    do {
      watch->look(now, wall);
      if (watch->descriptors().empty() || !answers) return;
      const int client = ::accept(fd, nullptr, nullptr);
      char bytes[4096];
      const ssize_t got = ::read(client, bytes, sizeof bytes);
      const std::string reply = answer_to(std::string(bytes, got > 0 ? got : 0)) + "\n";
      EXPECT_EQ(::write(client, reply.data(), reply.size()), static_cast<ssize_t>(reply.size()));
      ::close(client);
      const int own = watch->descriptors().front();
      pollfd ready{own, POLLIN, 0};
      ::poll(&ready, 1, -1);
      watch->hear(own);
    } while (watch->patience(now) == std::chrono::milliseconds(0));
  }
  void pass(std::chrono::milliseconds time) {
    now += time;
    wall += std::chrono::duration_cast<std::chrono::seconds>(time).count();
  }
  std::vector<std::uint64_t> numbers() const {
    std::vector<std::uint64_t> all;
    for (const HookMessage& message : told)
      all.push_back(json::parse(message.body).value("run", json(0)).is_null()
                        ? 0
                        : json::parse(message.body)["run"].get<std::uint64_t>());
    return all;
  }
};

using Numbers = std::vector<std::uint64_t>;

TEST(EventWatch, tells_what_ends_after_the_first_contact_once) {
  Bench bench;
  bench.add(1, "done");
  bench.add(2, "running");
  bench.turn();
  EXPECT_EQ(bench.numbers(), Numbers{});
  EXPECT_EQ(bench.kept.machine, "ac5");
  bench.runs[1]["outcome"] = "uncertain";
  bench.add(3, "stopped");
  bench.add(4, "done");
  bench.pass(EventWatch::kPeriod);
  bench.turn();
  EXPECT_EQ(bench.numbers(), (Numbers{2, 4}));
  EXPECT_TRUE(bench.told[0].fault);
  EXPECT_FALSE(bench.told[1].fault);
  bench.start();
  bench.turn();
  EXPECT_EQ(bench.numbers(), (Numbers{2, 4})) << "a restart tells nothing again";
  bench.watch.reset();
  bench.add(5, "failed");
  bench.start();
  bench.turn();
  EXPECT_EQ(bench.numbers(), (Numbers{2, 4, 5})) << "what ended while the desk was down is told";
}

TEST(EventWatch, what_cannot_be_kept_comes_again) {
  Bench bench;
  bench.turn();
  bench.add(1, "done");
  bench.keeps = false;
  for (int i = 0; i < 3; ++i) bench.pass(EventWatch::kPeriod), bench.turn();
  EXPECT_EQ(bench.numbers(), Numbers{});
  bench.keeps = true;
  for (int i = 0; i < 3; ++i) bench.pass(EventWatch::kPeriod), bench.turn();
  EXPECT_EQ(bench.numbers(), Numbers{1});
}

TEST(EventWatch, a_service_that_is_gone_is_a_fault_told_once) {
  Bench bench;
  bench.add(1, "running");
  bench.turn();
  bench.end_service();
  bench.pass(EventWatch::kPeriod);
  bench.turn();
  bench.pass(EventWatch::kLostAfter - std::chrono::milliseconds(1));
  bench.turn();
  EXPECT_EQ(bench.numbers(), Numbers{}) << "not yet: it may be started again";
  bench.pass(std::chrono::milliseconds(1));
  bench.turn();
  ASSERT_EQ(bench.told.size(), 1u);
  EXPECT_EQ(json::parse(bench.told[0].body)["outcome"], "not answered");
  EXPECT_EQ(json::parse(bench.told[0].body)["run"], 1) << "what was on the machine";
  bench.start();  // the desk, too, starts again
  for (int i = 0; i < 30; ++i) bench.pass(EventWatch::kPeriod), bench.turn();
  EXPECT_EQ(bench.told.size(), 1u);
  bench.listen();
  bench.runs[0]["outcome"] = "interrupted";
  bench.pass(EventWatch::kPeriod);
  bench.turn();
  EXPECT_EQ(bench.numbers(), (Numbers{1, 1})) << "and how its run ended";
  bench.end_service();
  for (int i = 0; i < 30; ++i) bench.pass(EventWatch::kPeriod), bench.turn();
  EXPECT_EQ(bench.told.size(), 3u) << "another loss is another fault";
  EXPECT_NE(bench.told[0].id, bench.told[2].id);
}

TEST(EventWatch, a_service_that_says_nothing_is_gone_too) {
  Bench bench;
  bench.turn();
  bench.pass(EventWatch::kPeriod);
  bench.turn(false);
  bench.pass(EventWatch::kSilence - std::chrono::milliseconds(1));
  bench.turn(false);
  bench.pass(EventWatch::kLostAfter);
  bench.turn(false);
  EXPECT_EQ(bench.told.size(), 0u) << "it is silent since now";
  bench.pass(EventWatch::kLostAfter);
  bench.turn(false);
  ASSERT_EQ(bench.told.size(), 1u);
  EXPECT_NE(bench.told[0].body.find("no answer within 3 s"), std::string::npos);
  EXPECT_GT(bench.watch->patience(bench.now), std::chrono::milliseconds(0)) << "it does not spin";
}

TEST(EventWatch, a_service_that_was_never_seen_is_no_fault) {
  Bench bench;
  bench.end_service();
  for (int i = 0; i < 30; ++i) bench.pass(EventWatch::kPeriod), bench.turn();
  EXPECT_EQ(bench.told.size(), 0u);
}

}  // namespace
}  // namespace tiltfeed::desk
