// Where TCP cannot begin with the table at home, and what its words keep to: travels, the profile, other
// lines.

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "config/table_home.h"
#include "daemon/post/tcp_start.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/machine/machine.h"
#include "sim/control/move_frames.h"
#include "tests/texts/posted.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

TEST(TcpHome, WithoutARetractTheNextOperationsTableWouldTurnUnderTheTool) {
  MachineProfile profile = machine(Dialect::kFanuc, true);
  ASSERT_TRUE(program_text(foreign(), profile, setup()));
  profile.format.retract = "none";
  const auto refused = program_text(foreign(), profile, setup());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("state a retract"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("generic-ac.yaml: program.retract: none"), std::string::npos);
  // Before any joints are looked for: here there are none.
  AptProgram far = foreign();
  far.operations.front().path.moves.front().pose.tip.x = 1e5;
  const auto sooner = program_text(far, profile, setup());
  ASSERT_FALSE(sooner);
  EXPECT_EQ(sooner.error().message, refused.error().message);
  AptProgram one = foreign();
  one.operations.resize(1);
  EXPECT_TRUE(program_text(one, profile, setup()));
  profile.format.tcp = false;
  EXPECT_TRUE(program_text(foreign(), profile, setup()));
}

/// At the ends of the travels, where decimals are few and levers long.
TEST(TcpHome, RoundedWordsAreNotOverTheTravel) {
  const tiltfeed::Setup on_table{{0.12345, 0.23456, 0.34567}, {}, 100.0};
  for (const char* name : {"generic-ac", "linuxcnc-trunnion-ac", "dmu-nutating-bc"})
    for (const int decimals : {2, 3}) {
      MachineProfile profile = machine(Dialect::kFanuc, true, name);
      const MachineModel& m = profile.model;
      profile.format.tcp_start_below = 0.0;
      profile.format.linear_decimals = profile.format.rotary_decimals = decimals;
      const sim::MoveFrames frames(m, on_table);
      // Where rounding leaves them: units of the linear words, and of the rotaries' at the end of a lever of
      // a metre.
      const double off = 20.0 * std::pow(10.0, -decimals);
      for (const auto& [x, y, z] : {std::array{30.0, 40.0, 0.0},
                                    {m.x.max, m.y.max, m.z.max},
                                    {m.x.min, m.y.min, m.z.max - 1e-4},
                                    {m.x.max - 3e-4, m.y.min + 2e-4, 0.0}})
        for (double a = -30.0; a < 30.0; a += 0.777) {
          const std::vector<Joints> start = tcp_start(profile, on_table, {x, y, z, a, 90 + a});
          ASSERT_FALSE(start.empty());
          for (const Joints& words : start) {
            const Joints at = frames.slide_words(words);
            ASSERT_TRUE(within_limits(m, {at.x, at.y, at.z, words.a, words.c}))
                << name << " " << decimals << ": " << *broken_limit(m, {at.x, at.y, at.z, words.a, words.c});
            ASSERT_LT(length(Vec3{at.x, at.y, at.z} - Vec3{x, y, m.z.max}), off);
            ASSERT_EQ(round_decimal(words.x, decimals), words.x);
            ASSERT_EQ(round_decimal(words.y, decimals), words.y);
            ASSERT_EQ(round_decimal(words.z, decimals), words.z);
          }
        }
    }
}

TEST(TcpHome, ThePlaceBeforeItIsNotOverTheTravel) {
  MachineProfile profile = machine(Dialect::kFanuc, true);
  profile.model.x.max = 599.9996, profile.model.y.min = -599.9996;
  const tiltfeed::Setup on_table{{1, 2, 3}, {}, 100.0};
  const sim::MoveFrames frames(profile.model, on_table);
  const Joints words = frames.tip_words({599.9996, -599.9996, 0, 20, 90});
  const Joints at = first_place(profile, on_table, words);
  EXPECT_EQ(at.x, 599.999);
  EXPECT_EQ(at.y, -599.999);
}

