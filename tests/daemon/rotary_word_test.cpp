// A judge of rotary words: it reads each dialect's text as that control turns its axes (absolute, the shorter
// way, by the sign) and compares every turn with the plan. What a control cannot be told is refused.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <sstream>

#include "kinematics/basics/decimal.h"
#include "tests/texts/dialect_posting.h"
#include "tests/texts/machine_text.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

/// The way to one of many turns, each shorter than half a turn, over several turns either way.
JointPath winding(std::mt19937& random, const ProgramFormat& format) {
  JointPath path;
  Joints at{0, 0, 100, 0, 0};
  at.c = round_decimal(static_cast<double>(random() % 7200) / 10.0 - 360.05, format.rotary_decimals);
  path.moves.push_back({at, 0.0, MoveKind::kRapid, 0});
  double drift = 0.0;
  for (int i = 0; i < 600; ++i) {
    if (i % 40 == 0) drift = static_cast<double>(random() % 301) - 150.0;
    at.c = round_decimal(at.c + std::clamp(drift + static_cast<double>(random() % 401) / 7.0, -179.0, 179.0),
                         format.rotary_decimals);
    if (std::fmod(at.c, 360.0) == 0.0) at.c += 0.5;
    at.a = round_decimal(60.0 * std::sin(0.7 * i), format.rotary_decimals);
    at.x = round_decimal(0.01 * (i + 1), format.linear_decimals);
    path.moves.push_back({at, 1.0, i % 9 == 0 ? MoveKind::kRapid : MoveKind::kCut, 0});
  }
  return path;
}

/// One rotary axis and what its control makes of a line. Knows the words of rotary axes and nothing else.
class Axis {
 public:
  Axis(Dialect dialect, char letter, RotaryWord parameter)
      : dialect_(dialect), letter_(letter), parameter_(parameter) {}

  /// True when the line turned it, or left it standing where it is.
  bool take(const std::string& line) {
    if (line.find("M126") != line.npos) shorter_ = true;
    if (line.find("M127") != line.npos) shorter_ = false;
    const std::string code = line.substr(0, line.find(';'));
    for (std::size_t i = 0; i + 1 < code.size(); ++i) {
      if (code[i] != letter_ || (i > 0 && code[i - 1] != ' ')) continue;
      const bool direct = code.compare(i + 1, 4, "=DC(") == 0;
      const char* number = code.c_str() + i + (direct ? 5 : 1);
      char* end = nullptr;
      const double word = std::strtod(number, &end);
      if (end == number) continue;
      if (direct && (*end != ')' || word < 0.0 || word >= 360.0)) return false;
      turn(word, direct);
      return true;
    }
    return true;
  }
  double at() const { return at_; }

 private:
  void turn(double word, bool direct) {
    switch (dialect_) {
      case Dialect::kSiemens:  // the word alone is absolute, DC( ) the shorter way
        at_ = direct ? at_ + std::remainder(word - at_, 360.0) : word;
        return;
      case Dialect::kHeidenhain:
      case Dialect::kHeidenhainIso:  // from 350 to 10: -340 degrees, under M126 +20
        at_ = shorter_ ? at_ + std::remainder(word - at_, 360.0) : word;
        return;
      default:
        break;
    }
    if (parameter_ == RotaryWord::kAccumulate) at_ = word;
    if (parameter_ == RotaryWord::kShortest) at_ += std::remainder(word - at_, 360.0);
    if (parameter_ != RotaryWord::kSigned) return;
    const double way = std::fmod(std::fmod(std::abs(word) - at_, 360.0) + 360.0, 360.0);
    const bool there = way < 1e-9 || way > 360.0 - 1e-9;
    at_ += there ? std::remainder(way, 360.0) : (std::signbit(word) ? way - 360.0 : way);
  }

  Dialect dialect_;
  char letter_;
  RotaryWord parameter_;
  bool shorter_ = false;
  double at_ = 0.0;
};

/// Whether a line has the word.
bool says(const std::string& line, char letter) {
  for (std::size_t at = line.find(letter); at != line.npos; at = line.find(letter, at + 1))
    if ((at == 0 || line[at - 1] == ' ') && line.find_first_of("+-.0123456789", at) == at + 1) return true;
  return false;
}

