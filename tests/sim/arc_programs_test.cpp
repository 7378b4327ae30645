// Programs with arcs, in every dialect and in tilted planes: the judges' reader and the postprocessor's own
// find the tool's way where the CL text says it; each kind of damage to an arc is refused, or seen as another
// way.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <regex>
#include <sstream>

#include "daemon/post/nc_arcs.h"
#include "sim/control/control_reader.h"
#include "sim/control/program_frame.h"
#include "sim/gcode/arc_way.h"
#include "sim/motion/forward.h"
#include "tests/shapes/aside.h"
#include "tests/texts/posted.h"

namespace tiltfeed::sim {
namespace {

constexpr double kArcShare = 0.003, kPostTolerance = 0.01, kTipFeed = 900.0;
// Chords of the CL text here, and what the words of places and planes are rounded by.
constexpr double kStated = 0.0015, kPrinted = 0.0025;

struct ArcShop {
  Dialect dialect;
  const char* machine;
  bool planes;
};

/// A lying 8 of two circles, a bow up and down in X Z, one in Y Z, and lines between: in the frame of a tool
/// that leans by `lean` degrees.
AptProgram bows(double lean) {
  const double s = std::sin(lean * std::numbers::pi / 180), c = std::cos(lean * std::numbers::pi / 180);
  AptProgram program;
  program.name = "bows";
  AptOperation op;
  op.tool_number = 3;
  op.path.name = program.name;
  op.path.tool = {6, 3, 100.0};
  op.path.cut_feed = op.path.plunge_feed = Feed::from_mm_per_min(kTipFeed);
  const auto go = [&](double x, double y, double z, MoveKind kind = MoveKind::kCut) {
    op.path.moves.push_back({{Point<Part>{c * x + s * z, y, c * z - s * x}, Vec3{s, 0, c}}, kind, kNoFacet});
  };
  const auto round = [&](double radius, double begin, double turn,
                         const std::function<void(double, double)>& put) {
    const int steps = static_cast<int>(std::ceil(std::abs(turn) / std::sqrt(8 * kStated / radius)));
    for (int i = 0; i <= steps; ++i) {
      const double at = (begin + turn * i / steps) * 1.0;
      put(radius * std::cos(at), radius * std::sin(at));
    }
  };
  const double pi = std::numbers::pi;
  go(0, 0, 60, MoveKind::kRapid);
  go(0, 0, 0);
  round(15, pi, 2 * pi, [&](double u, double v) { go(15 + u, v, 0); });
  round(12, 0, -2 * pi, [&](double u, double v) { go(u - 12, v, 0); });
  go(20, 5, 0);
  round(10, -pi / 2, pi, [&](double u, double v) { go(20 + u, 5, 10 + v); });
  go(0, 5, 20);
  round(8, pi / 2, -pi / 2, [&](double u, double v) { go(0, 5 + u, 12 + v); });
  go(-20, 5, 12);
  go(-20, 5, 60, MoveKind::kRapid);
  op.path.feeds.push_back({0, Feed::from_mm_per_min(kTipFeed)});
  op.events.push_back({0, EventKind::kSpindle, 5000, ""});
  for (std::size_t i = 0; i < op.path.moves.size(); ++i)
    op.lines.push_back(static_cast<std::uint32_t>(i + 1));
  program.operations.push_back(std::move(op));
  return program;
}

double off_polyline(Point<Part> p, const std::vector<Point<Part>>& way) {
  double least = 1e9;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Point<Part>&a = way[i - 1], &b = way[i];
    if (lies_aside(p.x, a.x, b.x, least) || lies_aside(p.y, a.y, b.y, least) ||
        lies_aside(p.z, a.z, b.z, least))
      continue;
    least = std::min(least, distance_to_segment(p, a, b));
  }
  return least;
}

class ArcPrograms : public testing::TestWithParam<ArcShop> {
 protected:
  void SetUp() override {
    const auto& [dialect, machine_name, planes] = GetParam();
    profile_ = machine(dialect, false, machine_name);
    MachineModel& m = profile_.model;
    for (LinearAxis* axis : {&m.x, &m.y, &m.z}) axis->min = -1500, axis->max = 1500;
    profile_.format.tilted_planes = planes;
    profile_.solid = {};
    options_.setup.part_zero = {12, -7, 30};
    options_.setup.fixture = fixture_of({0, 0, 90});
    options_.tolerance = kPostTolerance;
    options_.data.arc_tolerance = kArcShare;
    path_ = bows(planes ? 20.0 : 0.0);
    const auto posted = post(path_, "in.cls", profile_, options_);
    ASSERT_TRUE(posted) << posted.error().message;
    std::ostringstream out;
    const auto written = write_program(posted->posting, out);
    ASSERT_TRUE(written) << written.error().message;
    report_ = *written;
    text_ = out.str();
    // What the program states, too: it may have more decimals than the profile.
    job_.machine = posted->posting.machine;
    job_.setup = options_.setup;
    job_.setup.tool_length = 100.0;
    job_.program.tool = 3;
    std::istringstream in(text_);
    for (std::string line; std::getline(in, line);) lines_.push_back(line);
    for (const Move& move : path_.operations[0].path.moves) stated_.push_back(move.pose.tip);
  }
  static std::string joined(const std::vector<std::string>& lines) {
    std::string all;
    for (const std::string& line : lines) all += line + "\n";
    return all;
  }
  /// What the judges refuse of the text; empty: nothing.
  std::string refused(const std::string& text, std::vector<Point<Part>>* tips = nullptr) const {
    std::istringstream frame(text), moves(text);
    if (const auto sound = check_frame(frame, "p.nc", {&job_, 1}); !sound) return sound.error().message;
    ControlReader reader(profile_, job_.setup);
    const auto read = read_control_program(moves, "p.nc", reader, [&](const ControlBlock& one) {
      const bool cuts = one.block.op == Op::kFeed;
      if (cuts && tips != nullptr)
        tips->push_back(forward_by_frames(profile_.model, job_.setup, one.block.target).tip);
    });
    return read ? "" : read.error().message;
  }
  /// How far the judges' way is from the stated one, mm; what they refuse is endlessly far.
  double off(const std::string& text) const {
    std::vector<Point<Part>> tips;
    if (!refused(text, &tips).empty()) return 1e9;
    double most = 0.0;
    for (const Point<Part>& tip : tips) most = std::max(most, off_polyline(tip, stated_));
    // And that nothing of it is missing: its cuts alone.
    for (std::size_t i = 1; i + 1 < stated_.size(); ++i)
      most = std::max(most, off_polyline(stated_[i], tips));
    return most;
  }
  /// The same by the postprocessor's own reader.
  double off_by_own_reader(const std::string& text) const {
    UnpostOptions options;
    options.tolerance = 1e-4;
    const auto read = back(text, profile_, options);
    if (!read) return 1e9;
    double most = 0.0;
    std::vector<Point<Part>> tips;
    for (const Move& move : read->operations[0].path.moves)
      if (move.kind != MoveKind::kRapid) tips.push_back(move.pose.tip);
    for (const Point<Part>& tip : tips) most = std::max(most, off_polyline(tip, stated_));
    for (std::size_t i = 1; i + 1 < stated_.size(); ++i)
      most = std::max(most, off_polyline(stated_[i], tips));
    return most;
  }
  bool tnc() const {
    return GetParam().dialect == Dialect::kHeidenhain || GetParam().dialect == Dialect::kHeidenhainIso;
  }
  bool one_plane() const { return tnc() || GetParam().dialect == Dialect::kSiemens; }
  /// The lines that are arcs.
  std::vector<std::size_t> arcs() const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < lines_.size(); ++i)
      if (std::regex_search(lines_[i], std::regex("(^| )(G0?[23] |C X)")) && lines_[i][0] != '(')
        found.push_back(i);
    return found;
  }
  /// Every arc with this damage is refused or seen, by both readers.
  void expect_seen(const char* what,
                   const std::function<bool(std::vector<std::string>&, std::size_t)>& damage,
                   std::size_t least, bool by_own_reader = true) const {
    std::size_t seeded = 0;
    for (const std::size_t at : arcs()) {
      std::vector<std::string> bad = lines_;
      if (!damage(bad, at)) continue;
      ++seeded;
      EXPECT_NE(bad, lines_);
      EXPECT_GT(off(joined(bad)), kPostTolerance) << what << ": " << lines_[at];
      if (by_own_reader) {
        EXPECT_GT(off_by_own_reader(joined(bad)), kPostTolerance) << what << ", own reader: " << lines_[at];
      }
    }
    EXPECT_GE(seeded, least) << what;
  }

  MachineProfile profile_;
  PostOptions options_;
  AptProgram path_;
  ProgramReport report_;
  std::string text_;
  std::vector<std::string> lines_;
  std::vector<Point<Part>> stated_;
  Job job_;
};

