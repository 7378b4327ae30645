// The text for Prometheus, read back as its format says. Prometheus itself reads it in
// system/prometheus_test.py.

#include "daemon/metrics/metrics.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

namespace tiltfeed {
using namespace daemon;
namespace {

const std::vector<std::string> kAnswers = {
    R"({"ok":true,"machine":"a \"b\"","link":"grbl:/dev/x","more":true,"counts":{"runs":{"done":3,"uncertain":1},
        "plans_asked":{"open":2,"taken":1,"proving":0},"plans_asked_ended":{"refused":4},"plans_for_others":1,
        "plans_for_others_ended":{"done":5,"given back":6}},"jobs":[{"job":1,"name":"n","state":"done"},
        {"job":2,"state":"running","blocks":200,"sent":90,"acknowledged":80,"executed":75,"resends":2,"starved_seconds":1.5,"phase":"hold","feed_mm_per_min":1500,"spindle_rpm":9000,"slowest_hold_seconds":0.3,
         "seconds":12.5,"remaining_seconds":30.5,"override":{"feed":110,"spindle":100}}]})",
    R"({"ok":true,"machine":"a","link":"l","jobs":[{"job":3,"state":"queued","queue":1,"queue_moves":true},
        {"job":4,"state":"uncertain"},{"job":5,"state":"uncertain"}]})"};

/// Samples by name and labels. Fails on a line, a type or a name that the format or its conventions do not
/// have.
std::map<std::string, double> read(const std::string& text) {
  std::map<std::string, double> samples;
  std::set<std::string> families;
  std::string family;
  const std::regex help("# HELP (tiltfeed_[a-z_]+) [^ ].*\\."),
      type("# TYPE (tiltfeed_[a-z_]+) (gauge|counter)"),
      sample(
          "(tiltfeed_[a-z_]+)(\\{[a-z]+=\"(\\\\.|[^\"\\\\])*\"(,[a-z]+=\"(\\\\.|[^\"\\\\])*\")*\\})? "
          "([0-9.e+]+)");
  std::istringstream in(text);
  EXPECT_TRUE(text.ends_with("\n"));
  for (std::string line; std::getline(in, line);) {
    std::smatch found;
    if (std::regex_match(line, found, help)) {
      family = found[1];
      EXPECT_TRUE(families.insert(family).second) << family << " comes twice";
      EXPECT_FALSE(std::regex_search(family, std::regex("_(ms|milliseconds|percent|mm|minutes|rpm)$")))
          << family;
    } else if (std::regex_match(line, found, type)) {
      EXPECT_EQ(found[1], family);
      EXPECT_EQ(found[2] == "counter", family.ends_with("_total")) << line;
    } else {
      EXPECT_TRUE(std::regex_match(line, found, sample)) << line;
      EXPECT_EQ(found[1], family) << "a sample outside its family";
      const std::string name = found[1].str() + found[2].str();
      EXPECT_TRUE(samples.emplace(name, std::atof(found[6].str().c_str())).second) << name << " comes twice";
    }
  }
  return samples;
}

