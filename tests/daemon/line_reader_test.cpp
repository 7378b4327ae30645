// LineReader files: what is stripped, what is refused, windows and passes; words and numeric blocks; LINK
// texts.

#include "daemon/program/line_reader.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "daemon/files/sha256.h"
#include "daemon/post/dialect_words.h"
#include "daemon/post/nc_rules.h"
#include "daemon/program/numeric_block.h"
#include "daemon/wire/link.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

/// A file that is gone when the test ends.
struct TempFile {
  explicit TempFile(const std::string& text) {
    char name[] = "/tmp/tiltfeed_program_XXXXXX";
    ::close(::mkstemp(name));
    path = name;
    std::ofstream(path, std::ios::binary) << text;
  }
  ~TempFile() { std::filesystem::remove(path); }
  std::string path;
};

Result<std::vector<Line>> read_all(const std::string& text) {
  const TempFile file(text);
  Result<LineReader> program = LineReader::open(file.path);
  if (!program) return tl::unexpected<Error>(program.error());
  std::vector<Line> lines;
  for (;;) {
    Line line;
    const Result<bool> more = program->next(line);
    if (!more) return tl::unexpected<Error>(more.error());
    if (!*more) return lines;
    lines.push_back(line);
  }
}

std::string joined(const std::string& text) {
  const auto lines = read_all(text);
  if (!lines) return "error " + lines.error().message;
  std::string all;
  for (const Line& line : *lines) all += std::to_string(line.number) + ":" + line.text + " ";
  return all;
}

/// Without their brackets and blanks these say another thing, and may have been sent so: CYCLE800 alone ends
/// the plane that it was to begin.
TEST(LineReader, RefusesWordsThatLoseTheirMeaningOnAWire) {
  for (const char* line :
       {"CYCLE800(0,\"\",0,27,0,0,0,30,0,0,0,0,0,1,0)", "G0 C=DC(10)", "FGROUP(X,Y,Z,A,C)", "G0 SUPA Z0 D0",
        "ORIMKS ORIAXES", "0 BEGIN PGM A MM", "N180 PLANE SPATIAL SPA+0 SPB+0 SPC+0 STAY SEQ+ TABLE ROT*",
        "13 TOOL CALL 3 Z", "12 L Z-1 R0 FMAX M91 DR MB"}) {
    const std::string said = joined("G21\n" + std::string(line) + "\n");
    EXPECT_NE(said.find(":2: column "), std::string::npos) << line << ": " << said;
    EXPECT_NE(said.find("(siemens, heidenhain)"), std::string::npos) << said;
  }
  // Comments, messages, and names that are one with or without blanks.
  EXPECT_EQ(joined("G1 X5(done)\nT3 M6(ball)\nM117 Hello World\nN5 M117 Hello World\nG28 X Y\n"
                   "#<my value> = 3\nIF [#1 EQ 2] THEN #1 = 3\n"),
            "1:G1X5 2:T3M6 3:M117HELLOWORLD 4:N5M117HELLOWORLD 5:G28XY 6:#<MYVALUE>=3 7:IF[#1EQ2]THEN#1=3 ");
}

TEST(Program, StripsWhatIsNotProgram) {
  EXPECT_EQ(joined("G1 X1.5 (comment ! ? ~ \x18 \x85) Y-2 ; tail ?!\r\n\n  \n(only)\n\tg0x0\n%\nG1X9\n"),
            "1:G1X1.5Y-2 5:G0X0 ");
  EXPECT_EQ(joined("%\n(TILTFEED x)\nG1X1\n%\nrest ! of the tape\n"), "3:G1X1 ");
  EXPECT_EQ(joined("\xEF\xBB\xBFG1X1"), "1:G1X1 ") << "byte-order mark and no line end";
  EXPECT_EQ(joined("G1X1\nM30\nG0Z-50\n"), "1:G1X1 2:M30 ") << "nothing after the program's end";
  EXPECT_EQ(joined("G1X1\nM02\nG0Z-50\n"), "1:G1X1 2:M02 ");
  EXPECT_EQ(joined("G1X20\nM20\nG0X1\n"), "1:G1X20 2:M20 3:G0X1 ") << "M20 is not M2";
  EXPECT_EQ(joined(std::string("G1\0X1\n", 6)), "1:G1X1 ");
}