class RotaryWords : public testing::TestWithParam<DialectCase> {};
INSTANTIATE_TEST_SUITE_P(All, RotaryWords, testing::ValuesIn(dialect_cases()), case_name);

TEST_P(RotaryWords, TurnTheAxesAsPlanned) {
  std::mt19937 random(3);
  const Dialect dialect = GetParam().dialect;
  for (const RotaryWord word : {RotaryWord::kAccumulate, RotaryWord::kShortest, RotaryWord::kSigned}) {
    if (refusal_of(dialect, word)) continue;
    SCOPED_TRACE("word " + std::to_string(static_cast<int>(word)));
    Posting posting = posting_of(GetParam(), {});
    const JointPath first = winding(random, posting.machine.format),
                    second = winding(random, posting.machine.format);
    posting = posting_of(GetParam(), {&first, &second});
    posting.machine.model.rotary.word = word;
    std::istringstream in(text_of(posting));
    Axis tilt(dialect, 'B', RotaryWord::kAccumulate), rotary(dialect, 'C', word);
    std::size_t tool = 0, next = 0;
    double from = 0.0;
    for (std::string line; std::getline(in, line);) {
      if (line.find("TILTFEED") != line.npos || line.find("PGM") != line.npos) continue;
      ASSERT_TRUE(tilt.take(line) && rotary.take(line)) << line;
      const std::vector<JointMove>& moves = (tool == 0 ? first : second).moves;
      // The first block goes down to Z 100; X changes in every block after it.
      const bool block = next == 0 ? says(line, 'Z') && line.find("100") != line.npos : says(line, 'X');
      if (!block) continue;
      const Joints& want = moves[next].joints;
      if (next == 0) {
        EXPECT_NEAR(std::remainder(rotary.at() - want.c, 360.0), 0.0, 1e-6) << line;
      } else {
        ASSERT_NEAR(rotary.at() - from, want.c - moves[next - 1].joints.c, 1e-6) << line;
      }
      ASSERT_NEAR(tilt.at(), want.a, 1e-9) << line;
      from = rotary.at();
      if (++next == moves.size()) ++tool, next = 0;
      if (tool == 2) break;
    }
    EXPECT_EQ(tool, 2u);
  }
}

TEST(RotaryWord, WhatAControlCannotBeToldIsRefusedWithTheReason) {
  const struct {
    Dialect dialect;
    bool shortest, by_sign;  // does it know them?
  } table[]{{Dialect::kRs274, false, true},        {Dialect::kGrbl, false, false},
            {Dialect::kFanuc, true, true},         {Dialect::kHaas, false, false},
            {Dialect::kSiemens, true, false},      {Dialect::kHeidenhain, true, false},
            {Dialect::kHeidenhainIso, true, false}};
  ASSERT_EQ(std::size(table), kDialects.size());
  for (const auto& row : table) {
    const std::string name = name_of(row.dialect).name;
    for (const bool by_sign : {false, true}) {
      const std::string word = by_sign ? "signed" : "shortest";
      SCOPED_TRACE(name + " " + word);
      std::string text =
          kGoodMachine.substr(0, kGoodMachine.find("program:")) + "program: {dialect: fanuc}\n";
      text = replaced(text, "min_deg: -360, max_deg: 720", "word: " + word);
      ASSERT_TRUE(parse_machine(text, kMachinePath));
      // In the profile, and by --dialect.
      for (const bool stated : {true, false}) {
        const auto profile =
            stated ? parse_machine(replaced(text, "dialect: fanuc", "dialect: " + name), kMachinePath)
                   : parse_machine(text, kMachinePath, row.dialect);
        EXPECT_EQ(profile.has_value(), by_sign ? row.by_sign : row.shortest);
        if (profile) continue;
        EXPECT_NE(profile.error().message.find("word: " + word + " is no word of " + name + ": "),
                  std::string::npos)
            << profile.error().message;
      }
    }
  }
}

}  // namespace
}  // namespace tiltfeed
