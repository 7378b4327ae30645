// A value changed where it stands. What comes out is read by the reader of YAML itself.

#include "config/yaml_edit.h"

#include <gtest/gtest.h>

#include <sstream>

#include "config/job.h"
#include "config/job_catalogue.h"
#include "tests/texts/example_job.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

std::vector<std::string> order_of(const std::string& section) {
  return section.empty() ? std::vector<std::string>{"a", "b", "c", "d"}
                         : std::vector<std::string>{"x", "y", "z"};
}

std::string after(const std::string& text, const std::string& path, std::optional<std::string> value) {
  const Result<std::string> changed = edited(text, {path, std::move(value)}, order_of);
  return changed ? *changed : "refused: " + changed.error().message;
}

TEST(YamlEdit, changes_one_value_and_keeps_all_else) {
  struct Case {
    const char *text, *path, *value, *expected;
  };
  const Case cases[] = {
      {"a: 1   # one\nb: 2\n", "a", "3.5", "a: 3.5   # one\nb: 2\n"},
      {"a: \"x # y\"   # one\n", "a", "z", "a: z   # one\n"},
      {"a: 'it''s'\n", "a", "z", "a: z\n"},
      {"a: {x: 1, y: 2}  # r\n", "a.x", "[1, 2]", "a: {x: [1, 2], y: 2}  # r\n"},
      {"a: {x: 1, y: 2}\n", "a.y", "9", "a: {x: 1, y: 9}\n"},
      {"a: {x: 1, z: 2}\n", "a.y", "9", "a: {x: 1, y: 9, z: 2}\n"},
      {"a: {y: 1}\n", "a.x", "9", "a: {x: 9, y: 1}\n"},
      {"a: {}\n", "a.x", "9", "a: {x: 9}\n"},
      {"a: {x: 1, y: 2, z: 3}\n", "a.y", nullptr, "a: {x: 1, z: 3}\n"},
      {"a: {x: 1, y: 2, z: 3}\n", "a.z", nullptr, "a: {x: 1, y: 2}\n"},
      {"a: {x: 1}\nb: 2\n", "a.x", nullptr, "# a: {x: 1}\nb: 2\n"},
      {"a:\n  x: 1\n       # more of x\n  z: 3\nb: 1\n", "a.y", "2",
       "a:\n  x: 1\n       # more of x\n  y: 2\n  z: 3\nb: 1\n"},
      {"a:\n  x: 1\n  # y: 5    # of y\n  z: 3\n", "a.y", "2", "a:\n  x: 1\n  y: 2      # of y\n  z: 3\n"},
      {"a:\n  x: 1  # r\n  y: 2\n", "a.x", nullptr, "a:\n  # x: 1  # r\n  y: 2\n"},
      {"a:\n  x: 1\nb:\n  # x: 7\n  y: 1\n", "a.y", "2", "a:\n  x: 1\n  y: 2\nb:\n  # x: 7\n  y: 1\n"},
      {"a:\n  z: 1\nb:\n  # x: 7\n  y: 1\n", "a.x", "2", "a:\n  x: 2\n  z: 1\nb:\n  # x: 7\n  y: 1\n"},
      {"a: 1\nc: 2\n", "b.x", "5", "a: 1\nb: {x: 5}\nc: 2\n"},
      {"b: 1\n", "a", "5", "a: 5\nb: 1\n"},
      {"a: 1", "b", "5", "a: 1\nb: 5\n"},
      {"a:\n  - x: 1   # s\n    y: 2\n  - {x: 3}\n", "a[1].x", "7",
       "a:\n  - x: 7   # s\n    y: 2\n  - {x: 3}\n"},
      {"a:\n  - x: 1\n  - {x: 3}\n", "a[2].x", "7", "a:\n  - x: 1\n  - {x: 7}\n"},
      {"a:   # steps\n  - x: 1\n  - {x: 3}\nb: 1\n", "a", "[{x: 2}]", "a: [{x: 2}]   # steps\nb: 1\n"},
      {"a: [[1, 2], [3, 4]]\n", "a[2]", "[5, 6]", "a: [[1, 2], [5, 6]]\n"},
      {"a:\r\n  x: 1\r\n", "a.x", "2", "a:\r\n  x: 2\r\n"},
      {"a: {x: 1,   # one\n    y: 2}\n", "a.y", "3", "a: {x: 1,   # one\n    y: 3}\n"},
      {"a:\nb: 1\n", "a", "2", "a: 2\nb: 1\n"},
  };
  for (const Case& c : cases)
    EXPECT_EQ(after(c.text, c.path, c.value ? std::optional<std::string>(c.value) : std::nullopt), c.expected)
        << c.text << c.path;
}

