// What a job asks of its control besides motion: the high-speed function, the register of the tool's length,
// coolant through the spindle. In every dialect: the words, where they stand, and that both readers take
// them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "daemon/post/printed_path.h"
#include "kinematics/basics/decimal.h"
#include "sim/control/control_reader.h"
#include "sim/control/program_frame.h"
#include "tests/texts/dialect_posting.h"

namespace tiltfeed::sim {
namespace {

using ProgramText = std::vector<std::string>;

class ProgramOptions : public testing::TestWithParam<DialectCase> {
 protected:
  /// A cut with standing rotaries, or one that turns them.
  static JointPath cut(bool turning) {
    JointPath path;
    path.moves = {{{0, -12.5, 100, 0, 0}, 0.0, MoveKind::kRapid, 0},
                  {{1, -12.5, 10, 0, 0}, 4.0, MoveKind::kPlunge, 1},
                  {{10, -12.5, 10, 0, turning ? 20.0 : 0.0}, 0.36, MoveKind::kCut, 2},
                  {{10, -12.5, 100, 0, turning ? 20.0 : 0.0}, 0.5, MoveKind::kRapid, 3}};
    return path;
  }
  ProgramText text(bool turning, const ProgramData& data, int length_register = 0, double coolant = 1.0) {
    const JointPath path = cut(turning);
    Posting posting = posting_of(GetParam(), {&path});
    posting.data = data;
    posting.operations[0].length_register = length_register;
    posting.operations[0].smoothing = data.smoothing;
    posting.operations[0].smoothing_tolerance = data.smoothing_tolerance;
    posting.operations[0].events = {{0, EventKind::kSpindle, 8000, ""},
                                    {0, EventKind::kCoolant, coolant, ""}};
    if (posting.machine.format.through_on.empty())
      posting.machine.format.through_on = "M50", posting.machine.format.through_off = "M51";
    job_.machine = posting.machine;
    job_.setup = posting.operations[0].setup;
    job_.program = data;
    job_.program.tool = 3;
    ProgramText lines;
    std::istringstream in(text_of(posting));
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }
  /// What the judges and the postprocessor's own reader say; empty: it is sound.
  std::string fault(const ProgramText& lines) const {
    std::string all;
    for (const std::string& line : lines) all += line + "\n";
    std::istringstream frame(all), moves(all), back(all);
    if (const auto sound = check_frame(frame, "p.nc", std::span(&job_, 1)); !sound)
      return sound.error().message;
    ControlReader reader(job_.machine, job_.setup);
    if (const auto read = read_control_program(moves, "p.nc", reader, [](const ControlBlock&) {}); !read)
      return read.error().message;
    const auto read = read_nc_program(back, "p.nc", language_of(job_.machine));
    return read ? "" : read.error().message;
  }
  /// The line with these words, without its number; -1: none.
  static std::ptrdiff_t at(const ProgramText& lines, const std::string& words) {
    const auto found = std::find_if(lines.begin(), lines.end(), [&](const std::string& line) {
      const std::size_t from = line.find(words);
      const std::size_t number = line.find_first_not_of("N0123456789 ");
      return from != line.npos && (from == 0 || from == number) &&
             line.find_first_not_of("*", from + words.size()) == line.npos;
    });
    return found == lines.end() ? -1 : found - lines.begin();
  }
  static std::ptrdiff_t first_with(const ProgramText& lines, const std::string& word) {
    return std::find_if(lines.begin(), lines.end(),
                        [&](const std::string& line) {
                          return line.find(word) != line.npos && line.find("TILTFEED") == line.npos;
                        }) -
           lines.begin();
  }