TEST(Metrics, SayWhatTheServiceSaid) {
  const auto text = metrics_text(kAnswers, "1.2 (commit a)", {1000, 4000});
  ASSERT_TRUE(text) << text.error().message;
  const auto samples = read(*text);
  const std::map<std::string, double> expected = {
      {"tiltfeed_up", 1},
      {"tiltfeed_build_info{version=\"1.2 (commit a)\"}", 1},
      {"tiltfeed_machine_info{machine=\"a \\\"b\\\"\",link=\"grbl:/dev/x\"}", 1},
      {"tiltfeed_spool_free_bytes", 1000},
      {"tiltfeed_spool_size_bytes", 4000},
      {"tiltfeed_jobs{state=\"uncertain\"}", 2},
      {"tiltfeed_jobs{state=\"done\"}", 1},
      {"tiltfeed_jobs{state=\"failed\"}", 0},
      {"tiltfeed_jobs{state=\"tool change\"}", 0},
      {"tiltfeed_queue_jobs", 1},
      {"tiltfeed_queue_moving", 1},
      {"tiltfeed_run_phase{phase=\"hold\"}", 1},
      {"tiltfeed_run_phase{phase=\"run\"}", 0},
      {"tiltfeed_run_blocks", 200},
      {"tiltfeed_run_sent_blocks", 90},
      {"tiltfeed_run_executed_blocks", 75},
      {"tiltfeed_run_buffered_blocks", 5},
      {"tiltfeed_run_resends", 2},
      {"tiltfeed_run_elapsed_seconds", 12.5},
      {"tiltfeed_run_starved_seconds", 1.5},
      {"tiltfeed_run_remaining_seconds", 30.5},
      {"tiltfeed_override_ratio{kind=\"feed\"}", 1.1},
      {"tiltfeed_run_feed_meters_per_second", 0.025},
      {"tiltfeed_run_spindle_hertz", 150},
      {"tiltfeed_run_slowest_hold_seconds", 0.3},
      {"tiltfeed_runs_total{outcome=\"done\"}", 3},
      {"tiltfeed_runs_total{outcome=\"uncertain\"}", 1},
      {"tiltfeed_runs_total{outcome=\"failed\"}", 0},
      {"tiltfeed_plans_asked{state=\"open\"}", 2},
      {"tiltfeed_plans_asked{state=\"taken\"}", 1},
      {"tiltfeed_plans_asked{state=\"proving\"}", 0},
      {"tiltfeed_plans_asked_ended_total{outcome=\"refused\"}", 4},
      {"tiltfeed_plans_asked_ended_total{outcome=\"accepted\"}", 0},
      {"tiltfeed_plans_for_others", 1},
      {"tiltfeed_plans_for_others_ended_total{outcome=\"done\"}", 5},
      {"tiltfeed_plans_for_others_ended_total{outcome=\"failed\"}", 0},
      {"tiltfeed_plans_for_others_ended_total{outcome=\"given back\"}", 6},
  };
  for (const auto& [name, value] : expected) {
    ASSERT_TRUE(samples.contains(name)) << name << "\n" << *text;
    EXPECT_DOUBLE_EQ(samples.at(name), value) << name;
  }
}

TEST(Metrics, SayNothingOfPlansWhereThereIsNoShop) {
  const auto text = metrics_text({R"({"ok":true,"counts":{"runs":{}},"jobs":[]})"}, "1", {1, 2});
  ASSERT_TRUE(text);
  EXPECT_EQ(read(*text).at("tiltfeed_runs_total{outcome=\"done\"}"), 0);
  EXPECT_EQ(text->find("plans"), text->npos);
}

TEST(Metrics, SayNothingOfJobsWhereNoServiceAnswers) {
  const auto text = metrics_text({}, "1", {1, 2});
  ASSERT_TRUE(text);
  const auto samples = read(*text);
  EXPECT_EQ(samples.at("tiltfeed_up"), 0);
  EXPECT_EQ(samples.size(), 4u);
  EXPECT_EQ(text->find("jobs"), text->npos);
}

TEST(Metrics, RefuseAnAnswerThatIsNoList) {
  for (const char* const answer : {"", "{", "[]", R"({"ok":false})", R"({"jobs":[{"state":1}]})"})
    EXPECT_FALSE(metrics_text({answer}, "1", {})) << answer;
}

TEST(Metrics, RulesAndDashboardAskOnlyForWhatThereIs) {
  const auto text = metrics_text(kAnswers, "1", {});
  ASSERT_TRUE(text);
  const std::string folder = SOURCE_DIR "/config/prometheus/";
  std::ostringstream asked;
  const auto board = nlohmann::json::parse(std::ifstream(folder + "dashboard.json"));
  std::set<int> ids;
  for (const auto& panel : board.at("panels")) {
    EXPECT_TRUE(ids.insert(panel.at("id").get<int>()).second);
    EXPECT_TRUE(panel.contains("gridPos") && panel.contains("title"));
    for (const auto& target : panel.at("targets")) asked << target.at("expr").get<std::string>() << "\n";
  }
  asked << std::ifstream(folder + "tiltfeed.rules.yaml").rdbuf();
  const std::string all = asked.str();
  const std::regex name("tiltfeed_[a-z_]+");
  int count = 0;
  for (std::sregex_iterator it(all.begin(), all.end(), name), end; it != end; ++it, ++count)
    EXPECT_NE(text->find("# HELP " + it->str() + " "), text->npos) << it->str();
  EXPECT_GE(count, 12);
}

}  // namespace
}  // namespace tiltfeed
