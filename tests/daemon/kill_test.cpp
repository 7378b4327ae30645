// Kill points: a sender dies at any step, by SIGKILL or with the power, torn journal writes included, and the
// next life goes on. Every block is executed once, in order; where that cannot be proved nothing moves, and
// the range that the operator is told holds the truth.

#include <gtest/gtest.h>

#include "tests/peers/kill_campaign.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

#ifdef TILTFEED_KILLS
constexpr std::uint64_t kKills = TILTFEED_KILLS;
#else
constexpr std::uint64_t kKills = 100;
#endif

class KillPoints : public testing::Test {
 protected:
  KillPoints()
      : program(260, folder.path),
        prepared(*prepare_run(program.path, *parse_link("modbus-tcp:127.0.0.1:502"), 1)) {}

  Campaign until(std::uint64_t kills, Campaign campaign) {
    while (campaign.kills < kills && campaign.wrong == 0 && campaign.runs < kills + 20)
      campaign.run(prepared, program, folder.path);
    std::printf("%llu kills in %llu programs, %llu of these left to the operator, %llu wrong %s\n",
                static_cast<unsigned long long>(campaign.kills),
                static_cast<unsigned long long>(campaign.runs),
                static_cast<unsigned long long>(campaign.uncertain),
                static_cast<unsigned long long>(campaign.wrong), campaign.first_wrong.c_str());
    return campaign;
  }

  const Folder folder{"kill"};
  KillProgram program;
  ProgramRun prepared;
};

TEST_F(KillPoints, ProcessKilledAtAnyStep) {
  const Campaign campaign = until(kKills, {});
  EXPECT_EQ(campaign.wrong, 0u) << campaign.first_wrong;
  EXPECT_EQ(campaign.uncertain, 0u);
}

TEST_F(KillPoints, PowerLostAtAnyStep) {
  const Campaign campaign = until(kKills, {.power = true});
  EXPECT_EQ(campaign.wrong, 0u) << campaign.first_wrong;
  EXPECT_EQ(campaign.uncertain, 0u);
}

TEST_F(KillPoints, ControllerGoesToo) {
  for (const bool power : {false, true}) {
    const Campaign campaign = until(kKills / 4, {.power = power, .restarts_in = 3});
    EXPECT_EQ(campaign.wrong, 0u) << campaign.first_wrong;
    EXPECT_GT(campaign.uncertain, 0u);
  }
}

TEST_F(KillPoints, AnotherProgramIsNeverContinued) {
  const Campaign campaign = until(kKills / 10, {.new_program = true});
  EXPECT_EQ(campaign.wrong, 0u) << campaign.first_wrong;
  EXPECT_GT(campaign.uncertain, 0u);
}

TEST_F(KillPoints, EverySeededBugIsFound) {
  for (const Bug bug : {Bug::kNoJournal, Bug::kStartsAnew, Bug::kFromExecuted, Bug::kFromAcknowledged,
                        Bug::kFromOffered, Bug::kBuffered, Bug::kNeverDurable, Bug::kOfferedForSure}) {
    const bool power = bug == Bug::kNeverDurable || bug == Bug::kOfferedForSure;
    EXPECT_GT(until(400, {.power = power, .bug = bug}).wrong, 0u) << "bug " << static_cast<int>(bug);
  }
  const Campaign old = until(60, {.bug = Bug::kOldProgram, .new_program = true});
  EXPECT_EQ(old.uncertain, 0u) << "goes on with another program: the campaign above would have failed";
}

}  // namespace
}  // namespace tiltfeed