  Job job_;
};

/// A word that means something only beside a code: alone in a feed a control stops at it, or does what nobody
/// reads.
TEST_P(ProgramOptions, WordsWithoutTheirCodeAreRefused) {
  const ProgramText lines = text(false, {});
  ASSERT_EQ(fault(lines), "");
  std::size_t cut = lines.size();
  for (std::size_t i = 0; i < lines.size(); ++i)
    if (lines[i].find(lines[i].find("X+10") != std::string::npos ? "X+10" : "X10") != std::string::npos &&
        lines[i].find("TILTFEED") == std::string::npos)
      cut = std::min(cut, i);
  ASSERT_LT(cut, lines.size());
  for (const char letter : {'P', 'Q', 'R', 'H', 'D'}) {
    ProgramText damaged = lines;
    std::string& line = damaged[cut];
    line.insert(line.ends_with('*') ? line.size() - 1 : line.size(), std::string(" ") + letter + "7");
    ControlReader reader(job_.machine, job_.setup);
    std::string all, said;
    for (const std::string& one : damaged) all += one + "\n";
    std::istringstream in(all);
    if (const auto read = read_control_program(in, "p.nc", reader, [](const ControlBlock&) {}); !read)
      said = read.error().message;
    const bool edge = letter == 'D' && GetParam().dialect == config::Dialect::kSiemens;
    EXPECT_EQ(said.empty(), edge) << line << ": " << said;
    if (!edge) {
      EXPECT_NE(said.find(letter), std::string::npos) << line << ": " << said;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Control, ProgramOptions, testing::ValuesIn(dialect_cases()), case_name);

/// The tool is 97.25 mm long: half of 0.01 mm at its end is 0.00294 degrees.
TEST_P(ProgramOptions, TheHighSpeedFunctionIsOnFromTheToolToTheRetract) {
  const Dialect dialect = GetParam().dialect;
  if (!has_smoothing(dialect)) return;
  for (const bool turning : {false, true})
    for (const Smoothing smoothing : {Smoothing::kRough, Smoothing::kSemi, Smoothing::kFinish}) {
      SCOPED_TRACE(static_cast<int>(smoothing));
      ProgramData data;
      data.smoothing = smoothing, data.smoothing_tolerance = 0.01;
      const ProgramText lines = text(turning, data);
      const std::string within = turning ? "0.005" : "0.01";
      const int step = smoothing == Smoothing::kRough ? 0 : smoothing == Smoothing::kSemi ? 1 : 2;
      std::string on, off;
      switch (dialect) {
        case Dialect::kFanuc:
          on = "G5.1 Q1", off = "G5.1 Q0";
          break;
        case Dialect::kHaas:
          on = "G187 P" + std::to_string(1 + step) + " E" + within, off = "G187";
          break;
        case Dialect::kSiemens:
          on = turning ? "CYCLE832(0.005,1" + std::to_string(3 - step) + ",0.0029)"
                       : "CYCLE832(0.01," + std::to_string(3 - step) + ",1)";
          off = "CYCLE832(0,0,1)";
          break;
        case Dialect::kHeidenhain:
          on = "CYCL DEF 32.1 T" + within, off = "CYCL DEF 32.1";
          EXPECT_EQ(at(lines, std::string("CYCL DEF 32.2 HSC-MODE:") + (step == 0 ? "1" : "0") + " TA0.0029"),
                    at(lines, on) + 1);
          break;
        default:
          on = "G62 T" + within + " P01 " + (step == 0 ? "1" : "0") + " P02 0.0029", off = "G62";
      }
      const bool tnc = dialect == Dialect::kHeidenhain || dialect == Dialect::kHeidenhainIso;
      const std::string last_retract = dialect == Dialect::kFanuc     ? "G28"
                                       : dialect == Dialect::kHaas    ? "G53"
                                       : dialect == Dialect::kSiemens ? "SUPA"
                                                                      : "M91";
      ASSERT_GE(at(lines, on), 0) << on;
      ASSERT_GE(at(lines, off), 0) << off;
      EXPECT_GT(at(lines, on), first_with(lines, tnc && dialect == Dialect::kHeidenhain ? "CALL 3" : "T3"));
      EXPECT_LT(at(lines, on), first_with(lines, " X"));
      std::ptrdiff_t retract = 0;
      for (std::size_t i = 0; i < lines.size(); ++i)
        if (lines[i].find(last_retract) != std::string::npos) retract = static_cast<std::ptrdiff_t>(i);
      EXPECT_GT(at(lines, off), retract);
      EXPECT_EQ(fault(lines), "");
      // A figure that is not the job's.
      ProgramText wide = lines;
      std::string& line = wide[static_cast<std::size_t>(at(lines, on))];
      const std::size_t figure = line.find(dialect == Dialect::kFanuc ? "Q1" : within);
      line.replace(figure, 2, dialect == Dialect::kFanuc ? "Q3" : "9.");
      EXPECT_NE(fault(wide), "") << line;
      // Other work than the job's, and more degrees than its tool has.
      const auto changed = [&](const std::string& from, const std::string& to) {
        ProgramText bad = lines;
        bool found = false;
        for (std::string& one : bad) {
          if (const std::size_t place = one.find(from); place != one.npos && !found)
            one.replace(place, from.size(), to), found = true;
        }
        EXPECT_TRUE(found) << from;
        EXPECT_NE(fault(bad), "") << from << " as " << to;
      };
      const std::string mode = std::to_string(3 - step), other = std::to_string(step == 1 ? 1 : 2);
      const std::string rough = step == 0 ? "1" : "0", fine = step == 0 ? "0" : "1";
      if (dialect == Dialect::kHaas)
        changed("G187 P" + std::to_string(1 + step),
                "G187 P" + std::to_string(3 - step + (step == 1 ? 1 : 0)));
      if (dialect == Dialect::kSiemens)
        changed(turning ? ",1" + mode : "," + mode + ",", turning ? ",1" + other : "," + other + ",");
      if (dialect == Dialect::kSiemens && turning) changed("0.0029)", "0.0039)");
      if (dialect == Dialect::kHeidenhain)
        changed("HSC-MODE:" + rough, "HSC-MODE:" + fine), changed("TA0.0029", "TA0.0031");
      if (dialect == Dialect::kHeidenhainIso)
        changed("P01 " + rough, "P01 " + fine), changed("P02 0.0029", "P02 0.029");
      const Smoothing asked = std::exchange(job_.program.smoothing, Smoothing::kNone);
      EXPECT_NE(fault(lines), "") << "a job that asks for none";
      job_.program.smoothing = asked;
      for (const std::string& lost : {on, off}) {
        ProgramText bad = lines;
        bad.erase(bad.begin() + at(lines, lost));
        EXPECT_NE(fault(bad), "") << lost;
      }
    }
}

TEST_P(ProgramOptions, TheLengthRegisterIsTheJobs) {
  const Dialect dialect = GetParam().dialect;
  const bool tnc = dialect == Dialect::kHeidenhain || dialect == Dialect::kHeidenhainIso;
  ProgramData data;
  data.tool = 3, data.length_register = 14;
  MachineProfile profile = profile_of(GetParam());
  const auto wrong = not_of_control(data, profile.format, "m.yaml");
  EXPECT_EQ(wrong.size(), tnc || dialect == Dialect::kGrbl ? 1u : 0u);
  if (!wrong.empty()) return;
  const ProgramText lines = text(false, data, 14);
  const std::string word = dialect == Dialect::kSiemens ? "D14" : "H14";
  EXPECT_NE(std::count_if(lines.begin(), lines.end(),
                          [&](const std::string& line) {
                            return line.find(word) != line.npos && line.find("TILTFEED") == line.npos;
                          }),
            0);
  EXPECT_EQ(fault(lines), "");
  // The tool's own number is not the register that the job states.
  const ProgramText own = text(false, {});
  job_.program.length_register = 14;
  EXPECT_NE(fault(own), "");
}

TEST_P(ProgramOptions, CoolantThroughTheSpindleIsOffBehindTheCut) {
  const ProgramText lines = text(false, {}, 0, 3.0);
  const bool haas = GetParam().dialect == Dialect::kHaas;
  const std::ptrdiff_t on = at(lines, haas ? "M88" : "M50"), off = at(lines, haas ? "M89" : "M51");
  ASSERT_GE(on, 0);
  EXPECT_GT(off, on);
  EXPECT_EQ(at(lines, "M9"), off + 1);
  EXPECT_LT(on, first_with(lines, " X"));
  EXPECT_EQ(fault(lines), "");
}

TEST_P(ProgramOptions, TheNextToolIsMadeReadyBehindTheChange) {
  const Dialect dialect = GetParam().dialect;
  if (dialect == Dialect::kGrbl) return;
  const JointPath path = cut(false);
  Posting posting = posting_of(GetParam(), {&path, &path, &path});
  posting.machine.format.preselects = true;
  job_.machine = posting.machine;
  job_.setup = posting.operations[0].setup;
  job_.program.tool = 3;
  ProgramText lines;
  std::istringstream in(text_of(posting)), again(text_of(posting));
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  const bool tnc = dialect == Dialect::kHeidenhain || dialect == Dialect::kHeidenhainIso;
  const std::string ready = dialect == Dialect::kHeidenhain      ? "TOOL DEF "
                            : dialect == Dialect::kHeidenhainIso ? "G51 T"
                                                                 : "T";
  // Siemens has T in a line of its own for the change, too.
  for (const std::string tool : {"4", "5"})
    EXPECT_EQ(std::count_if(lines.begin(), lines.end(),
                            [&](const std::string& line) {
                              const std::size_t at = line.find(ready + tool);
                              return at != line.npos &&
                                     line.find_first_not_of("*", at + ready.size() + 1) == line.npos;
                            }),
              dialect == Dialect::kSiemens ? 2 : 1)
        << tool;
  EXPECT_EQ(fault(lines), "");
  const auto read = read_nc_program(again, "p.nc", language_of(job_.machine));
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->operations.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read->operations[i].tool_number, static_cast<int>(3 + i));
    EXPECT_GE(read->operations[i].blocks.size(), path.moves.size());
  }
  if (tnc) return;  // there the call is the change
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].find("M6") == std::string::npos) continue;
    ProgramText bad = lines;
    bad.erase(bad.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_NE(fault(bad), "") << i + 1 << ": " << lines[i];
  }
}

