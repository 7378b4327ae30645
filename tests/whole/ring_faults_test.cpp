// The campaign of ring_campaign_test.cpp in small, each class of fault by itself, and the proof that the
// campaign would see a mistake: every seeded bug is caught.

#include <gtest/gtest.h>

#include "tests/peers/ring_campaign.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

sim::FaultScript script(const std::string& text) {
  const auto parsed = sim::parse_fault_script(text, "test");
  EXPECT_TRUE(parsed) << parsed.error().message;
  return *parsed;
}

constexpr const char* kMixed =
    "drop p=0.001\nduplicate p=0.001\ncorrupt p=0.002\ninsert p=0.001\ndelay p=0.0005 for=0.4\n"
    "lose-request p=0.05\nlose-reply p=0.1\nlate-reply p=0.05 for=0.25\nwrong-unit p=0.05\n"
    "half-frame p=0.03\nexception p=0.03 value=6\n";

TEST(RingFaults, EachClassByItselfLosesDuplicatesAndAltersNoBlock) {
  const CampaignProgram program(80);
  for (const char* rule :
       {"drop p=0.004", "duplicate p=0.004", "corrupt p=0.004", "insert p=0.004", "delay p=0.002 for=0.5",
        "lose-request p=0.4", "lose-reply p=0.4", "late-reply p=0.3 for=0.2", "late-reply p=0.05 for=0.35",
        "late-reply p=0.04 for=1", "wrong-unit p=0.3", "half-frame p=0.3", "exception p=0.3 value=5",
        "exception p=0.3 value=6", "silence p=0.05 for=1.5", "disconnect p=0.05 for=2",
        "disconnect p=0.02 for=15", "slow-read p=1"}) {
    std::uint64_t faults = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const CampaignOutcome outcome =
          campaign_run(program, script(rule), seed, SeededBug::kNone, seed % 2 == 0);
      EXPECT_EQ(outcome.wrong, "") << rule << ", seed " << seed;
      faults += outcome.faults;
    }
    if (std::string(rule) != "slow-read p=1") {
      EXPECT_GT(faults, 10u) << rule;
    }
  }
}

TEST(RingFaults, ARestartOfTheControllerIsNeverResumed) {
  const CampaignProgram program(80);
  std::uint64_t restarts = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const CampaignOutcome outcome =
        campaign_run(program,
                     script("reset at=" + std::to_string(0.05 + 0.01 * static_cast<double>(seed % 40)) +
                            "\nlose-reply p=0.05"),
                     seed, SeededBug::kNone, false);
    EXPECT_EQ(outcome.wrong, "") << "seed " << seed;
    restarts += outcome.resets;
  }
  EXPECT_GT(restarts, 30u);
}

TEST(RingFaults, EverySeededBugIsCaught) {
  const CampaignProgram program(120), longer(66000);
  for (int bug = 1; bug <= static_cast<int>(SeededBug::kLast); ++bug) {
    const auto which = static_cast<SeededBug>(bug);
    const bool restart = which == SeededBug::kBootIgnored, wrap = which == SeededBug::kNoWrap;
    const std::string text = restart ? "reset at=0.2" : wrap ? "lose-reply p=0.0001" : kMixed;
    const std::uint64_t seeds = wrap ? 1 : 60;
    std::uint64_t caught = 0;
    for (std::uint64_t seed = 1; seed <= seeds && caught == 0; ++seed) {
      const auto wrong = [&](SeededBug with) {
        return campaign_run(wrap ? longer : program, script(text), seed, with, seed % 2 == 0).wrong;
      };
      if (wrong(which).empty()) continue;
      EXPECT_EQ(wrong(SeededBug::kNone), "") << "seed " << seed << ": it was not the bug that was seen";
      ++caught;
    }
    EXPECT_GT(caught, 0u) << "bug " << bug << " passes unseen";
  }
}

TEST(RingFaults, TheSequenceNumbersWrapUnseen) {
  const CampaignProgram longer(66000);
  EXPECT_EQ(campaign_run(longer, script("lose-reply p=0.01"), 1, SeededBug::kNone, false).wrong, "");
}

}  // namespace
}  // namespace tiltfeed
