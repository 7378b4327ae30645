// The simulated machine's G-code reader and its trace file.

#include "sim/gcode/gcode_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>
#include <sstream>

#include "sim/motion/trace.h"

namespace tiltfeed::sim {
namespace {

GcodeReader reader() { return GcodeReader('A', 'C'); }

std::vector<Block> read_all(const std::string& text) {
  std::istringstream in(text);
  auto blocks = read_program(in, "test.nc", 'A', 'C');
  EXPECT_TRUE(blocks) << (blocks ? "" : blocks.error().message);
  return blocks.value_or(std::vector<Block>{});
}

TEST(SimProgram, RelativeWordsOnlyWhereTheyAreAskedFor) {
  GcodeReader reader = GcodeReader('A', 'C').with_relative();
  const auto ends_at = [&](const char* line) {
    const auto blocks = reader.read_line(line);
    EXPECT_TRUE(blocks) << line << ": " << blocks.error().message;
    return reader.modal().at;
  };
  ends_at("G0 X1 Y2 Z3 A4 C5");
  EXPECT_EQ(ends_at("G91 G0 X1 Z-2 C-3"), (Joints{2, 2, 1, 4, 2}));
  EXPECT_EQ(ends_at("X1 A.5"), (Joints{3, 2, 1, 4.5, 2}));
  EXPECT_EQ(ends_at("G90 Y7"), (Joints{3, 7, 1, 4.5, 2}));
  ends_at("G91");
  ends_at("M2");
  EXPECT_EQ(ends_at("G0 X1"), (Joints{1, 7, 1, 4.5, 2})) << "the end of a program restores G90";
}

TEST(SimProgram, FillsInModalValues) {
  const std::vector<Block> blocks = read_all(
      "%\n(a part)\nG21 G90 G17 G40 G49 G54 G64 G80\nS8000 M3\nG0 X1 Y-2.5 Z+3. A.5 C-180\n"
      "G93\nN70 G1 X2 F120\nC-179.5 F60 ; modal G1\nG94 G1 Y0 F500\nZ1\nG4 P0.25\nM5\nM2\nG0 X99\n");
  ASSERT_EQ(blocks.size(), 9U);
  EXPECT_EQ(blocks[0].op, Op::kMCode);
  EXPECT_EQ(blocks[0].m_code, 3);
  EXPECT_EQ(blocks[0].spindle, 8000);
  EXPECT_EQ(blocks[1].op, Op::kRapid);
  EXPECT_EQ(blocks[1].target, (Joints{1, -2.5, 3, .5, -180}));
  EXPECT_EQ(blocks[1].line, 5U);
  EXPECT_EQ(blocks[2].op, Op::kFeed);
  EXPECT_TRUE(blocks[2].inverse_time);
  EXPECT_EQ(blocks[2].feed, 120);
  EXPECT_EQ(blocks[2].line, 70U);
  EXPECT_EQ(blocks[2].target, (Joints{2, -2.5, 3, .5, -180}));
  EXPECT_EQ(blocks[3].target.c, -179.5);
  EXPECT_EQ(blocks[3].line, 8U);
  EXPECT_FALSE(blocks[4].inverse_time);
  EXPECT_EQ(blocks[5].feed, 500) << "F stays in G94";
  EXPECT_EQ(blocks[5].target, (Joints{2, 0, 1, .5, -179.5}));
  EXPECT_EQ(blocks[6].op, Op::kDwell);
  EXPECT_EQ(blocks[6].feed, 0.25);
  EXPECT_EQ(blocks[8].m_code, 2);
}

/// G53: Z from the top of its travel. Until X, Y and Z are stated the machine comes from anywhere.
TEST(SimProgram, MachineCoordinatesAndTheWayToTheFirstBlock) {
  MachineModel machine;
  machine.z.max = 300;
  machine.tilt.letter = 'A', machine.rotary.letter = 'C';
  std::istringstream in("G53 G0 Z-1\nG0 A4 C5\nX1 Y2\nZ3\nG1 X4 F10\nG53 G0 Z0\nA0\nZ9\nM2\n");
  const auto blocks = read_program(in, "x.nc", GcodeReader(machine));
  ASSERT_TRUE(blocks) << blocks.error().message;
  const std::vector<Joints> targets{{0, 0, 299, 0, 0}, {0, 0, 299, 4, 5}, {1, 2, 299, 4, 5}, {1, 2, 3, 4, 5},
                                    {4, 2, 3, 4, 5},   {4, 2, 300, 4, 5}, {4, 2, 300, 0, 5}, {4, 2, 9, 0, 5}};
  ASSERT_EQ(blocks->size(), targets.size() + 1);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    EXPECT_EQ((*blocks)[i].target, targets[i]) << i;
    EXPECT_EQ((*blocks)[i].placed, i >= 2) << i;
    EXPECT_EQ((*blocks)[i].off_path, i != 4) << i;
  }
  for (const char* bad : {"G53 G0 X1", "G53 G0 Z1 Y1", "G53 G1 Z1 F1", "G53"}) {
    GcodeReader reader(machine);
    EXPECT_FALSE(reader.read_line(bad)) << bad;
  }
}

TEST(SimProgram, ExactStopIsModal) {
  const std::vector<Block> blocks =
      read_all("G1 X1 F100\nG61 X2\nX3\nG64 X4\nG61.1\nG0 X5\nG64 P0.01 X6\nM2\n");
  ASSERT_EQ(blocks.size(), 7U);
  const bool stops[] = {false, true, true, false, true, false};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(blocks[i].exact_stop, stops[i]) << i;
}

TEST(SimProgram, WordsComeInAnyOrderCaseAndSpacing) {
  const char* lines[] = {"G1 X1.5 Y2 A-3 F100", "f100y2x1.5a-3g1", "  N9 g 1 (go) x 1 . 5\tY2 A - 3 F1 00\r",
                         "Y2G01X+1.5A-3.0F100.0"};
  for (const char* line : lines) {
    GcodeReader r = reader();
    const auto blocks = r.read_line(line);
    ASSERT_TRUE(blocks) << line << ": " << blocks.error().message;
    ASSERT_EQ(blocks->size(), 1U) << line;
    EXPECT_EQ((*blocks)[0].target, (Joints{1.5, 2, 0, -3, 0})) << line;
    EXPECT_EQ((*blocks)[0].feed, 100) << line;
  }
}

TEST(SimProgram, OrderOfExecutionOnOneLine) {
  GcodeReader r = reader();
  const auto blocks = r.read_line("M2 G0 X5 M8 M3 S100 M6 T1");
  ASSERT_TRUE(blocks);
  ASSERT_EQ(blocks->size(), 5U);
  EXPECT_EQ((*blocks)[0].m_code, 6);
  EXPECT_EQ((*blocks)[1].m_code, 3);
  EXPECT_EQ((*blocks)[2].m_code, 8);
  EXPECT_EQ((*blocks)[2].target.x, 0) << "M8 happens before the move";
  EXPECT_EQ((*blocks)[3].op, Op::kRapid);
  EXPECT_EQ((*blocks)[4].m_code, 2);
  EXPECT_EQ((*blocks)[4].target.x, 5);
  EXPECT_TRUE(r.ended());
}

TEST(SimProgram, LinesWithoutBlocks) {
  for (const char* line : {"", "   ", "\r", "%", "(only a comment)", "; only a comment", "G90 G21", "G1 F100",
                           "N10", "G93", "T3", "G97 S100", "G61", "G61.1", "G64 P0.01"}) {
    GcodeReader r = reader();
    const auto blocks = r.read_line(line);
    ASSERT_TRUE(blocks) << line << ": " << blocks.error().message;
    EXPECT_TRUE(blocks->empty()) << line;
  }
}

TEST(SimProgram, RefusesWithTheFaultAndTheWord) {
  const struct {
    const char* before;
    const char* line;
    Fault fault;
    const char* named;
  } cases[] = {
      {"", "G20", Fault::kUnsupported, "inches"},
      {"", "G91", Fault::kUnsupported, "incremental"},
      {"", "G28", Fault::kUnsupported, "G28"},
      {"G0 X0 Y0 Z0", "G2 X1 F1", Fault::kNoCentre, "I and J"},
      {"G0 X0 Y0 Z0", "G3", Fault::kNoMotionMode, "'G3'"},
      {"G0 X0 Y0 Z0 G18", "G2 X1 F1", Fault::kNoCentre, "K and I"},
      {"G0 X0 Y0 Z0", "G2 X1 F1 R1", Fault::kUnsupported, "R1"},
      {"G0 X0 Y0 Z0", "G2 X1 F1 I0.5 K0", Fault::kUnusedWord, "K is no word of an arc in G17"},
      {"G0 X0 Y0 Z0", "G3 X1 F1 I0.49", Fault::kBadArc, "ends 0.51 mm"},
      {"G0 X0 Y0 Z0", "G3 X0 Y0 F1 I0.5", Fault::kBadArc, "full circle"},
      {"G0 X0 Y0 Z0", "G3 X1 Z1 F1 I0.5", Fault::kBadArc, "moves Z"},
      {"G0 X0 Y0 Z0 A0", "G3 X1 A1 F1 I0.5", Fault::kBadArc, "rotary"},
      {"G0 X0 Y0", "G3 X1 F1 I0.5", Fault::kUnsupported, "not known"},
      {"G93 G0 X0 Y0 Z0", "G3 X1 I0.5", Fault::kNoFeed, "F"},
      {"", "G43.4", Fault::kUnsupported, "tool centre"},
      {"", "G92 X0", Fault::kUnsupported, "G92"},
      {"", "M98", Fault::kUnsupported, "M98"},
      {"", "G0 B5", Fault::kUnsupported, "B5"},
      {"", "G1 X1 F1 I3", Fault::kUnusedWord, "I belongs"},
      {"", "G0 G1 X1 F1", Fault::kModalConflict, "G1"},
      {"", "M3 M5", Fault::kModalConflict, "M5"},
      {"", "G93 G94", Fault::kModalConflict, "G94"},
      {"", "M2 M30", Fault::kModalConflict, "M30"},
      {"", "G0 X1 X2", Fault::kRepeatedWord, "X2"},
      {"", "G1 X1", Fault::kNoFeed, "F"},
      {"", "G1 X1 F0", Fault::kNoFeed, "F"},
      {"G93 G1 X1 F10", "X2", Fault::kNoFeed, "F"},
      {"G93 G1 X1 F10", "G94 X2", Fault::kNoFeed, "F"},
      {"G94 G1 X1 F10", "G93 X2", Fault::kNoFeed, "F"},
      {"", "X1", Fault::kNoMotionMode, "G0"},
      {"G0 X1", "G80 X2", Fault::kNoMotionMode, "G0"},
      {"", "G4", Fault::kMissingP, "P"},
      {"", "G4 P-1", Fault::kNegative, "P-1"},
      {"", "G4 P1 X5", Fault::kUnusedWord, "axis"},
      {"", "G0 X1 P5", Fault::kUnusedWord, "P"},
      {"", "G1 X1 F-5", Fault::kNegative, "F-5"},
      {"", "S-1 M3", Fault::kNegative, "S-1"},
      {"", "G0 X1e3", Fault::kBadNumber, "X1"},
      {"", "G0 X1E-3", Fault::kBadNumber, "X1"},
      {"", "G0 X1.2.3", Fault::kBadNumber, "X1.2.3"},
      {"", "G0 X1,5", Fault::kBadNumber, "X1,5"},
      {"", "G0 X", Fault::kBadNumber, "X"},
      {"", "G0 X-", Fault::kBadNumber, "X-"},
      {"", "G0 X+-1", Fault::kBadNumber, "X+-1"},
      {"", "G0 X--1", Fault::kBadNumber, "X--1"},
      {"", "G0 X.", Fault::kBadNumber, "X."},
      {"", "G0 Xinf", Fault::kBadNumber, "X"},
      {"", "G0 Xnan", Fault::kBadNumber, "X"},
      {"", "G0 X1#2", Fault::kBadNumber, "X1#2"},
      {"", "/G0 X1", Fault::kNoLetter, "/"},
      {"", "\xEF\xBB\xBFG0 X1", Fault::kNoLetter, "letter"},
      {"", "G0 X1 (open", Fault::kNoLetter, ")"},
      {"", "G0 (a (b) c) X1", Fault::kNoLetter, "("},
      {"", "G1.5 X1", Fault::kUnsupported, "G1.5"},
      {"", "G1.05 X1", Fault::kNotInteger, "G1.05"},
      {"", "M3.5", Fault::kNotInteger, "M3.5"},
      {"", "G-1", Fault::kNotInteger, "G-1"},
      {"", "T1.5", Fault::kNotInteger, "T1.5"},
      {"", "N1.5 G0 X1", Fault::kLineNumber, "N1.5"},
      {"", "N-1", Fault::kLineNumber, "N-1"},
      {"", "N4294967296", Fault::kLineNumber, "N4294967296"},
  };
  for (const auto& c : cases) {
    GcodeReader r = reader();
    ASSERT_TRUE(r.read_line(c.before)) << c.before;
    const ModalState before = r.modal();
    const auto blocks = r.read_line(c.line);
    ASSERT_FALSE(blocks) << c.line;
    EXPECT_EQ(blocks.error().code, Code::kInput);
    EXPECT_EQ(r.fault(), c.fault) << c.line << ": " << blocks.error().message;
    EXPECT_NE(blocks.error().message.find(c.named), std::string::npos)
        << c.line << ": " << blocks.error().message;
    EXPECT_EQ(r.modal().at, before.at) << c.line;
    EXPECT_EQ(r.modal().feed, before.feed) << c.line;
    EXPECT_EQ(r.modal().inverse_time, before.inverse_time) << c.line;
  }
}

TEST(SimProgram, WhatIsNoProgramIsToldInFewPrintableLetters) {
  const std::string text = "\x1b[2J\xff\x01" + std::string(100000, '7');
  const auto blocks = reader().read_line(text);
  ASSERT_FALSE(blocks);
  const std::string& said = blocks.error().message;
  EXPECT_LT(said.size(), 100u);
  EXPECT_TRUE(std::all_of(said.begin(), said.end(), [](char c) { return c >= ' ' && c <= '~'; })) << said;
}

TEST(SimProgram, OtherLettersForOtherMachines) {
  GcodeReader r('B', 'W');
  const auto blocks = r.read_line("G0 B12 W-7");
  ASSERT_TRUE(blocks);
  EXPECT_EQ((*blocks)[0].target, (Joints{0, 0, 0, 12, -7}));
  EXPECT_FALSE(r.read_line("G0 A1"));
}

TEST(SimProgram, NamesFileAndLine) {
  std::istringstream in("G21\nG0 X0\nG1 X1 F100\nG2 X3\n");
  const auto blocks = read_program(in, "part.nc", 'A', 'C');
  ASSERT_FALSE(blocks);
  EXPECT_EQ(blocks.error().message.rfind("part.nc:4: ", 0), 0U) << blocks.error().message;
}

TEST(SimProgram, CrAlone_IsALineEndAndNeverDropped) {
  const std::vector<Block> blocks = read_all("G0 X1 Y2 Z3 A0 C0 ; a comment\rG1 X5 F600\rY10\r\nX6\r");
  ASSERT_EQ(blocks.size(), 4U);
  EXPECT_EQ(blocks[1].target, (Joints{5, 2, 3, 0, 0}));
  EXPECT_EQ(blocks[2].target, (Joints{5, 10, 3, 0, 0}));
  EXPECT_EQ(blocks[3].target, (Joints{6, 10, 3, 0, 0}));
  EXPECT_FALSE(reader().read_line("G0 X5\rY10")) << "it is two lines";
  // A CR LF that the reading-ahead cuts in two is one end.
  std::string text = "G0 X0 Y0 Z0 A0 C0\r\n";
  for (int i = 1; i <= 30000; ++i) text += "X" + std::to_string(i % 900) + (i % 7 ? "\r\n" : " \r\n");
  std::istringstream in(text + "G7 X1");
  const auto wrong = read_program(in, "part.nc", 'A', 'C');
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().message.rfind("part.nc:30002: ", 0), 0U) << wrong.error().message;
}

