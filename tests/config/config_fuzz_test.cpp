// Damaged settings never crash the reader: every seeded mutation of the example files is either accepted with
// values in range or refused with a place that lies in the text.

#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <random>
#include <sstream>
#include <vector>

#include "config/job.h"
#include "tests/samples.h"
#include "tests/texts/example_job.h"
#include "tests/texts/job_text.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

constexpr int kAllMutations = 6000, kMutations = samples(kAllMutations);  // of each file

/// Same numbers on every platform: the generator is fixed by the standard, the reduction is ours.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : generator_(seed) {}
  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(generator_() % limit); }

 private:
  std::mt19937_64 generator_;
};

/// The text without comments: most damage then hits something that matters.
std::string bare(const std::string& text) {
  std::istringstream in(text);
  std::string out;
  for (std::string line; std::getline(in, line);) {
    line = line.starts_with('#') ? "" : line.substr(0, line.find(" #"));
    while (!line.empty() && line.back() == ' ') line.pop_back();
    if (!line.empty()) out += line + "\n";
  }
  return out;
}

std::string mutated(std::string text, Dice& dice) {
  static const std::string kBytes = "0123456789.-+eE:,#[]{}&*!|>'\"%@`?~<=\\ \n\t\r\0\x7F\x80\xC3\xFF_azAZ";
  const std::size_t changes = 1 + dice.below(4);
  for (std::size_t i = 0; i < changes && !text.empty(); ++i) {
    const std::size_t at = dice.below(text.size());
    const std::size_t length = 1 + dice.below(12);
    switch (dice.below(6)) {
      case 0:
        text.erase(at, 1);
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(at, length));
        break;
      case 3:
        text[at] = kBytes[dice.below(kBytes.size())];
        break;
      case 4:
        text.insert(at, 1, kBytes[dice.below(kBytes.size())]);
        break;
      case 5:
        text.insert(at, text.substr(dice.below(text.size()), length));
        break;
    }
  }
  return text;
}

/// The line starts with path:line:column, within the text or just behind it, and says something.
testing::AssertionResult line_has_place(const std::string& message, const std::string& path,
                                        const std::string& text) {
  const auto bad = [&](const char* what) { return testing::AssertionFailure() << what << ": " << message; };
  if (message.compare(0, path.size() + 1, path + ":") != 0) return bad("other file");
  const char* at = message.data() + path.size() + 1;
  const char* end = message.data() + message.size();
  std::size_t line = 0, column = 0;
  const auto read_line = std::from_chars(at, end, line);
  if (read_line.ec != std::errc() || *read_line.ptr != ':') return bad("no line");
  const auto read_column = std::from_chars(read_line.ptr + 1, end, column);
  if (read_column.ec != std::errc() || end - read_column.ptr < 10) return bad("no column or no text");
  if (std::string_view(read_column.ptr, 2) != ": ") return bad("no ': ' behind the place");
  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
  if (line < 1 || line > lines) return bad("no such line");
  std::size_t start = 0;
  for (std::size_t i = 1; i < line; ++i) start = text.find('\n', start) + 1;
  const std::size_t length = std::min(text.find('\n', start), text.size()) - start;
  if (column < 1 || column > length + 1) return bad("no such column");
  return testing::AssertionSuccess();
}

void expect_cutter_in_range(const Cutter& cutter) {
  EXPECT_TRUE(cutter.diameter > 0 && cutter.diameter <= 500);
  EXPECT_TRUE(cutter.nose_radius() >= 0 && cutter.nose_radius() <= cutter.radius());
  EXPECT_TRUE(cutter.cutting_end() > 0 && cutter.cutting_end() <= cutter.shank_length);
  EXPECT_LE(cutter.shank_length, cutter.length);
  EXPECT_TRUE(cutter.type == CutterType::kTaperBall || cutter.cutting_end() >= cutter.nose_radius());
  EXPECT_TRUE(cutter.shank_radius() > 0 && cutter.shank_radius() <= 250);
  for (const HolderStep& step : cutter.holder)
    EXPECT_TRUE(step.length > 0 && step.lower_diameter > 0 && step.upper_diameter > 0 &&
                step.upper_diameter <= 500);
}

void expect_pattern_in_range(const Pattern& pattern) {
  using enum PatternKind;
  const bool steps_aside = pattern.kind != kZLevel && pattern.kind != kPencil;
  const bool steps_down = pattern.kind == kZLevel || pattern.kind == kSplit || pattern.kind == kRough;
  EXPECT_TRUE(pattern.side_step >= 0 && pattern.side_step <= 1000);
  EXPECT_EQ(pattern.side_step > 0 || pattern.scallop > 0, steps_aside);
  const bool may_limit = pattern.measure == StepMeasure::kRidge && pattern.scallop > 0;
  EXPECT_EQ(pattern.scallop > 0, pattern.measure == StepMeasure::kScallop || may_limit);
  EXPECT_EQ(pattern.step_down > 0, steps_down);
  EXPECT_TRUE(pattern.split_slope.radians() > 0 && pattern.split_slope.radians() < kPi / 2);
}

