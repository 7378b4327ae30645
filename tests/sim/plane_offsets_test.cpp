// Tilted planes with a work offset each, in every dialect: which offset is called where, what the readers
// make of it, and which of its faults they find.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <regex>
#include <sstream>

#include "sim/control/control_reader.h"
#include "sim/control/program_frame.h"
#include "sim/motion/forward.h"
#include "tests/texts/posted.h"

namespace tiltfeed::sim {
namespace {

struct OffsetShop {
  Dialect dialect;
  const char* machine;
  int first;                        ///< work offset of the first plane
  std::vector<std::string> called;  ///< how those from the first on are called
};

const std::vector<OffsetShop> kOffsetShops{
    {Dialect::kFanuc, "generic-ac", 5, {"G58", "G59", "G54.1 P1"}},
    {Dialect::kHaas, "linuxcnc-trunnion-ac", 6, {"G59", "G154 P1", "G154 P2"}},
    {Dialect::kSiemens, "dmu-nutating-bc", 3, {"G56", "G57", "G505"}},
    {Dialect::kHeidenhain, "generic-ac", 7, {"Q339=+7", "Q339=+8", "Q339=+9"}},
    {Dialect::kHeidenhainIso, "linuxcnc-bridge-bc", 1, {"Q339=+1", "Q339=+2", "Q339=+3"}}};

/// Directions 1, 2, 3, the second tool 3, 1 a whole turn on where the rotary has that room, 2.
class PlaneOffsets : public testing::TestWithParam<OffsetShop> {
 protected:
  void SetUp() override {
    profile_ = machine(GetParam().dialect, false, GetParam().machine);
    MachineModel& m = profile_.model;
    for (LinearAxis* axis : {&m.x, &m.y, &m.z}) axis->min = -1500, axis->max = 1500;
    profile_.format.tilted_planes = true;
    profile_.solid = {};
    options_.setup.part_zero = {12, -7, 30};
    options_.data.work_offset = GetParam().first;
    options_.data.plane_offsets = true;
    for (const auto& [tool, ways] : {std::pair{3, std::vector<int>{1, 2, 3}}, {4, {3, 1, 2}}})
      add(tool, ways);
    const auto text = program_text(path_, profile_, options_);
    ASSERT_TRUE(text) << text.error().message;
    text_ = *text;
    lines_ = lines_of(text_);
    job_.machine = profile_;
    job_.setup = options_.setup;
    job_.setup.tool_length = 97;
    job_.program.tool = 3;
    job_.program.work_offset = GetParam().first;
    job_.program.plane_offsets = true;
  }
  void add(int tool, const std::vector<int>& ways) {
    AptOperation op;
    op.tool_number = tool;
    op.path.name = path_.name = "ways";
    op.path.tool = {6, 3, 100.0 - tool};
    op.path.cut_feed = op.path.plunge_feed = Feed::from_mm_per_min(800);
    tiltfeed::Setup longer = options_.setup;
    longer.tool_length = op.path.tool.length;
    for (const int way : ways) {
      const Joints at{0, 0, 0, 15.0 * way, 40.0 * way};
      const Vec3 axis = forward(profile_.model, longer, at).axis;
      for (const double up : {60.0, 0.0, 0.0, 60.0}) {
        const double i = static_cast<double>(op.path.moves.size());
        const MoveKind kind = up > 0.0 ? MoveKind::kRapid : MoveKind::kCut;
        op.path.moves.push_back({{{2.0 * i, 5.0 - i, i + up}, axis}, kind, kNoFacet});
        op.lines.push_back(static_cast<std::uint32_t>(i + 1));
      }
    }
    op.path.feeds.push_back({0, Feed::from_mm_per_min(800)});
    op.events.push_back({0, EventKind::kSpindle, 5000, ""});
    path_.operations.push_back(std::move(op));
  }
  static std::string joined(const std::vector<std::string>& lines) {
    std::string all;
    for (const std::string& line : lines) all += line + "\n";
    return all;
  }
  /// What the judges say of the text; empty: it is sound.
  std::string fault(const std::vector<std::string>& lines) const {
    std::istringstream frame(joined(lines)), moves(joined(lines));
    if (const auto sound = check_frame(frame, "p.nc", std::span(&job_, 1)); !sound)
      return sound.error().message;
    ControlReader reader(profile_, job_.setup);
    const auto read = read_control_program(moves, "p.nc", reader, [](const ControlBlock&) {});
    return read ? "" : read.error().message;
  }
  bool comment(const std::string& line) const { return line.find("TILTFEED") != line.npos; }
  /// Of the offsets from 0 on; -1: the line calls none.
  int called(const std::string& line) const {
    for (std::size_t i = 0; i < GetParam().called.size(); ++i) {
      const std::string& word = GetParam().called[i];
      const std::size_t at = line.find(word);
      if (at == line.npos || comment(line)) continue;
      const std::size_t end = at + word.size();
      if (end == line.size() || line[end] == ' ' || line[end] == '*') return static_cast<int>(i);
    }
    return -1;
  }
  std::vector<std::size_t> calls() const {
    std::vector<std::size_t> at;
    for (std::size_t i = 0; i < lines_.size(); ++i)
      if (called(lines_[i]) >= 0) at.push_back(i);
    return at;
  }
  /// The line with the call of another offset.
  std::string with(std::string line, int other) const {
    const std::string from = GetParam().called[static_cast<std::size_t>(called(line))];
    return line.replace(line.find(from), from.size(), GetParam().called[static_cast<std::size_t>(other)]);
  }