TEST(SimProgram, EndsAtM2AndAtTheSecondPercent) {
  EXPECT_EQ(read_all("G0 X1\nM30\nnot even G-code\n").size(), 2U);
  EXPECT_EQ(read_all("%\nG0 X1\n%\nnot even G-code\n").size(), 1U);
  GcodeReader r = reader();
  ASSERT_TRUE(r.read_line("G93 G1 X1 F5"));
  ASSERT_TRUE(r.read_line("M2"));
  const auto after = r.read_line("G1 X2 F5");
  ASSERT_TRUE(after);
  EXPECT_FALSE((*after)[0].inverse_time) << "the end of a program restores G94";
}

// Values printed with printf and read back: the same decimal, so the same double.
TEST(SimProgram, ReadsBackWhatPrintfWrote) {
  std::mt19937 random(99);
  std::uniform_real_distribution<double> value(-2000, 2000);
  GcodeReader r = reader();
  for (int i = 0; i < 5000; ++i) {
    double words[5];
    char line[160];
    for (double& word : words) {
      char text[40];
      std::snprintf(text, sizeof text, "%.4f", value(random));
      word = std::strtod(text, nullptr);
    }
    std::snprintf(line, sizeof line, "G93 G1 X%.4f Y%.4f Z%.4f A%.4f C%.4f F%.3f", words[0], words[1],
                  words[2], words[3], words[4], 12.5);
    const auto blocks = r.read_line(line);
    ASSERT_TRUE(blocks) << line;
    EXPECT_EQ((*blocks)[0].target, (Joints{words[0], words[1], words[2], words[3], words[4]})) << line;
  }
}

