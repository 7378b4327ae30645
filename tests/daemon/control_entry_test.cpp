// Programs of Fanuc and Haas entered at each of their lines: what the control does from there on, by the
// simulated machine's own reader, is what the whole program does there; the way in is a program that the
// judges of posted programs pass.

#include "daemon/journal/control_entry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <regex>
#include <sstream>

#include "daemon/journal/control_block.h"
#include "daemon/journal/reentry.h"
#include "daemon/stream/stream.h"
#include "sim/control/control_reader.h"
#include "sim/control/program_frame.h"
#include "sim/control/slide_blocks.h"
#include "sim/motion/forward.h"
#include "tests/texts/folder.h"
#include "tests/texts/posted.h"

namespace tiltfeed {
namespace {

enum class WayOfWords { kPlain, kTcp, kPlanes };

struct EntryCase {
  Dialect dialect;
  WayOfWords words;
  const char* machine;
  bool options;  ///< high-speed function, clamps, a register, feed per minute, offsets of planes, arcs
};

std::string entry_case_name(const testing::TestParamInfo<EntryCase>& one) {
  constexpr const char* kWords[]{"plain", "tcp", "planes"};
  std::string name = std::string(name_of(one.param.dialect).name) + "_" +
                     kWords[static_cast<int>(one.param.words)] + "_" + one.param.machine +
                     (one.param.options ? "_options" : "");
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

/// Travels wide enough for the paths below.
MachineProfile wide_profile(const EntryCase& c) {
  MachineProfile profile = machine(c.dialect, c.words == WayOfWords::kTcp, c.machine);
  MachineModel& m = profile.model;
  for (LinearAxis* axis : {&m.x, &m.y, &m.z}) axis->min = -1500, axis->max = 1500;
  profile.solid = {};
  profile.format.tilted_planes = c.words == WayOfWords::kPlanes;
  if (!c.options) return profile;
  profile.format.clamp_tilt = "M10", profile.format.unclamp_tilt = "M11";
  profile.format.clamp_rotary = "M78", profile.format.unclamp_rotary = "M79";
  profile.format.feed_mode = FeedMode::kPerMinute;
  profile.format.start = {"M50"};
  if (c.dialect == Dialect::kHaas) profile.format.inches = true, profile.format.linear_decimals = 4;
  return profile;
}

/// Two tools, each in three directions that the machine reaches; outside of planes the axis leans in cuts.
AptProgram two_tools(const EntryCase& c, const MachineProfile& profile, const Setup& setup) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-40, 40);
  AptProgram program;
  program.name = "entered";
  for (int tool = 3; tool <= 4; ++tool) {
    AptOperation op;
    op.tool_number = tool;
    if (c.options) op.length_register = tool + 20;
    op.path.name = program.name;
    op.path.tool = {6, 3, 100.0 - tool};
    op.path.cut_feed = op.path.plunge_feed = Feed::from_mm_per_min(800);
    Setup longer = setup;
    longer.tool_length = op.path.tool.length;
    for (const double share : {0.3, 0.1, -0.4}) {
      const auto axis_at = [&](double lean) {
        return forward(profile.model, longer,
                       {0, 0, 0, share * std::min(profile.model.tilt.max, 90.0) + lean, 130.0 * share + tool})
            .axis;
      };
      const auto go = [&](double up, MoveKind kind, double lean = 0.0) {
        const Point<Part> tip{place(random), place(random), place(random) + up};
        op.path.moves.push_back(
            {{tip, axis_at(c.words == WayOfWords::kPlanes ? 0.0 : lean)}, kind, kNoFacet});
      };
      op.path.feeds.push_back(
          {static_cast<std::uint32_t>(op.path.moves.size()), Feed::from_mm_per_min(700 + 300 * share)});
      go(80, MoveKind::kRapid);
      for (int i = 0; i < 3; ++i) go(0, MoveKind::kCut, i == 1 ? 0.0 : 2.0 * i);
      // A bow that arcs stand for.
      const Pose last = op.path.moves.back().pose;
      const auto [u, v] = [&] {
        const Vec3 one = normalized(cross(last.axis, Vec3{0.3, 1, 0.2}));
        return std::pair{one, cross(last.axis, one)};
      }();
      for (int i = 1; i <= 12; ++i) {
        const double angle = 0.1 * i;
        op.path.moves.push_back(
            {{last.tip + (u * std::sin(angle) + v * (1.0 - std::cos(angle))) * 10.0, last.axis},
             MoveKind::kCut,
             kNoFacet});
      }
      go(80, MoveKind::kRapid, 4.0);
    }
    op.events = {{0, EventKind::kSpindle, tool == 3 ? 5000.0 : -4000.0, ""},
                 {0, EventKind::kCoolant, tool == 3 ? 1.0 : 2.0, ""},
                 {2, EventKind::kDwell, 0.5, ""},
                 {4, EventKind::kSpindle, tool == 3 ? 6000.0 : -4500.0, ""},
                 {20, EventKind::kCoolant, 0.0, ""}};
    for (std::size_t i = 0; i < op.path.moves.size(); ++i)
      op.lines.push_back(static_cast<std::uint32_t>(i + 1));
    program.operations.push_back(std::move(op));
  }
  return program;
}

/// Each group of words excludes each other, and the newest is in force.
const std::map<std::string, std::regex>& modes() {
  static const std::map<std::string, std::regex> all{
      {"spindle", std::regex("M[345](?![0-9])")},
      {"speed", std::regex("S[0-9]+")},
      {"tool", std::regex("T[0-9]+ M6")},
      {"coolant", std::regex("M[789](?![0-9])")},
      {"feed mode", std::regex("G9[34](?![0-9])")},
      {"plane", std::regex("G1[789](?![0-9])")},
      {"work offset", std::regex("G5[4-9](?![0-9.])|G54\\.1 P[0-9]+|G154 P[0-9]+")},
      {"tilt's clamp", std::regex("M1[01](?![0-9])")},
      {"rotary's clamp", std::regex("M7[89](?![0-9])")},
      {"smoothing", std::regex("G5\\.1 Q[01]|G187.*")},
      {"distances", std::regex("G9[01](?![0-9])")},
      {"length", std::regex("G4[39](\\.4)? *(?=[XYZABC]|$)|(G43|G43\\.4|G234) H[0-9]+")},
      {"tilted plane", std::regex("G68\\.2.*|G69|G25[45]")}};
  return all;
}

/// What is in force behind each line, by group.
std::vector<std::map<std::string, std::string>> in_force(const std::vector<std::string>& lines,
                                                         std::size_t count) {
  std::vector<std::map<std::string, std::string>> found{{}};
  for (std::size_t i = 0; i < count; ++i) {
    found.push_back(found.back());
    const std::string words = lines[i].substr(0, lines[i].find('('));
    for (const auto& [name, group] : modes())
      for (auto at = std::sregex_iterator(words.begin(), words.end(), group); at != std::sregex_iterator();
           ++at)
        found.back()[name] = at->str();
  }
  return found;
}

class ControlEntry : public testing::TestWithParam<EntryCase> {
 protected:
  void SetUp() override {
    const EntryCase& c = GetParam();
    profile_ = wide_profile(c);
    PostOptions options;
    options.setup.part_zero = {12, -7, 30};
    options.setup.fixture = fixture_of({0, 0, 90});
    if (c.options) {
      options.tolerance = 0.05;
      options.data.smoothing = Smoothing::kFinish, options.data.smoothing_tolerance = 0.01;
      options.data.work_offset = 2;
      options.data.arc_tolerance = c.words == WayOfWords::kTcp ? 0.0 : 0.01;
      options.data.plane_offsets = c.words == WayOfWords::kPlanes;
    }
    const AptProgram path = two_tools(c, profile_, options.setup);
    const auto text = program_text(path, profile_, options);
    ASSERT_TRUE(text) << text.error().message;
    text_ = *text;
    lines_ = lines_of(text_);
    job_.machine = profile_;
    job_.setup = options.setup;
    job_.program = options.data;
    file_ = folder_.write("p.nc", text_);
    const auto count = count_blocks(file_, LinkKind::kDrip);
    ASSERT_TRUE(count) << count.error().message;
    count_ = *count;
  }

