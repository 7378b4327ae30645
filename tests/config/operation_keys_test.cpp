#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "config/job.h"
#include "config/job_catalogue.h"
#include "config/yaml_edit.h"

namespace tiltfeed::config {
namespace {

std::string job_text() {
  auto text = read_config_text(std::string(SOURCE_DIR) + "/config/jobs/pin_operations.yaml");
  return text ? *text : text.error().message;
}

const KeyFact* find(const OperationKeys& keys, const std::string& path) {
  for (const KeyFact& fact : keys.log.facts())
    if (fact.path == path) return &fact;
  return nullptr;
}

TEST(OperationKeys, say_what_each_states_itself_and_where_it_stands) {
  const std::string text = job_text();
  const auto all = operation_keys(text);
  ASSERT_TRUE(all.has_value());
  ASSERT_EQ(all->size(), 3u);
  const OperationKeys &first = (*all)[0], &second = (*all)[1];
  EXPECT_EQ(first.name, "semi-finish");
  EXPECT_EQ(first.number, 1u);
  EXPECT_EQ(first.place("cutter.diameter_mm"), "operations[1].cutter.diameter_mm");
  EXPECT_EQ(second.place("cutter.diameter_mm"), "cutter.diameter_mm");
  EXPECT_EQ(second.place("program.coolant"), "operations[2].program.coolant");
  EXPECT_EQ(first.place("program.coolant"), "program.coolant");
  EXPECT_EQ(first.place("allowance_mm"), "operations[1].allowance_mm");
  // What is told of a key is what stands at its place: the values by an independent way through the text.
  for (const OperationKeys& one : *all)
    for (const char* path : {"cutter.diameter_mm", "pattern.side_step_mm", "tolerance_mm", "axis.mode"}) {
      const KeyFact* const fact = find(one, path);
      ASSERT_NE(fact, nullptr) << path;
      ASSERT_TRUE(fact->present) << path;
      const auto value = value_texts(text, {one.place(path)});
      ASSERT_TRUE(value.has_value());
      std::size_t at = 0;
      for (int line = 1; line < fact->place.line; ++line) at = text.find('\n', at) + 1;
      at += static_cast<std::size_t>(fact->place.column) - 1;
      EXPECT_EQ(text.compare(at, value->front().size(), value->front()), 0) << one.name << " " << path;
    }
}

TEST(OperationKeys, an_edit_at_the_place_changes_that_operation_as_the_reader_sees_it) {
  const std::string text = job_text();
  const auto all = operation_keys(text);
  const auto order = key_order(text);
  ASSERT_TRUE(all.has_value() && order.has_value());
  for (std::size_t i = 0; i < all->size(); ++i) {
    const auto changed = edited(text, {(*all)[i].place("tolerance_mm"), "0.02"}, *order);
    ASSERT_TRUE(changed.has_value()) << changed.error().message;
    const auto keys = operation_keys(*changed);
    ASSERT_TRUE(keys.has_value());
    for (std::size_t k = 0; k < keys->size(); ++k) {
      const auto before = value_texts(text, {(*all)[k].place("tolerance_mm")});
      const auto now = value_texts(*changed, {(*keys)[k].place("tolerance_mm")});
      EXPECT_EQ(now->front(), k == i ? "0.02" : before->front());
    }
  }
}

TEST(OperationKeys, a_job_without_a_list_is_one) {
  const auto text = read_config_text(std::string(SOURCE_DIR) + "/config/jobs/pin.yaml");
  ASSERT_TRUE(text.has_value());
  const auto all = operation_keys(*text);
  ASSERT_TRUE(all.has_value());
  ASSERT_EQ(all->size(), 1u);
  EXPECT_EQ(all->front().number, 0u);
  EXPECT_EQ(all->front().place("cutter.type"), "cutter.type");
  const auto same = job_keys(*text);
  ASSERT_TRUE(same.has_value());
  std::map<std::string, bool> known;
  for (const KeyFact& fact : same->facts()) known[fact.path] = fact.present;
  for (const KeyFact& fact : all->front().log.facts()) {
    ASSERT_TRUE(known.contains(fact.path)) << fact.path;
    EXPECT_EQ(known[fact.path], fact.present) << fact.path;
  }
}

/// A key that the shared sections together may not have, and an operation may, stays.
TEST(OperationKeys, a_key_is_unused_where_no_operation_may_have_it) {
  std::string text = job_text();
  const auto with = [](std::string in, const std::string& what, const std::string& before) {
    return in.insert(in.find(before), what);
  };
  text = with(text, "pattern: {kind: z_level, step_down_mm: 1, side_step_mm: 1}\n", "setup:");
  auto unused = unused_keys(text);
  ASSERT_TRUE(unused.has_value());
  EXPECT_EQ(unused->size(), 0u);  // all three have patterns of their own, nobody reads it
  text =
      with(text, "  - name: last\n    tolerance_mm: 0.02\n    program: {tool: 2}\n", "  - name: semi-finish");
  unused = unused_keys(text);
  ASSERT_TRUE(unused.has_value());
  EXPECT_EQ(*unused, std::vector<std::string>{"pattern.side_step_mm"});
  // What the first two may have, and the last one may not, stays.
  text = with(job_text(), "containment: {theta_deg: [-10, 10]}\n", "setup:") +
         "  - name: last\n    axis: {mode: fixed}\n    program: {tool: 2}\n";
  unused = unused_keys(text);
  ASSERT_TRUE(unused.has_value());
  EXPECT_EQ(unused->size(), 0u);
  // A job that is one operation has no order of them.
  text = with(job_text(), "operation_order: listed\n", "machine:");
  text.erase(text.find("# What each has by itself"));
  unused = unused_keys(text);
  ASSERT_TRUE(unused.has_value());
  EXPECT_EQ(*unused, std::vector<std::string>{"operation_order"});
}

TEST(OperationKeys, broken_lists_have_no_operations_and_do_no_harm) {
  for (const char* text : {"operations: 3\n", "operations: []\n", "operations: [1, 2]\n", "operations:\n",
                           "operations: [{name: a}, 3]\n", "[1, 2]\n", "3\n"}) {
    const auto all = operation_keys(text);
    const std::vector<OperationKeys> found = all ? *all : std::vector<OperationKeys>{};
    for (const OperationKeys& one : found) EXPECT_FALSE(one.place("cutter.type").empty());
    (void)unused_keys(text);
    (void)key_order(text);
  }
}

}  // namespace
}  // namespace tiltfeed::config