TEST(SimProgram, AnyBytesGiveAnErrorOrABlock) {
  std::mt19937 random(5);
  const std::string alphabet = "GMXYZACFNSTP0123456789.-+() ;%E\t\x80\xff$!?";
  std::uniform_int_distribution<std::size_t> pick(0, alphabet.size() - 1), length(0, 30);
  GcodeReader r = reader();
  int refused = 0;
  for (int i = 0; i < 200000; ++i) {
    std::string line(length(random), ' ');
    for (char& c : line) c = alphabet[pick(random)];
    const auto blocks = r.read_line(line);
    refused += !blocks;
    if (!blocks) continue;
    EXPECT_EQ(r.fault(), Fault::kNone);
    for (const Block& block : *blocks) EXPECT_TRUE(std::isfinite(block.target.x)) << line;
  }
  EXPECT_GT(refused, 100000);
}

TEST(SimProgram, AMillionLines) {
  std::string text;
  for (int i = 0; i < 200000; ++i)
    text += "G1X" + std::to_string(i % 100) + ".1234Y-12.3456Z7.8901A12.3456C-123.4567F1234.567\n";
  std::istringstream in("G93\n" + text);
  const auto begin = std::chrono::steady_clock::now();
  const auto blocks = read_program(in, "long.nc", 'A', 'C');
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ASSERT_TRUE(blocks);
  EXPECT_EQ(blocks->size(), 200000U);
  std::printf("%.2f million lines/s\n", 0.2 / seconds);
}

