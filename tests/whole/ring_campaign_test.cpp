// The campaign on the link that proves its work: at least a million faults of all classes, in made-up time.

#include "tests/peers/ring_campaign.h"

#include <gtest/gtest.h>

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

constexpr std::uint64_t kFaults = 1'000'000;

/// Every class that a ring line knows but the restart of the controller.
constexpr const char* kEverything =
    "drop p=0.0008\nduplicate p=0.0006\ncorrupt p=0.001\ninsert p=0.0006\ndelay p=0.0003 for=0.4\n"
    "lose-request p=0.05\nlose-reply p=0.08\nlate-reply p=0.04 for=0.25\nwrong-unit p=0.03\n"
    "half-frame p=0.03\nexception p=0.03 value=6\nsilence p=0.002 for=1.2\ndisconnect p=0.001 for=2\n";

// (stream.h, property 2)
TEST(RingCampaign, AMillionFaultsLoseDuplicateAndAlterNoBlock) {
  const CampaignProgram program(150);
  const auto script = sim::parse_fault_script(kEverything, "everything");
  ASSERT_TRUE(script) << script.error().message;
  std::uint64_t faults = 0, kills = 0, runs = 0, wrong = 0;
  for (std::uint64_t seed = 1; faults < kFaults; ++seed, ++runs) {
    const CampaignOutcome outcome = campaign_run(program, *script, seed, SeededBug::kNone, seed % 3 == 0);
    faults += outcome.faults;
    kills += outcome.kills;
    if (outcome.wrong.empty()) continue;
    if (++wrong <= 5) ADD_FAILURE() << "seed " << seed << ": " << outcome.wrong;
  }
  EXPECT_EQ(wrong, 0u);
  std::printf("%llu runs, %llu faults, %llu senders killed, %llu runs wrong\n",
              static_cast<unsigned long long>(runs), static_cast<unsigned long long>(faults),
              static_cast<unsigned long long>(kills), static_cast<unsigned long long>(wrong));
}

}  // namespace
}  // namespace tiltfeed
