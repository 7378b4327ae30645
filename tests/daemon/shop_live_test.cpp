// What a machine is at, as text for the shop's database and back.

#include "daemon/shop/shop_live.h"

#include <gtest/gtest.h>

namespace tiltfeed {
using namespace daemon;
namespace {

TEST(ShopLiveText, IsReadBackAsItWasWritten) {
  for (const char* state : {"idle", "running", "held", "setup", "fault", "off", "unknown"}) {
    ShopLive live{state, "seat rail", "door \"open\"\n", 100, 7, 12.0, 1700000000123};
    EXPECT_EQ(parse_live(live_json(live)), live) << live_json(live);
    live = {state, "", "", 0, 0, -1.0, 5};
    EXPECT_EQ(parse_live(live_json(live)), live) << live_json(live);
  }
}

TEST(ShopLiveText, TextsOfAnyLengthStayWithinTheLimitAndWhole) {
  ShopLive live;
  for (const std::string piece : {"x", "\xC3\xA4", "\xE2\x82\xAC", "\xFF", "\x01"}) {
    live.job = live.alarm = "";
    for (int i = 0; i < 3000; ++i) live.job += piece, live.alarm += piece;
    const std::string text = live_json(live);
    EXPECT_LE(text.size(), kMostLiveJson) << piece;
    const ShopLive back = parse_live(text);
    EXPECT_LE(back.alarm.size(), 300u * 3u);
    EXPECT_FALSE(back.alarm.empty());
    if (piece[0] == '\xC3') {
      EXPECT_EQ(back.alarm, live.alarm.substr(0, back.alarm.size() / 2 * 2));
    }
  }
}

TEST(ShopLiveText, WhatAnybodyMayHaveWrittenIsNothingWorse) {
  const ShopLive none;
  EXPECT_EQ(none.state, "unknown");
  for (const std::string& text :
       {std::string(), std::string("null"), std::string("[]"), std::string("{"), std::string("{}"),
        std::string(
            "{\"state\": 7, \"job\": [], \"blocks\": -1, \"remaining_seconds\": \"x\", \"clock\": 1.5}"),
        std::string("{\"state\": \"flying\"}"), std::string("{\"remaining_seconds\": -3}"),
        "{\"job\": \"" + std::string(kMostLiveJson, 'x') + "\"}", std::string(100000, '[')})
    EXPECT_EQ(parse_live(text), none) << text.substr(0, 80);
  EXPECT_EQ(parse_live("{\"state\": \"idle\", \"more\": 1}").state, "idle");
}

}  // namespace
}  // namespace tiltfeed
