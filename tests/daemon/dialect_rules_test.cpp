// The rules of each control, on one short path: clamps, line numbers and ends, percent, start and end lines,
// limits, and what TCP asks for.

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tests/texts/dialect_posting.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

JointPath short_path() {
  JointPath path;
  path.moves = {{{0, -12.5, 100, 0, -90}, 0.0, MoveKind::kRapid, 0},
                {{1, -12.5, 10, 0, -90}, 4.0, MoveKind::kPlunge, 1},
                {{10, -12.5, 10, 0, -90}, 0.36, MoveKind::kCut, 2},
                {{10, -12.5, 10, 0, -80.5}, 0.1, MoveKind::kCut, 3},
                {{10, -12.5, 100, 30, -80.5}, 0.5, MoveKind::kRapid, 4},
                {{11, -12.5, 100, 30, -80.5}, 0.5, MoveKind::kCut, 5}};
  return path;
}

TEST(Dialect, ClampsCloseWhereTheirAxisStandsAndOpenBeforeItTurns) {
  const JointPath path = short_path();
  Posting posting = posting_of({Dialect::kHaas, false}, {&path});
  ProgramFormat& format = posting.machine.format;
  format.clamp_tilt = "M10", format.unclamp_tilt = "M11", format.clamp_rotary = "M12",
  format.unclamp_rotary = "M13";
  std::string codes;
  for (const std::string& line : lines_of(text_of(posting)))
    if (line == "M10" || line == "M11" || line == "M12" || line == "M13")
      codes += line + " ";
    else if (line.find_first_of("XBC") != line.npos)
      codes += ". ";
  // Start; the rotaries, then X Y, go to their first place; tilt stands in the first cut, rotary does not;
  // tilt turns on the rapid; both stand in the last cut.
  EXPECT_EQ(codes.substr(codes.find("M11")), "M11 M13 . . M10 . . . M11 . M10 M12 . ");
}

// (dialect.h, property 4)
TEST(Dialect, LineNumbersLineEndsAndPercentAreTheProfiles) {
  const JointPath path = short_path();
  for (const DialectCase& c : dialect_cases()) {
    SCOPED_TRACE(name_of(c.dialect).name);
    Posting posting = posting_of(c, {&path});
    const std::string plain = text_of(posting);
    const bool numbered = c.dialect == Dialect::kHeidenhain || c.dialect == Dialect::kHeidenhainIso;
    EXPECT_EQ(plain.find('\r'), plain.npos);
    EXPECT_EQ(plain.rfind("%\n", 0) == 0, c.dialect == Dialect::kFanuc || c.dialect == Dialect::kHaas);
    if (has_percent(c.dialect)) {
      posting.machine.format.percent = false;
      EXPECT_EQ(text_of(posting).find('%'), plain.npos);
      posting.machine.format.percent = true;
      const std::vector<std::string> lines = lines_of(text_of(posting));
      EXPECT_EQ(lines.front(), "%");
      EXPECT_EQ(lines.back(), "%");
      EXPECT_EQ(std::count(lines.begin(), lines.end(), "%"), 2);
    }
    posting.machine.format = usual_format(c.dialect);
    posting.machine.format.tcp = c.tcp;
    posting.machine.format.crlf = true;
    std::string crlf = text_of(posting), stripped;
    for (std::size_t i = 0; i < crlf.size(); ++i) {
      EXPECT_EQ(crlf[i] == '\n', i > 0 && crlf[i - 1] == '\r');
      if (crlf[i] != '\r') stripped += crlf[i];
    }
    EXPECT_EQ(stripped, plain);
    if (numbered) continue;  // always: HeidenhainNumbersEveryLineOnce
    posting.machine.format.crlf = false;
    posting.machine.format.line_numbers = true;
    posting.machine.format.line_number_step = 7;
    int number = 1;
    std::string bare;
    for (const std::string& line : lines_of(text_of(posting))) {
      const std::string word = "N" + std::to_string(number) + " ";
      if (line.rfind(word, 0) == 0) number += 7;
      bare += (line.rfind(word, 0) == 0 ? line.substr(word.size()) : line) + "\n";
    }
    EXPECT_EQ(bare, plain) << "nothing but numbers, in their order";
    EXPECT_GT(number, 7 * static_cast<int>(path.moves.size()));
  }
}

