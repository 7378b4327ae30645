// Seeded faults in printed programs of every dialect: what changes no move of the text but the machine's
// (retracts, safe words, work offset, length register, the end) and the way that a rotary turns.

#include "sim/control/program_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <regex>
#include <sstream>

#include "config/program_lines.h"
#include "daemon/post/nc_reader.h"
#include "kinematics/basics/decimal.h"
#include "sim/control/control_reader.h"
#include "tests/texts/dialect_posting.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

/// A ring that the table turns twice, by 25 degrees a block, with a lean that comes and goes.
JointPath ring(const ProgramFormat& format) {
  JointPath path;
  for (int i = 0; i <= 58; ++i) {
    Joints at{10.0 + i, -5.0, 200.0 - (i > 0 ? 40.0 : 0.0), 20.0 * std::sin(0.3 * i), -200.0 + 25.0 * i};
    for (double* word : {&at.a, &at.c}) *word = round_decimal(*word, format.rotary_decimals);
    path.moves.push_back({at, i > 0 ? 1.0 : 0.0, i > 0 ? MoveKind::kCut : MoveKind::kRapid, 0});
  }
  return path;
}

using Lines = std::vector<std::string>;

struct Printed {
  Job job;
  Lines lines;

  Printed(const DialectCase& one, RotaryWord word, const std::function<void(ProgramFormat&)>& change = {},
          int work_offset = 1) {
    Posting posting = posting_of(one, {});
    const JointPath path = ring(posting.machine.format);
    posting = posting_of(one, {&path});
    posting.machine.model.rotary.word = word;
    if (change) change(posting.machine.format);
    posting.data.work_offset = job.program.work_offset = work_offset;
    job.machine = posting.machine;
    job.setup = posting.operations[0].setup;
    job.program.tool = posting.operations[0].tool_number;
    std::istringstream in(text_of(posting));
    for (std::string line; std::getline(in, line);) lines.push_back(line);
  }
  /// What the judges say of the text; empty: it is sound.
  std::string fault(const Lines& text) const {
    std::string all;
    for (const std::string& line : text) all += line + "\n";
    std::istringstream frame(all), moves(all);
    if (const auto sound = check_frame(frame, "p.nc", std::span(&job, 1)); !sound)
      return sound.error().message;
    ControlReader reader(job.machine, job.setup);
    const auto read = read_control_program(moves, "p.nc", reader, [](const ControlBlock&) {});
    return read ? "" : read.error().message;
  }
  /// Each line that fits, changed in turn; returns how many do.
  int seed(const std::string& pattern, const std::function<void(Lines&, std::size_t)>& damage) const {
    int seeded = 0;
    const std::regex fits(pattern);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i].find("TILTFEED") != std::string::npos || !std::regex_search(lines[i], fits)) continue;
      Lines bad = lines;
      damage(bad, i);
      ++seeded;
      EXPECT_NE(fault(bad), "") << lines[i];
    }
    return seeded;
  }
};

void drop(Lines& lines, std::size_t at) { lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(at)); }

class ProgramFrame : public testing::TestWithParam<DialectCase> {};
INSTANTIATE_TEST_SUITE_P(Control, ProgramFrame, testing::ValuesIn(dialect_cases()), case_name);

TEST_P(ProgramFrame, FindsEveryDroppedLineThatTheMachineNeeds) {
  const Printed printed(GetParam(), RotaryWord::kAccumulate);
  ASSERT_EQ(printed.fault(printed.lines), "");
  EXPECT_EQ(printed.seed("G28|G53|SUPA|M91", drop), 2) << "before the first move, and after the last";
  const Dialect dialect = GetParam().dialect;
  const bool tnc = dialect == Dialect::kHeidenhain || dialect == Dialect::kHeidenhainIso;
  if (tnc) {
    // The retract and the tool call of the ISO text say G90 G17 G40, too; END PGM ends the other.
    EXPECT_GE(printed.seed("T3|CALL 3|M129|PLANE RESET|ROT|G73|M127|Q339", drop), 6);
  } else {
    EXPECT_GE(printed.seed("G17|G69|TRAFOOF|TOROTOF|PAROTOF|TRANS|G54", drop), 1);
    EXPECT_EQ(printed.seed("M30|M2$", drop), 1);
    EXPECT_EQ(printed.seed("T3", drop), 1);
  }
  if (dialect == Dialect::kRs274) {
    EXPECT_EQ(printed.seed("^G43 H3", drop), 1);
  }
  if (has_inverse_time(dialect) && !GetParam().tcp) {
    EXPECT_EQ(printed.seed("^G94$", drop), 1);
  }
}

