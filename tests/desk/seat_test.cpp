#include "desk/session/seat.h"

#include <gtest/gtest.h>

#include <random>

namespace tiltfeed::desk {
namespace {

using std::chrono::seconds;

TEST(Seat, is_taken_when_it_is_free_and_asked_for_when_it_is_not) {
  Seat seat;
  const Seat::Time now{};
  EXPECT_FALSE(seat.has(0)) << "nobody has no session";
  EXPECT_FALSE(seat.ask(0, now));
  EXPECT_TRUE(seat.ask(1, now));
  EXPECT_TRUE(seat.ask(1, now)) << "it has it already";
  EXPECT_FALSE(seat.ask(2, now));
  EXPECT_FALSE(seat.ask(3, now)) << "one asks at a time";
  EXPECT_EQ(seat.owner(), 1u);
  EXPECT_EQ(seat.asking(), 2u);
  seat.give(2, now);
  EXPECT_EQ(seat.owner(), 1u) << "who does not have it cannot give it";
  seat.give(1, now);
  EXPECT_EQ(seat.owner(), 2u);
  EXPECT_EQ(seat.asking(), 0u);
  seat.give(2, now);
  EXPECT_EQ(seat.owner(), 0u) << "nobody had asked";
}

TEST(Seat, a_lost_connection_keeps_the_seat_until_another_takes_it) {
  Seat seat;
  const Seat::Time now{};
  seat.ask(1, now);
  seat.beat(2, now + seconds(5));  // of no owner
  EXPECT_FALSE(seat.is_lost(now + seconds(5)));
  EXPECT_TRUE(seat.is_lost(now + Seat::kLost));
  EXPECT_TRUE(seat.has(1)) << "it is still its own";
  seat.beat(1, now + Seat::kLost);
  EXPECT_FALSE(seat.is_lost(now + Seat::kLost)) << "it came back";
  EXPECT_FALSE(seat.ask(2, now + Seat::kLost));
  EXPECT_TRUE(seat.ask(2, now + 2 * Seat::kLost));
  EXPECT_TRUE(seat.has(2));
}

TEST(Seat, who_does_not_answer_loses_it_only_to_the_one_that_asked) {
  Seat seat;
  Seat::Time now{};
  seat.ask(1, now);
  seat.ask(2, now);
  for (; now < Seat::Time{} + Seat::kAnswer; now += seconds(1)) {
    seat.beat(1, now);
    EXPECT_FALSE(seat.is_unanswered(now));
    EXPECT_FALSE(seat.ask(2, now));
  }
  seat.beat(1, now);
  EXPECT_TRUE(seat.is_unanswered(now));
  EXPECT_FALSE(seat.ask(3, now)) << "another one";
  EXPECT_TRUE(seat.has(1)) << "it does not change hands by itself";
  EXPECT_TRUE(seat.ask(2, now));
  seat.ask(1, now);
  seat.keep(2);
  EXPECT_EQ(seat.asking(), 0u);
}

TEST(Seat, signing_out_leaves_it) {
  Seat seat;
  const Seat::Time now{};
  seat.ask(1, now);
  seat.ask(2, now);
  seat.leave(1);
  EXPECT_EQ(seat.owner(), 0u);
  EXPECT_TRUE(seat.ask(2, now));
  seat.ask(1, now);
  seat.leave(1);
  EXPECT_EQ(seat.asking(), 0u);
}

/// Whatever is asked in whatever order: the seat passes from one that is there to another by its word or
/// after kAnswer only.
TEST(Seat, never_goes_from_who_is_there_without_its_word) {
  std::mt19937 random(7);
  Seat seat;
  Seat::Time now{};
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t before = seat.owner(), who = random() % 4;
    const bool there = before != 0 && !seat.is_lost(now),
               waited = seat.asking() == who && seat.is_unanswered(now);
    const unsigned deed = random() % 5;
    if (deed == 0) seat.give(who, now);
    if (deed == 1) seat.beat(who, now);
    if (deed == 2) seat.keep(who);
    if (deed >= 3) seat.ask(who, now);
    if (seat.owner() != before && there) {
      ASSERT_TRUE((deed == 0 && who == before) || (deed >= 3 && waited)) << "step " << i;
    }
    now += std::chrono::milliseconds(random() % 3000);
  }
}

}  // namespace
}  // namespace tiltfeed::desk
