// When a delivery is tried again: the pauses by closed form, the verdict of every status.
#include "desk/webhooks/retry_schedule.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tiltfeed::desk {
namespace {

TEST(RetrySchedule, pauses_double_up_to_the_longest) {
  for (int tries = 1; tries < 1000; ++tries) {
    const double whole = std::min(4000.0 * std::pow(2.0, tries - 1), 600'000.0);
    EXPECT_EQ(pause_after(tries, 0.0, {}).count(), whole / 2) << tries;
    EXPECT_EQ(pause_after(tries, 1.0, {}).count(), whole) << tries;
    EXPECT_EQ(pause_after(tries, 0.5, {}).count(), whole * 0.75) << tries;
  }
}

TEST(RetrySchedule, the_receivers_wish_is_heard_within_bounds) {
  EXPECT_EQ(pause_after(1, 0.0, 30).count(), 30'000);
  EXPECT_EQ(pause_after(1, 0.0, 1).count(), 2000) << "no shorter than ours";
  EXPECT_EQ(pause_after(1, 0.0, 3600).count(), 3'600'000);
  for (const std::int64_t wish : {std::int64_t{3601}, std::int64_t{1} << 40, INT64_MAX})
    EXPECT_EQ(pause_after(1, 0.0, wish).count(), 3'600'000) << wish;
  for (const std::int64_t wish : {std::int64_t{0}, std::int64_t{-1}, INT64_MIN})
    EXPECT_EQ(pause_after(1, 0.0, wish).count(), 2000) << wish;
}

TEST(RetrySchedule, every_status_has_its_verdict) {
  for (int status = 0; status < 700; ++status) {
    const Verdict expected = status >= 200 && status <= 299 ? Verdict::kTaken
                             : status >= 300 && status <= 499 && status != 408 && status != 429
                                 ? Verdict::kRefused
                                 : Verdict::kAgain;
    EXPECT_EQ(verdict_of(status), expected) << status;
  }
}

}  // namespace
}  // namespace tiltfeed::desk
