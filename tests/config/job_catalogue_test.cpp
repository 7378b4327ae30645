// The catalogue of keys: what the reader asks is what it takes, and the example says the same.

#include "config/job_catalogue.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "config/description.h"
#include "config/job.h"
#include "config/machine_files.h"
#include "config/yaml_edit.h"
#include "tests/texts/example_job.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

/// The example with some lines that it hides, or without some that it has.
std::string example_with(const std::vector<std::pair<std::string, std::string>>& values,
                         const std::vector<std::string>& without = {}) {
  std::string text = example_job_text();
  for (const auto& key : without) text = edited(text, {key, std::nullopt}, {}).value();
  for (const auto& [key, value] : values) text = edited(text, {key, value}, {}).value();
  return text;
}

const KeyFact* fact_of(const KeyLog& log, const std::string& path) {
  for (const KeyFact& fact : log.facts())
    if (fact.path == path) return &fact;
  return nullptr;
}

std::vector<std::string> variants() {
  const std::vector<std::string> frame = {"axis.sense", "axis.circle_radius_mm", "containment"};
  std::vector<std::string> texts = {example_job_text()};
  for (const char* mode : {"fixed", "indexed", "free"}) {
    std::vector<std::string> without = frame;
    std::vector<std::pair<std::string, std::string>> with = {{"axis.mode", mode}};
    if (std::string(mode) != "fixed")
      for (const char* key : {"axis.origin_mm", "axis.t", "axis.n"}) without.emplace_back(key);
    if (std::string(mode) == "free") with.push_back({"axis.plane_normals", "[[0, 0, 1]]"});
    texts.push_back(example_with(with, without));
  }
  for (const char* kind : {"z_level", "split", "contour", "rough"})
    texts.push_back(example_with({{"pattern.kind", kind}, {"pattern.step_down_mm", "1"}}));
  for (const char* type : {"bull_nose", "flat", "taper_ball"})
    texts.push_back(example_with({{"cutter.type", type}}));
  return texts;
}

TEST(JobCatalogue, the_files_in_the_program_are_those_of_the_tree) {
  EXPECT_EQ(example_job_text(), text_of(kExample));
  ASSERT_GE(machine_files().size(), 9u);
  for (const MachineFile& machine : machine_files()) {
    EXPECT_EQ(machine.text, text_of(std::string(SOURCE_DIR) + "/config/machines/" + machine.name + ".yaml"));
    EXPECT_TRUE(parse_machine(machine.text, machine.name).has_value()) << machine.name;
  }
}

TEST(JobCatalogue, has_help_for_every_key_in_every_mode) {
  std::size_t keys = 0;
  for (const std::string& text : variants()) {
    const Result<KeyLog> log = job_keys(text);
    ASSERT_TRUE(log.has_value()) << log.error().message;
    for (const KeyFact& fact : log->facts()) {
      EXPECT_FALSE(key_help(fact.path).empty()) << fact.path;
      ++keys;
    }
  }
  EXPECT_GT(keys, 500u);
  EXPECT_EQ(key_help("cutter.holder[2].upper_diameter_mm"), "at its upper end, likewise; default: the same");
  EXPECT_EQ(
      key_help("axis.sense"),
      "outward: the shank points away from the feature (outside work: a pin); inward: towards it (inside "
      "work: a mould)");
  EXPECT_EQ(key_help("feeds"), "Speeds of the program.");
  EXPECT_EQ(key_help("nothing"), "");
}

TEST(JobCatalogue, knows_what_one_word_makes_of_the_others) {
  const Result<KeyLog> circle = job_keys(example_job_text());
  ASSERT_TRUE(circle.has_value());
  ASSERT_NE(fact_of(*circle, "axis.circle_radius_mm"), nullptr);
  EXPECT_TRUE(fact_of(*circle, "axis.circle_radius_mm")->required);
  EXPECT_TRUE(fact_of(*circle, "axis.circle_radius_mm")->unused.empty());
  EXPECT_FALSE(fact_of(*circle, "cutter.corner_radius_mm")->unused.empty());
  EXPECT_FALSE(fact_of(*circle, "cutter.corner_radius_mm")->present);
  EXPECT_EQ(fact_of(*circle, "pattern.kind")->usual, "raster");
  EXPECT_EQ(fact_of(*circle, "axis.mode")->words.size(), 6u);
  const Result<KeyLog> fixed =
      job_keys(example_with({{"axis.mode", "fixed"}}, {"axis.sense", "axis.circle_radius_mm"}));
  ASSERT_TRUE(fixed.has_value());
  EXPECT_FALSE(fact_of(*fixed, "axis.circle_radius_mm")->unused.empty());
  EXPECT_FALSE(fact_of(*fixed, "axis.sense")->unused.empty());
  EXPECT_EQ(fact_of(*fixed, "axis.origin_mm")->usual, "[0, 0, 0]");
  // A file that is wrong has its keys all the same, and a text that is no YAML has none.
  const Result<KeyLog> wrong = job_keys("cutter: {type: ball, diameter_mm: wide}\n");
  ASSERT_TRUE(wrong.has_value());
  EXPECT_NE(fact_of(*wrong, "setup.part_zero_mm"), nullptr);
  EXPECT_FALSE(job_keys("a: [").has_value());
}

/// The limits that a form shows are those that the reader keeps: just inside is taken, just outside is not.
TEST(JobCatalogue, states_the_limits_that_the_reader_keeps) {
  const Result<KeyLog> log = job_keys(example_job_text());
  ASSERT_TRUE(log.has_value());
  std::size_t tried = 0;
  for (const KeyFact& fact : log->facts()) {
    if (fact.kind != KeyKind::kNumber || !fact.unused.empty() || fact.path == "part.unit") continue;
    ASSERT_TRUE(fact.range.has_value()) << fact.path;
    const auto complains = [&](double value) {
      const std::string text = example_with({{fact.path, exact_text(value)}});
      const Result<Job> job = parse_job(text, kExample);
      return !job && job.error().message.find("is out of range") != std::string::npos;
    };
    const double step = std::max(1e-6, 1e-6 * fact.range->max);
    EXPECT_TRUE(complains(fact.range->max + step)) << fact.path;
    EXPECT_TRUE(complains(fact.range->min - step)) << fact.path;
    EXPECT_EQ(complains(fact.range->min), fact.range->above_min) << fact.path;
    EXPECT_EQ(complains(fact.range->max), fact.range->below_max) << fact.path;
    ++tried;
  }
  EXPECT_GT(tried, 25u);
}

/// The limits in the example's words are the reader's.
TEST(JobCatalogue, the_example_states_the_limits_of_the_reader) {
  for (const std::string& text : variants()) {
    const Result<KeyLog> log = job_keys(text);
    ASSERT_TRUE(log.has_value());
    for (const KeyFact& fact : log->facts()) {
      const std::string help = key_help(fact.path);
      if (!fact.range || !fact.unused.empty() || help.find("likewise") != std::string::npos) continue;
      if (fact.kind != KeyKind::kNumber && fact.kind != KeyKind::kInteger) continue;
      if (help.find(" 0 to ") != std::string::npos || help.find("at most ") != std::string::npos) {
        EXPECT_TRUE(help.find(exact_text(fact.range->max)) != std::string::npos ||
                    help.find("at most clearance_mm") != std::string::npos)
            << fact.path << " " << exact_text(fact.range->max) << ": " << help;
      }
    }
  }
}

}  // namespace
}  // namespace tiltfeed
