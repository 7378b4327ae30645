// LineReader text that the reader would misread is refused with its line, and however much it is fed it stays
// within its limits.

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/texts/posted.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

const std::string kHead = "G21 G90 G54\nG0 X0 Y0 Z50 B0 C0\n";

Result<AptProgram> taken_back(const std::string& text,
                              const DialectCase& control = {Dialect::kRs274, false}) {
  UnpostOptions options;
  options.tool_length = 50.0;
  options.part_zero = Vec3{};
  return back(text, profile_of(control), options);
}

TEST(Misread, LinesThatSayMoreThanTheReaderKnows) {
  const struct {
    const char* line;
    const char* message;
  } table[]{{"M98 P1000", "M98 is not understood"},
            {"M99", "M99 is not understood"},
            {"M97 P10", "M97 is not understood"},
            {"M60", "no line of the machine profile has it"},
            {"O100 CALL", "is not understood"},
            {"G28 X0", "G28 goes by way of a place"},
            {"G28", "G28 goes by way of a place"},
            {"G91 G28 Z5", "G28 goes by way of a place"},
            {"G30 Z0", "G30 is not understood"},
            {"G0 G1 X5 F100", "two G codes of one kind"},
            {"G90 G91 X5", "two G codes of one kind"},
            {"G1 G81 X5 F100", "two G codes of one kind"},
            {"G41 G40", "two G codes of one kind"},
            {"M3 M5", "two M codes of one kind"},
            {"G1 X5 F100 R2", "R is not understood"},
            {"G1 X5 F100 P2", "P is understood in G4, G64, G54.1 and G154 only"},
            {"G4 P1 X5", "G4 stands with other words"},
            {"G4 P1 G1 Z5 F9", "G4 stands with other words"},
            {"G1.04 X5 F100", "G1.04 is no code"},
            {"M3.2 S100", "M3.2 is no code"},
            {"T1.5 M6", "T wants a whole number"},
            {"G1 X2000 F100", "X 2000 mm is above its travel"},
            {"G1 B130 F100", "B 130 degrees is above"},
            {"G1 C3000000000 F100", "C 3000000000 degrees is above"},
            {"G55", "another work offset"},
            {"G59.1", "another work offset"},
            {"G54.1 P2", "G54.1 is not understood"},
            {"G154 P2", "G154 is not understood"},
            {"G154", "want P with the number"},
            {"G54.1 P1.5", "want P with the number"},
            {"G92 X0", "G92 is not understood"},
            {"G4 P-1", "G4 has a time below 0"},
            {"G43.4 H1", "G43.4 is not understood"},
            {"G234 H1", "G234 is not understood"},
            {"TRAORI", "\"TRAORI\" is not understood"},
            {"M128", "M128 is not understood"},
            {"M126", "M126 is not understood"},
            {"G68.2 X0", "G68.2 is not understood"}};
  for (const auto& row : table) {
    SCOPED_TRACE(row.line);
    const auto program = taken_back(kHead + row.line + "\nG1 X1 F100\nM2\n");
    ASSERT_FALSE(program) << "accepted";
    EXPECT_NE(program.error().message.find(row.message), std::string::npos) << program.error().message;
    EXPECT_NE(program.error().message.find(":3:") + program.error().message.find("line 3:"),
              2 * std::string::npos)
        << program.error().message;
  }
  EXPECT_TRUE(taken_back(kHead + "G91 G28 Z0\nG90\nG0 Z50\nG1 X1 F100\nM2\n"));
  const auto after = taken_back(kHead + "G80\nX5\nM2\n");
  ASSERT_FALSE(after) << "G80 ends the motion word";
  // Under TCP the tip is within reach, and the axes are not.
  EXPECT_TRUE(taken_back("G21 G90 G54\nG0 B90 C0\nG43.4 H1\nG0 X800 Y0 Z0 B90 C0\nG1 X700 F100\nM30\n",
                         {Dialect::kFanuc, true}));
  EXPECT_FALSE(taken_back("G21 G90 G54\nG0 B90 C0\nG43.4 H1\nG0 X800 Y0 Z0 B90 C0\nG1 X900 F100\nM30\n",
                          {Dialect::kFanuc, true}));
}