/// The text is read by the postprocessor's own reader, too.
TEST_P(ProgramFrame, CallsEveryWorkOffsetThatTheControlHas) {
  const int most = most_work_offsets(GetParam().dialect);
  for (const int offset : {1, 4, 5, 6, 7, 8, 9, 99, 105, 306, 999}) {
    if (offset > most) continue;
    SCOPED_TRACE(offset);
    Printed printed(GetParam(), RotaryWord::kAccumulate, {}, offset);
    EXPECT_EQ(printed.fault(printed.lines), "");
    std::string text;
    for (const std::string& line : printed.lines) text += line + "\n";
    std::istringstream in(text);
    const auto read = read_nc_program(in, "p.nc", text_language(printed.job.machine));
    EXPECT_TRUE(read) << read.error().message;
    for (const int other : {offset - 1, offset + 1}) {
      printed.job.program.work_offset = other;
      EXPECT_NE(printed.fault(printed.lines), "") << other;
    }
  }
}

/// What a control knows a file by, and what is left in force behind the end.
TEST_P(ProgramFrame, FindsALostFirstOrLastLine) {
  const Printed printed(GetParam(), RotaryWord::kAccumulate);
  ASSERT_EQ(printed.fault(printed.lines), "");
  switch (GetParam().dialect) {
    case Dialect::kFanuc:
      EXPECT_EQ(printed.seed("^G90$", drop), 2);
      [[fallthrough]];
    case Dialect::kHaas:
      EXPECT_EQ(printed.seed("^%$", drop), 2);
      EXPECT_EQ(printed.seed("^O0", drop), 1);
      EXPECT_EQ(printed.seed("^G49$", drop), 2);
      break;
    case Dialect::kHeidenhain:
      EXPECT_EQ(printed.seed(" PGM ", drop), 2);
      EXPECT_EQ(printed.seed("BEGIN PGM ",
                             [](Lines& lines, std::size_t at) {
                               lines[at] = std::regex_replace(lines[at], std::regex(" MM"), "");
                             }),
                1);
      break;
    case Dialect::kHeidenhainIso:
      EXPECT_EQ(printed.seed("%PART", drop), 2);
      break;
    default:
      break;
  }
}

/// Ways to a place in machine coordinates whose motion word is lost.
TEST_P(ProgramFrame, FindsARetractThatIsNoRapid) {
  const Printed printed(GetParam(), RotaryWord::kAccumulate);
  ASSERT_EQ(printed.fault(printed.lines), "");
  const int retracts = GetParam().dialect == Dialect::kFanuc ? 0 : 2;  // G28 is one always
  EXPECT_EQ(printed.seed("G53|SUPA|M91",
                         [](Lines& lines, std::size_t at) {
                           lines[at] = std::regex_replace(lines[at], std::regex("G00? | FMAX"), "");
                         }),
            retracts);
}

