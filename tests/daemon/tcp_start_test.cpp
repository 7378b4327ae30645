// Where TCP begins on controls that may count X Y Z from the table at home, or from the table as it stands
// there: a reader of its own knows both, and the program must mean the same to it.

#include "daemon/post/tcp_start.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "config/table_home.h"
#include "kinematics/timing/tcp_path.h"
#include "sim/control/control_reader.h"
#include "sim/control/move_frames.h"
#include "tests/judges/dialect_reader.h"
#include "tests/texts/posted.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

enum class Reading { kFromHome, kAsItStands };

/// A block under TCP as one reading has it: the tip from part zero in the directions of the table at home.
struct TipBlock {
  Vec3 tip;
  double a = 0.0, c = 0.0;
};

struct TipOperation {
  std::vector<TipBlock> blocks;
  Vec3 place;                      ///< X and Y of the slides before TCP begins
  std::array<double, 2> turned{};  ///< the rotaries there
};

/// Where a point of the frame is on the table when the table comes home from (a, c).
Vec3 come_home(const MachineModel& m, Vec3 point, double a, double c) {
  const auto back = [](const RotaryAxis& axis, double word, Vec3 v) {
    const double angle = Angle::from_degrees(axis.sign * (word - axis.zero)).radians();
    return transposed(rotation_about(axis.direction, angle)) * v;
  };
  if (m.structure == Structure::kHeadHead) return point;
  if (m.structure == Structure::kTableTable)
    point = back(m.tilt, a, point - m.rotary_to_tilt) + m.rotary_to_tilt;
  return back(m.rotary, c, point);
}

/// Knows the words of Fanuc and Haas that say where TCP begins and ends, and nothing of the rest.
std::vector<TipOperation> read_tips(const std::string& text, const MachineModel& m, Vec3 part_zero,
                                    Reading reading) {
  std::vector<TipOperation> all;
  std::map<char, double> at;
  bool tcp = false;
  double frame_a = 0.0, frame_c = 0.0;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("T")) all.emplace_back();
    if (line == "G49") tcp = false;
    if (line.find("G28") != line.npos || line.find("G53") != line.npos || line.find("G4 ") != line.npos ||
        line.starts_with("(") || line.starts_with("O") || all.empty())
      continue;
    const bool begins = line.find("G43.4") != line.npos || line.find("G234") != line.npos;
    const std::map<char, double> before = at;
    bool moves = false;
    for (const auto& [letter, number] : seen_words(line, false)) {
      if (letter != 'X' && letter != 'Y' && letter != 'Z' && letter != m.tilt.letter &&
          letter != m.rotary.letter)
        continue;
      const bool by_sign = letter == m.rotary.letter && m.rotary.word == RotaryWord::kSigned;
      at[letter] = by_sign ? std::abs(std::stod(number)) : std::stod(number);
      moves = true;
    }
    if (!moves) continue;
    const double a = at[m.tilt.letter], c = at[m.rotary.letter];
    if (begins) {
      EXPECT_EQ(at.at(m.tilt.letter), before.at(m.tilt.letter)) << line;
      EXPECT_EQ(at.at(m.rotary.letter), before.at(m.rotary.letter)) << line;
      EXPECT_EQ(seen_words(line, false).size(), 8u) << "G0, G43.4, H, all five: " << line;
      all.back().place = {before.at('X'), before.at('Y'), 0.0};
      all.back().turned = {a, c};
      tcp = true, frame_a = a, frame_c = c;
    }
    if (!tcp) continue;
    Vec3 tip{at['X'], at['Y'], at['Z']};
    if (reading == Reading::kAsItStands) tip = come_home(m, part_zero + tip, frame_a, frame_c) - part_zero;
    all.back().blocks.push_back({tip, a, c});
  }
  return all;
}

struct StartShop {
  const char* machine;
  Dialect dialect;
};

class TcpStart : public testing::TestWithParam<StartShop> {
 protected:
  /// The golden CL file on the machine of a shop, somewhere on the table that it can reach.
  void SetUp() override {
    profile_ = machine(GetParam().dialect, true, GetParam().machine);
    options_.setup.part_zero = {-6, 9, 20};
    auto posted = post(foreign(), "in.cls", profile_, options_);
    ASSERT_TRUE(posted) << posted.error().message;
    posted_ = std::move(*posted);
    std::ostringstream out;
    const auto written = write_program(posted_.posting, out);
    ASSERT_TRUE(written) << written.error().message;
    text_ = out.str();
  }
  MachineProfile profile_;
  PostOptions options_;
  Posted posted_;
  std::string text_;
};

