// Which rows are cut: every need is met, and what is cut lies between bounds that are found otherwise.
#include "pathgen/pattern/row_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kBin = 1.0, kWayUp = 6.0;

/// A row from bin 0 to bin `bins` - 1, a millimetre each.
ChoosableRow row_of(std::int32_t bins) {
  ChoosableRow row;
  row.passes = {{0, bins - 1}};
  for (std::int32_t i = 0; i < bins; ++i) row.way.push_back(static_cast<float>(i + 1));
  return row;
}

double cut(const ChosenRows& chosen) {
  double sum = 0.0;
  for (const auto* part : {&chosen.main, &chosen.fill})
    for (const RowStretch& s : *part) sum += kBin * (s.last - s.first + 1);
  return sum;
}

std::size_t unmet(const std::vector<ChoosableRow>& rows, const ChosenRows& chosen) {
  std::size_t found = 0;
  for (const ChoosableRow& row : rows)
    for (const RowNeed& need : row.needs) {
      bool met = false;
      for (const auto* part : {&chosen.main, &chosen.fill})
        for (const RowStretch& s : *part)
          met |= need.low <= s.row && s.row <= need.high && s.first <= need.bin && need.bin <= s.last;
      found += met ? 0 : 1;
    }
  return found;
}

/// The fewest rows that meet all needs in the bins from..to.
std::int32_t fewest(const std::vector<ChoosableRow>& rows, std::int32_t from, std::int32_t to) {
  std::vector<RowNeed> needs;
  for (const ChoosableRow& row : rows)
    for (const RowNeed& need : row.needs)
      if (need.bin >= from && need.bin <= to) needs.push_back(need);
  std::sort(needs.begin(), needs.end(), [](const RowNeed& a, const RowNeed& b) { return a.high < b.high; });
  std::int32_t count = 0, last = -1;
  for (const RowNeed& need : needs)
    if (need.low > last) last = need.high, ++count;
  return count;
}

/// Needs of a surface that allows `wide` rows to both sides, `narrow` in a patch of bins and rows.
std::vector<ChoosableRow> surface(std::int32_t rows, std::int32_t bins, std::int32_t wide,
                                  std::int32_t narrow, RowStretch patch, std::int32_t patch_rows) {
  std::vector<ChoosableRow> all;
  for (std::int32_t k = 0; k < rows; ++k) {
    ChoosableRow row = row_of(bins);
    for (std::int32_t bin = 0; bin < bins; ++bin) {
      const bool in = k >= patch.row && k < patch.row + patch_rows && bin >= patch.first && bin <= patch.last;
      const std::int32_t reach = in ? narrow : wide;
      row.needs.push_back({bin, std::max(0, k - reach), std::min(rows - 1, k + reach)});
    }
    all.push_back(std::move(row));
  }
  return all;
}

TEST(RowChoice, EvenNeedsAreMetByTheFewestWholeRows) {
  for (const std::int32_t wide : {0, 1, 3, 7}) {
    const auto rows = surface(60, 40, wide, wide, {}, 0);
    const ChosenRows chosen = choose_rows(rows, kWayUp, kBin);
    EXPECT_EQ(unmet(rows, chosen), 0u);
    EXPECT_TRUE(chosen.fill.empty());
    EXPECT_EQ(std::ssize(chosen.main), (60 + 2 * wide) / (2 * wide + 1)) << wide;
  }
}

TEST(RowChoice, APatchIsFilledByShortRows) {
  const auto rows = surface(60, 200, 5, 1, {20, 50, 60}, 12);
  const ChosenRows chosen = choose_rows(rows, kWayUp, kBin);
  EXPECT_EQ(unmet(rows, chosen), 0u);
  EXPECT_FALSE(chosen.fill.empty());
  for (const RowStretch& s : chosen.fill) EXPECT_LE(s.last - s.first, 12);
  EXPECT_LE(std::ssize(chosen.main), 7);
}

TEST(RowChoice, WhatTheNeighboursCutIsLeftOut) {
  // Rows that come together at one end: there one of three is enough.
  std::vector<ChoosableRow> rows;
  for (std::int32_t k = 0; k < 30; ++k) {
    ChoosableRow row = row_of(120);
    for (std::int32_t bin = 0; bin < 120; ++bin) {
      const std::int32_t reach = bin < 60 ? 4 : 1;
      row.needs.push_back({bin, std::max(0, k - reach), std::min(29, k + reach)});
    }
    rows.push_back(std::move(row));
  }
  const ChosenRows chosen = choose_rows(rows, kWayUp, kBin);
  EXPECT_EQ(unmet(rows, chosen), 0u);
  EXPECT_LE(cut(chosen), 1.2 * (60 * 10 + 60 * 4));
}

TEST(RowChoice, RandomNeedsAreMetWithinBounds) {
  std::mt19937 random(11);
  const auto dice = [&](std::int32_t low, std::int32_t high) {
    return std::uniform_int_distribution<std::int32_t>(low, high)(random);
  };
  for (int k = 0; k < 300; ++k) {
    const std::int32_t count = dice(1, 40), bins = dice(1, 60), most = dice(0, 9);
    std::vector<ChoosableRow> rows;
    for (std::int32_t r = 0; r < count; ++r) {
      ChoosableRow row = row_of(bins);
      for (std::int32_t bin = 0; bin < bins; ++bin)
        for (std::int32_t i = dice(0, 2); i > 0; --i)
          row.needs.push_back({bin, std::max(0, r - dice(0, most)), std::min(count - 1, r + dice(0, most))});
      rows.push_back(std::move(row));
    }
    const ChosenRows chosen = choose_rows(rows, kWayUp, kBin);
    ASSERT_EQ(unmet(rows, chosen), 0u) << "case " << k;
    double least = 0.0;
    for (std::int32_t bin = 0; bin < bins; ++bin) least += kBin * fewest(rows, bin, bin);
    EXPECT_GE(cut(chosen), least) << "case " << k;
    EXPECT_LE(cut(chosen) + kWayUp * static_cast<double>(chosen.fill.size()),
              kBin * bins * fewest(rows, 0, bins - 1) + 1e-9)
        << "case " << k << ": whole rows alone are better";
    const ChosenRows again = choose_rows(rows, kWayUp, kBin);
    EXPECT_TRUE(chosen.main == again.main && chosen.fill == again.fill);
  }
}

TEST(RowChoice, NothingComesOfNothing) {
  EXPECT_TRUE(choose_rows({}, kWayUp, kBin).main.empty());
  const ChosenRows chosen = choose_rows(std::vector<ChoosableRow>(200), kWayUp, kBin);
  EXPECT_TRUE(chosen.main.empty() && chosen.fill.empty());
}

}  // namespace
}  // namespace tiltfeed