TEST(Program, RefusesLiveBytesWithTheLine) {
  for (const std::string live : {"!", "~", "?", "\x18", "\x80", "\x85", "\xFF", "$"}) {
    const std::string message = joined("G1X1\nG1X" + live + "2\n");
    EXPECT_NE(message.find(":2: column 4"), std::string::npos) << message;
  }
  EXPECT_NE(joined("/G1X1\n").find("block delete"), std::string::npos);
  EXPECT_NE(joined("G1 (open\n").find(":1: column 4"), std::string::npos);
  EXPECT_NE(joined("G1X1\n" + std::string(257, '1') + "\n").find(":2: 257 bytes"), std::string::npos);
  EXPECT_NE(joined("(" + std::string(70000, 'x') + ")\n").find("longer than 65536"), std::string::npos);
  EXPECT_EQ(joined("(" + std::string(60000, 'x') + ")G1\n"), "1:G1 ");
}

TEST(Program, MarksLinesThatTravelAlone) {
  const auto lines = read_all("G1X1\nM0\nM3S100\nM6T1\nG10L2P1X0\nG28.1\nG28\nM00\nG4P2.5\nG04 P.5\nG10X1\n");
  ASSERT_TRUE(lines);
  const std::vector<bool> alone = {false, true, false, true, true, true, false, true, false, false, true};
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_EQ((*lines)[i].alone, alone[i]) << (*lines)[i].text;
  EXPECT_EQ((*lines)[8].dwell, 2.5);
  EXPECT_EQ((*lines)[9].dwell, 0.5);
  EXPECT_EQ((*lines)[2].dwell, 0.0);
}

TEST(Program, SurveyCountsAndRewinds) {
  const TempFile file("(TILTFEED part machine)\nG0X1\n\nG1X1234\nM2\n");
  auto program = LineReader::open(file.path);
  ASSERT_TRUE(program);
  const auto facts = program->survey();
  ASSERT_TRUE(facts) << facts.error().message;
  EXPECT_EQ(facts->lines, 3u);
  EXPECT_EQ(facts->bytes, 5u + 8u + 3u);
  EXPECT_EQ(facts->longest, 7u);
  EXPECT_EQ(facts->longest_line, 4u);
  EXPECT_EQ(facts->header, "TILTFEED part machine");
  Line line;
  ASSERT_TRUE(program->next(line).value());
  EXPECT_EQ(line.number, 2u);
  std::ofstream(file.path, std::ios::app) << "G1X5\n";
  ASSERT_TRUE(program->rewind());
  EXPECT_EQ(program->next(line).error().code, Code::kIo) << "the file has changed";
}

TEST(Program, ReadsWhatItHashed_AnEditInPlaceCannotReachTheWire) {
  std::string text;
  while (text.size() < 4 * ProgramFile::kPiece) text += "G1X" + std::to_string(text.size()) + "\n";
  text.resize(3 * ProgramFile::kPiece + 1000);
  text += "\n";
  struct Edit {
    const char* name;
    std::size_t at, cut;  // a byte that becomes 9, bytes that are left
  };
  const std::size_t all = text.size(), piece = ProgramFile::kPiece;
  for (const Edit& edit : {Edit{"first byte of a number", 3, all}, Edit{"second piece", piece + 99, all},
                           Edit{"last piece", all - 2, all}, Edit{"cut at a piece", all, 2 * piece},
                           Edit{"cut in a piece", all, 2 * piece + 7}, Edit{"cut to nothing", all, 0}}) {
    const TempFile file(text);
    auto program = LineReader::open(file.path);
    ASSERT_TRUE(program);
    const auto facts = program->survey();
    ASSERT_TRUE(facts);
    EXPECT_EQ(facts->hash, sha256(text)) << edit.name;
    const auto before = std::filesystem::last_write_time(file.path);
    if (edit.at < all) {
      std::fstream out(file.path, std::ios::in | std::ios::out | std::ios::binary);
      out.seekp(static_cast<std::streamoff>(edit.at));
      out.put(text[edit.at] == '9' ? '8' : '9');
    }
    std::filesystem::resize_file(file.path, edit.cut);
    std::filesystem::last_write_time(file.path, before);
    // Every line that is given out is the one that was hashed, up to the error.
    Line line;
    std::size_t at = 0;
    Result<bool> more = program->next(line);
    for (; more && *more; more = program->next(line)) {
      const std::size_t end = text.find('\n', at);
      ASSERT_EQ(line.text, text.substr(at, end - at)) << edit.name;
      at = end + 1;
    }
    ASSERT_FALSE(more) << edit.name;
    EXPECT_NE(more.error().message.find("was changed"), std::string::npos);
  }
  // What is behind the program's end counts, too: the file is not the one that was checked.
  const TempFile ended("G0X1\nM30\n" + std::string(2 * piece, ' '));
  auto program = LineReader::open(ended.path);
  const auto facts = program->survey();
  ASSERT_TRUE(facts);
  EXPECT_EQ(facts->hash, sha256(file_text(ended.path)));
}