/// TCP that begins without a word of an axis, or length compensation without Z.
TEST_P(ProgramFrame, FindsALostWordWhereTcpOrTheLengthBegins) {
  const Printed printed(GetParam(), RotaryWord::kAccumulate);
  ASSERT_EQ(printed.fault(printed.lines), "");
  const bool h = GetParam().dialect == Dialect::kFanuc || GetParam().dialect == Dialect::kHaas;
  const auto without = [](char letter) {
    return [=](Lines& lines, std::size_t at) {
      lines[at] = std::regex_replace(lines[at], std::regex(std::string(" ") + letter + "[-+.0-9]+"), "");
    };
  };
  if (h && !GetParam().tcp) {
    EXPECT_EQ(printed.seed("G43 H", without('Z')), 1);
  }
  if (!GetParam().tcp) return;
  for (const char letter : {'X', 'Y', 'Z', 'B', 'C'}) {
    SCOPED_TRACE(letter);
    EXPECT_EQ(printed.seed(h ? "G43.4|G234" : "G00? X.*Z.*B.*C|L X.*Z.*B.*C.*FMAX", without(letter)), 1);
  }
}

/// The length of one tool that is in force while the next is changed for.
TEST(ProgramFrame, FindsALengthThatIsLeftBeforeAToolChange) {
  for (const Dialect dialect : {Dialect::kFanuc, Dialect::kHaas}) {
    for (const bool tcp : {false, true}) {
      Posting posting = posting_of({dialect, tcp}, {});
      const JointPath path = ring(posting.machine.format);
      posting = posting_of({dialect, tcp}, {&path, &path});
      Job job;
      job.machine = posting.machine;
      std::string text = text_of(posting);
      const std::size_t change = text.find("T4 M6"), off = text.rfind("G49\n", change);
      ASSERT_NE(change, text.npos);
      std::istringstream sound(text);
      EXPECT_TRUE(check_frame(sound, "p.nc", std::span(&job, 1)));
      std::istringstream damaged(text.erase(off, 4));
      const auto found = check_frame(damaged, "p.nc", std::span(&job, 1));
      ASSERT_FALSE(found);
      EXPECT_NE(found.error().message.find("G49 is missing"), std::string::npos) << found.error().message;
    }
  }
}

/// The tool that is selected and never changed, and the way to a place of which nobody knows where it begins.
TEST_P(ProgramFrame, FindsALostToolChangeAndALostWayToTheFirstPlace) {
  const Printed printed(GetParam(), RotaryWord::kAccumulate);
  ASSERT_EQ(printed.fault(printed.lines), "");
  EXPECT_EQ(printed.seed("(G0|G00|L) B[^ ]* C[^ ]*( R0 FMAX)?$", drop), 1) << "the rotaries";
  EXPECT_EQ(printed.seed("(G0|G00|L) X[^ ]* Y[^ ZF]*( R0 FMAX)?$", drop), 1) << "X and Y";
  const Dialect dialect = GetParam().dialect;
  if (dialect == Dialect::kHeidenhain) {
    EXPECT_EQ(printed.seed("CYCL DEF 247", drop), 1);
  } else if (dialect == Dialect::kSiemens || dialect == Dialect::kGrbl) {
    EXPECT_EQ(printed.seed("^(M6|M0)$", drop), 1);
  } else if (dialect != Dialect::kHeidenhainIso) {
    EXPECT_EQ(printed.seed(" M6$",
                           [](Lines& lines, std::size_t at) {
                             lines[at] = std::regex_replace(lines[at], std::regex(" M6"), "");
                           }),
              1);
  }
  const auto without = [](const char* word) {
    return [=](Lines& lines, std::size_t at) {
      lines[at] = std::regex_replace(lines[at], std::regex(word), "");
    };
  };
  if (dialect == Dialect::kSiemens) {
    EXPECT_EQ(printed.seed("SUPA", without(" D0")), 2);
    if (GetParam().tcp) {
      EXPECT_EQ(printed.seed("ORIMKS", drop), 1);
      EXPECT_EQ(printed.seed("ORIMKS", without(" ORIAXES")), 1);
    }
  }
  if (dialect == Dialect::kFanuc) {
    EXPECT_EQ(printed.seed("G28", without("G91 ")), 2) << "by way of Z0, which is in the part";
    EXPECT_EQ(printed.seed("G28", without("Z0.")), 2);
  }
  if (dialect == Dialect::kRs274 || dialect == Dialect::kFanuc || dialect == Dialect::kHaas) {
    EXPECT_EQ(printed.seed("H3 ?", without("(G43.4|G43|G234) ?")), 1) << "H alone";
  }
}

