// LineReader text: exact golden text, read back word by word, feeds, limits, hostile names.

#include "daemon/post/block.h"

#include <gtest/gtest.h>

#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include "kinematics/basics/decimal.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

Job test_job() {
  Job job;
  job.plan.name = "pin";
  job.plan.cutter.diameter = 6;
  job.setup.part_zero = {20, -10, 60};
  job.setup.tool_length = 100.5;
  job.spindle_rpm = 12000;
  MachineModel& m = job.machine.model;
  m.name = "test-ac";
  m.x = m.y = m.z = {-1000, 1000, 12000, 2000};
  m.tilt = {'A', {1, 0, 0}, +1, 0.0, -120, 120, 5400, 1000};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -2e6, 2e6, 7200, 1000};
  m.pivot_to_gauge = {0, 0, -150};
  return job;
}

/// A path that winds round the part, in and out of contact, `poses` poses long.
ToolPath winding_path(int poses) {
  ToolPath path;
  path.name = "pin";
  path.tool = {6, 3, 100.5};
  path.cut_feed = Feed::from_mm_per_min(1500);
  path.plunge_feed = Feed::from_mm_per_min(400);
  for (int i = 0; i < poses; ++i) {
    const double t = 0.02 * i, tilt = 0.5 + 0.45 * std::sin(0.3 * t);
    const Vec3 axis =
        normalized(Vec3{std::sin(tilt) * std::cos(t), std::sin(tilt) * std::sin(t), std::cos(tilt)});
    const int phase = i % 100;
    const MoveKind kind =
        i == 0 || phase < 4 ? MoveKind::kRapid : (phase < 8 ? MoveKind::kPlunge : MoveKind::kCut);
    const double height = 20 + (phase < 6 ? 5.0 : 0.0);
    path.moves.push_back({{Point<Part>{0, 0, 0.001 * i} + axis * height, axis}, kind, kNoFacet});
  }
  return path;
}

/// The test's own reader: modal words to axis values; refuses what a control would refuse.
struct ReadBlock {
  Joints joints;
  bool rapid = true;
  double feed = 0.0;
};

struct ReadBack {
  std::vector<ReadBlock> blocks;
  std::vector<std::string> comments, words;  // words: non-motion lines
  std::string trouble;
};

ReadBack read_back(const std::string& text, char tilt = 'A', char rotary = 'C') {
  ReadBack result;
  std::istringstream in(text);
  std::string line;
  Joints at;
  bool rapid = true, inverse = false;
  std::set<char> stated;
  while (std::getline(in, line)) {
    const auto trouble = [&](const std::string& what) {
      if (result.trouble.empty()) result.trouble = what + " in: " + line;
    };
    for (const char c : line)
      if (c < ' ' || c > '~') trouble("not printable ASCII");
    if (line.empty()) trouble("empty line");
    if (line[0] == '(') {
      if (line.find(')') != line.size() - 1) trouble("comment");
      result.comments.push_back(line);
      continue;
    }
    std::map<char, double> axes;
    bool other = false;
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      const char letter = word[0];
      double value = 0;
      const auto end =
          std::from_chars(word.data() + 1, word.data() + word.size(), value, std::chars_format::fixed);
      if (end.ptr != word.data() + word.size()) trouble("number " + word);
      if (word.find("-0") == 1 && value == 0) trouble("-0");
      if (letter == 'G' && (value == 0 || value == 1)) {
        rapid = value == 0;
      } else if (letter == 'G' && (value == 93 || value == 94)) {
        inverse = value == 93;
        other = true;
      } else if (letter == 'N') {
      } else if (letter == 'G' || letter == 'M' || letter == 'S') {
        other = true;
      } else {
        if (axes.count(letter)) trouble("word twice");
        axes[letter] = value;
      }
    }
    if (other) {
      result.words.push_back(line);
      if (!axes.empty()) trouble("axes beside modal words");
      continue;
    }
    if (stated.size() < 5) {
      // From wherever the machine stands: rotaries, X Y, and at last Z; no more in one rapid.
      std::string letters;
      for (const auto& [letter, value] : axes) letters += letter;
      const std::string want = stated.empty() ? std::string{tilt, rotary} : (stated.size() == 2 ? "XY" : "Z");
      if (!rapid || letters != want) trouble("the way to the first block begins with " + letters);
      for (const char letter : letters) stated.insert(letter);
    }
    for (const auto& [letter, value] : axes) {
      if (letter == 'X')
        at.x = value;
      else if (letter == 'Y')
        at.y = value;
      else if (letter == 'Z')
        at.z = value;
      else if (letter == tilt)
        at.a = value;
      else if (letter == rotary)
        at.c = value;
      else if (letter != 'F')
        trouble("unknown letter");
    }
    if (stated.size() < 5) continue;
    if (rapid == (axes.count('F') == 1)) trouble("F");
    if (!rapid && (!inverse || !(axes['F'] > 0))) trouble("feed block without G93 and F");
    result.blocks.push_back({at, rapid, rapid ? 0.0 : axes['F']});
  }
  if (inverse) result.trouble = "ends in G93";
  return result;
}