TEST(Program, OpenErrors) {
  EXPECT_EQ(LineReader::open("/nonexistent.nc").error().code, Code::kIo);
  EXPECT_EQ(LineReader::open("/dev/null").error().code, Code::kInput);
  const TempFile empty("(nothing)\n%\n");
  auto program = LineReader::open(empty.path);
  EXPECT_EQ(program->survey().error().code, Code::kInput);
}

TEST(Program, LinesSurviveTheWindowsEdges) {
  std::mt19937 random(3);
  std::string text;
  std::vector<std::string> expected;
  for (int i = 0; i < 20000; ++i) {
    const std::string line = "G1X" + std::to_string(random() % 1000000);
    expected.push_back(line);
    text += line + (random() % 2 ? " (" + std::string(random() % 60, 'c') + ")\n" : "\n");
  }
  const auto lines = read_all(text);
  ASSERT_EQ(lines->size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ((*lines)[i].text, expected[i]);
    ASSERT_EQ((*lines)[i].number, i + 1);
  }
}

/// Line ends of the three kinds, in all places of the window.
TEST(Program, CrAlone_IsALineEndAndNeverDropped) {
  EXPECT_EQ(joined("G1 X5 F600\rY10\rM5\r"), "1:G1X5F600 2:Y10 3:M5 ");
  EXPECT_EQ(joined("G1X1\r\nG1X2\n\rG1X3\r\r\nG1X4"), "1:G1X1 2:G1X2 4:G1X3 6:G1X4 ");
  EXPECT_EQ(joined("; a comment ends there\rG1X1\rM30\rG0Z-50\r"), "2:G1X1 3:M30 ");
  EXPECT_EQ(joined("(open\rG1X1)\n").substr(0, 5), "error");
  std::mt19937 random(4);
  std::string text;
  for (int i = 0; i < 40000; ++i)
    text += "G1X" + std::to_string(i) + std::string(random() % 9, ' ') + (random() % 2 ? "\r\n" : "\r");
  const auto lines = read_all(text);
  ASSERT_TRUE(lines);
  ASSERT_EQ(lines->size(), 40000u);
  for (std::size_t i = 0; i < lines->size(); ++i) {
    ASSERT_EQ((*lines)[i].text, "G1X" + std::to_string(i));
    ASSERT_EQ((*lines)[i].number, i + 1);
  }
}

/// Python, word processors and old tapes end lines with them: dropped they would fuse two lines into one.
TEST(Program, OtherLineEnds_AreRefusedBetweenWords) {
  for (const std::string end : {"\v", "\f", "\x1C", "\x1D", "\x1E"}) {
    EXPECT_NE(joined("G1 X5 F600" + end + "Y10\n").find("error"), std::string::npos);
    EXPECT_NE(joined("G1 X5 F600" + end + " G0 Z5\n").find("column 11"), std::string::npos)
        << joined("G1 X5 F600" + end + "Y10\n");
    // A page's end, and what a comment holds, divide no words.
    EXPECT_EQ(joined(end + "G1 X5" + end + "\r\n" + end + "\nY1 (a" + end + "b)\n"), "1:G1X5 3:Y1 ");
  }
  EXPECT_EQ(joined(std::string("G1\0X5\x7F\n", 8) + "\x1A"), "1:G1X5 ") << "leader of a tape, end of a file";
}

TEST(Words, CrAlone_IsNoPartOfALine) {
  std::string_view rest = "\rY10";
  EXPECT_FALSE(take_word(rest));
  DialectWords words;
  EXPECT_TRUE(split_words("G1 X5\rY10", words));
  std::istringstream in("G1 X5\rY10\r\n\nM5");
  std::string line;
  std::vector<std::string> lines;
  while (read_bounded_line(in, line, 100) == LineRead::kLine) lines.push_back(line);
  EXPECT_EQ(lines, (std::vector<std::string>{"G1 X5", "Y10", "", "M5"}));
}