TEST(YamlEdit, refuses_what_would_change_anything_else) {
  for (const char* value : {"1, y: 2", "1\nb: 2", "}", "", "[1", "*a", "1}", "\"x"})
    EXPECT_TRUE(after("a: {x: 1}\n", "a.x", value).starts_with("refused: a.x: ")) << value;
  EXPECT_TRUE(after("a: 1\n", "a.x", "2").starts_with("refused: a.x: "));
  EXPECT_TRUE(after("a: [1]\n", "a[3]", "2").starts_with("refused: a[3]: "));
  EXPECT_TRUE(after("a: one\n  two\n", "a", "2").starts_with("refused: a: "));
  EXPECT_TRUE(after("a: [\n", "a", "2").starts_with("refused: "));
}

TEST(YamlEdit, tells_values_as_they_are_written) {
  const auto values =
      value_texts("a: {x: [1, 2], y: 'it''s'}  # r\nb: 1.50 # r\nc:\n  - x: 1\n    y: 2\nd:\n",
                  {"a.x", "a.x[2]", "a.y", "b", "c[1].y", "c[2].y", "d", "e", "b.x"});
  ASSERT_TRUE(values.has_value());
  EXPECT_EQ(*values, (std::vector<std::string>{"[1, 2]", "2", "'it''s'", "1.50", "2", "", "", "", ""}));
}

/// The remarks of a text, sorted.
std::vector<std::string> remarks(const std::string& text) {
  std::vector<std::string> found;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const std::size_t at = line.rfind("# ");
    if (at != std::string::npos) found.push_back(line.substr(at));
  }
  std::sort(found.begin(), found.end());
  return found;
}

bool has_all(const std::string& text, const std::string& of) {
  const std::vector<std::string> there = remarks(text), wanted = remarks(of);
  return std::includes(there.begin(), there.end(), wanted.begin(), wanted.end());
}

TEST(YamlEdit, the_example_goes_through_all_modes_and_back_with_every_remark) {
  const std::string example = example_job_text();
  const Result<KeyLog> log = job_keys(example);
  ASSERT_TRUE(log.has_value());
  const KeyOrder order = [&](const std::string& section) { return log->known(section); };
  std::string text = example;
  const auto set = [&](const std::string& path, std::optional<std::string> value) {
    const Result<std::string> changed = edited(text, {path, std::move(value)}, order);
    ASSERT_TRUE(changed.has_value()) << changed.error().message;
    text = *changed;
  };
  for (const char* key : {"axis.circle_radius_mm", "axis.sense", "containment"}) set(key, std::nullopt);
  set("axis.mode", "fixed");
  set("axis.n", "[0, 0, 1]");
  ASSERT_TRUE(parse_job(text, kExample).has_value()) << parse_job(text, kExample).error().message;
  set("cutter.corner_radius_mm", "0.5");
  set("cutter.type", "bull_nose");
  set("cutter.holder[2].length_mm", "60");
  set("pattern.angle_deg", "30");
  const Result<Job> job = parse_job(text, kExample);
  ASSERT_TRUE(job.has_value()) << job.error().message;
  EXPECT_EQ(job->plan.cutter.corner_radius, 0.5);
  EXPECT_EQ(job->plan.cutter.holder[1].length, 60.0);
  EXPECT_TRUE(has_all(text, example)) << text;
  set("cutter.type", "ball");
  set("cutter.corner_radius_mm", std::nullopt);
  set("axis.mode", "circle");
  set("axis.sense", "inward");
  set("axis.circle_radius_mm", "280");
  set("axis.n", "[0, 0, -1]");
  set("cutter.holder[2].length_mm", "50");
  set("pattern.angle_deg", "0");
  ASSERT_TRUE(parse_job(text, kExample).has_value());
  EXPECT_TRUE(has_all(text, example)) << text;
}

TEST(YamlEdit, every_plain_value_of_the_example_can_be_changed_alone) {
  const std::string example = example_job_text();
  const Result<KeyLog> log = job_keys(example);
  ASSERT_TRUE(log.has_value());
  int changed = 0;
  for (const KeyFact& fact : log->facts()) {
    if (!fact.present || fact.kind != KeyKind::kNumber) continue;
    const Result<std::string> text = edited(example, {fact.path, "12.25"}, {});
    ASSERT_TRUE(text.has_value()) << text.error().message;
    // The one line that differs has the value at its place.
    std::istringstream before(example), now(*text);
    int differ = 0;
    for (std::string a, b; std::getline(before, a) && std::getline(now, b);) differ += a != b;
    EXPECT_EQ(differ, 1) << fact.path;
    ++changed;
  }
  EXPECT_GT(changed, 25);
}

}  // namespace
}  // namespace tiltfeed
