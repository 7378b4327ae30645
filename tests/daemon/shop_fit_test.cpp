// Which machine may have which job: the rule by hand, by brute force over small worlds, and texts of anybody.

#include "daemon/shop/shop_fit.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "tests/texts/machine_text.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

const ShopOffer kOffer{
    "ac5", "v1", "grbl", {{'X', -100, 100}, {'Y', 0, 50}, {'C', -1e9, 1e9}}, {{3, "ball_6"}, {4, ""}}};

TEST(ShopFit, TheRuleByHand) {
  struct Case {
    ShopNeeds needs;
    const char* why;  ///< of the answer; empty: it fits
  };
  const Case cases[] = {
      {{}, ""},
      {{"ac5", "v1", "grbl", {{'X', -100, 100}, {'Y', 0, 50}, {'C', -720, 7200}}, {{3, ""}}}, ""},
      {{"other", "", "", {}, {}}, "for the profile other"},
      {{"ac5", "v2", "", {}, {}}, "other values"},
      {{"", "", "fanuc", {}, {}}, "dialect fanuc"},
      {{"", "", "", {{'X', -100.001, 0}}, {}}, "X goes -100 to 100"},
      {{"", "", "", {{'Y', 0, 50.001}}, {}}, "the job 0 to 50.001"},
      {{"", "", "", {{'Y', 0, 50.0000001}}, {}}, ""},
      {{"", "", "", {{'A', 0, 0}}, {}}, "no axis A"},
      {{"", "", "", {}, {{3, "ball_6"}, {4, ""}}}, ""},
      {{"", "", "", {}, {{9, "ball_6"}}}, ""},                // the id says more than the number
      {{"", "", "", {}, {{3, "flat_6"}}}, "no flat_6 (T3)"},  // another tool stands at that number
      {{"", "", "", {}, {{4, "flat_6"}}}, ""},                // the magazine has no id for it: the number
      {{"", "", "", {}, {{5, ""}}}, "no T5"},
      {{"", "", "", {}, {{0, "flat_6"}}}, "no flat_6"},
  };
  for (const Case& one : cases) {
    const auto why = misfit(one.needs, kOffer);
    EXPECT_EQ(why.has_value(), *one.why != '\0') << needs_json(one.needs) << why.value_or("");
    if (why) {
      EXPECT_NE(why->find(one.why), std::string::npos) << *why;
    }
  }
  ShopOffer unknown = kOffer;
  unknown.tools.clear();
  EXPECT_FALSE(misfit({"", "", "", {}, {{5, "any"}}}, unknown)) << "a magazine that is not known";
}

/// Property 4, and that each need alone decides: a job fits where each of its needs fits alone.
TEST(ShopFit, NeedsAreJudgedEachByItself) {
  std::mt19937 random(7);
  const auto pick = [&](std::initializer_list<std::string> words) {
    return words.begin()[random() % words.size()];
  };
  int fits = 0;
  for (int round = 0; round < 3000; ++round) {
    ShopNeeds needs{pick({"", "ac5", "b"}), pick({"", "v1"}), pick({"", "grbl"}), {}, {}};
    for (const char letter : {'X', 'Y', 'A', 'C'}) {
      const double from = static_cast<double>(random() % 300) - 150;
      if (random() % 4 == 0)
        needs.travels.push_back({letter, from, from + static_cast<double>(random() % 120)});
    }
    if (random() % 2 == 0) needs.tools.push_back({static_cast<int>(random() % 6) + 1, pick({"", "ball_6"})});
    bool each = !misfit({needs.profile, "", "", {}, {}}, kOffer) &&
                !misfit({"", needs.values, "", {}, {}}, kOffer) &&
                !misfit({"", "", needs.dialect, {}, {}}, kOffer);
    for (const ShopTravel& one : needs.travels) each = each && !misfit({"", "", "", {one}, {}}, kOffer);
    for (const ShopTool& one : needs.tools) each = each && !misfit({"", "", "", {}, {one}}, kOffer);
    ASSERT_EQ(!misfit(needs, kOffer), each) << needs_json(needs);
    fits += each;
    const auto back = parse_needs(needs_json(needs));
    ASSERT_TRUE(back) << back.error().message;
    ASSERT_EQ(*back, needs);
  }
  EXPECT_GT(fits, 300);
  EXPECT_LT(fits, 2700);
  EXPECT_EQ(*parse_offer(offer_json(kOffer)), kOffer);
}