/// The words times 25.4 are those of the same program in mm, within half of a last decimal of each.
TEST_P(ProgramOptions, InInchesTheProgramSaysTheSame) {
  const Dialect dialect = GetParam().dialect;
  if (dialect == Dialect::kRs274 || dialect == Dialect::kGrbl) return;
  const auto blocks_of = [&](bool inches, std::string& text) {
    Posting posting = posting_of(GetParam(), {});
    ProgramFormat& format = posting.machine.format;
    format.feed_mode = FeedMode::kPerMinute, format.feed_measure = FeedMeasure::kXyz;
    format.inches = inches;
    if (inches) ++format.linear_decimals;
    const JointPath path = printed_path(cut(true), format);
    const ProgramFormat whole = format;
    posting = posting_of(GetParam(), {&path});
    posting.machine.format = whole;
    job_.machine = posting.machine;
    job_.setup = posting.operations[0].setup;
    job_.program = {};
    job_.program.tool = 3;
    text = text_of(posting);
    ProgramText lines;
    std::istringstream in(text), again(text), moves(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    EXPECT_EQ(fault(lines), "") << text;
    const auto read = read_nc_program(again, "p.nc", language_of(job_.machine));
    std::vector<TextBlock> blocks = read ? read->operations.at(0).blocks : std::vector<TextBlock>{};
    // By the judge's reader, too.
    ControlReader reader(job_.machine, job_.setup);
    std::vector<ControlBlock> seen;
    EXPECT_TRUE(
        read_control_program(moves, "p.nc", reader, [&](const ControlBlock& b) { seen.push_back(b); }));
    std::erase_if(seen,
                  [](const ControlBlock& b) { return b.block.op != Op::kFeed && b.block.op != Op::kRapid; });
    EXPECT_GE(seen.size(), 4u);
    const auto& last = seen[seen.size() - 2].block.target;  // the retract is behind it
    EXPECT_NEAR(last.x, blocks.back().words.x, 1e-9);
    EXPECT_NEAR(seen[seen.size() - 3].block.feed, blocks[blocks.size() - 2].feed, 1e-9);
    return blocks;
  };
  std::string mm_text, inch_text;
  const auto mm = blocks_of(false, mm_text), inch = blocks_of(true, inch_text);
  ASSERT_EQ(mm.size(), inch.size());
  const double half = 25.4 * 0.5 / decimal_scale(profile_of(GetParam()).format.linear_decimals + 1);
  for (std::size_t i = 0; i < mm.size(); ++i) {
    for (double Joints::*place : {&Joints::x, &Joints::y, &Joints::z})
      EXPECT_NEAR(inch[i].words.*place, mm[i].words.*place, half + 1e-9) << i;
    EXPECT_EQ(inch[i].words.c, mm[i].words.c);
    // F has five digits in either unit, and ways are rounded.
    EXPECT_NEAR(inch[i].feed, mm[i].feed, 2e-3 * mm[i].feed + 1e-9) << i;
  }
  const char* const unit = dialect == Dialect::kSiemens         ? "G700"
                           : dialect == Dialect::kHeidenhain    ? "PGM PART_7 INCH"
                           : dialect == Dialect::kHeidenhainIso ? "G70"
                                                                : "G20";
  EXPECT_NE(inch_text.find(unit), std::string::npos);
  EXPECT_NE(inch_text, mm_text);
  // A judge whose profile has the other unit.
  ProgramText lines;
  std::istringstream in(mm_text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  EXPECT_NE(fault(lines), "");
}

/// Damage that leaves every place of the path as it is: the retract elsewhere, another tool, a spindle that
/// stands.
TEST_P(ProgramOptions, WhatTheMachineWouldDoOtherwiseIsFound) {
  const Dialect dialect = GetParam().dialect;
  const bool tnc = dialect == Dialect::kHeidenhain || dialect == Dialect::kHeidenhainIso;
  ProgramText lines = text(false, {});
  job_.spindle_rpm = 8000;
  ASSERT_EQ(fault(lines), "");
  const auto damaged = [&](const std::string& line_with, const std::string& from, const std::string& to) {
    bool seen = false;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::size_t at = lines[i].find(from);
      if (lines[i].find(line_with) == std::string::npos || at == std::string::npos ||
          lines[i].find("TILTFEED") != std::string::npos || lines[i].find("M30") != std::string::npos)
        continue;
      seen = true;
      ProgramText bad = lines;
      bad[i].replace(at, from.size(), to);
      EXPECT_NE(fault(bad), "") << bad[i];
    }
    EXPECT_TRUE(seen) << line_with;
  };
  const std::string retract = dialect == Dialect::kFanuc     ? "G28"
                              : dialect == Dialect::kSiemens ? "SUPA"
                              : tnc                          ? "M91"
                                                             : "G53";
  damaged(retract, tnc ? "Z-1" : "Z0", "Z-300");
  damaged(retract, tnc ? "Z-1" : "Z0", tnc ? "X+0 Z-1" : "X0 Z0");
  if (tnc) damaged(retract, "M91", "M92");
  const std::string tool = dialect == Dialect::kHeidenhain ? "CALL 3" : "T3";
  damaged(tool, tool, tool.substr(0, tool.size() - 1) + "8");
  if (dialect == Dialect::kHeidenhain) {
    damaged(tool, "CALL 3 Z", "CALL 3 Z DL+5");
    damaged(tool, "CALL 3 Z", "CALL 3 X");
  }
  if (dialect == Dialect::kHeidenhainIso) damaged("G01", "F", "FMAX F");
  // What no posted program has.
  for (const char* code : {"M198", "M21", "M17", "M70"}) damaged("M8", "M8", code);
  // The spindle never starts, or stops on the way.
  damaged("M3", "M3", "M5");
  ProgramText bad = lines;
  const auto cut = std::find_if(bad.begin(), bad.end(), [](const std::string& line) {
    return line.find("X10") != line.npos || line.find("X+10") != line.npos;
  });
  ASSERT_NE(cut, bad.end());
  ProgramText turned = lines;
  for (std::string& line : turned)
    if (const std::size_t found = line.find("M3");
        found != line.npos && line.find("M30") == line.npos && line.find("TILT") == line.npos)
      line.replace(found, 2, "M4");
  EXPECT_NE(turned, lines);
  EXPECT_NE(fault(turned).find("counter-clockwise"), std::string::npos) << fault(turned);
  const std::string number = dialect == Dialect::kHeidenhain ? "99 " : "";
  bad.insert(cut, number + "M5" + (dialect == Dialect::kHeidenhainIso ? "*" : ""));
  EXPECT_NE(fault(bad), "");
  job_.spindle_rpm = 0;
  EXPECT_EQ(fault(bad), "") << "a job without a spindle's speed says nothing of it";
}

TEST(ProgramOptionsOfAJob, AreRefusedWhereTheControlHasNone) {
  ProgramData data;
  data.coolant = Coolant::kThrough, data.smoothing = Smoothing::kFinish, data.length_register = 4;
  const auto keys = [&](Dialect dialect) {
    std::string all;
    for (const auto& [key, why] : not_of_control(data, usual_format(dialect), "m.yaml"))
      all += std::string(key) + " ";
    return all;
  };
  EXPECT_EQ(keys(Dialect::kRs274), "coolant smoothing length_register ");
  EXPECT_EQ(keys(Dialect::kHaas), "length_register ") << "no tool is called";
  data.tool = 7;
  EXPECT_EQ(keys(Dialect::kHaas), "");
  EXPECT_EQ(keys(Dialect::kHeidenhain), "coolant length_register ");
  EXPECT_EQ(keys(Dialect::kGrbl), "coolant smoothing length_register ");
}

}  // namespace
}  // namespace tiltfeed::sim