TEST_P(ProgramFrame, FindsAnotherWorkOffsetAndLength) {
  const Printed printed(GetParam(), RotaryWord::kAccumulate);
  const auto replaced_by = [](const char* what, const char* with) {
    return [=](Lines& lines, std::size_t at) {
      lines[at] = std::regex_replace(lines[at], std::regex(what), with);
    };
  };
  EXPECT_GE(printed.seed("G54", replaced_by("G54", "G55")) +
                printed.seed("Q339", replaced_by("Q339=\\+1", "Q339=+2")),
            1);
  const Dialect dialect = GetParam().dialect;
  if (dialect == Dialect::kFanuc || dialect == Dialect::kHaas || dialect == Dialect::kRs274) {
    EXPECT_EQ(printed.seed(" H3", replaced_by("H3", "H4")), 1);
    EXPECT_EQ(printed.seed(" H3", replaced_by(" (G43|G43.4|G234|)? ?H3", "")), 1);
  }
  if (dialect == Dialect::kSiemens) {
    EXPECT_EQ(printed.seed("^D1$", replaced_by("D1", "D2")), 1);
  }
}

TEST_P(ProgramFrame, FindsALostWayOrSignOfARotary) {
  for (const RotaryWord word : {RotaryWord::kAccumulate, RotaryWord::kShortest, RotaryWord::kSigned}) {
    if (refusal_of(GetParam().dialect, word)) continue;
    SCOPED_TRACE("word " + std::to_string(static_cast<int>(word)));
    const Printed printed(GetParam(), word);
    ASSERT_EQ(printed.fault(printed.lines), "");
    if (word == RotaryWord::kAccumulate) {
      EXPECT_EQ(printed.seed("X.*C[+]?1000",
                             [](Lines& lines, std::size_t at) {
                               lines[at] = std::regex_replace(lines[at], std::regex("C([+]?)1000"), "C$01");
                             }),
                1);
    }
    const Dialect dialect = GetParam().dialect;
    const bool tnc = dialect == Dialect::kHeidenhain || dialect == Dialect::kHeidenhainIso;
    if (word == RotaryWord::kShortest && tnc) {
      EXPECT_EQ(printed.seed("M126", drop), 1);
    }
    if (word == RotaryWord::kShortest && GetParam().dialect == Dialect::kSiemens) {
      Lines bad = printed.lines;
      for (std::string& line : bad) line = std::regex_replace(line, std::regex("=DC\\(([0-9.]+)\\)"), "$1");
      EXPECT_NE(printed.fault(bad), "");
    }
    if (word == RotaryWord::kSigned) {
      EXPECT_GE(printed.seed("^(G1 )?X.*C(7|8|9|1[0-9])[0-9.]*( |$)",
                             [](Lines& lines, std::size_t at) {
                               lines[at] = std::regex_replace(lines[at], std::regex(" C"), " C-");
                             }),
                3);
    }
  }
}

