// Programs of every dialect, as their controls execute them: read back they are the words that were posted, a
// sound one is proven, and one of which a line is damaged is refused at that line.

#include "sim/proof/program_proof.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <regex>
#include <sstream>

#include "kinematics/basics/decimal.h"
#include "kinematics/timing/tcp_path.h"
#include "sim/control/slide_blocks.h"
#include "tests/shapes/plate_program.h"
#include "tests/texts/dialect_posting.h"

namespace tiltfeed::sim {
using namespace pathgen;
using namespace config;
using namespace daemon;
namespace {

/// The plate's rows on the machine of a dialect, posted.
struct Posted {
  Job job = make_job();
  JointPath words;
  std::vector<std::string> lines;

  explicit Posted(const DialectCase& one) {
    const Shop shop;
    job.machine = profile_of(one);
    job.setup.part_zero = {0, 0, 60.5};
    JointPath path;
    double c = 0.0;
    const int decimals = one.tcp ? kTcpDecimals : job.machine.format.linear_decimals;
    for (std::size_t i = 0; i < shop.poses.size(); ++i) {
      const auto both = inverse(job.machine.model, job.setup, shop.poses[i], c);
      EXPECT_TRUE(both);
      Joints j = (*both)[0].a > 0.0 ? (*both)[0] : (*both)[1];
      j.a = round_decimal(j.a, job.machine.format.rotary_decimals);
      j.c = c = round_decimal(j.c, job.machine.format.rotary_decimals);
      j = solve_linear(job.machine.model, job.setup, shop.poses[i].tip, j.a, j.c);
      for (double* word : {&j.x, &j.y, &j.z}) *word = round_decimal(*word, decimals);
      const bool rapid = shop.lines[i + 1][1] == '0';
      path.moves.push_back(
          {j, 0.1, rapid ? MoveKind::kRapid : MoveKind::kCut, static_cast<std::uint32_t>(i)});
    }
    words = one.tcp ? words_under_tcp(path, job.machine.model, job.setup,
                                      {job.machine.format.linear_decimals, 1e-4, 1e-4})
                    : path;
    Posting posting{"plate", job.machine, {}, {}};
    Operation op;
    op.words = &words, op.setup = job.setup, op.tool_number = 3;
    op.tool = {2.0 * kRadius, 0.0, 100.0};
    op.cut_feed = op.plunge_feed = Feed::from_mm_per_min(1000);
    op.events = {{0, EventKind::kSpindle, 8000.0, ""},
                 {0, EventKind::kCoolant, 1.0, ""},
                 {5, EventKind::kDwell, 0.5, ""}};
    posting.operations.push_back(op);
    std::istringstream in(text_of(posting));
    for (std::string line; std::getline(in, line);) lines.push_back(line);
  }
  std::string text() const {
    std::string all;
    for (const std::string& line : lines) all += line + "\n";
    return all;
  }
  Result<ProgramProof> prove(const Prover& prover) const {
    std::istringstream in(text());
    return prove_program(in, "p.nc", std::span(&job, 1), {{&prover, nullptr}}, 2, {});
  }
  std::vector<ControlBlock> read() const {
    std::istringstream in(text());
    ControlReader reader(job.machine, job.setup);
    std::vector<ControlBlock> blocks;
    const auto done =
        read_control_program(in, "p.nc", reader, [&](const ControlBlock& b) { blocks.push_back(b); });
    EXPECT_TRUE(done) << done.error().message;
    return blocks;
  }
};

/// With a post beside it, which the tool meets when it leans another way.
CheckedMesh plate() {
  CheckedMesh part =
      checked(box_mesh({{Vec3{-8, -4, -6}, Vec3{8, 4, 0}}, {Vec3{-16, -4, -6}, Vec3{-12, 4, 40}}}));
  part.mesh.source.clear();
  for (std::uint32_t f = 0; f < part.mesh.facets.size(); ++f) part.mesh.source.push_back(f + 1000);
  return part;
}

/// Moves a word of a line, in the way that the line's numbers are printed; false: it has none.
bool shift_word(std::string& line, char letter, double by) {
  const std::regex word(std::string("( |^)") + letter + "([+-]?[0-9.]+)( |$|\\*)");
  std::smatch found;
  if (!std::regex_search(line, found, word)) return false;
  std::array<char, 40> number;
  std::snprintf(number.data(), number.size(), found[2].str()[0] == '+' ? "%+.4f" : "%.4f",
                std::stod(found[2].str()) + by);
  line =
      found.prefix().str() + found[1].str() + letter + number.data() + found[3].str() + found.suffix().str();
  return true;
}

/// A program shorter than what is read at a time, too, shows how far its proof is, and hears the user.
TEST(ProgramProof, CountsWithinABatch) {
  Posted posted(dialect_cases().front());
  std::string rows;
  for (int i = 0; i < 10000; ++i) rows += i % 2 == 0 ? "G0 X1\n" : "G0 X-1\n";
  const auto end = std::find(posted.lines.rbegin(), posted.lines.rend(), "G53 G0 Z0");
  ASSERT_NE(end, posted.lines.rend());
  *end = "G53 G0 Z0\nG0 X0 Y0\nG0 Z60\n" + rows + "G53 G0 Z0";
  const CheckedMesh part = plate();
  const Prover prover(part, posted.job);
  std::vector<double> shares;
  const auto prove = [&](std::size_t most) {
    std::istringstream in(posted.text());
    return prove_program(in, "p.nc", std::span(&posted.job, 1), {{&prover, nullptr}}, 2, [&](double share) {
      shares.push_back(share);
      return shares.size() < most;
    });
  };
  const auto proven = prove(1000);
  ASSERT_TRUE(proven) << proven.error().message;
  EXPECT_GT(proven->proof.moves, 10000u);
  EXPECT_GE(shares.size(), 5u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_LE(shares.front(), 0.3);
  EXPECT_NEAR(shares.back(), 1.0, 1e-9);
  shares.clear();
  const auto stopped = prove(2);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Code::kCancelled);
  EXPECT_EQ(shares.size(), 2u);
}

class EveryDialect : public testing::TestWithParam<DialectCase> {};
INSTANTIATE_TEST_SUITE_P(Control, EveryDialect, testing::ValuesIn(dialect_cases()), case_name);

TEST_P(EveryDialect, ReadsTheWordsThatWerePosted) {
  const Posted posted(GetParam());
  std::size_t at = 0;
  double dwelt = 0.0;
  const std::vector<ControlBlock> blocks = posted.read();
  std::vector<ControlBlock> motion;
  for (const ControlBlock& one : blocks) {
    if (one.block.op == Op::kDwell) dwelt += one.block.feed;
    if (one.block.op == Op::kRapid || one.block.op == Op::kFeed) motion.push_back(one);
  }
  EXPECT_EQ(dwelt, 0.5);
  ASSERT_GE(motion.size(), posted.words.moves.size());
  // Before the first of them the tool comes from the retract; after the last it goes there.
  while (at + posted.words.moves.size() < motion.size() &&
         !(motion[at].block.target == posted.words.moves[0].joints && motion[at].tcp == GetParam().tcp))
    ++at;
  for (std::size_t i = 0; i < posted.words.moves.size(); ++i) {
    const ControlBlock& one = motion[at + i];
    const JointMove& move = posted.words.moves[i];
    EXPECT_EQ(one.block.target, move.joints) << i;
    EXPECT_EQ(one.tcp, GetParam().tcp);
    EXPECT_EQ(one.block.op == Op::kRapid, move.kind == MoveKind::kRapid) << i;
    if (one.block.op == Op::kFeed) {
      EXPECT_GT(one.block.feed, 0.0);
    }
    EXPECT_EQ(one.block.tool, 3);
    const std::string& line = posted.lines[one.block.line - 1];
    EXPECT_NE(line.find_first_of("XYZBC"), std::string::npos) << line;
  }
  const std::vector<int> codes = [&] {
    std::vector<int> all;
    for (const ControlBlock& one : blocks)
      if (one.block.op == Op::kMCode) all.push_back(one.block.m_code);
    return all;
  }();
  for (const int code : {3, 8, 9, 5})
    EXPECT_NE(std::find(codes.begin(), codes.end(), code), codes.end()) << code;
}

TEST_P(EveryDialect, ProvesASoundProgram) {
  const Posted posted(GetParam());
  const CheckedMesh part = plate();
  const auto proof = posted.prove(Prover(part, posted.job));
  ASSERT_TRUE(proof) << proof.error().message;
  EXPECT_FALSE(proof->proof.deepest);
  EXPECT_FALSE(proof->inside);
  EXPECT_GE(proof->proof.moves + 1, posted.words.moves.size());
  EXPECT_LT(proof->proof.gouge, 0.01);
  EXPECT_GT(proof->proof.gouge, 0.0);
}

/// What `tiltfeed verify` executes: every piece ends where the block under TCP is at its share, in its time.
TEST_P(EveryDialect, SlidesRunTheSameWay) {
  const Posted posted(GetParam());
  const MoveFrames frames(posted.job.machine.model, posted.job.setup);
  SlideBlocks slides(posted.job.machine.model, posted.job.setup, 100.0, 1e-3);
  Joints before;
  std::size_t pieces = 0;
  for (const ControlBlock& one : posted.read()) {
    const bool moves = one.block.op == Op::kRapid || one.block.op == Op::kFeed;
    double minutes = 0.0, parts = 0.0;
    Joints last;
    slides.take(one, [&](const Block& block) {
      ++parts, last = block.target;
      if (block.inverse_time) minutes += 1.0 / block.feed;
    });
    if (!moves) continue;
    pieces += static_cast<std::size_t>(parts);
    EXPECT_LT(distance(frames.pose(last, false).tip, frames.pose(one.block.target, one.tcp).tip), 1e-9);
    EXPECT_LT(length(frames.pose(last, false).axis - frames.pose(one.block.target, one.tcp).axis), 1e-12);
    const double way = std::hypot(one.block.target.x - before.x, one.block.target.y - before.y,
                                  one.block.target.z - before.z);
    if (one.tcp && one.block.op == Op::kFeed && way > 0.0) {
      EXPECT_NEAR(minutes * one.block.feed, way, 1e-9);
    }
    before = one.block.target;
  }
  EXPECT_GE(pieces, posted.words.moves.size());
}

struct Damage {
  const char* what;
  char letter;
  double by;
  bool rapid;
};

// (proof.h, properties 2 and 3)
TEST_P(EveryDialect, RefusesAGougeAndNamesItsLine) {
  const Posted sound(GetParam());
  const CheckedMesh part = plate();
  const Prover prover(part, sound.job);
  const std::vector<ControlBlock> blocks = sound.read();
  for (const Damage& damage : {Damage{"a word", 'Z', -0.05, false}, Damage{"a rapid", 'Z', -13.0, true},
                               Damage{"a swing of the tilt", 'B', GetParam().tcp ? 40.0 : -25.0, false},
                               Damage{"a swing of the table", 'C', 360.0, false}}) {
    int tried = 0;
    for (std::size_t i = 20; i < blocks.size() && tried < 3; i += 17) {
      std::size_t at = i;
      const auto fits = [&](std::size_t k) {
        std::string line = sound.lines[blocks[k].block.line - 1];
        return (blocks[k].block.op == Op::kRapid) == damage.rapid &&
               (damage.rapid || blocks[k].block.op == Op::kFeed) && shift_word(line, damage.letter, 0.0);
      };
      while (at + 4 < blocks.size() && !fits(at)) ++at;
      if (at + 4 >= blocks.size()) break;
      ++tried;
      Posted bad = sound;
      const std::uint32_t line = blocks[at].block.line;
      ASSERT_TRUE(shift_word(bad.lines[line - 1], damage.letter, damage.by));
      const auto proof = bad.prove(prover);
      if (damage.by == 360.0) {  // refused as it is read
        ASSERT_FALSE(proof);
        EXPECT_EQ(proof.error().message.find("p.nc:" + std::to_string(line) + ": C turns by more than 180"),
                  0u)
            << proof.error().message;
        continue;
      }
      ASSERT_TRUE(proof) << proof.error().message;
      ASSERT_TRUE(proof->proof.deepest) << damage.what << ": " << bad.lines[line - 1];
      // The word stays until another is said, so what follows may cut as deep.
      EXPECT_GE(proof->proof.deepest->line, line) << damage.what;
      if (damage.by == -0.05) {
        EXPECT_NEAR(proof->proof.deepest->depth, 0.05, 0.012);
      }
    }
    EXPECT_GT(tried, 0) << damage.what;
  }
}

TEST_P(EveryDialect, TakesNoLineThatItDoesNotUnderstand) {
  const Posted sound(GetParam());
  const Prover prover(plate(), sound.job);
  for (const char* line :
       {"G2 X1. Y2. I3. J4.", "G68.2 X0 Y0", "M98 P100", "X1.2.3", "WHATEVER", "G1 X1. X2."}) {
    Posted bad = sound;
    bad.lines.insert(bad.lines.end() - 5, line);
    EXPECT_FALSE(bad.prove(prover)) << line;
  }
}

TEST(ControlWords, ASiemensRotaryTakesTheWayThatIsSaid) {
  Job job = make_job();
  job.machine.format = usual_format(Dialect::kSiemens);
  job.machine.model.rotary.word = RotaryWord::kShortest;
  ControlReader reader(job.machine, job.setup);
  std::vector<ControlBlock> blocks;
  const auto c_after = [&](const char* line) {
    const auto read = reader.read_line(line, blocks);
    EXPECT_TRUE(read) << read.error().message;
    return blocks.back().block.target.c;
  };
  EXPECT_EQ(c_after("N10 G0 X0 Y0 Z0 A0 C=DC(350)"), -10.0);
  EXPECT_EQ(c_after("C=DC(10)"), 10.0);
  EXPECT_EQ(c_after("C=ACN(350)"), -10.0);
  EXPECT_EQ(c_after("C=ACP(20)"), 20.0);
  EXPECT_EQ(c_after("C=ACP(10)"), 370.0);
  EXPECT_EQ(c_after("C350"), 710.0);  // no word for the shorter way: 340 degrees up on the present turn
}

TEST(ControlWords, AHeidenhainRotaryTakesTheShorterWayUnderM126) {
  Job job = make_job();
  job.machine.format = usual_format(Dialect::kHeidenhain);
  job.machine.model.rotary.word = RotaryWord::kShortest;
  ControlReader reader(job.machine, job.setup);
  std::vector<ControlBlock> blocks;
  const auto c_after = [&](const char* line) {
    const auto read = reader.read_line(line, blocks);
    EXPECT_TRUE(read) << read.error().message;
    return blocks.empty() ? 0.0 : blocks.back().block.target.c;
  };
  EXPECT_EQ(c_after("1 L X+0 Y+0 Z+0 A+0 C+350 R0 FMAX"), 350.0);
  EXPECT_EQ(c_after("2 L C+10 FMAX"), 10.0);
  c_after("3 M126");
  EXPECT_EQ(c_after("4 L C+350 FMAX"), -10.0);
  c_after("5 M127");
  EXPECT_EQ(c_after("6 L C+10 FMAX"), -350.0);
}

TEST(ControlWords, CrAlone_IsALineEnd) {
  const Job job = make_job();
  ControlReader reader(job.machine, job.setup);
  std::istringstream in("G21 G90\rG0 X0 Y0 Z5 A0 C0\rG94 G1 X5 F600\rY10\r\nM2\r");
  std::vector<Joints> targets;
  const auto read = read_control_program(in, "p.nc", reader,
                                         [&](const ControlBlock& b) { targets.push_back(b.block.target); });
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_GE(targets.size(), 3u);
  EXPECT_EQ(targets[1], (Joints{5.0, 0.0, 5.0, 0.0, 0.0}));
  EXPECT_EQ(targets[2], (Joints{5.0, 10.0, 5.0, 0.0, 0.0}));
  EXPECT_EQ(reader.lines(), 5u);
}

TEST(ControlWords, AFanucNumberWithoutAPointIsThousandths) {
  Job job = make_job();
  job.machine.format = usual_format(Dialect::kFanuc);
  ControlReader reader(job.machine, job.setup);
  std::vector<ControlBlock> blocks;
  ASSERT_TRUE(reader.read_line("G0 X1500 Y2. Z-10 A0. C90000", blocks));
  EXPECT_EQ(blocks.back().block.target, (Joints{1.5, 2.0, -0.01, 0.0, 90.0}));
}

TEST(ControlWords, AMachinePlaceOfZIsTheTopOfItsTravel) {
  Job job = make_job();
  ControlReader reader(job.machine, job.setup);
  std::vector<ControlBlock> blocks;
  ASSERT_TRUE(reader.read_line("G53 G0 Z0", blocks));
  EXPECT_TRUE(blocks.empty());
  ASSERT_TRUE(reader.read_line("G0 A0 C0", blocks));
  ASSERT_TRUE(reader.read_line("X1 Y2", blocks));
  ASSERT_EQ(blocks.size(), 1u);
  EXPECT_TRUE(blocks[0].fresh);
  EXPECT_EQ(blocks[0].block.target.z, 500.0);
  ASSERT_TRUE(reader.read_line("Z3", blocks));
  EXPECT_FALSE(blocks[1].fresh);
  ASSERT_TRUE(reader.read_line("G53 X0 Y0", blocks));
  ASSERT_TRUE(reader.read_line("X5 Y5", blocks));
  EXPECT_TRUE(blocks.back().fresh);
}

}  // namespace
}  // namespace tiltfeed::sim