void expect_in_range(const Job& job) {
  const PlanOptions& plan = job.plan;
  expect_cutter_in_range(plan.cutter);
  expect_pattern_in_range(plan.pattern);
  for (const Interval& interval : {plan.containment.first, plan.containment.second, plan.containment.height})
    EXPECT_LT(interval.low, interval.high);
  EXPECT_TRUE(plan.containment.boundary.empty() || plan.containment.boundary.size() >= 3);
  EXPECT_TRUE(plan.tolerance >= 1e-4 && plan.tolerance <= 1);
  for (const double stock : {plan.allowance, plan.radial_stock, plan.axial_stock})
    EXPECT_TRUE(stock >= 0 && stock <= 50);
  for (const double step : {plan.max_point_distance, plan.max_angle_step.degrees()})
    EXPECT_TRUE(step == 0 || step >= 0.00099);
  EXPECT_TRUE(plan.shank.clearance >= 0 && plan.holder.clearance <= 100);
  EXPECT_TRUE(plan.links.approach > 0 && plan.links.approach <= plan.links.clearance &&
              plan.links.clearance <= 1000);
  EXPECT_TRUE(plan.links.join_distance >= 0 && plan.links.lead_radius <= 100);
  EXPECT_NEAR(dot(plan.axis.t, plan.axis.n), 0.0, 1e-15);
  EXPECT_TRUE(is_finite(plan.axis.origin) && is_finite(job.setup.part_zero));
  EXPECT_NEAR(length(job.setup.fixture.rows[2]), 1.0, 1e-12);
  EXPECT_FALSE(plan.name.empty() || plan.name.size() > 40);
}

/// So does each line of the message, but for the number of those that are not told.
testing::AssertionResult has_place(const std::string& message, const std::string& path,
                                   const std::string& text) {
  std::istringstream lines(message);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(path + ": and ")) continue;
    if (auto good = line_has_place(line, path, text); !good) return good;
  }
  return testing::AssertionSuccess();
}

/// So many damages to one job text, of which at least `least` are harmless.
void expect_sound_answers(const std::string& commented, const std::string& path, std::uint64_t seed,
                          int mutations, int least) {
  const std::string original = bare(commented);
  ASSERT_TRUE(parse_job(original, path).has_value());
  Dice dice(seed);
  int accepted = 0;
  for (int i = 0; i < mutations && !testing::Test::HasFailure(); ++i) {
    const std::string text = mutated(i % 2 == 0 ? original : commented, dice);
    const Result<Job> job = parse_job(text, path);
    if (job) {
      expect_in_range(*job);
    } else {
      // kIo: the damage hit the machine's path.
      EXPECT_TRUE(job.error().code == Code::kInput || job.error().code == Code::kIo);
      EXPECT_TRUE(has_place(job.error().message, path, text));
    }
    accepted += job.has_value();
    if (testing::Test::HasFailure()) ADD_FAILURE() << "mutation " << i << ":\n" << text;
  }
  EXPECT_GT(accepted, least);
  EXPECT_LT(accepted, mutations / 2);
}

// (cutter.h, properties 1 to 3)
TEST(ConfigFuzz, DamagedJobs) {
  const std::string path = SOURCE_DIR "/config/jobs/example.yaml";
  expect_sound_answers(text_of(path), path, 20050901, kMutations, kMutations / 50);
}

// (cutter.h, properties 1 to 3)
TEST(ConfigFuzz, DamagedOptions) {  // all of them everywhere: few are harmless
  expect_sound_answers(kOptionsJob, kJobPath, 20261, kAllMutations, kAllMutations / 200);
}

TEST(ConfigFuzz, DamagedMachines) {
  const std::string path = SOURCE_DIR "/config/machines/generic-ac.yaml";
  const std::string commented = text_of(path), original = bare(commented);
  ASSERT_TRUE(parse_machine(original, path).has_value());
  Dice dice(19991231);
  int accepted = 0;
  for (int i = 0; i < kMutations && !HasFailure(); ++i) {
    const std::string text = mutated(i % 2 == 0 ? original : commented, dice);
    const Result<MachineProfile> machine = parse_machine(text, path);
    if (machine) {
      const MachineModel& model = machine->model;
      EXPECT_TRUE(model.x.min < model.x.max && model.y.min < model.y.max && model.z.min < model.z.max);
      EXPECT_TRUE(model.tilt.min < model.tilt.max && model.rotary.min < model.rotary.max);
      EXPECT_TRUE(model.tilt.velocity > 0 && model.rotary.acceleration > 0 && model.z.velocity > 0);
      EXPECT_NE(model.tilt.letter, model.rotary.letter);
      EXPECT_EQ(std::abs(model.tilt.sign), 1);
      EXPECT_LE(model.pivot_to_gauge.z, 0.0);
    } else {
      EXPECT_EQ(machine.error().code, Code::kInput);
      EXPECT_TRUE(has_place(machine.error().message, path, text));
    }
    accepted += machine.has_value();
    if (HasFailure()) ADD_FAILURE() << "mutation " << i << ":\n" << text;
  }
  EXPECT_GT(accepted, kMutations / 50);
  EXPECT_LT(accepted, kMutations / 2);
}

}  // namespace
}  // namespace tiltfeed