/// A line of the profile that is equal to one of the post's own does not stand in for it.
TEST_P(ProgramFrame, FindsALostLineThatTheProfileHasToo) {
  const Printed plain(GetParam(), RotaryWord::kAccumulate);
  int dropped = 0;
  for (std::size_t i = 0; i < plain.lines.size(); ++i) {
    Lines bad = plain.lines;
    drop(bad, i);
    const std::string line(
        std::regex_replace(plain.lines[i], std::regex("^N?[0-9]+ | ?\\*$"), ""));  // its number
    const bool framed = line.find("PGM") != line.npos || line.front() == '%' || line.front() == 'O';
    if (plain.fault(bad) == "" || framed || line.find("TILTFEED") != line.npos || moves_the_tool(line) ||
        line.find("M30") == 0 || line.find("M2") == 0)
      continue;
    SCOPED_TRACE(line);
    const bool before = i < plain.lines.size() / 2;
    // A line that leaves G91 is followed by G90, as the profile must say it.
    const bool relative = line.find("G91") != line.npos;
    const Lines own = relative ? Lines{line, "G90"} : Lines{line};
    const Printed printed(GetParam(), RotaryWord::kAccumulate,
                          [&](ProgramFormat& format) { (before ? format.start : format.end) = own; });
    ASSERT_EQ(printed.fault(printed.lines), "");
    // The post's own is the first of them, or stands behind the profile's.
    const auto says = [&](std::size_t at) {
      return std::regex_replace(printed.lines[at], std::regex("^N?[0-9]+ | ?\\*$"), "") == line;
    };
    const std::size_t at = says(i) ? i : i + own.size();
    ASSERT_TRUE(says(at));
    ++dropped;
    Lines lost = printed.lines;
    drop(lost, at);
    EXPECT_NE(printed.fault(lost), "");
  }
  EXPECT_GE(dropped, 4);
}

/// What the reader understands of the profile's lines, it does as the control does.
TEST(ProgramFrame, TheProfilesLinesCount) {
  const Printed printed({Dialect::kFanuc, false}, RotaryWord::kAccumulate, [](ProgramFormat& format) {
    format.start = {"G5.1 Q1", "G91 G28 X0 Y0", "G90"};
    format.end = {"G91 G28 X0 Y0", "G90", "M77"};
  });
  EXPECT_EQ(printed.fault(printed.lines), "");
  EXPECT_EQ(printed.seed("^(G5.1 Q1|M77|G91 G28 X0 Y0)$", drop), 4) << "the profile's own lines are wanted";
  const Printed left({Dialect::kFanuc, false}, RotaryWord::kAccumulate, [](ProgramFormat& format) {
    format.start = {"G91", "M77"};
  });
  EXPECT_NE(left.fault(left.lines), "");
}

/// A retract of the profile's own is what its machine needs: at a feed, without a motion word, to M92.
TEST(ProgramFrame, TakesTheProfilesOwnRetract) {
  const struct {
    Dialect dialect;
    const char* retract;
  } table[]{{Dialect::kHaas, "G53 Z0."},
            {Dialect::kFanuc, "G53 Z0."},
            {Dialect::kRs274, "G1 G53 Z-2 F4000"},
            {Dialect::kGrbl, "G53 Z-1"},
            {Dialect::kSiemens, "G1 SUPA Z0 F9000"},
            {Dialect::kHeidenhain, "L Z-1 R0 F9999 M91"},
            {Dialect::kHeidenhain, "L Z-1 R0 FMAX M92"},
            {Dialect::kHeidenhainIso, "G01 G40 G90 Z-1 F9999 M91"}};
  for (const auto& row : table) {
    for (const bool tcp : {false, true}) {
      if (tcp && !has_tcp(row.dialect)) continue;
      SCOPED_TRACE(std::string(row.retract) + (tcp ? " TCP" : ""));
      EXPECT_EQ(no_retract(row.retract, row.dialect), std::nullopt);
      const Printed printed({row.dialect, tcp}, RotaryWord::kAccumulate,
                            [&](ProgramFormat& format) { format.retract = row.retract; });
      EXPECT_EQ(printed.fault(printed.lines), "");
      EXPECT_EQ(printed.seed("G53|SUPA|M9[12]", drop), 2);
    }
  }
}

TEST(ProgramFrame, AForeignProgramPasses) {
  Job job;
  std::istringstream in("G21 G90\nG0 X0 Y0 Z5 A0 C0\nG55\nM2\n");
  EXPECT_TRUE(check_frame(in, "p.nc", std::span(&job, 1)));
}

}  // namespace
}  // namespace tiltfeed::sim
