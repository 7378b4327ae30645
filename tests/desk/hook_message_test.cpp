// What a receiver is told of a run: every outcome of the service's history, and an id that is always the
// same.
#include "desk/webhooks/hook_message.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

namespace tiltfeed::desk {
namespace {

using nlohmann::json;

ToldRun seventeen(const std::string& outcome) {
  ToldRun run;
  run.run = 17, run.job = 4, run.blocks = 900, run.executed = 512;
  run.began = 1764300000;
  run.ended = 1764315878;
  run.name = "seat rail.nc", run.sha256 = std::string(64, 'a');
  run.outcome = outcome, run.note = "ALARM:1";
  return run;
}

TEST(HookMessage, a_run_as_json) {
  const auto told = message_of(seventeen("done"), "ac5", 5);
  ASSERT_TRUE(told);
  EXPECT_FALSE(told->fault);
  // hashlib.sha256(b"ac5\nrun 17 done\n1764300000").hexdigest()[:32]; date -u -d @1764315878
  EXPECT_EQ(json::parse(told->body), (json{{"id", "67fd28706a5d5f6dfa1b1658e52e8249"},
                                           {"event", "done"},
                                           {"time", "2025-11-28T07:44:38Z"},
                                           {"machine", "ac5"},
                                           {"run", 17},
                                           {"job", 4},
                                           {"program", "seat rail.nc"},
                                           {"sha256", std::string(64, 'a')},
                                           {"blocks_done", 512},
                                           {"blocks", 900},
                                           {"outcome", "done"},
                                           {"reason", "ALARM:1"}}));
  EXPECT_EQ(told->id, json::parse(told->body)["id"]);
}

TEST(HookMessage, outcomes_are_done_fault_or_nothing) {
  for (const char* quiet : {"running", "stopped", "tool change"})
    EXPECT_FALSE(message_of(seventeen(quiet), "ac5", 5)) << quiet;
  for (const char* fault : {"uncertain", "interrupted", "failed", "unknown", "nothing sent"}) {
    const auto told = message_of(seventeen(fault), "ac5", 5);
    ASSERT_TRUE(told && told->fault) << fault;
    EXPECT_EQ(json::parse(told->body)["event"], "fault");
    EXPECT_EQ(json::parse(told->body)["outcome"], fault);
  }
}

TEST(HookMessage, the_id_is_of_the_event_and_of_no_other) {
  const ToldRun run = seventeen("done");
  const std::string id = message_of(run, "ac5", 5)->id;
  ToldRun again = run;
  again.ended.reset();
  EXPECT_EQ(message_of(again, "ac5", 99)->id, id) << "whenever it is found";
  EXPECT_EQ(json::parse(message_of(again, "ac5", 0)->body)["time"], "1970-01-01T00:00:00Z")
      << "when it was seen";
  std::vector<std::string> others{id, message_of(run, "ac6", 5)->id,
                                  message_of(seventeen("failed"), "ac5", 5)->id};
  again.run = 18;
  others.push_back(message_of(again, "ac5", 5)->id);
  again = run, again.began += 1;
  others.push_back(message_of(again, "ac5", 5)->id);
  others.push_back(lost_message("ac5", 1764300000, "x", {}).id);
  EXPECT_EQ(others.back(), "51ab816e5fc90cefd3b62afa64ebd1f3");  // hashlib: b"ac5\nlost\n1764300000"
  EXPECT_EQ(std::set<std::string>(others.begin(), others.end()).size(), others.size());
}

TEST(HookMessage, a_machine_that_is_not_answered) {
  const json with =
      json::parse(lost_message("ac5", 1764300000, "no answer within 3 s", seventeen("running")).body);
  EXPECT_EQ(with["time"], "2025-11-28T03:20:00Z");
  EXPECT_EQ(with["event"], "fault");
  EXPECT_EQ(with["run"], 17);
  EXPECT_EQ(with["reason"], "the machine's service does not answer: no answer within 3 s");
  const json without = json::parse(lost_message("ac5", 1764300000, "x", {}).body);
  for (const char* key : {"run", "job", "program", "sha256", "blocks_done", "blocks"})
    EXPECT_TRUE(without[key].is_null()) << key;
}

TEST(HookMessage, a_history_is_read_and_what_is_none_refused) {
  const auto page = read_history(
      R"({"v":1,"ok":true,"runs":[{"run":3,"job":2,"name":"a","sha256":"","began":7,"ended":null,"blocks":9,)"
      R"("executed":1,"outcome":"running","note":""},{"run":"x"},5,{"run":4,"name":7,"ended":8}],"more":true})");
  ASSERT_TRUE(page);
  ASSERT_EQ(page->runs.size(), 2u);
  EXPECT_TRUE(page->more);
  EXPECT_TRUE(page->runs[0].goes_on());
  EXPECT_FALSE(page->runs[0].ended);
  EXPECT_EQ(page->runs[1].ended, 8);
  for (const char* wrong : {"", "[]", "{}", R"({"runs":5})", "null"})
    EXPECT_FALSE(read_history(wrong)) << wrong;
}

TEST(HookMessage, hostile_text_is_cut_and_escaped) {
  ToldRun run = seventeen("failed");
  run.note = "\xff\xfe\n\"\x01";
  const std::string body = message_of(run, "ac5", 5)->body;
  EXPECT_TRUE(json::accept(body));
  EXPECT_TRUE(std::all_of(body.begin(), body.end(), [](char c) { return c >= ' ' && c < 0x7F; }));
  const auto page = read_history(R"({"runs":[{"run":1,"note":")" + std::string(100'000, 'x') + R"("}]})");
  EXPECT_EQ(page->runs[0].note.size(), 1000u);
}

}  // namespace
}  // namespace tiltfeed::desk