  Result<Reentry> enter(std::uint64_t from, double retract = 50.0) const {
    ReentryOptions options;
    options.from = from;
    options.retract = retract;
    return plan_reentry(file_, LinkKind::kDrip, profile_, options);
  }
  static std::string whole(const std::string& file, const Reentry& entry) {
    std::ostringstream out;
    EXPECT_TRUE(write_reentry(file, entry, out));
    return out.str();
  }
  /// As the control executes it, with the tool of the part of the program that is read.
  std::vector<sim::ControlBlock> executed(const std::string& text, double tool_length) const {
    tiltfeed::Setup setup = job_.setup;
    setup.tool_length = tool_length;
    sim::ControlReader reader(profile_, setup);
    std::istringstream in(text);
    std::vector<sim::ControlBlock> blocks;
    const auto read = sim::read_control_program(in, "p.nc", reader,
                                                [&](const sim::ControlBlock& one) { blocks.push_back(one); });
    EXPECT_TRUE(read) << read.error().message << "\n" << text;
    return blocks;
  }
  /// That the program states before a line, mm.
  double length_at(std::size_t line) const {
    double found = 0.0;
    constexpr std::string_view kSaid = "tool length ";
    for (std::size_t i = 0; i < line; ++i)
      if (const auto at = lines_[i].find(kSaid); at != std::string::npos)
        found = std::stod(lines_[i].substr(at + kSaid.size()));
    return found;
  }

