// Programs in tilted planes, in every dialect that has them and on every kind of machine: the tip is where
// the CL text says, by both readers; what damages them is refused.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <regex>
#include <sstream>

#include "kinematics/basics/decimal.h"
#include "sim/control/control_reader.h"
#include "sim/control/program_frame.h"
#include "sim/motion/forward.h"
#include "tests/texts/posted.h"

namespace tiltfeed::sim {
namespace {

struct PlaneShop {
  Dialect dialect;
  const char* machine;
};

/// Travels wide enough for any of the paths below.
MachineProfile wide(const PlaneShop& shop) {
  MachineProfile profile = machine(shop.dialect, false, shop.machine);
  MachineModel& m = profile.model;
  for (LinearAxis* axis : {&m.x, &m.y, &m.z}) axis->min = -1500, axis->max = 1500;
  profile.format.tilted_planes = true;
  profile.solid = {};
  return profile;
}

/// Three directions that every machine here reaches, with a few cuts in each, and two tools.
AptProgram three_ways(const MachineProfile& profile, const Setup& setup) {
  const RotaryAxis &tilt = profile.model.tilt, &rotary = profile.model.rotary;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-40, 40);
  AptProgram program;
  program.name = "ways";
  for (int tool = 3; tool <= 4; ++tool) {
    AptOperation op;
    op.tool_number = tool;
    op.path.name = program.name;
    op.path.tool = {6, 3, 100.0 - tool};
    op.path.cut_feed = op.path.plunge_feed = Feed::from_mm_per_min(800);
    Setup longer = setup;
    longer.tool_length = op.path.tool.length;
    for (const double share : {0.3, 0.0, -0.4}) {
      const Joints at{0, 0, 0, tilt.present ? share * std::min(tilt.max, 90.0) : 0.0,
                      rotary.present ? 130.0 * share + tool : 0.0};
      const Vec3 axis = forward(profile.model, longer, at).axis;
      const auto go = [&](double up, MoveKind kind) {
        const Point<Part> tip{place(random), place(random), place(random) + up};
        op.path.moves.push_back({{tip, axis}, kind, kNoFacet});
      };
      go(80, MoveKind::kRapid);
      for (int i = 0; i < 5; ++i) go(0, MoveKind::kCut);
      go(80, MoveKind::kRapid);
    }
    op.path.feeds.push_back({0, Feed::from_mm_per_min(800)});
    op.events.push_back({0, EventKind::kSpindle, 5000, ""});
    for (std::size_t i = 0; i < op.path.moves.size(); ++i)
      op.lines.push_back(static_cast<std::uint32_t>(i + 1));
    program.operations.push_back(std::move(op));
  }
  return program;
}

class PlanePrograms : public testing::TestWithParam<PlaneShop> {
 protected:
  void SetUp() override {
    profile_ = wide(GetParam());
    options_.setup.part_zero = {12, -7, 30};
    options_.setup.fixture = fixture_of({0, 0, 90});
    path_ = three_ways(profile_, options_.setup);
    const auto posted = post(path_, "in.cls", profile_, options_);
    ASSERT_TRUE(posted) << posted.error().message;
    std::ostringstream out;
    const auto written = write_program(posted->posting, out);
    ASSERT_TRUE(written) << written.error().message;
    EXPECT_EQ(written->planes, 6u);
    text_ = out.str();
    job_.machine = profile_;
    job_.setup = options_.setup;
    job_.setup.tool_length = path_.operations[0].path.tool.length;
    job_.program.tool = 3;
    std::istringstream in(text_);
    for (std::string line; std::getline(in, line);) lines_.push_back(line);
  }
  /// What the judges say of the text; empty: it is sound.
  std::string fault(const std::vector<std::string>& lines) const {
    std::string all;
    for (const std::string& line : lines) all += line + "\n";
    std::istringstream frame(all), moves(all);
    if (const auto sound = check_frame(frame, "p.nc", std::span(&job_, 1)); !sound)
      return sound.error().message;
    ControlReader reader(profile_, job_.setup);
    const auto read = read_control_program(moves, "p.nc", reader, [](const ControlBlock&) {});
    return read ? "" : read.error().message;
  }
  using Damage = std::function<void(std::vector<std::string>&, std::size_t)>;
  int seed(const std::string& pattern, const Damage& damage) const {
    int seeded = 0;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (lines_[i].find("TILTFEED") != std::string::npos) continue;
      if (!std::regex_search(lines_[i], std::regex(pattern))) continue;
      std::vector<std::string> bad = lines_;
      damage(bad, i);
      EXPECT_NE(fault(bad), "") << i + 1 << ": " << lines_[i];
      ++seeded;
    }
    return seeded;
  }
  /// The first plane, whose tilt is not at home, with the other of two words for its side.
  std::vector<std::string> first_on_the_other_side(const std::string& one, const std::string& other) const {
    std::vector<std::string> bad = lines_;
    for (std::string& line : bad) {
      const std::size_t at = line.find(one), back = line.find(other);
      if (at == line.npos && back == line.npos) continue;
      if (at != line.npos)
        line.replace(at, one.size(), other);
      else
        line.replace(back, other.size(), one);
      break;
    }
    EXPECT_NE(bad, lines_);
    return bad;
  }
  bool tnc() const {
    return GetParam().dialect == Dialect::kHeidenhain || GetParam().dialect == Dialect::kHeidenhainIso;
  }