std::string program_of(const JointPath& path, const Job& job, ProgramReport* report = nullptr) {
  std::ostringstream out;
  const auto written = write_program(path, job, out);
  if (!written) {
    ADD_FAILURE() << written.error().message;
    return {};
  }
  EXPECT_EQ(written->bytes, out.str().size());
  EXPECT_EQ(written->blocks, path.moves.size());
  if (report) *report = *written;
  return out.str();
}

JointPath joints_of(const ToolPath& path, const Job& job) {
  JointPathOptions options;
  options.linear_decimals = job.machine.format.linear_decimals;
  options.rotary_decimals = job.machine.format.rotary_decimals;
  const auto joints = to_joints(path, job.machine.model, job.setup, options);
  if (!joints) {
    ADD_FAILURE() << joints.error().message;
    return {};
  }
  return *joints;
}

TEST(Block, GoldenText) {
  JointPath path;
  path.moves = {{{0, -12.5, 100, 0, -90}, 0.0, MoveKind::kRapid, 0},
                {{0.0001, -12.5, 50, 0, -90}, 0.5, MoveKind::kRapid, 1},
                {{0.0001, -12.5, 10, 0, -90}, 4.0, MoveKind::kPlunge, 2},
                {{10, -12.5, 10, 30.25, 450.0625}, 0.007, MoveKind::kCut, 3},
                {{10, -12.5, 10, 30.25, 451}, 0.0001, MoveKind::kCut, 4},
                {{10, -12.5, 100, 30.25, 451}, 0.5, MoveKind::kRapid, 5}};
  path.report.seconds = 5.0071;
  ProgramReport report;
  EXPECT_EQ(program_of(path, test_job(), &report),
            "(TILTFEED part pin D6 L100.5)\n(TILTFEED machine test-ac)\n"
            "(TILTFEED tool length 100.5 mm is in the words, use G49)\n(TILTFEED part zero 20 -10 60 mm)\n"
            "(TILTFEED blocks 6 time 5 s)\nG21 G90 G17 G40 G49 G54\nS12000 M3\n"
            "G0 A0 C-90\nG0 X0 Y-12.5\nG0 Z100\nX0.0001 Z50\nG93\nG1 Z10 F15\nX10 A30.25 C450.0625 F8571.4\n"
            "C451 F100000\nG0 Z100\nG94\nM5\nM2\n");
  EXPECT_EQ(report.clamped_feeds, 1u);
}