TEST(Misread, TheMachinesOwnLinesAreKnown) {
  MachineProfile profile = profile_of({Dialect::kFanuc, false});
  profile.format.clamp_rotary = "M210";
  profile.format.start = {"M52 M777"};
  std::istringstream in("G21 G90 G54\nM777\nG0 X0 Y0 Z50 B0 C0\nM210\nG1 X1 F100\nM30\n");
  EXPECT_TRUE(read_nc_program(in, "p.nc", text_language(profile)));
}

/// A text without end: its head, then one piece again and again.
class Endless : public std::streambuf {
 public:
  Endless(std::string head, std::string piece) : text_(std::move(head)), piece_(std::move(piece)) {
    setg(text_.data(), text_.data(), text_.data() + text_.size());
  }
  std::size_t rounds() const { return rounds_; }

 protected:
  int_type underflow() override {
    ++rounds_;
    text_ = piece_;
    setg(text_.data(), text_.data(), text_.data() + text_.size());
    return traits_type::to_int_type(text_.front());
  }

 private:
  std::string text_, piece_;
  std::size_t rounds_ = 0;
};

TEST(Misread, TextWithoutEndIsRefusedAtALimit) {
  const TextLanguage language = text_language(profile_of({Dialect::kRs274, false}));
  const struct {
    const char* head;
    const char* piece;
    std::size_t rounds;  ///< at most
    const char* message;
  } table[]{{"", "X", 5000, "p.nc:1: the line is longer than 4096 bytes"},
            {"(", "          ", 500, "p.nc:1: the line is longer than 4096 bytes"},
            {"G21 G90\nG0 X0 Y0 Z50 B0 C0\nG1 F100 X1\n", "X2\nX1\nX3\n", 400'000, "too long to be read"},
            {"", "(a)\n(b)\n(c)\n", 1'100'000, "too long to be read"},
            {"G21 G90\nG0 X0 Y0 Z50 B0 C0\n", "M8\nM9\nM8\nM9\n", 60'000, "too long to be read"}};
  for (const auto& row : table) {
    SCOPED_TRACE(row.piece);
    Endless text(row.head, row.piece);
    std::istream in(&text);
    const auto program = read_nc_program(in, "p.nc", language);
    ASSERT_FALSE(program);
    EXPECT_NE(program.error().message.find(row.message), std::string::npos) << program.error().message;
    EXPECT_LE(text.rounds(), row.rounds);
  }
}

TEST(Misread, WholeTurnsBetweenTheSampledPlacesAreSeen) {
  // 200 turns in one block: at every quarter of it the tip is where it was.
  UnpostOptions options;
  options.tool_length = 50.0;
  options.part_zero = Vec3{};
  options.tolerance = 5.0;
  const auto program =
      back(kHead + "G0 X100\nG1 C72000 F100\nM2\n", profile_of({Dialect::kRs274, false}), options);
  ASSERT_TRUE(program) << program.error().message;
  double way = 0.0;
  const std::vector<Move>& moves = program->operations[0].path.moves;
  for (std::size_t i = 2; i < moves.size(); ++i) way += distance(moves[i - 1].pose.tip, moves[i].pose.tip);
  EXPECT_NEAR(way / (200 * 2 * kPi * 100), 1.0, 0.05);
}

TEST(Misread, NoPathHasMorePointsThanTheLimit) {
  // Each block turns the table under a tip far from its axis, to a tolerance that nothing meets.
  std::string text = kHead + "G0 X900\n";
  for (int i = 1; i <= 4; ++i) text += "G0 C" + std::to_string(i % 2 ? 1'000'000 : -1'000'000) + "\n";
  UnpostOptions options;
  options.tool_length = 50.0;
  options.part_zero = Vec3{};
  options.tolerance = 1e-9;
  const auto program = back(text + "M2\n", profile_of({Dialect::kRs274, false}), options);
  ASSERT_FALSE(program);
  EXPECT_EQ(program.error().code, Code::kLimit);
  EXPECT_NE(program.error().message.find("more than 1000000 points"), std::string::npos);
}

}  // namespace
}  // namespace tiltfeed