TEST(Words, TakesPlainDecimalNumbersOnly) {
  const auto value = [](std::string_view text) {
    const auto word = take_word(text);
    return word && text.empty() ? word->value : std::nan("");
  };
  EXPECT_EQ(value("X1.5"), 1.5);
  EXPECT_EQ(value("X-.5"), -0.5);
  EXPECT_EQ(value("X+2"), 2.0);
  EXPECT_EQ(value("X3."), 3.0);
  for (const char* bad :
       {"X", "X-", "X+", "X+-1", "X1E3", "XINF", "XNAN", "X--1", "1", "x1", "X0X10X", "X 1"})
    EXPECT_TRUE(std::isnan(value(bad))) << bad;
}

/// The blocks of a program, or the first error.
Result<std::vector<NumericBlock>> convert(const std::vector<std::string>& texts) {
  BlockReader reader;
  std::vector<NumericBlock> blocks;
  for (std::size_t i = 0; i < texts.size(); ++i)
    if (const auto read = reader.read({i + 1, texts[i], false, false, 0.0}, blocks); !read)
      return tl::unexpected<Error>(read.error());
  return blocks;
}

TEST(BlockReader, KeepsModalState) {
  const auto blocks = convert({"G21G90G17G40G49G54G80", "G0X1Y2Z3A4C5", "G93", "G1X2F10", "C-370.5F20", "G94",
                               "G1Z0F600", "Y0", "G0Z50", "M3S8000", "S9000", "M8", "G4P1.5", "M5M9", "M2"});
  ASSERT_TRUE(blocks) << blocks.error().message;
  ASSERT_EQ(blocks->size(), 13u);
  const auto& b = *blocks;
  EXPECT_EQ(b[0].op, BlockOp::kRapid);
  EXPECT_EQ(b[0].feed, 0.0);
  EXPECT_TRUE(b[1].inverse_time && b[2].inverse_time && !b[3].inverse_time);
  EXPECT_EQ(b[2].x, 2.0);
  EXPECT_EQ(b[2].tilt, 4.0);
  EXPECT_EQ(b[2].rotary, -370.5);
  EXPECT_EQ(b[2].feed, 20.0);
  EXPECT_EQ(b[3].feed, 600.0);
  EXPECT_EQ(b[4].feed, 600.0) << "G94 F is modal";
  EXPECT_EQ(b[4].y, 0.0);
  EXPECT_EQ(b[4].line, 8u);
  EXPECT_EQ(b[6].m_code, 3);
  EXPECT_EQ(b[6].spindle, 8000.0);
  EXPECT_EQ(b[7].m_code, 3) << "a new S while the spindle turns";
  EXPECT_EQ(b[7].spindle, 9000.0);
  EXPECT_EQ(b[9].op, BlockOp::kDwell);
  EXPECT_EQ(b[9].seconds, 1.5);
  EXPECT_EQ(b[10].m_code, 5);
  EXPECT_EQ(b[11].m_code, 9);
  EXPECT_EQ(b[12].m_code, 2);
}

TEST(BlockReader, OrdersOneLine) {
  const auto blocks = convert({"M30G1X1Y1Z1B1C1F100M3S1M8"});
  ASSERT_TRUE(blocks) << blocks.error().message;
  ASSERT_EQ(blocks->size(), 4u);
  EXPECT_EQ((*blocks)[0].m_code, 3);
  EXPECT_EQ((*blocks)[1].m_code, 8);
  EXPECT_EQ((*blocks)[2].op, BlockOp::kFeed);
  EXPECT_EQ((*blocks)[3].m_code, 30);
}

