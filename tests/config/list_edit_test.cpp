#include "config/list_edit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <sstream>

#include "config/text_layout.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

/// In the forms in which people write it: remarks above items, in them, at line ends; blank lines; braces.
const char* const kTexts[] = {
    R"(a: 1
# above the list
ops:
  # of the first
  - name: one  # at its end
    cutter: {type: ball}
      # further in

  # of the second, in
  # two lines
  - name: two
    axis:
      mode: line
      t: [0, 1, 0]
  - {name: three, pattern: {along: x}}
# of what comes behind
b: 2
)",
    "ops:\n- name: one\n- name: two\n  x: [1, 2]\n- name: three",
    R"(ops: [{name: one}, {name: 'two', x: {y: 3}},
  {name: three}]  # in braces
b: 2
)",
    R"(b: 2
ops:
    -   name: one
        x: "a - b # c"
    -   name: two


    -   name: three

# end
)",
};

std::vector<std::string> names_in(const std::string& text) {
  const auto tree = parse_yaml(text, "test");
  if (!tree) return {tree.error().message};
  std::vector<std::string> names;
  for (const YamlNode& item : tree->items[*key_index(*tree, "ops")].items)
    names.push_back(item.items[0].text);
  return names;
}

/// Every line of a text that has words, sorted.
std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);)
    if (line.find_first_not_of(' ') != line.npos) lines.push_back(line);
  std::sort(lines.begin(), lines.end());
  return lines;
}

TEST(ListEdit, every_move_gives_the_order_that_a_list_of_names_gives_and_loses_no_line) {
  for (const char* const text : kTexts)
    for (std::size_t from = 1; from <= 3; ++from)
      for (std::size_t to = 1; to <= 3; ++to) {
        std::vector<std::string> wanted = names_in(text);
        const std::string name = wanted[from - 1];
        wanted.erase(wanted.begin() + static_cast<std::ptrdiff_t>(from) - 1);
        wanted.insert(wanted.begin() + static_cast<std::ptrdiff_t>(to) - 1, name);
        const auto moved = item_moved(text, "ops", from, to);
        ASSERT_TRUE(moved.has_value()) << moved.error().message << "\n" << text;
        EXPECT_EQ(names_in(*moved), wanted) << *moved;
        if (std::string(text).find("ops: [") == std::string::npos) {
          EXPECT_EQ(lines_of(*moved), lines_of(text));
        }
        // There and back again is the same text, but for the end of a last line that had none.
        const auto back = item_moved(*moved, "ops", to, from);
        ASSERT_TRUE(back.has_value());
        EXPECT_EQ(lines_of(*back), lines_of(text));
      }
}

TEST(ListEdit, remarks_right_above_an_item_go_with_it) {
  const auto moved = item_moved(kTexts[0], "ops", 2, 1);
  ASSERT_TRUE(moved.has_value());
  EXPECT_EQ(*moved, R"(a: 1
# above the list
ops:
  # of the second, in
  # two lines
  - name: two
    axis:
      mode: line
      t: [0, 1, 0]
  # of the first
  - name: one  # at its end
    cutter: {type: ball}
      # further in

  - {name: three, pattern: {along: x}}
# of what comes behind
b: 2
)");
}

TEST(ListEdit, what_is_taken_out_stays_as_a_remark) {
  const auto without = item_taken_out(kTexts[0], "ops", 2);
  ASSERT_TRUE(without.has_value()) << without.error().message;
  EXPECT_EQ(names_in(*without), (std::vector<std::string>{"one", "three"}));
  EXPECT_NE(without->find("  # - name: two\n  #   axis:\n  #     mode: line\n"), std::string::npos)
      << *without;
  for (const char* const text : kTexts)
    for (std::size_t number = 1; number <= 3; ++number) {
      std::vector<std::string> wanted = names_in(text);
      wanted.erase(wanted.begin() + static_cast<std::ptrdiff_t>(number) - 1);
      const auto out = item_taken_out(text, "ops", number);
      ASSERT_TRUE(out.has_value()) << out.error().message;
      EXPECT_EQ(names_in(*out), wanted) << *out;
    }
}

TEST(ListEdit, a_copy_stands_behind_its_item) {
  for (const char* const text : kTexts)
    for (std::size_t number = 1; number <= 3; ++number) {
      std::vector<std::string> wanted = names_in(text);
      wanted.insert(wanted.begin() + static_cast<std::ptrdiff_t>(number), wanted[number - 1]);
      const auto out = item_copied(text, "ops", number);
      ASSERT_TRUE(out.has_value()) << out.error().message;
      EXPECT_EQ(names_in(*out), wanted) << *out;
    }
  const auto out = item_copied(kTexts[0], "ops", 1);
  ASSERT_TRUE(out.has_value());
  // The remark above the item is there once, that at its end twice.
  EXPECT_EQ(out->find("# of the first"), out->rfind("# of the first"));
  EXPECT_NE(out->find("# at its end"), out->rfind("# at its end"));
}

TEST(ListEdit, a_hundred_changes_in_a_row_keep_a_list_that_is_known) {
  std::mt19937 random(7);
  for (const char* const start : kTexts) {
    std::string text = start;
    std::vector<std::string> known = names_in(text);
    for (int step = 0; step < 100; ++step) {
      const auto any = [&](std::size_t most) { return 1 + random() % most; };
      const std::size_t from = any(known.size()), to = any(known.size());
      const auto at = [&](std::size_t number) {
        return known.begin() + static_cast<std::ptrdiff_t>(number) - 1;
      };
      const std::string name = known[from - 1];
      const std::size_t what = known.size() == 1 ? 0 : known.size() > 6 ? 1 : random() % 3;
      Result<std::string> changed = what == 0   ? item_copied(text, "ops", from)
                                    : what == 1 ? item_taken_out(text, "ops", from)
                                                : item_moved(text, "ops", from, to);
      ASSERT_TRUE(changed.has_value()) << changed.error().message << "\n" << text;
      if (what == 0) known.insert(at(from) + 1, name);
      if (what > 0) known.erase(at(from));
      if (what == 2) known.insert(at(to), name);
      text = std::move(*changed);
      ASSERT_EQ(names_in(text), known) << text;
    }
  }
}

TEST(ListEdit, refuses_what_is_not_there) {
  EXPECT_FALSE(item_moved("ops: [1, 2]\n", "ops", 1, 3).has_value());
  EXPECT_FALSE(item_moved("ops: [1, 2]\n", "ops", 0, 1).has_value());
  EXPECT_FALSE(item_copied("a: 1\n", "ops", 1).has_value());
  EXPECT_FALSE(item_copied("ops: 1\n", "ops", 1).has_value());
  EXPECT_FALSE(item_copied("- 1\n", "ops", 1).has_value());
  EXPECT_FALSE(item_copied("ops: [\n", "ops", 1).has_value());
  const auto last = item_taken_out("ops:\n  - name: a\n", "ops", 1);
  ASSERT_FALSE(last.has_value());
  EXPECT_NE(last.error().message.find("only one"), std::string::npos);
}

}  // namespace
}  // namespace tiltfeed::config