TEST(ShopFit, WhatIsNotUnderstoodIsNotMet) {
  std::string deep;
  for (int i = 0; i < 3000; ++i) deep += "[";
  std::string tools = R"({"tools":[)";
  for (int i = 0; i < 201; ++i) tools += (i > 0 ? "," : "") + std::string(R"({"number":1})");
  for (const std::string& bad : {std::string(),
                                 std::string("[]"),
                                 std::string("7"),
                                 std::string("{\"arms\":4}"),
                                 std::string("{\"profile\":7}"),
                                 std::string(R"({"travels":{"X":[1]}})"),
                                 std::string(R"({"travels":{"X":[2,1]}})"),
                                 std::string(R"({"travels":{"x":[1,2]}})"),
                                 std::string(R"({"travels":{"X":["a",2]}})"),
                                 std::string(R"({"travels":{"X":[0,1e999]}})"),
                                 std::string(R"({"tools":[{}]})"),
                                 std::string(R"({"tools":[{"number":0}]})"),
                                 std::string(R"({"tools":[{"number":1.5}]})"),
                                 std::string(R"({"tools":[{"number":1,"arm":2}]})"),
                                 std::string(R"({"tools":{"number":1}})"),
                                 R"({"profile":")" + std::string(kMostShopJson, 'x') + "\"}",
                                 deep,
                                 "{\"tools\":" + deep,
                                 tools + "]}",
                                 std::string("{\"profile\":\"\xff\"}"),
                                 std::string("{\"travels\":{\"X\":[[[[[1]]]],2]}}")}) {
    EXPECT_FALSE(parse_needs(bad)) << bad.substr(0, 60);
    EXPECT_FALSE(parse_offer(bad)) << bad.substr(0, 60);
  }
  EXPECT_EQ(needs_text({"ac5", "v", "grbl", {{'X', -1, 2.5}}, {{3, ""}}}),
            "profile ac5 with these values; dialect grbl; X -1 to 2.5; tool T3");
  EXPECT_EQ(needs_text({}), "any machine");
}

TEST(ShopFit, AProfileAndItsValues) {
  const std::string path = std::string(SOURCE_DIR) + "/config/machines/generic-ac.yaml";
  const auto profile = load_machine(path);
  ASSERT_TRUE(profile) << profile.error().message;
  const ShopOffer offer = offer_of(*profile);
  EXPECT_EQ(offer.profile, "generic-ac");
  EXPECT_EQ(offer.dialect, "rs274");
  ASSERT_EQ(offer.travels.size(), 5u);
  EXPECT_EQ(offer.travels[0].letter, 'X');
  EXPECT_EQ(offer.travels[0].max, profile->model.x.max);
  EXPECT_EQ(*parse_offer(offer_json(offer)), offer);
  MachineProfile same = *profile;
  same.path = "elsewhere.yaml";
  same.link = "grbl:/dev/ttyUSB7";
  same.receive_buffer = 999;
  same.magazine.push_back({7, "x"});
  EXPECT_EQ(profile_values(same), offer.values) << "the wire and the magazine are of one machine";
  MachineProfile other = *profile;
  other.model.pivot_to_gauge.z -= 0.01;
  EXPECT_NE(profile_values(other), offer.values);
  other = *profile;
  other.model.x.max += 1;
  EXPECT_NE(profile_values(other), offer.values);
}

}  // namespace
}  // namespace tiltfeed