  const Folder folder_{"control_entry"};
  MachineProfile profile_;
  Job job_;
  std::string text_, file_;
  std::vector<std::string> lines_;
  std::uint64_t count_ = 0;
};

double length_of(Vec3 v) { return length(v); }

bool moves(const sim::ControlBlock& one) {
  return one.block.op == sim::Op::kRapid || one.block.op == sim::Op::kFeed;
}

TEST_P(ControlEntry, GoesOnAsTheWholeProgramDoes) {
  std::size_t entered = 0, refused = 0;
  const auto before = in_force(lines_, lines_.size());
  for (std::uint64_t from = 2; from <= count_; ++from) {
    const auto entry = enter(from);
    if (!entry) {
      ++refused;
      ASSERT_EQ(entry.error().code, Code::kUsage) << from << ": " << entry.error().message;
      // It names a block that can be entered, but behind the last cut.
      std::smatch named;
      const std::string& message = entry.error().message;
      if (message.find("only ends there") != std::string::npos) continue;
      ASSERT_TRUE(std::regex_search(message, named, std::regex("enter at block ([0-9]+)"))) << message;
      const auto other = enter(std::stoull(named[1]));
      EXPECT_TRUE(other) << message << " -- " << (other ? "" : other.error().message);
      continue;
    }
    ++entered;
    const std::string again = whole(file_, *entry);
    const std::vector<std::string> is = lines_of(again);
    // The rest stands as it did.
    const std::size_t rest = lines_.size() - (entry->line - 1), head = is.size() - rest;
    ASSERT_GT(is.size(), rest);
    ASSERT_TRUE(std::equal(is.end() - static_cast<std::ptrdiff_t>(rest), is.end(),
                           lines_.begin() + static_cast<std::ptrdiff_t>(entry->line - 1)))
        << from;
    auto here = in_force(is, head).back(), there = before[entry->line - 1];
    for (const auto& [name, group] : modes()) {
      // Without words from the start both are off.
      const auto off = [](const std::string& word) {
        return word.empty() || word == "M5" || word == "M9" || word == "M11" || word == "M79" ||
               word == "G5.1 Q0" || word == "G187" || word == "G69" || word == "G255";
      };
      EXPECT_TRUE(here[name] == there[name] || (off(here[name]) && off(there[name])))
          << from << " " << name << ": " << here[name] << ", not " << there[name] << "\n"
          << again;
    }
    // What moves from there on, and from where.
    const double length = length_at(entry->line);
    const auto all = executed(text_, length), some = executed(again, length);
    std::size_t first = 0;
    while (first < all.size() && all[first].block.line < entry->line) ++first;
    const std::size_t left = all.size() - first;
    ASSERT_GT(some.size(), left);
    for (std::size_t i = 0; i < left; ++i) {
      const sim::ControlBlock &now = some[some.size() - left + i], &then = all[first + i];
      ASSERT_EQ(now.block.op, then.block.op) << from << "+" << i << "\n" << again;
      if (moves(now)) {
        ASSERT_EQ(now.block.target, then.block.target) << from << "+" << i << "\n" << again;
      }
      ASSERT_EQ(now.block.feed, then.block.feed) << from << "+" << i << "\n" << again;
      ASSERT_EQ(now.block.inverse_time, then.block.inverse_time) << from << "+" << i;
      ASSERT_EQ(now.block.m_code, then.block.m_code) << from << "+" << i;
      ASSERT_EQ(now.block.spindle, then.block.spindle) << from << "+" << i;
      ASSERT_EQ(now.block.tool, then.block.tool) << from << "+" << i;
      ASSERT_EQ(now.tcp, then.tcp) << from << "+" << i;
    }
    const auto last_move = [](const std::vector<sim::ControlBlock>& blocks, std::size_t count) {
      while (count > 0 && !moves(blocks[count - 1])) --count;
      return blocks[count - 1].block.target;
    };
    EXPECT_EQ(last_move(some, some.size() - left), last_move(all, first)) << from << "\n" << again;
    // The judges of posted programs pass what stands round it.
    Job job = job_;
    job.setup.tool_length = length;
    job.program.tool = std::stoi(there["tool"].substr(1));
    // A job has one register: both tools' own are said as such.
    std::istringstream frame(std::regex_replace(again, std::regex("H2([34])"), "H$1"));
    // Offsets of planes are counted from the first plane, which an entry in a later one does not call.
    if (job.program.plane_offsets && there["work offset"] != "G55") continue;
    const auto sound = sim::check_frame(frame, "again", std::span(&job, 1));
    EXPECT_TRUE(sound) << from << ": " << sound.error().message << "\n" << again;
    if (HasFailure()) return;
  }
  EXPECT_GT(entered, 20u);
  EXPECT_GT(refused, 2u);
}

/// The tip and its axis at the end of each block that moves the tool; nothing for other blocks.
std::vector<std::optional<Pose>> poses(const std::vector<sim::ControlBlock>& blocks,
                                       const MachineProfile& profile, const tiltfeed::Setup& setup) {
  std::vector<std::optional<Pose>> found;
  sim::SlideBlocks slides(profile.model, setup, 100.0, 0.001);
  for (const sim::ControlBlock& one : blocks) {
    std::optional<Joints> at;
    slides.take(one, [&](const sim::Block& block) { at = block.target; });
    const bool placed = moves(one) && at && one.block.placed;
    found.push_back(placed ? std::optional(sim::forward_by_frames(profile.model, setup, *at)) : std::nullopt);
  }
  return found;
}

TEST_P(ControlEntry, ComesDownTheToolAxisFromOverEveryCut) {
  std::size_t seen = 0;
  for (std::uint64_t from = 2; from <= count_; from += 7) {
    const auto entry = enter(from, 30.0);
    if (!entry) continue;
    const double length = length_at(entry->line);
    tiltfeed::Setup setup = job_.setup;
    setup.tool_length = length;
    const auto way = executed(entry->head, length);
    // The last motion of the way in, and the place where it begins.
    std::vector<std::size_t> ends;
    const auto at = poses(way, profile_, setup);
    for (std::size_t i = 0; i < way.size(); ++i)
      if (moves(way[i]) && way[i].block.line < lines_of(entry->head).size()) ends.push_back(i);
    ASSERT_GT(ends.size(), 1u);
    const std::size_t last = ends.back(), before = ends[ends.size() - 2];
    ASSERT_TRUE(at[last]) << entry->head;
    const Pose &entered = *at[last], &over = at[before] ? *at[before] : *at[last];
    const Vec3 up = over.tip - entered.tip;
    EXPECT_LT(length_of(up - entered.axis * dot(up, entered.axis)), 0.01) << entry->head;
    EXPECT_LT(length_of(over.axis - entered.axis), 1e-6) << entry->head;
    // 200 mm a minute.
    const double feed = way[last].block.feed;
    EXPECT_NEAR(way[last].block.inverse_time ? feed * length_of(up) : feed, 200.0, 1.0) << entry->head;
    EXPECT_TRUE(way[last].block.op == sim::Op::kFeed && way[before].block.op == sim::Op::kRapid);
    for (const int tool : {3, 4}) {
      tiltfeed::Setup own = setup;
      own.tool_length = 100.0 - tool;
      const auto all = executed(text_, own.tool_length);
      const auto tips = poses(all, profile_, own);
      for (std::size_t i = 0; i < all.size(); ++i) {
        if (!tips[i] || all[i].block.op != sim::Op::kFeed || all[i].block.tool != tool) continue;
        EXPECT_GT(dot(over.tip - tips[i]->tip, entered.axis), 30.0 - 0.01)
            << from << " line " << all[i].block.line << "\n"
            << entry->head;
      }
    }
    // The spindle, where it is to turn, before it goes down, and the wait for that.
    if (way[last].block.spindle > 0.0 && in_force(lines_, entry->line - 1).back()["spindle"] != "M5") {
      const auto waits = std::find_if(way.begin(), way.end(),
                                      [](const auto& one) { return one.block.op == sim::Op::kDwell; });
      EXPECT_LT(waits - way.begin(), static_cast<std::ptrdiff_t>(before)) << entry->head;
      EXPECT_EQ(waits->block.feed, 3.0);
    }
    if (HasFailure()) return;
    ++seen;
  }
  EXPECT_GT(seen, 8u);
}

/// `show --block`: the line, and the words in force at its end.
TEST_P(ControlEntry, TellsWhereABlockIs) {
  std::uint64_t before = 0;
  for (std::uint64_t number = 1; number <= count_; number += 3) {
    const auto place = find_control_block(file_, profile_, number);
    ASSERT_TRUE(place) << place.error().message;
    EXPECT_GE(place->moves, before);
    before = place->moves;
    std::string sent = lines_[place->line - 1].substr(0, lines_[place->line - 1].find('('));
    std::erase(sent, ' ');
    EXPECT_EQ(place->text, sent);
    std::optional<Joints> at;
    bool moves_here = false;
    for (const sim::ControlBlock& one : executed(text_, length_at(place->line))) {
      if (!moves(one) || one.block.line > place->line || !one.block.placed) continue;
      at = one.block.target;
      moves_here = one.block.line == place->line;
    }
    // The simulated machine counts the ways between the retract and the next Z, too, and slides in planes.
    if (place->is_move) {
      EXPECT_TRUE(moves_here) << number;
    }
    if (place->is_move && !place->plane && place->words) {
      EXPECT_EQ(*place->words, *at) << number;
    }
    EXPECT_EQ(place->tcp, GetParam().words == WayOfWords::kTcp && place->words.has_value()) << number;
  }
  EXPECT_GT(before, 30u);
  EXPECT_EQ(find_control_block(file_, profile_, count_ + 1).error().code, Code::kUsage);
}

TEST_P(ControlEntry, AProgramThatEntersCanBeEnteredAgain) {
  const std::uint64_t middle = count_ / 2;
  std::optional<Reentry> first;
  for (std::uint64_t from = middle; !first && from < count_; ++from)
    if (auto entry = enter(from)) first = *entry;
  ASSERT_TRUE(first);
  const std::string once = whole(file_, *first), path = folder_.write("once.nc", once);
  const auto count = count_blocks(path, LinkKind::kDrip);
  ASSERT_TRUE(count);
  std::size_t again = 0;
  for (std::uint64_t back = 8; back < 20; ++back) {
    const auto direct = enter(count_ - back);
    ReentryOptions options;
    options.from = *count - back;
    const auto entry = plan_reentry(path, LinkKind::kDrip, profile_, options);
    ASSERT_EQ(entry.has_value(), direct.has_value()) << back << (entry ? "" : entry.error().message);
    if (!entry) continue;
    ++again;
    // All but how high it begins: cuts that it has behind it count no more.
    const auto is = lines_of(whole(path, *entry)), was = lines_of(whole(file_, *direct));
    const std::size_t rest = lines_.size() - (direct->line - 1);
    ASSERT_TRUE(is.size() > rest && was.size() > rest);
    EXPECT_TRUE(std::equal(is.end() - static_cast<std::ptrdiff_t>(rest), is.end(),
                           was.end() - static_cast<std::ptrdiff_t>(rest)));
    EXPECT_EQ(in_force(is, is.size() - rest).back(), in_force(was, was.size() - rest).back());
  }
  EXPECT_GT(again, 3u);
}

INSTANTIATE_TEST_SUITE_P(
    Controls, ControlEntry,
    testing::Values(EntryCase{Dialect::kFanuc, WayOfWords::kPlain, "generic-ac", false},
                    EntryCase{Dialect::kFanuc, WayOfWords::kPlain, "generic-ac", true},
                    EntryCase{Dialect::kFanuc, WayOfWords::kTcp, "generic-ac", false},
                    EntryCase{Dialect::kFanuc, WayOfWords::kTcp, "linuxcnc-bridge-bc", true},
                    EntryCase{Dialect::kFanuc, WayOfWords::kTcp, "linuxcnc-trunnion-ac", false},
                    EntryCase{Dialect::kFanuc, WayOfWords::kPlanes, "generic-ac", false},
                    EntryCase{Dialect::kFanuc, WayOfWords::kPlanes, "generic-ac", true},
                    EntryCase{Dialect::kFanuc, WayOfWords::kPlanes, "dmu-nutating-bc", false},
                    EntryCase{Dialect::kHaas, WayOfWords::kPlain, "linuxcnc-trunnion-ac", true},
                    EntryCase{Dialect::kHaas, WayOfWords::kTcp, "generic-ac", true},
                    EntryCase{Dialect::kHaas, WayOfWords::kPlanes, "linuxcnc-trunnion-ac", false},
                    EntryCase{Dialect::kHaas, WayOfWords::kPlanes, "linuxcnc-trunnion-ac", true}),
    entry_case_name);

/// A Fanuc's program without a tool change, in a text of its own.
class EntryText : public testing::Test {
 protected:
  Result<Reentry> enter(const std::string& text, std::uint64_t from, const MachineProfile& profile,
                        const tiltfeed::Setup& setup = {}) const {
    ReentryOptions options;
    options.from = from;
    options.setup = setup;
    return plan_reentry(folder_.write("p.nc", text), LinkKind::kDrip, profile, options);
  }
  std::string why(const std::string& text, std::uint64_t from, const MachineProfile& profile) const {
    const auto entry = enter(text, from, profile);
    return entry ? "" : entry.error().message;
  }
  const Folder folder_{"entry_text"};
  const MachineProfile profile_ = machine(Dialect::kFanuc, false);
};

constexpr const char* kStart =
    "%\nO0001\n(TILTFEED tool length 80 mm is planned)\n(TILTFEED part zero 0 0 50 mm)\n"
    "G21 G90 G17 G40 G80 G94 G54\nG91 G28 Z0.\nG90\nG49\nG69\nT1 M6\nS900 M3\n";

TEST_F(EntryText, RefusesWhatItCannotWriteAgain) {
  const std::string start = kStart;
  const std::string place = "G0 A0. C0.\nG0 X0. Y0.\nG0 Z60.\nG1 Z50. F300.\n";
  const auto said = [&](const std::string& text, std::uint64_t from, const char* what) {
    const std::string message = why(text, from, profile_);
    EXPECT_NE(message.find(what), std::string::npos) << what << ": " << message;
  };
  said(start + place + "G41 D1\nX10.\nX20.\nG40\nX30.\nM30\n", 15, "shifts the tool to a side (G41 or G42)");
  said(start + place + "G2 X10. I5. J0.\nX0. I-5. J0.\nG1 X5.\nM30\n", 14,
       "an arc without a G2 or G3 of its own");
  said(start + place + "X10.\nX20.\nG33 X30.\nM30\n", 14, "G33 is not understood");
  said(start + place + "X10.\nM30\n", 1, "start the job instead");
  said(start + place + "X10.\nM30\n", 99, "the program has 14");
  said(start + place + "X10.\nX700.\nX900.\nM30\n", 15, "enter at another block");
  std::string without = start;
  without.replace(without.find(" G54"), 4, "");
  said(without + place + "X10.\nX20.\nM30\n", 14, "calls no work offset");
  const std::string plane =
      "G0 A30. C0.\nG0 X0. Y0.\nG68.2 X5. Y0. Z0. I0. J30. K0.\nG53.1\n"
      "G0 G43 H1 X0. Y0. Z60.\nG1 Z50. F300.\nX10.\nG0 Z60.\nG91 G28 Z0.\nG90\nG49\nG69\nM30\n";
  said(start + plane, 15, "a tilted plane with another origin or other angles");
  std::string nameless = start;
  nameless.erase(nameless.find("(TILTFEED tool"), nameless.find("G21") - nameless.find("(TILTFEED tool"));
  std::string usual = plane;
  usual.replace(usual.find("X5."), 3, "X0.");
  EXPECT_EQ(why(start + usual, 15, profile_), "");
  said(nameless + usual, 15, "neither its header nor a job states the tool's length");
  MachineProfile none = profile_;
  none.format.retract = "none";
  EXPECT_NE(why(start + place + "X10.\nX20.\nM30\n", 15, none).find("program.retract: none"),
            std::string::npos);
  // The words of a control whose numbers need a point, and its milliseconds.
  const auto entry = enter(start + place + "X10.\nX20.\nM30\n", 14, profile_);
  ASSERT_TRUE(entry) << entry.error().message;
  for (const char* words : {"\nS900 M3\n", "\nG4 P3000\n", "\nG0 A0. C0.\n", "\nG0 X10. Y0.\n", "\nX20.\n"})
    EXPECT_NE(entry->head.find(words), std::string::npos) << entry->head;
}

/// WayOfWords that stay in force: the plane of arcs, and no F of another feed mode.
TEST_F(EntryText, WritesThePlaneAndTheFeedThatAreInForce) {
  const std::string start = std::string(kStart) + "G0 A0. C0.\nG0 X0. Y0.\nG0 Z60.\nG1 Z50. F300.\n";
  const auto plane =
      enter(start + "G18\nG2 X10. Z50. I5. K0.\nG3 X20. Z50. I5. K0.\nG17\nM30\n", 15, profile_);
  ASSERT_TRUE(plane) << plane.error().message;
  EXPECT_NE(plane->head.find("\nG18\n"), std::string::npos) << plane->head;
  EXPECT_NE(plane->head.find("\nF300.\nG3 X20."), std::string::npos) << plane->head;
  const auto feed = enter(start + "G93\nX10. F60.\nG94\nG1 X20. F200.\nM30\n", 16, profile_);
  ASSERT_TRUE(feed) << feed.error().message;
  EXPECT_EQ(feed->head.find("F60."), std::string::npos) << feed->head;
  EXPECT_NE(feed->head.find("\nG94\nG1 X20. F200.\n"), std::string::npos) << feed->head;
}

/// Where Z's travel ends the tool comes from as high as it goes, and that is said.
TEST_F(EntryText, ComesFromAsHighAsTheTravelAllows) {
  const std::string text =
      std::string(kStart) + "G0 A40. C0.\nG0 X0. Y0.\nG0 Z180.\nG1 Z160. F300.\nX10.\nX20.\nM30\n";
  MachineProfile low = profile_;
  const auto free = enter(text, 14, low);
  ASSERT_TRUE(free) << free.error().message;
  EXPECT_NE(free->preview.find(", over every cut of the program"), std::string::npos) << free->preview;
  low.model.z.max = 185.0;
  const auto held = enter(text, 14, low);
  ASSERT_TRUE(held) << held.error().message;
  EXPECT_NE(held->preview.find("the travel ends there"), std::string::npos) << held->preview;
  std::istringstream in(held->head);
  sim::ControlReader reader(low, {});
  double most = 0.0;
  ASSERT_TRUE(sim::read_control_program(in, "head", reader, [&](const sim::ControlBlock& one) {
    if (one.block.op == sim::Op::kRapid && one.block.target.a == 40.0)
      most = std::max(most, one.block.target.z);
  }));
  EXPECT_LE(most, 185.0);
  EXPECT_GT(most, 180.0);
  // Never by a rapid down to a cut; to the end of a rapid it may be one.
  low.model.z.max = 160.5;
  EXPECT_NE(why(text, 14, low).find("no way to it along the tool axis"), std::string::npos)
      << why(text, 14, low);
  low.model.z.max = 180.5;
  EXPECT_EQ(why(text, 12, low), "");
}

}  // namespace
}  // namespace tiltfeed