  MachineProfile profile_;
  PostOptions options_;
  AptProgram path_;
  std::string text_;
  std::vector<std::string> lines_;
  Job job_;
};

INSTANTIATE_TEST_SUITE_P(Shops, PlaneOffsets, testing::ValuesIn(kOffsetShops),
                         [](const testing::TestParamInfo<OffsetShop>& one) {
                           return std::string(name_of(one.param.dialect).name);
                         });

TEST_P(PlaneOffsets, EachPlaneHasItsOwn) {
  std::vector<int> offsets;
  for (const std::size_t at : calls()) offsets.push_back(called(lines_[at]));
  EXPECT_EQ(offsets, (std::vector<int>{0, 1, 2, 0, 1}))
      << "the second tool begins in the plane of the first\n"
      << text_;
  int planes = 0, force = -1;
  for (const std::string& line : lines_) {
    if (const int one = called(line); one >= 0) force = one;
    if (comment(line) || !std::regex_search(line, std::regex("G68.2|G254|CYCLE800[(]0|PLANE SPATIAL")))
      continue;
    EXPECT_EQ(force, (std::vector<int>{0, 1, 2, 2, 0, 1}[static_cast<std::size_t>(planes++)])) << line;
  }
  EXPECT_EQ(planes, 6);
  EXPECT_EQ(fault(lines_), "");
  std::size_t said = 0;
  for (const std::string& line : lines_) said += line.find("TILTFEED work offset ") != line.npos;
  EXPECT_EQ(said, 3u);
}

TEST_P(PlaneOffsets, TheTipIsWhereTheClTextSays) {
  const auto read = back(text_, profile_);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->notes.size(), 1u);
  EXPECT_TRUE(read->notes[0].starts_with("3 planes have work offsets of their own")) << read->notes[0];
  ASSERT_EQ(read->operations.size(), path_.operations.size());
  for (std::size_t i = 0; i < path_.operations.size(); ++i) {
    std::size_t at = 0;
    for (const Move& move : path_.operations[i].path.moves) {
      const auto& moves = read->operations[i].path.moves;
      while (at < moves.size() && distance(moves[at].pose.tip, move.pose.tip) > 2e-3) ++at;
      EXPECT_LT(at, moves.size()) << move.pose.tip.x << " " << move.pose.tip.y << " " << move.pose.tip.z;
    }
  }
  std::istringstream in(text_);
  ControlReader reader(profile_, job_.setup);
  std::size_t feeds = 0;
  const auto moved = read_control_program(in, "p.nc", reader, [&](const ControlBlock& block) {
    if (block.block.op != Op::kFeed || feeds >= 6) return;  // the second tool is shorter
    const auto& moves = path_.operations[0].path.moves;
    const Pose tip = forward_by_frames(profile_.model, job_.setup, block.block.target);
    EXPECT_LT(distance(tip.tip, moves[feeds / 2 * 4 + 1 + feeds % 2].pose.tip), 2e-3);
    ++feeds;
  });
  EXPECT_TRUE(moved);
  EXPECT_EQ(feeds, 6u);
}

TEST_P(PlaneOffsets, AMissingOrSwappedOneIsFound) {
  const std::vector<std::size_t> calls_there = calls();
  ASSERT_EQ(calls_there.size(), 5u);
  for (std::size_t call = 0; call < calls_there.size(); ++call) {
    const std::size_t at = calls_there[call];
    if (call > 0) {
      std::vector<std::string> lost = lines_;
      const bool cycle = GetParam().dialect == Dialect::kHeidenhain;
      lost.erase(lost.begin() + static_cast<std::ptrdiff_t>(at - (cycle ? 1 : 0)),
                 lost.begin() + static_cast<std::ptrdiff_t>(at + 1));
      EXPECT_NE(fault(lost), "") << "without " << lines_[at];
      EXPECT_FALSE(back(joined(lost), profile_)) << "without " << lines_[at];
    }
    for (int other = 0; other < 3; ++other) {
      if (other == called(lines_[at])) continue;
      std::vector<std::string> bad = lines_;
      bad[at] = with(lines_[at], other);
      EXPECT_NE(fault(bad), "") << bad[at] << " for " << lines_[at];
      EXPECT_FALSE(back(joined(bad), profile_)) << bad[at] << " for " << lines_[at];
    }
  }
  for (std::size_t one = 0; one < 3; ++one)
    for (std::size_t other = one + 1; other < 3; ++other) {
      std::vector<std::string> bad = lines_;
      bad[calls_there[one]] = with(lines_[calls_there[one]], static_cast<int>(other));
      bad[calls_there[other]] = with(lines_[calls_there[other]], static_cast<int>(one));
      EXPECT_NE(fault(bad), "") << "swapped " << one << " " << other;
      EXPECT_FALSE(back(joined(bad), profile_)) << "swapped " << one << " " << other;
    }
}

TEST_P(PlaneOffsets, OneBehindTheWayToThePlaneIsFound) {
  const std::size_t at = calls()[1];
  const bool cycle = GetParam().dialect == Dialect::kHeidenhain;
  const std::size_t from = at - (cycle ? 1 : 0), count = cycle ? 2 : 1;
  std::vector<std::string> bad = lines_;
  const std::vector<std::string> call(bad.begin() + static_cast<std::ptrdiff_t>(from),
                                      bad.begin() + static_cast<std::ptrdiff_t>(from + count));
  bad.erase(bad.begin() + static_cast<std::ptrdiff_t>(from),
            bad.begin() + static_cast<std::ptrdiff_t>(from + count));
  bad.insert(bad.begin() + static_cast<std::ptrdiff_t>(from + 1), call.begin(), call.end());
  EXPECT_NE(fault(bad).find("behind the way of the axes"), std::string::npos) << fault(bad) << joined(bad);
}

TEST_P(PlaneOffsets, TheJobSaysWhether) {
  job_.program.plane_offsets = false;
  EXPECT_NE(fault(lines_).find("the job's program.work_offset is"), std::string::npos) << fault(lines_);
  job_.program.plane_offsets = true;
  options_.data.plane_offsets = false;
  const auto plain = program_text(path_, profile_, options_);
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_NE(fault(lines_of(*plain)).find("program.plane_offsets"), std::string::npos)
      << fault(lines_of(*plain));
  EXPECT_TRUE(back(*plain, profile_));
}

TEST_P(PlaneOffsets, WhatCannotBeIsRefused) {
  options_.data.work_offset = most_work_offsets(GetParam().dialect) - 1;
  const auto more = program_text(path_, profile_, options_);
  ASSERT_FALSE(more);
  EXPECT_NE(more.error().message.find("3 planes need the work offsets"), std::string::npos)
      << more.error().message;
  --options_.data.work_offset;
  EXPECT_TRUE(program_text(path_, profile_, options_));
  path_.operations[0].path.moves[2].pose.axis = path_.operations[0].path.moves[5].pose.axis;
  const auto turned = program_text(path_, profile_, options_);
  ASSERT_FALSE(turned);
  EXPECT_NE(turned.error().message.find("program.plane_offsets: false"), std::string::npos)
      << turned.error().message;
}

TEST(PlaneOffsetKeys, ControlsWithoutPlanesAreRefusedByName) {
  ProgramData data;
  data.plane_offsets = true;
  for (const DialectName& one : kDialects) {
    ProgramFormat format = usual_format(one.dialect);
    format.tilted_planes = has_tilted_planes(one.dialect);
    const auto wrong = not_of_control(data, format, "m.yaml");
    if (format.tilted_planes) {
      EXPECT_TRUE(wrong.empty()) << one.name;
      format.tilted_planes = false;
      ASSERT_EQ(not_of_control(data, format, "m.yaml").size(), 1u) << one.name;
      continue;
    }
    ASSERT_EQ(wrong.size(), 1u) << one.name;
    EXPECT_STREQ(wrong[0].first, "plane_offsets");
    EXPECT_TRUE(wrong[0].second.starts_with(std::string(one.name) + " has no words for a tilted plane"));
  }
}

}  // namespace
}  // namespace tiltfeed::sim