/// What the header says of TCP fits on a control that takes its other lines.
TEST(TcpHome, TheHeadersLinesAreNoLongerThanOthers) {
  MachineProfile profile = machine(Dialect::kFanuc, true);
  const auto text = program_text(foreign(), profile, setup());
  ASSERT_TRUE(text) << text.error().message;
  std::size_t longest = 0;
  std::istringstream in(*text);
  for (std::string line; std::getline(in, line);)
    if (line.find("X Y Z are") == line.npos && line.find("No.") == line.npos)
      longest = std::max(longest, line.size());
  EXPECT_EQ(longest, std::string("(TILTFEED tool length 100 mm is planned, TCP takes the control's)").size());
  profile.format.max_line_length = static_cast<int>(longest);
  EXPECT_TRUE(program_text(foreign(), profile, setup()));
}

TEST(TcpHome, NearestWithinTheTravel) {
  RotaryAxis axis{'C', {0, 0, 1}, +1, 0.0, -400, 1000, 1, 1};
  EXPECT_EQ(nearest_home(axis, 0.0, 3), 0.0);
  EXPECT_EQ(nearest_home(axis, 90.0, 3), 0.0);
  EXPECT_EQ(nearest_home(axis, 700.0, 3), 720.0);
  EXPECT_EQ(nearest_home(axis, 999.0, 3), 720.0) << "1080 is beyond the travel";
  EXPECT_EQ(nearest_home(axis, -390.0, 3), -360.0);
  axis.zero = 1.5;
  EXPECT_EQ(nearest_home(axis, 90.0, 3), 1.5);
  axis.zero = axis.min = 0.0004;
  EXPECT_EQ(nearest_home(axis, 90.0, 3), 0.001) << "0 is below the travel";
  axis.zero = axis.max = 360.0006;
  EXPECT_EQ(nearest_home(axis, 300.0, 3), 360.0) << "360.001 is above the travel";
  axis.zero = 1.5;
  axis.min = 10, axis.max = 200;
  EXPECT_FALSE(nearest_home(axis, 90.0, 3));
}

TEST(TcpHome, TheProfileSaysHowFarBelowTheEndOfTheTravel) {
  std::ifstream in(SOURCE_DIR "/config/machines/generic-ac.yaml");
  std::stringstream profile;
  profile << in.rdbuf();
  std::string text = profile.str();
  text.replace(text.find("  dialect: rs274"), 16, "  dialect: fanuc");
  text.replace(text.find("  tcp: false"), 12, "  tcp: true\n  tcp_start_below_mm: 120");
  text.erase(text.find("  feed_mode:"),
             1 + text.find('\n', text.find("  feed_mode:")) - text.find("  feed_mode:"));
  const std::size_t measure = text.find("  feed_measure:");
  text.replace(measure, 2, "  # ");
  const auto read = parse_machine(text, "m.yaml");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_NE(describe(*read).find("program.tcp_start_below_mm: 120"), std::string::npos);
  const tiltfeed::Setup on_table{{0, 0, 0}, {}, 100.0};
  const Joints first{30, 40, 200, 20, 90};
  const sim::MoveFrames frames(read->model, on_table);
  const std::vector<Joints> start = tcp_start(*read, on_table, first);
  ASSERT_EQ(start.size(), 4u);
  EXPECT_NEAR(frames.slide_words(start.front()).z, read->model.z.max - 120.0, 2e-3);
  // A first place that is higher is not gone below.
  const Joints high{30, 40, read->model.z.max - 7.0, 20, 90};
  EXPECT_NEAR(frames.slide_words(tcp_start(*read, on_table, high).front()).z, high.z, 2e-3);
}

TEST(TcpHome, ATableThatCannotStandThereIsRefused) {
  MachineProfile profile = machine(Dialect::kFanuc, true);
  profile.model.rotary.min = 5.0, profile.model.rotary.max = 355.0;
  const auto refused = program_text(foreign(), profile, setup());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("generic-ac.yaml: program.tcp: fanuc may count"), std::string::npos);
  EXPECT_NE(refused.error().message.find("C has no place at home"), std::string::npos)
      << refused.error().message;
  // Before any joints are looked for: here there are none.
  AptProgram far = foreign();
  far.operations.front().path.moves.front().pose.tip.x = 1e5;
  const auto sooner = program_text(far, profile, setup());
  ASSERT_FALSE(sooner);
  EXPECT_EQ(sooner.error().message, refused.error().message);
  profile.format.dialect = Dialect::kSiemens;
  EXPECT_TRUE(program_text(foreign(), profile, setup()));
}

}  // namespace
}  // namespace tiltfeed
