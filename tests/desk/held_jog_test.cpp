#include "desk/service/held_jog.h"

#include <gtest/gtest.h>

namespace tiltfeed::desk {
namespace {

using std::chrono::milliseconds;

TEST(HeldJog, ends_300_ms_after_the_last_beat_once) {
  HeldJog jog;
  HeldJog::Time now{};
  EXPECT_FALSE(jog.is_due(now)) << "there is none";
  jog.begin(5, now);
  for (int i = 0; i < 20; ++i) {
    now += milliseconds(100);
    EXPECT_FALSE(jog.is_due(now));
    EXPECT_TRUE(jog.beat(5, now));
  }
  EXPECT_FALSE(jog.is_due(now + milliseconds(299)));
  EXPECT_TRUE(jog.lives(now + milliseconds(299)));
  EXPECT_FALSE(jog.lives(now + milliseconds(300)));
  EXPECT_TRUE(jog.is_due(now + milliseconds(300)));
  EXPECT_FALSE(jog.is_due(now + milliseconds(301))) << "the machine is told once";
  EXPECT_FALSE(jog.is_held());
}

TEST(HeldJog, a_late_beat_does_not_bring_it_back) {
  HeldJog jog;
  const HeldJog::Time now{};
  jog.begin(5, now);
  EXPECT_FALSE(jog.beat(5, now + milliseconds(300))) << "before anybody looked";
  EXPECT_TRUE(jog.is_due(now + milliseconds(300)));
  EXPECT_FALSE(jog.beat(5, now + milliseconds(310)));
}

TEST(HeldJog, only_its_owner_holds_it_and_lets_go) {
  HeldJog jog;
  const HeldJog::Time now{};
  jog.begin(5, now);
  EXPECT_FALSE(jog.beat(6, now));
  EXPECT_FALSE(jog.beat(0, now));
  jog.let_go(6);
  EXPECT_FALSE(jog.is_due(now));
  jog.let_go(5);
  EXPECT_FALSE(jog.beat(5, now)) << "the hand is off the key";
  EXPECT_FALSE(jog.lives(now));
  EXPECT_TRUE(jog.is_due(now)) << "at once";
  jog.begin(6, now);
  EXPECT_FALSE(jog.is_due(now)) << "a new one";
  jog.end();
  EXPECT_FALSE(jog.is_due(now + milliseconds(1000)));
}

}  // namespace
}  // namespace tiltfeed::desk