// (block.h, properties 1 to 3)
TEST(Block, ReadsBackToTheLastDigit) {
  for (const int decimals : {3, 4, 5}) {
    for (const bool numbers : {false, true}) {
      Job job = test_job();
      job.machine.format.linear_decimals = job.machine.format.rotary_decimals = decimals;
      job.machine.format.line_numbers = numbers;
      job.machine.format.max_line_length = 100;
      job.machine.model.tilt.letter = 'B';
      const JointPath path = joints_of(winding_path(3000), job);
      const ReadBack back = read_back(program_of(path, job), 'B');
      EXPECT_EQ(back.trouble, "");
      ASSERT_EQ(back.blocks.size(), path.moves.size());
      for (std::size_t i = 0; i < path.moves.size(); ++i) {
        ASSERT_EQ(back.blocks[i].joints, path.moves[i].joints) << "block " << i;
        ASSERT_EQ(back.blocks[i].rapid, path.moves[i].kind == MoveKind::kRapid);
        if (back.blocks[i].rapid) continue;
        const double expected = std::min(60.0 / path.moves[i].seconds, job.machine.format.max_inverse_time);
        ASSERT_NEAR(back.blocks[i].feed / expected, 1.0, kFeedError) << "block " << i;
      }
    }
  }
}

TEST(Block, ForwardOfThePrintedWordsFollowsThePath) {
  const Job job = test_job();
  const ToolPath path = winding_path(2000);
  const JointPath joints = joints_of(path, job);
  const ReadBack back = read_back(program_of(joints, job));
  ASSERT_EQ(back.blocks.size(), joints.moves.size());
  for (std::size_t i = 0; i < joints.moves.size(); ++i) {
    if (i + 1 < joints.moves.size() && joints.moves[i + 1].move == joints.moves[i].move)
      continue;  // inside a move
    const Pose& want = path.moves[joints.moves[i].move].pose;
    const Pose got = forward(job.machine.model, job.setup, back.blocks[i].joints);
    ASSERT_LE(distance(got.tip, want.tip), JointPathOptions{}.tolerance) << "block " << i;
    ASSERT_LE(angle_between(got.axis, want.axis), Angle::from_degrees(0.01).radians()) << "block " << i;
  }
}

// (block.h, property 2)
TEST(Block, FeedsOfAllSizesKeepTheirDigits) {
  JointPath path;
  path.moves = {{{0, 0, 0, 0, 0}, 0.0, MoveKind::kRapid, 0}};
  for (double seconds = 5e6; seconds > 1e-4; seconds /= 1.7)
    path.moves.push_back({{round_decimal(1e-3 * static_cast<double>(path.moves.size()), 4), 0, 0, 0, 0},
                          seconds,
                          MoveKind::kCut,
                          0});
  Job job = test_job();
  job.machine.format.max_inverse_time = 1e9;
  ProgramReport report;
  const ReadBack back = read_back(program_of(path, job, &report));
  EXPECT_EQ(back.trouble, "");
  EXPECT_EQ(report.clamped_feeds, 0u);
  ASSERT_EQ(back.blocks.size(), path.moves.size());
  for (std::size_t i = 1; i < path.moves.size(); ++i)
    EXPECT_NEAR(back.blocks[i].feed * path.moves[i].seconds / 60.0, 1.0, kFeedError);
}

// (block.h, property 2)
TEST(Block, C17FeedsPerMinuteStayWithinWhatTheControlTakes) {
  JointPath path;
  path.moves = {{{0, 0, 0, 0, 0}, 0.0, MoveKind::kRapid, 0},
                {{100, 0, 0, 0, 0}, 1.2, MoveKind::kCut, 1},      // 5000 mm/min: the most
                {{200, 0, 0, 0, 0}, 1.1999, MoveKind::kCut, 2},   // 5000.4
                {{200, 0, 0, 0, 360}, 0.6, MoveKind::kCut, 3},    // as the rotary's measure says
                {{300, 0, 0, 0, 360}, 12.0, MoveKind::kCut, 4}};  // 500
  Job job = test_job();
  ProgramFormat& format = job.machine.format;
  format.feed_mode = FeedMode::kPerMinute;
  format.feed_measure = FeedMeasure::kDegrees;
  format.max_feed = 5000.0;
  ProgramReport report;
  std::istringstream words(program_of(path, job, &report));
  std::vector<double> feeds;
  for (std::string word; words >> word;)
    if (word[0] == 'F') feeds.push_back(std::stod(word.substr(1)));
  EXPECT_EQ(feeds, (std::vector<double>{5000.0, 500.0})) << "F is stated where it changes";
  EXPECT_EQ(report.clamped_feeds, 2u);
}