TEST(BlockReader, RefusesWhatItCannotExpress) {
  const std::string start = "G0X0Y0Z0A0C0";
  for (const char* bad :
       {"G2X1I1F1",        "G91",   "G20",   "G43.4H1", "G28",    "M62",    "M3.5", "G1X1", "G93G1X1", "X1E2",
        "G1X1F0",          "G4",    "G4P-1", "P1",      "G1U1F1", "G1B1F1", "M3M5", "M0M2", "#1=2",    "S-1",
        "G1X1F5000000000", "G1XNAN"})
    EXPECT_FALSE(convert({start, bad})) << bad;
  for (const std::vector<std::string>& lines :
       {std::vector<std::string>{"G1Z50F1"}, {"G0Z50", "G1Y2F1"}, {start, "G1Y2F1", "G53G1Z0"}}) {
    const auto unstated = convert(lines);
    ASSERT_FALSE(unstated);
    EXPECT_NE(unstated.error().message.find("X has no value yet"), std::string::npos);
  }
  const auto lost = convert({start, "G53G0Z0", "G1X2F1"});
  ASSERT_FALSE(lost);
  EXPECT_NE(lost.error().message.find("Z has no value yet"), std::string::npos);
}

/// The way from an unknown place: each rapid leaves alone what the program has not said.
TEST(BlockReader, RapidsKeepWhatIsNotSaid) {
  const auto blocks = convert({"G53G0Z-1", "G0A4C5", "X1Y2", "Z3", "G1X2F10", "G53G0Z0", "G0C6", "Z9"});
  ASSERT_TRUE(blocks) << blocks.error().message;
  const std::vector<std::uint8_t> kept{0b11011, 0b00111, 0b00100, 0, 0, 0b11011, 0b00100, 0};
  ASSERT_EQ(blocks->size(), kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ((*blocks)[i].kept, kept[i]) << i;
    EXPECT_EQ((*blocks)[i].machine, i == 0 || i == 5) << i;
  }
  EXPECT_EQ((*blocks)[0].z, -1.0);
  EXPECT_EQ((*blocks)[3].x, 1.0);
  EXPECT_EQ((*blocks)[3].rotary, 5.0);
}

TEST(ParseLink, ReadsTheThreeForms) {
  const auto grbl = parse_link("grbl:/dev/ttyUSB0");
  ASSERT_TRUE(grbl);
  EXPECT_EQ(grbl->place, "/dev/ttyUSB0");
  EXPECT_EQ(grbl->baud, 115200);
  EXPECT_EQ(parse_link("grbl:/dev/serial/by-id/usb-a@b@250000")->place, "/dev/serial/by-id/usb-a@b");
  const auto tcp = parse_link("modbus-tcp:192.168.0.5:1502/7");
  ASSERT_TRUE(tcp);
  EXPECT_EQ(tcp->kind, LinkKind::kModbusTcp);
  EXPECT_EQ(tcp->port, 1502);
  EXPECT_EQ(tcp->unit, 7);
  EXPECT_EQ(parse_link("modbus-tcp:[::1]:502")->place, "::1");
  const auto rtu = parse_link("modbus-rtu:/dev/ttyS0@38400/12");
  ASSERT_TRUE(rtu);
  EXPECT_EQ(rtu->baud, 38400);
  EXPECT_EQ(rtu->unit, 12);
  EXPECT_EQ(parse_link("modbus-rtu:/dev/ttyS0")->baud, 19200);
  for (const char* text :
       {"grbl:/dev/ttyUSB0@9600", "modbus-tcp:[fe80::1]:502/1", "modbus-rtu:/dev/pts/3@19200/1",
        "drive-tcp:10.0.0.7:502/3", "drive-rtu:/dev/ttyS0@19200/2"})
    EXPECT_EQ(describe(*parse_link(text)), text);
}

TEST(ParseLink, ErrorsAreKUsageWithExamples) {
  for (const char* bad : {"", "grbl", "grbl:", "grbl:ttyUSB0", "grbl:/dev/ttyUSB0@", "grbl:/dev/ttyUSB0@fast",
                          "grbl:/dev/ttyUSB0@10", "modbus-tcp:host", "modbus-tcp::502", "modbus-tcp:host:0",
                          "modbus-tcp:host:502/0", "modbus-tcp:host:502/248", "modbus-tcp:host:502x",
                          "modbus-rtu:/dev/ttyS0@19200/x", "tcp:host:1", "grbl:/dev/tty USB"}) {
    const auto link = parse_link(bad);
    ASSERT_FALSE(link) << bad;
    EXPECT_EQ(link.error().code, Code::kUsage);
    EXPECT_NE(link.error().message.find("modbus-rtu:/dev/ttyS0@19200"), std::string::npos);
  }
}

}  // namespace
}  // namespace tiltfeed