INSTANTIATE_TEST_SUITE_P(Shops, TcpStart,
                         testing::Values(StartShop{"generic-ac", Dialect::kFanuc},
                                         StartShop{"generic-ac", Dialect::kHaas},
                                         StartShop{"dmu-nutating-bc", Dialect::kFanuc},
                                         StartShop{"vmc-bhead-bc", Dialect::kFanuc},
                                         StartShop{"linuxcnc-trunnion-ac", Dialect::kFanuc},
                                         StartShop{"linuxcnc-trunnion-ac", Dialect::kHaas},
                                         StartShop{"linuxcnc-bridge-bc", Dialect::kFanuc}));

TEST_P(TcpStart, TheProgramMeansTheSameInBothReadings) {
  const MachineModel& m = profile_.model;
  for (const Reading reading : {Reading::kFromHome, Reading::kAsItStands}) {
    SCOPED_TRACE(static_cast<int>(reading));
    const auto operations = read_tips(text_, m, options_.setup.part_zero, reading);
    ASSERT_EQ(operations.size(), posted_.posting.operations.size());
    for (std::size_t k = 0; k < operations.size(); ++k) {
      const std::vector<TipBlock>& got = operations[k].blocks;
      const std::vector<JointMove>& want = posted_.posting.operations[k].words->moves;
      ASSERT_GE(got.size(), want.size());
      for (std::size_t i = 0; i < want.size(); ++i) {
        const TipBlock& one = got[got.size() - want.size() + i];
        const Joints& words = want[i].joints;
        ASSERT_LT(length(one.tip - Vec3{words.x, words.y, words.z}), 1e-9) << "block " << i;
        ASSERT_NEAR(std::remainder(one.c - words.c, 360.0), 0.0, 1e-9) << "block " << i;
        ASSERT_NEAR(one.a, words.a, 1e-9) << "block " << i;
      }
    }
  }
}

/// From the retract the table comes home, the slides go over the first place, and there they stay, high up,
/// while the table turns.
TEST_P(TcpStart, TheSlidesStandWhileTheTableTurns) {
  const MachineModel& m = profile_.model;
  const auto operations = read_tips(text_, m, options_.setup.part_zero, Reading::kFromHome);
  int turned = 0;
  for (std::size_t k = 0; k < operations.size(); ++k) {
    const TipOperation& op = operations[k];
    const Operation& planned = posted_.posting.operations[k];
    const sim::MoveFrames frames(m, planned.setup);
    const auto slides = [&](const TipBlock& one) {
      return frames.slide_words({one.tip.x, one.tip.y, one.tip.z, one.a, one.c});
    };
    const std::size_t before = op.blocks.size() - planned.words->moves.size();
    if (m.structure != Structure::kHeadHead) {
      EXPECT_EQ(std::fmod(op.turned[1] - m.rotary.zero, 360.0), 0.0);
    }
    if (m.structure == Structure::kTableTable) {
      EXPECT_EQ(op.turned[0], m.tilt.zero);
    }
    const Joints first = slides(op.blocks[before]);
    const double height = std::max(first.z, m.z.max - 50.0);
    EXPECT_NEAR(op.place.x, first.x, 0.01);
    EXPECT_NEAR(op.place.y, first.y, 0.01);
    for (std::size_t i = 0; i < before; ++i) {
      const TipBlock &from = op.blocks[i > 0 ? i - 1 : 0], &to = op.blocks[i];
      ++turned;
      EXPECT_LE(std::abs(to.a - from.a), 30.0 + 1e-9);
      EXPECT_LE(std::abs(std::remainder(to.c - from.c, 360.0)), 30.0 + 1e-9);
      for (double f = 0.0; f <= 1.0; f += 0.125) {
        const Joints at = slides({from.tip + (to.tip - from.tip) * f, from.a + f * (to.a - from.a),
                                  from.c + f * std::remainder(to.c - from.c, 360.0)});
        const double lever = length(to.tip + options_.setup.part_zero) + length(m.rotary_to_tilt);
        const double off = f == 0.0 || f == 1.0 ? 0.02 : 0.02 + 0.04 * lever;
        EXPECT_NEAR(at.x, first.x, off) << i << " " << f;
        EXPECT_NEAR(at.y, first.y, off) << i << " " << f;
        EXPECT_NEAR(at.z, height, off) << i << " " << f;
      }
    }
  }
  if (m.structure == Structure::kHeadHead) {
    EXPECT_EQ(turned, 0);
  } else {
    EXPECT_GT(turned, 4);
  }
}