TraceRow row_of(Op op, int m_code, bool inverse) {
  TraceRow row;
  row.block = 123456789012;
  row.command.op = op;
  row.command.m_code = m_code;
  row.command.inverse_time = inverse;
  row.command.feed = op == Op::kRapid || op == Op::kMCode ? 0 : 1234.567;
  row.command.spindle = op == Op::kMCode ? 8000 : 0;
  row.command.line = 4294967295;
  row.command.target = {-1.2345, 1000.5, -0.000125, 89.9999, -3600.1234};
  row.start = 86400.000001;
  row.end = 86400.000003;
  row.peak_rate = 123.456789, row.peak_acceleration = 0.000001;
  row.pose = {{-12.123456789, 0.000000001, 300}, {0.267261242, 0.534522484, 0.801783726}};
  return row;
}

TEST(SimTrace, ReadsBackWhatItWrote) {
  const std::vector<TraceRow> rows{row_of(Op::kRapid, -1, false), row_of(Op::kFeed, -1, false),
                                   row_of(Op::kFeed, -1, true), row_of(Op::kDwell, -1, false),
                                   row_of(Op::kMCode, 30, false)};
  std::stringstream file;
  write_trace_header(file);
  for (const TraceRow& row : rows) write_trace_row(row, file);
  const auto read = read_trace(file, "trace.csv");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TraceRow &a = rows[i], &b = (*read)[i];
    EXPECT_EQ(a.block, b.block);
    EXPECT_EQ(a.command.op, b.command.op);
    EXPECT_EQ(a.command.m_code, b.command.m_code);
    EXPECT_EQ(a.command.inverse_time, b.command.inverse_time);
    EXPECT_EQ(a.command.feed, b.command.feed);
    EXPECT_EQ(a.command.spindle, b.command.spindle);
    EXPECT_EQ(a.command.line, b.command.line);
    EXPECT_EQ(a.command.target, b.command.target);
    EXPECT_EQ(a.start, b.start);
    EXPECT_EQ(a.end, b.end);
    EXPECT_EQ(a.pose, b.pose);
    EXPECT_EQ(a.peak_rate, b.peak_rate);
    EXPECT_EQ(a.peak_acceleration, b.peak_acceleration);
  }
}