TEST(Dialect, StartAndEndLinesOfTheProfile) {
  const JointPath path = short_path();
  for (const Dialect dialect : {Dialect::kRs274, Dialect::kFanuc, Dialect::kHaas}) {
    Posting posting = posting_of({dialect, false}, {&path, &path});
    posting.machine.format.start = {"M77", "G53 G0 Z-1"};
    posting.machine.format.end = {"G53 G0 X-2 Y-3"};
    const std::vector<std::string> lines = lines_of(text_of(posting));
    const auto at = [&](const std::string& text) {
      EXPECT_EQ(std::count(lines.begin(), lines.end(), text), 1) << text;
      return std::find(lines.begin(), lines.end(), text) - lines.begin();
    };
    const auto motion =
        std::find_if(lines.begin(), lines.end(),
                     [](const std::string& line) {
                       return line.find("X") != line.npos && line.find("C") != line.npos && line[0] != '(';
                     }) -
        lines.begin();
    EXPECT_LT(at("G53 G0 Z-1"), motion);
    EXPECT_EQ(at("M77") + 1, at("G53 G0 Z-1"));
    EXPECT_EQ(lines[static_cast<std::size_t>(at("G53 G0 X-2 Y-3")) + 1],
              dialect == Dialect::kRs274 ? "M2" : "M30");
    // Moves in machine coordinates are none of the path.
    std::istringstream in(text_of(posting));
    const auto read = read_nc_program(in, "x.nc", language_of(posting.machine));
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->operations[0].blocks.size(), path.moves.size());
    EXPECT_EQ(read->operations[1].blocks.size(), path.moves.size());
  }
}

// (block.h, property 4)
TEST(Dialect, LimitsOfBlocksAndBytesAreKept) {
  const JointPath path = short_path();
  Posting posting = posting_of({Dialect::kFanuc, false}, {&path});
  std::ostringstream out;
  posting.machine.format.max_blocks = 5;
  auto refused = write_program(posting, out);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kLimit);
  EXPECT_NE(refused.error().message.find("6 blocks, the control takes 5"), std::string::npos);
  posting.machine.format.max_blocks = 6;
  const std::size_t size = text_of(posting).size();
  posting.machine.format.max_bytes = static_cast<int>(size);
  EXPECT_TRUE(write_program(posting, out));
  posting.machine.format.max_bytes = static_cast<int>(size) - 1;
  refused = write_program(posting, out);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("longer than the"), std::string::npos);
}

TEST(Dialect, TcpWithHWantsATool) {
  const JointPath path = short_path();
  for (const Dialect dialect : {Dialect::kFanuc, Dialect::kHaas}) {
    Posting posting = posting_of({dialect, true}, {&path});
    posting.operations[0].tool_number = 0;
    std::ostringstream out;
    const auto refused = write_program(posting, out);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("needs a tool number"), std::string::npos);
  }
}

// (dialect.h, property 4)
TEST(Dialect, HeidenhainNumbersEveryLineOnce) {
  const JointPath path = short_path();
  const std::string plain = text_of(posting_of({Dialect::kHeidenhain, true}, {&path}));
  int number = 0;
  for (const std::string& line : lines_of(plain)) {
    if (line[0] == ' ') continue;
    EXPECT_EQ(line.rfind(std::to_string(number++) + " ", 0), 0u) << line;
  }
  const std::string iso = text_of(posting_of({Dialect::kHeidenhainIso, false}, {&path}));
  number = 0;
  for (const std::string& line : lines_of(iso)) {
    EXPECT_EQ(line.back(), '*') << line;
    if (line[0] == '%' || line.rfind("N99999999", 0) == 0) continue;
    EXPECT_EQ(line.rfind("N" + std::to_string(number += 10) + " ", 0), 0u) << line;
  }
}

}  // namespace
}  // namespace tiltfeed