  MachineProfile profile_;
  PostOptions options_;
  AptProgram path_;
  std::string text_;
  std::vector<std::string> lines_;
  Job job_;
};

INSTANTIATE_TEST_SUITE_P(
    Shops, PlanePrograms,
    testing::Values(
        PlaneShop{Dialect::kFanuc, "generic-ac"}, PlaneShop{Dialect::kFanuc, "dmu-nutating-bc"},
        PlaneShop{Dialect::kFanuc, "linuxcnc-trunnion-ac"}, PlaneShop{Dialect::kFanuc, "linuxcnc-bridge-bc"},
        PlaneShop{Dialect::kHaas, "linuxcnc-trunnion-ac"}, PlaneShop{Dialect::kHaas, "mill-4x-table-a"},
        PlaneShop{Dialect::kSiemens, "generic-ac"}, PlaneShop{Dialect::kSiemens, "dmu-nutating-bc"},
        PlaneShop{Dialect::kSiemens, "linuxcnc-trunnion-ac"},
        PlaneShop{Dialect::kHeidenhain, "dmu-nutating-bc"}, PlaneShop{Dialect::kHeidenhain, "mill-4x-head-b"},
        PlaneShop{Dialect::kHeidenhain, "linuxcnc-bridge-bc"},
        PlaneShop{Dialect::kHeidenhainIso, "generic-ac"}),
    [](const testing::TestParamInfo<PlaneShop>& one) {
      std::string name = std::string(name_of(one.param.dialect).name) + "_" + one.param.machine;
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

/// Half of a last decimal of each word, and those of both rotaries at the end of the tool's lever.
constexpr double kRoundedTip = 2e-3, kRoundedAxis = 1e-4;

/// Each place of the CL text is met in its order, of `poses`.
void expect_met(const AptProgram& path, const std::vector<Pose>& poses, double within = kRoundedTip) {
  std::size_t at = 0;
  for (const AptOperation& op : path.operations)
    for (const Move& move : op.path.moves) {
      const auto met =
          std::find_if(poses.begin() + static_cast<std::ptrdiff_t>(at), poses.end(), [&](const Pose& pose) {
            return distance(pose.tip, move.pose.tip) < within &&
                   length(pose.axis - move.pose.axis) < kRoundedAxis;
          });
      ASSERT_NE(met, poses.end()) << "tip " << move.pose.tip.x << " " << move.pose.tip.y << " "
                                  << move.pose.tip.z;
      at = static_cast<std::size_t>(met - poses.begin());
    }
}

TEST_P(PlanePrograms, TheTipIsWhereTheClTextSays) {
  std::istringstream in(text_);
  ControlReader reader(profile_, job_.setup);
  std::vector<Pose> poses;
  std::size_t feeds = 0;
  // The second tool is shorter: its places are read with its own set-up below.
  std::vector<ControlBlock> blocks;
  const auto read =
      read_control_program(in, "p.nc", reader, [&](const ControlBlock& block) { blocks.push_back(block); });
  ASSERT_TRUE(read) << read.error().message;
  AptProgram first = path_;
  first.operations.pop_back();
  for (const ControlBlock& block : blocks) {
    if (block.block.op != Op::kFeed && block.block.op != Op::kRapid) continue;
    EXPECT_FALSE(block.tcp);
    if (block.block.op == Op::kFeed) {
      EXPECT_NEAR(block.block.feed, 800, 0.1);
      ++feeds;
    }
    poses.push_back(forward_by_frames(profile_.model, job_.setup, block.block.target));
  }
  EXPECT_EQ(feeds, 30u) << "five cuts in each of three planes, with two tools";
  expect_met(first, poses);

  const auto read_back = back(text_, profile_);
  ASSERT_TRUE(read_back) << read_back.error().message;
  poses.clear();
  for (const AptOperation& op : read_back->operations) {
    EXPECT_EQ(op.path.moves.size(), 21u);
    for (const Move& move : op.path.moves) poses.push_back(move.pose);
    for (const FeedChange& change : op.path.feeds) EXPECT_NEAR(change.feed.mm_per_min(), 800, 0.1);
  }
  expect_met(path_, poses);
}

TEST_P(PlanePrograms, InInchesTheTipIsThere) {
  profile_.format.inches = true;
  ++profile_.format.linear_decimals;
  const auto text = program_text(path_, profile_, options_);
  ASSERT_TRUE(text) << text.error().message;
  const auto read_back = back(*text, profile_);
  ASSERT_TRUE(read_back) << read_back.error().message;
  std::vector<Pose> poses;
  for (const AptOperation& op : read_back->operations) {
    for (const Move& move : op.path.moves) poses.push_back(move.pose);
    for (const FeedChange& change : op.path.feeds) EXPECT_NEAR(change.feed.mm_per_min(), 800, 0.1);
  }
  expect_met(path_, poses, 3e-3);  // fanuc: half of 0.0001 inch in each word
  EXPECT_NE(*text, text_);
  EXPECT_FALSE(back(*text, wide(GetParam()))) << "a profile in mm";
}

TEST_P(PlanePrograms, WhatItLosesIsFound) {
  ASSERT_EQ(fault(lines_), "");
  const auto drop = [](std::vector<std::string>& lines, std::size_t at) {
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(at));
  };
  const int planes = 6;
  switch (GetParam().dialect) {
    case Dialect::kFanuc:
      EXPECT_EQ(seed("^G68.2", drop), planes);
      EXPECT_EQ(seed("^G53.1", drop), planes);
      EXPECT_EQ(seed("^G69", drop), planes + 1);
      EXPECT_EQ(seed("^G49", drop), planes + 1);
      break;
    case Dialect::kHaas:
      EXPECT_EQ(seed("^G254", drop), planes);
      EXPECT_EQ(seed("^G255", drop), planes + 1);
      EXPECT_EQ(seed("^G49", drop), planes + 1);
      break;
    case Dialect::kSiemens:
      EXPECT_EQ(seed("^CYCLE800[(]0", drop), planes);
      EXPECT_EQ(seed("^CYCLE800[(][)]", drop), planes + 1);
      EXPECT_EQ(seed("^D1$", drop), planes);
      break;
    default:
      EXPECT_EQ(seed("PLANE SPATIAL", drop), planes);
      EXPECT_EQ(seed("PLANE RESET", drop), planes + 1);
  }
  EXPECT_EQ(seed("G28|G53 Z|SUPA|M91", drop), planes + 1) << "each retract";
  EXPECT_EQ(seed("^([0-9]+ L|N[0-9]+ G00|G0) X[^ ]* Y[^ ]*( R0 FMAX|[*])?$", drop), planes)
      << "X and Y at the retract";
}

TEST_P(PlanePrograms, AnAngleOrASideThatIsNotTheMachinesIsFound) {
  if (GetParam().dialect == Dialect::kHaas) return;  // its plane is stated by no angles
  // Rotaries that stand elsewhere than the plane says.
  const auto turn = [](const std::string& letter) {
    return [letter](std::vector<std::string>& lines, std::size_t at) {
      const std::size_t word = lines[at].find(letter) + letter.size();
      std::size_t end = 0;
      const double value = std::stod(lines[at].substr(word), &end);
      std::string text = decimal(value + 0.05, 3);
      if (tiltfeed::daemon::table_of(Dialect::kFanuc).point && text.find('.') == text.npos) text += '.';
      if (lines[at][word] == '+' && text[0] != '-') text = "+" + text;
      lines[at].replace(word, end, text);
    };
  };
  if (profile_.model.tilt.present) {
    const std::string tilt = std::string(" ") + profile_.model.tilt.letter;
    EXPECT_EQ(seed("^(N?[0-9]+ )?(G0+|L)" + tilt, turn(tilt)), 6);
  }
  const auto swap = [](const std::string& from, const std::string& to) {
    return [from, to](std::vector<std::string>& lines, std::size_t at) {
      lines[at].replace(lines[at].find(from), from.size(), to);
    };
  };
  if (!profile_.model.tilt.present) return;
  if (tnc()) {
    EXPECT_NE(fault(first_on_the_other_side("SEQ+", "SEQ-")), "");
    EXPECT_EQ(seed("STAY SEQ", swap("STAY", "MOVE")), 6);
  }
  if (GetParam().dialect == Dialect::kSiemens) {
    EXPECT_NE(fault(first_on_the_other_side(",1,0)", ",-1,0)")), "");
  }
  if (GetParam().dialect == Dialect::kFanuc) {
    EXPECT_EQ(seed("^G68.2", swap(" J", " J1")), 6);
  }
}

/// Of several swivel data a Sinumerik takes those of the name.
TEST_P(PlanePrograms, TheSwivelDataAreTheProfiles) {
  if (GetParam().dialect != Dialect::kSiemens) return;
  EXPECT_NE(text_.find("CYCLE800(0,\"\",0,27,"), text_.npos) << "none are stated";
  const MachineProfile unnamed = profile_;
  profile_.format.swivel_data = "HEAD_2.B-1";
  const auto text = program_text(path_, profile_, options_);
  ASSERT_TRUE(text) << text.error().message;
  std::vector<std::string> named;
  std::istringstream in(*text);
  for (std::string line; std::getline(in, line);) named.push_back(line);
  job_.machine = profile_;
  ASSERT_EQ(fault(named), "");
  int calls = 0;
  for (std::size_t i = 0; i < named.size(); ++i) {
    if (!named[i].starts_with("CYCLE800(0")) continue;
    EXPECT_TRUE(named[i].starts_with("CYCLE800(0,\"HEAD_2.B-1\",0,27,")) << named[i];
    ++calls;
    for (const char* other : {"\"HEAD_2.B-2\"", "\"\"", "\"0\""}) {
      std::vector<std::string> bad = named;
      bad[i].replace(bad[i].find('"'), 12, other);
      EXPECT_NE(fault(bad), "") << bad[i];
      std::string all;
      for (const std::string& line : bad) all += line + "\n";
      EXPECT_FALSE(back(all, profile_)) << bad[i];
    }
  }
  EXPECT_EQ(calls, 6);
  const auto read_back = back(*text, profile_);
  ASSERT_TRUE(read_back) << read_back.error().message;
  std::vector<Pose> poses;
  for (const AptOperation& op : read_back->operations)
    for (const Move& move : op.path.moves) poses.push_back(move.pose);
  expect_met(path_, poses);
  job_.machine = unnamed;
  EXPECT_NE(fault(named).find("program.swivel_data is \"\""), std::string::npos) << fault(named);
  EXPECT_TRUE(back(*text, unnamed)) << "a profile that states none says nothing of others' programs";
}

/// The retract goes along the machine's Z: a tool that lies in its cut would be drawn through the part.
TEST_P(PlanePrograms, AToolInItsCutIsNotRetracted) {
  AptProgram deep = path_;
  AptOperation& op = deep.operations[1];
  op.path.moves.erase(op.path.moves.begin() + 6),
      op.lines.erase(op.lines.begin() + 6);  // the first way's last rapid
  const auto refused = program_text(deep, profile_, options_);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("in.cls:6: the tool is to be retracted"), std::string::npos)
      << refused.error().message;
}

TEST_P(PlanePrograms, ACutThatTurnsTheToolIsPostedWithoutPlanes) {
  if (!profile_.model.tilt.present || !profile_.model.rotary.present) return;  // turns no tool
  AptProgram bent = path_;
  bent.operations[1].path.moves[3].pose.axis = bent.operations[1].path.moves[9].pose.axis;
  const auto text = program_text(bent, profile_, options_);
  ASSERT_TRUE(text) << text.error().message;
  for (const char* word : {"G68.2", "G254", "CYCLE800", "SPATIAL"}) EXPECT_EQ(text->find(word), text->npos);
}

}  // namespace
}  // namespace tiltfeed::sim