TEST(SimTrace, LeavesOutTheRowThatIsStillBeingWritten) {
  std::stringstream file;
  write_trace_header(file);
  write_trace_row(row_of(Op::kFeed, -1, true), file);
  write_trace_row(row_of(Op::kFeed, -1, true), file);
  const std::string text = file.str();
  for (const std::size_t cut : {std::size_t{1}, std::size_t{2}, std::size_t{30}}) {
    std::istringstream partial(text.substr(0, text.size() - cut));
    const auto read = read_trace(partial, "trace.csv");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->size(), 1U);
  }
}

TEST(SimTrace, RefusesWithNameAndLine) {
  const std::string header = std::string(kTraceHeader) + "\n";
  const std::string good = "1,2,rapid,0,1,1,2,3,4,5,0,1,2,3,0,0,1,5,6\n";
  {
    std::istringstream in(header + good);
    ASSERT_TRUE(read_trace(in, "t"));
  }
  const struct {
    std::string text;
    const char* named;
  } cases[] = {{"", "t:1:"},
               {"block,line\n", "t:1:"},
               {header + good + "1,2,rapid\n", "t:3: start_s"},
               {header + "x,2,rapid,0,1,1,2,3,4,5,0,1,2,3,0,0,1,5,6\n", "t:2: block"},
               {header + "1,-2,rapid,0,1,1,2,3,4,5,0,1,2,3,0,0,1,5,6\n", "t:2: line"},
               {header + "1,2,jump,0,1,1,2,3,4,5,0,1,2,3,0,0,1,5,6\n", "t:2: op"},
               {header + "1,2,M,0,1,1,2,3,4,5,0,1,2,3,0,0,1,5,6\n", "t:2: op"},
               {header + "1,2,rapid,0,1,nan,2,3,4,5,0,1,2,3,0,0,1,5,6\n", "t:2: x"},
               {header + "1,2,rapid,0,1,1,2,3,4,5,0,1,2,3,0,0,1z,5,6\n", "t:2: axis_k"},
               {header + "1,2,rapid,0,1,1,2,3,4,5,0,1,2,3,0,0,1,5,6,7\n", "t:2: the end"}};
  for (const auto& c : cases) {
    std::istringstream in(c.text);
    const auto read = read_trace(in, "t");
    ASSERT_FALSE(read) << c.text;
    EXPECT_EQ(read.error().message.rfind(c.named, 0), 0U) << read.error().message;
  }
}

}  // namespace
}  // namespace tiltfeed::sim
