// Where TCP begins on controls that may count X Y Z from the table at home, or from the table as it stands
// there: a reader of its own knows both, and the program must mean the same to it.

#include "daemon/post/tcp_start.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "kinematics/basics/decimal.h"
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

/// The machining time, in the header and for the report, has the start's moves: from where TCP begins to the
/// first place, as another reader finds them.
TEST_P(TcpStart, TheTimeCountsTheTurnOfTheTable) {
  const MachineModel& m = profile_.model;
  const auto operations = read_tips(text_, m, options_.setup.part_zero, Reading::kFromHome);
  double turn = 0.0;
  std::size_t blocks = 0;
  for (std::size_t k = 0; k < operations.size(); ++k) {
    const TipOperation& op = operations[k];
    const sim::MoveFrames frames(m, posted_.posting.operations[k].setup);
    const std::size_t before = op.blocks.size() - posted_.posting.operations[k].words->moves.size();
    blocks += before;
    for (std::size_t i = 0; i < before; ++i) {
      const auto axes = [&](const TipBlock& one) {
        return frames.slide_words({one.tip.x, one.tip.y, one.tip.z, one.a, one.c});
      };
      const Joints from = axes(op.blocks[i]), to = axes(op.blocks[i + 1]);
      turn +=
          60.0 * std::max({std::abs(to.z - from.z) / m.z.velocity, std::abs(to.a - from.a) / m.tilt.velocity,
                           std::abs(std::remainder(to.c - from.c, 360.0)) / m.rotary.velocity});
    }
  }
  // A control that needs no such start: the same moves without it.
  MachineProfile other = profile_;
  other.format.dialect = Dialect::kSiemens;
  const auto without = post(foreign(), "in.cls", other, options_);
  ASSERT_TRUE(without) << without.error().message;
  const double more = posted_.timing.seconds - without->timing.seconds;
  EXPECT_GE(more, turn - 1e-3);
  EXPECT_LE(more, turn + 2.0 * static_cast<double>(blocks)) << "accelerations, too";
  EXPECT_EQ(more > 0.0, m.structure != Structure::kHeadHead);
  EXPECT_EQ(posted_.timing.durations.size(), without->timing.durations.size());
  const std::string stated = " time " + decimal(posted_.timing.seconds, 1) + " s)";
  EXPECT_NE(text_.find(stated), std::string::npos) << stated;
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
}

/// Where the first place is higher than the start would be, the table turns there, and it is the path's.
TEST_P(TcpStart, AHighFirstPlaceComesBackAsPath) {
  profile_.format.tcp_start_below = 5000.0;
  std::ostringstream out;
  posted_.posting.machine = profile_;
  ASSERT_TRUE(write_program(posted_.posting, out));
  const auto made = back(out.str(), profile_);
  ASSERT_TRUE(made) << made.error().message;
  for (std::size_t k = 0; k < made->operations.size(); ++k) {
    const Operation& op = posted_.posting.operations[k];
    const Pose want = pose_under_tcp(profile_.model, op.setup, op.words->moves.front().joints);
    EXPECT_LT(distance(made->operations[k].path.moves.front().pose.tip, want.tip), 0.02) << k;
  }
}

/// Without comments; `rapids`: also without feed, which turns of a nutating head cut into other blocks.
std::vector<std::string> motion_of(const std::string& text, bool rapids) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  bool feed = false;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("(") || line.starts_with("O")) continue;
    if (line.starts_with("G0") || line.starts_with("G1 ")) feed = line.starts_with("G1 ");
    if (!feed || !rapids) lines.push_back(line);
  }
  return lines;
}

/// A program and the CL text that is made of it are one path: posted again it is the same program. So where
/// the table turns low or with few decimals, and where a path begins with rapids that stand or turn the
/// table.
TEST_P(TcpStart, WhatComesBackIsPostedAsTheSameProgram) {
  AptProgram path = foreign();
  for (AptOperation& op : path.operations)
    std::erase_if(op.events, [](const PathEvent& event) { return event.kind == EventKind::kRemark; });
  AptProgram turning = path;
  // The second operation's first place, and then the table turned there by a rapid, the tip held; and again.
  AptOperation& op = turning.operations[1];
  for (const double y : {0.1, 0.2}) {
    Move move = op.path.moves.front();
    move.pose.axis = normalized(Vec3{-0.3, y, 0.9});
    op.path.moves.insert(op.path.moves.begin() + 1, move);
    op.lines.insert(op.lines.begin() + 1, op.lines.front());
    for (PathEvent& event : op.events)
      if (event.move > 0) ++event.move;
    for (FeedChange& feed : op.path.feeds) ++feed.move;
  }
  const double top = profile_.model.z.max;
  struct Case {
    const char* what;
    const AptProgram* path;
    double below;
    int decimals;
  };
  for (const Case& one :
       {Case{"as it is", &path, 50.0, 3}, Case{"below the first place", &path, 2.0 * top, 3},
        Case{"two decimals", &path, 50.0, 2}, Case{"a turn follows", &turning, 50.0, 3},
        Case{"a turn follows below", &turning, 2.0 * top, 3}}) {
    SCOPED_TRACE(one.what);
    MachineProfile profile = profile_;
    ProgramFormat& format = profile.format;
    format.tcp_start_below = one.below;
    format.linear_decimals = format.most_linear_decimals = one.decimals;
    format.rotary_decimals = format.most_rotary_decimals = one.decimals;
    const auto text = program_text(*one.path, profile, options_);
    ASSERT_TRUE(text) << text.error().message;
    UnpostOptions ends;  // the points of the program, none between
    ends.tolerance = 10.0, ends.axis_tolerance = 30.0;
    const auto made = back(*text, profile, ends);
    ASSERT_TRUE(made) << made.error().message;
    std::stringstream cl;
    write_apt(*made, cl);
    const auto read = read_apt(cl, "again.cls", {});
    ASSERT_TRUE(read) << read.error().message;
    const auto again = program_text(*read, profile, options_);
    ASSERT_TRUE(again) << again.error().message;
    const bool rapids = one.path == &turning;
    const std::vector<std::string> got = motion_of(*again, rapids), want = motion_of(*text, rapids);
    const auto [ours, theirs] = std::mismatch(got.begin(), got.end(), want.begin(), want.end());
    ASSERT_TRUE(got == want) << *ours << ", not " << *theirs;
  }
}

}  // namespace
}  // namespace tiltfeed