// (block.h, property 3)
TEST(Block, HostileNamesStayInTheirComment) {
  Job job = test_job();
  job.plan.name = "a)\nG1 X99 (\r;!~?\x18\x85 b%c \xC3\xA9 0123456789012345678901234567890123456789";
  job.machine.model.name = std::string(500, 'm') + ")";
  JointPath path;
  path.moves = {{{0, 0, 0, 0, 0}, 0.0, MoveKind::kRapid, 0}};
  const ReadBack back = read_back(program_of(path, job));
  EXPECT_EQ(back.trouble, "");
  EXPECT_EQ(back.blocks.size(), 1u);
  ASSERT_EQ(back.comments.size(), 5u);
  EXPECT_EQ(back.comments[0].find("(TILTFEED part aG1 X99  bc  0123456789"), 0u) << back.comments[0];
  for (const std::string& comment : back.comments) {
    EXPECT_LE(comment.size(), 70u);
    EXPECT_EQ(comment.find_first_of("!~?;%"), std::string::npos);
  }
}

TEST(Block, NoSpindleWordsWithoutSpindle) {
  Job job = test_job();
  job.spindle_rpm = 0;
  JointPath path;
  path.moves = {{{0, 0, 0, 0, 0}, 0.0, MoveKind::kRapid, 0}};
  const ReadBack back = read_back(program_of(path, job));
  EXPECT_EQ(back.words, (std::vector<std::string>{"G21 G90 G17 G40 G49 G54", "M2"}));
}

// (block.h, property 4)
TEST(Block, LongLinesAreRefused) {
  Job job = test_job();
  JointPath path;
  path.moves = {{{0, 0, 0, 0, 0}, 0.0, MoveKind::kRapid, 0},
                {{-1000.1234, -1000.1234, -1000.1234, -100.1234, -10000.1234}, 0.123456, MoveKind::kCut, 1}};
  job.machine.format.max_line_length = 60;
  std::ostringstream out;
  const auto refused = write_program(path, job, out);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kLimit);
  EXPECT_EQ(refused.error().message.find("block 2 is 67 bytes long, the control takes 60: \"G1 X-1000.1234"),
            0u)
      << refused.error().message;
  job.machine.format.max_line_length = 67;
  EXPECT_TRUE(write_program(path, job, out));
  job.machine.format.line_numbers = true;
  EXPECT_FALSE(write_program(path, job, out));
}

TEST(Block, AStreamThatRefusesIsAnError) {
  JointPath path;
  std::ostringstream out;
  EXPECT_EQ(write_program(path, test_job(), out).error().code, Code::kInput);
  path.moves = {{{0, 0, 0, 0, 0}, 0.0, MoveKind::kRapid, 0}};
  out.setstate(std::ios::badbit);
  EXPECT_EQ(write_program(path, test_job(), out).error().code, Code::kIo);
}

/// Also the measure of speed, printed and not judged. TILTFEED_PROGRAM names a file that is to get the
/// program.
TEST(Block, AMillionBlocks) {
  const Job job = test_job();
  const char* const file = std::getenv("TILTFEED_PROGRAM");
  const JointPath path = joints_of(winding_path(file ? 18000 : 900'000), job);
  std::ostringstream text;
  const auto start = std::chrono::steady_clock::now();
  const auto report = write_program(path, job, text);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  ASSERT_TRUE(report) << report.error().message;
  std::printf("%llu blocks, %llu bytes in %.2f s\n", static_cast<unsigned long long>(report->blocks),
              static_cast<unsigned long long>(report->bytes), took.count());
  if (file) std::ofstream(file) << text.str();
}

}  // namespace
}  // namespace tiltfeed
