// The sweep over a line's candidates against what its breaks and stretches are said to be.
#include "pathgen/surface/candidates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace tiltfeed {
using namespace pathgen;
namespace {

/// Sorted starts and ends; of those nearer than `close` to the last one kept, all but the last of all go.
std::vector<double> breaks_of(const std::vector<Candidate>& all, double close) {
  std::vector<double> places;
  for (const Candidate& c : all) places.push_back(c.from), places.push_back(c.to);
  std::sort(places.begin(), places.end());
  std::vector<double> breaks;
  for (const double place : places)
    if (breaks.empty() || place - breaks.back() >= close) breaks.push_back(place);
  if (!breaks.empty() && breaks.back() < places.back()) breaks.push_back(places.back());
  return breaks;
}

/// By rising start, some alike.
std::vector<Candidate> some_candidates(std::mt19937& random, std::size_t count) {
  std::vector<Candidate> all(count);
  const auto tenths = [&](unsigned most) { return 0.1 * static_cast<double>(random() % most); };
  for (std::size_t i = 0; i < count; ++i) {
    all[i].from = tenths(200), all[i].to = all[i].from + tenths(random() % 8 == 0 ? 100 : 12);
    all[i].patch = static_cast<PatchId>(i), all[i].top = static_cast<float>(random() % 5);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Candidate& a, const Candidate& b) { return a.from < b.from; });
  return all;
}

TEST(CandidateSweep, GoesFromBreakToBreakWithAllThatOverlap) {
  std::mt19937 random(3);
  for (std::size_t round = 0; round < 400; ++round) {
    const std::vector<Candidate> all = some_candidates(random, 1 + round % 60);
    const double close = 0.05 + 0.15 * static_cast<double>(round % 7);  // between tenths: no tie is rounded
    SCOPED_TRACE("round " + std::to_string(round));
    const std::vector<double> breaks = breaks_of(all, close);
    CandidateSweep sweep(all, close);
    for (std::size_t i = 0; i < breaks.size(); ++i) {
      ASSERT_TRUE(sweep.next()) << "break " << i;
      const double from = breaks[i == 0 ? 0 : i - 1], to = breaks[i];
      ASSERT_EQ(sweep.from(), from);
      ASSERT_EQ(sweep.to(), to);
      if ((round + i) % 3 == 1) continue;  // whether it was asked before does not matter
      std::vector<Candidate> expected;
      for (const Candidate& c : all)
        if (c.from <= to && c.to >= from) expected.push_back(c);
      std::stable_sort(expected.begin(), expected.end(),
                       [](const Candidate& a, const Candidate& b) { return a.top > b.top; });
      const std::vector<Candidate>& active = sweep.active();
      ASSERT_EQ(active.size(), expected.size()) << "break " << i;
      for (std::size_t k = 0; k < active.size(); ++k) EXPECT_EQ(active[k].patch, expected[k].patch);
    }
    EXPECT_FALSE(sweep.next());
  }
}

TEST(CandidateSweep, HasNowhereToGoWithoutCandidates) {
  CandidateSweep sweep({}, 0.1);
  EXPECT_FALSE(sweep.next());
}

}  // namespace
}  // namespace tiltfeed