/// The judges refuse a program with our header whose table is not at home where TCP begins; `unpost` says so.
TEST_P(TcpStart, ATableThatIsNotAtHomeIsTold) {
  const auto judged = [&](const std::string& text) {
    sim::ControlReader reader(profile_, posted_.posting.operations[0].setup);
    std::istringstream in(text);
    const auto read = sim::read_control_program(in, "p.nc", reader, [](const sim::ControlBlock&) {});
    return read ? "" : read.error().message;
  };
  EXPECT_EQ(judged(text_), "");
  const auto made = back(text_, profile_);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_TRUE(made->notes.empty());
  if (profile_.model.structure == Structure::kHeadHead) return;
  // Before the block that begins it, and in it.
  const std::string on = GetParam().dialect == Dialect::kFanuc ? "G43.4" : "G234";
  for (const bool before : {true, false}) {
    std::string bad = text_;
    const std::string c(1, profile_.model.rotary.letter);
    std::size_t at = bad.find(on);
    if (before) {
      at = bad.rfind("\n", at);
      bad.insert(at + 1, "G0 " + c + "45.\n");
    } else {
      at = bad.find(" " + c, at);
      bad.replace(at, bad.find('\n', at) - at, " " + c + "45.");
    }
    EXPECT_NE(judged(bad).find("TCP begins while " + c + " of the table is not at home"), std::string::npos)
        << judged(bad);
    if (!before) continue;
    const auto other = back(bad, profile_);
    ASSERT_TRUE(other) << other.error().message;
    ASSERT_EQ(other->notes.size(), 1u);
    EXPECT_NE(other->notes[0].find("is not at home"), std::string::npos);
  }
}

/// What begins TCP is the post's own: the path that comes back begins where the planned one does.
TEST_P(TcpStart, TheTurnOfTheTableDoesNotComeBackAsPath) {
  const auto made = back(text_, profile_);
  ASSERT_TRUE(made) << made.error().message;
  ASSERT_EQ(made->operations.size(), posted_.posting.operations.size());
  for (std::size_t k = 0; k < made->operations.size(); ++k) {
    const Operation& op = posted_.posting.operations[k];
    const Pose want = pose_under_tcp(profile_.model, op.setup, op.words->moves.front().joints);
    const Pose& got = made->operations[k].path.moves.front().pose;
    EXPECT_LT(distance(got.tip, want.tip), 2e-3) << k;
    EXPECT_LT(angle_between(got.axis, want.axis), 1e-4) << k;
  }
  const auto again = post(*made, "again.cls", profile_, options_);
  ASSERT_TRUE(again) << again.error().message;
  std::ostringstream out;
  ASSERT_TRUE(write_program(again->posting, out));
  const auto twice = back(out.str(), profile_);
  ASSERT_TRUE(twice) << twice.error().message;
  const Pose &once = made->operations[0].path.moves.front().pose,
             &then = twice->operations[0].path.moves.front().pose;
  EXPECT_LT(distance(once.tip, then.tip), 2e-3);
}

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

TEST(TcpHome, RoundedWordsAreNotOverTheTravel) {
  MachineProfile profile = machine(Dialect::kFanuc, true);
  profile.format.tcp_start_below = 0.0;
  const tiltfeed::Setup on_table{{0.12345, 0.23456, 0.34567}, {}, 100.0};
  const sim::MoveFrames frames(profile.model, on_table);
  for (double a = -30.0; a < 30.0; a += 0.777)
    for (const Joints& words : tcp_start(profile, on_table, {30, 40, 0, a, 90 + a}))
      ASSERT_LE(frames.slide_words(words).z, profile.model.z.max) << a;
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