INSTANTIATE_TEST_SUITE_P(Shops, ArcPrograms,
                         testing::Values(ArcShop{Dialect::kRs274, "generic-ac", false},
                                         ArcShop{Dialect::kGrbl, "generic-ac", false},
                                         ArcShop{Dialect::kFanuc, "generic-ac", false},
                                         ArcShop{Dialect::kHaas, "generic-ac", false},
                                         ArcShop{Dialect::kSiemens, "generic-ac", false},
                                         ArcShop{Dialect::kHeidenhain, "generic-ac", false},
                                         ArcShop{Dialect::kHeidenhainIso, "generic-ac", false},
                                         ArcShop{Dialect::kRs274, "linuxcnc-trunnion-ac", false},
                                         ArcShop{Dialect::kFanuc, "dmu-nutating-bc", true},
                                         ArcShop{Dialect::kHaas, "linuxcnc-trunnion-ac", true},
                                         ArcShop{Dialect::kSiemens, "generic-ac", true},
                                         ArcShop{Dialect::kHeidenhain, "linuxcnc-bridge-bc", true},
                                         ArcShop{Dialect::kHeidenhainIso, "generic-ac", true}),
                         [](const testing::TestParamInfo<ArcShop>& one) {
                           std::string name = std::string(name_of(one.param.dialect).name) + "_" +
                                              one.param.machine + (one.param.planes ? "_planes" : "");
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(ArcPrograms, BothReadersFindTheWayOfTheClText) {
  EXPECT_EQ(refused(text_), "");
  EXPECT_LE(off(text_), kPostTolerance);
  EXPECT_LE(off_by_own_reader(text_), kPostTolerance);
  // Two circles of three arcs each; the bows where the control has arcs in their planes, and the plane that
  // leans has its axes along them.
  EXPECT_EQ(report_.arcs, arcs().size());
  EXPECT_GE(arcs().size(), one_plane() || GetParam().planes ? 6u : 9u);
  EXPECT_GT(report_.arcs_stand_for, 20 * report_.arcs);
  std::ostringstream plain;
  options_.data.arc_tolerance = 0.0;
  const auto straight = post(path_, "in.cls", profile_, options_);
  ASSERT_TRUE(straight);
  const auto written = write_program(straight->posting, plain);
  ASSERT_TRUE(written);
  EXPECT_EQ(written->arcs, 0u);
  EXPECT_LT(report_.blocks * (one_plane() || GetParam().planes ? 3 : 5), written->blocks);
}

/// The judges' time of the cuts is that of the way at the stated feed.
TEST_P(ArcPrograms, AnArcTakesTheTimeOfItsWay) {
  std::istringstream in(text_);
  ControlReader reader(profile_, job_.setup);
  double seconds = 0.0, way = 0.0, arc_seconds = 0.0;
  std::size_t pieces = 0;
  Joints at;
  const auto read = read_control_program(in, "p.nc", reader, [&](const ControlBlock& one) {
    const Block& block = one.block;
    if (block.op == Op::kFeed) {
      const double length = std::hypot(block.target.x - at.x, block.target.y - at.y, block.target.z - at.z);
      const double took = block.inverse_time ? 60.0 / block.feed : 60.0 * length / block.feed;
      seconds += took, way += length;
      if (block.goes_on) arc_seconds += took, ++pieces;
    }
    at = block.target;
  });
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_NEAR(seconds, way * 60.0 / kTipFeed, 2e-3 * seconds);
  EXPECT_GT(pieces, 100u);
  EXPECT_GT(arc_seconds, 0.5 * seconds);
  const auto own = back(text_, profile_);
  ASSERT_TRUE(own);
  for (const FeedChange& change : own->operations[0].path.feeds)
    EXPECT_NEAR(change.feed.mm_per_min(), kTipFeed, 3e-3 * kTipFeed);
}

TEST_P(ArcPrograms, ADamagedArcIsSeen) {
  const auto replaced = [](const std::string& from, const std::string& to) {
    return [from, to](std::vector<std::string>& bad, std::size_t at) {
      const std::string line = std::regex_replace(bad[at], std::regex(from), to);
      if (line == bad[at]) return false;
      bad[at] = line;
      return true;
    };
  };
  // The other way round.
  const auto turned = [&](std::vector<std::string>& bad, std::size_t at) {
    std::string& line = bad[at];
    if (const auto dr = line.find("DR"); dr != line.npos)
      return line[dr + 2] = line[dr + 2] == '+' ? '-' : '+', true;
    const auto word = line.find("G02") != line.npos || line.find("G03") != line.npos ? line.find("G0") + 2
                                                                                     : line.find('G') + 1;
    line[word] = line[word] == '2' ? '3' : '2';
    return true;
  };
  expect_seen("direction", turned, 6);
  expect_seen("a straight way", replaced("(G0?)[23] (.*?)( [IJK].*|$)", "$011 $2 F900"), tnc() ? 0 : 6);
  const auto dropped = [](std::vector<std::string>& bad, std::size_t at) {
    bad.erase(bad.begin() + static_cast<std::ptrdiff_t>(at));
    return true;
  };
  // Where the centre is absolute, the next arc of the circle does for one that is lost, and the judges refuse
  // it as one of more than half a circle.
  expect_seen("dropped", dropped, 6, !tnc());
  if (tnc()) {
    expect_seen(
        "dropped centre",
        [](std::vector<std::string>& bad, std::size_t at) {
          // The centre of the arc before may be the same.
          const std::regex pole("(CC X|I)([-+0-9.]+) [YJ]([-+0-9.]+)");
          std::smatch now, before;
          std::regex_search(bad[at - 1], now, pole);
          for (std::size_t i = at - 1; i-- > 0 && before.empty();) std::regex_search(bad[i], before, pole);
          const auto value = [](const std::smatch& m, int k) { return std::stod(m[k].str()); };
          if (!before.empty() &&
              std::hypot(value(now, 2) - value(before, 2), value(now, 3) - value(before, 3)) < 1)
            return false;
          bad.erase(bad.begin() + static_cast<std::ptrdiff_t>(at - 1));
          return true;
        },
        2);
    for (const char* const letter : {"X", "Y", "I", "J"})
      expect_seen(
          "moved centre",
          [&](std::vector<std::string>& bad, std::size_t at) {
            const std::string line = std::regex_replace(
                bad[at - 1], std::regex(std::string(letter) + "[-+][0-9.]+"), std::string(letter) + "+77.7");
            if (line == bad[at - 1]) return false;
            bad[at - 1] = line;
            return true;
          },
          0);
    return;
  }
  for (const std::string letter : {"I", "J", "K"}) {
    expect_seen("moved centre", replaced(letter + "(-?)([0-9]*)\\.?[0-9]*", letter + "$01$023.25"),
                letter == "K" && (one_plane() || GetParam().planes) ? 0 : 1);
    expect_seen(
        "centre of another sign",
        [&](std::vector<std::string>& bad, std::size_t at) {
          const auto found = bad[at].find(letter);
          if (found == std::string::npos ||
              std::abs(std::strtod(bad[at].c_str() + found + 1, nullptr)) < 0.02)
            return false;
          if (bad[at][found + 1] == '-')
            bad[at].erase(found + 1, 1);
          else
            bad[at].insert(found + 1, 1, '-');
          return true;
        },
        0);
  }
  expect_seen(
      "lost end",
      [](std::vector<std::string>& bad, std::size_t at) {
        const std::regex word(" ([XYZ])(-?[0-9.]+)");
        std::smatch end;
        if (!std::regex_search(bad[at], end, word)) return false;
        // An arc may end where it begins, along one axis.
        const std::regex same(end[1].str() + "(-?[0-9.]+)");
        std::smatch before;
        for (std::size_t i = at; i-- > 0 && before.empty();)
          if (bad[i].find("TILTFEED") == std::string::npos) std::regex_search(bad[i], before, same);
        if (!before.empty() && std::abs(std::stod(before[1].str()) - std::stod(end[2].str())) < 0.1)
          return false;
        bad[at].erase(static_cast<std::size_t>(end.position(0)), static_cast<std::size_t>(end.length(0)));
        return true;
      },
      4);
}

TEST_P(ArcPrograms, APlaneThatIsLostOrAnotherOneIsSeen) {
  std::size_t seeded = 0;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const bool plane = std::regex_match(lines_[i], std::regex("(N[0-9]+ )?G1[789]"));
    if (!plane) continue;
    ++seeded;
    std::vector<std::string> bad = lines_;
    bad.erase(bad.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_GT(off(joined(bad)), kPostTolerance) << "dropped " << lines_[i];
    for (const char* const other : {"G17", "G18", "G19"}) {
      if (lines_[i].find(other) != std::string::npos) continue;
      bad = lines_;
      bad[i] = other;
      EXPECT_GT(off(joined(bad)), kPostTolerance) << lines_[i] << " became " << other;
    }
  }
  if (!one_plane() && !GetParam().planes) {
    EXPECT_GE(seeded, 3u);
  }
  if (one_plane()) {
    EXPECT_EQ(seeded, 0u);
  }
}

/// As the control says it: the first arc of the first circle begins at X0 and goes anticlockwise round X15.
TEST(ArcWords, AreEachControlsOwn) {
  const std::pair<Dialect, const char*> wanted[] = {{Dialect::kRs274, "\nG3 X28.0025 Y7.4812 I15 J0 F"},
                                                    {Dialect::kGrbl, "\nG3 X28.0025 Y7.4812 I15 J0 F"},
                                                    {Dialect::kFanuc, "\nG3 X"},
                                                    {Dialect::kHaas, "\nG3 X"},
                                                    {Dialect::kSiemens, "\nG3 X"},
                                                    {Dialect::kHeidenhain, " DR+ F900\n"},
                                                    {Dialect::kHeidenhainIso, " G03 X"}};
  for (const auto& [dialect, words] : wanted) {
    PostOptions options;
    options.tolerance = kPostTolerance;
    options.data.arc_tolerance = kArcShare;
    const auto text = program_text(bows(0), machine(dialect, false), options);
    ASSERT_TRUE(text) << text.error().message;
    EXPECT_NE(text->find(std::string(words).substr(0, 6)), std::string::npos) << words << "\n" << *text;
  }
}

}  // namespace
}  // namespace tiltfeed::sim
