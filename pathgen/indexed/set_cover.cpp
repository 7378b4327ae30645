#include "pathgen/indexed/set_cover.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <utility>

namespace tiltfeed::pathgen {

namespace {

/// With more sets than this, exchanging three for two takes too long.
constexpr std::size_t kMostForThree = 8;

/// Elements, a bit each.
using Bits = std::vector<std::uint64_t>;

std::uint32_t count(const Bits& bits) {
  int sum = 0;
  for (const std::uint64_t word : bits) sum += std::popcount(word);
  return static_cast<std::uint32_t>(sum);
}
/// What a holds and b does not.
std::uint32_t count_without(const Bits& a, const Bits& b) {
  int sum = 0;
  for (std::size_t w = 0; w < a.size(); ++w) sum += std::popcount(a[w] & ~b[w]);
  return static_cast<std::uint32_t>(sum);
}
void add(Bits& a, const Bits& b) {
  for (std::size_t w = 0; w < a.size(); ++w) a[w] |= b[w];
}

using Chosen = std::vector<std::uint32_t>;

class Chooser {
 public:
  Chooser(const std::vector<std::vector<std::uint8_t>>& sets, double share, std::uint32_t most,
          double least_gain)
      : most_(most) {
    const std::size_t elements = sets.empty() ? 0 : sets[0].size();
    words_ = (elements + 63) / 64;
    Bits all(words_, 0);
    for (const auto& set : sets) {
      assert(set.size() == elements);
      Bits bits(words_, 0);
      for (std::size_t e = 0; e < elements; ++e)
        if (set[e] != 0) bits[e / 64] |= std::uint64_t{1} << e % 64;
      add(all, bits);
      sets_.push_back(std::move(bits));
    }
    constexpr double kRounding = 1e-9;
    wanted_ = static_cast<std::uint32_t>(std::ceil(share * count(all) - kRounding));
    least_ = static_cast<std::uint32_t>(std::ceil(least_gain * count(all) - kRounding));
  }

  SetCover run() {
    improve();
    // What small sets held may be worth another set.
    for (Chosen best = chosen_;; best = chosen_) {
      improve();
      if (count(held_by(chosen_)) > count(held_by(best))) continue;
      chosen_ = best;
      return in_order();
    }
  }

 private:
  void improve() {
    grow();
    while (drop() || two_to_one() || three_to_two() || exchange()) grow();
    drop_small();
  }
  Bits held_by(const Chosen& some) const {
    Bits held(words_, 0);
    for (const std::uint32_t s : some) add(held, sets_[s]);
    return held;
  }
  bool enough(const Chosen& some) const { return count(held_by(some)) >= wanted_; }
  Chosen without(std::initializer_list<std::size_t> places) const {
    Chosen rest;
    for (std::size_t i = 0; i < chosen_.size(); ++i)
      if (std::find(places.begin(), places.end(), i) == places.end()) rest.push_back(chosen_[i]);
    return rest;
  }
  /// The set that adds the most, if any adds enough to be worth it.
  std::optional<std::uint32_t> best(const Bits& held) const {
    std::uint32_t most = least_ > 0 ? least_ - 1 : 0;
    std::optional<std::uint32_t> found;
    for (std::uint32_t s = 0; s < sets_.size(); ++s)
      if (const std::uint32_t gain = count_without(sets_[s], held); gain > most) most = gain, found = s;
    return found;
  }
  /// Two sets that with `held` are enough.
  std::optional<std::array<std::uint32_t, 2>> best_two(const Bits& held) const {
    const std::uint32_t lacking = wanted_ - std::min(wanted_, count(held));
    std::vector<std::pair<std::uint32_t, std::uint32_t>> gains;  // descending; then by index
    for (std::uint32_t s = 0; s < sets_.size(); ++s)
      if (const std::uint32_t gain = count_without(sets_[s], held); gain > 0) gains.emplace_back(~gain, s);
    std::sort(gains.begin(), gains.end());
    for (std::size_t i = 0; i < gains.size() && 2 * ~gains[i].first >= lacking; ++i) {
      Bits with = held;
      add(with, sets_[gains[i].second]);
      for (std::size_t j = i + 1; j < gains.size() && ~gains[i].first + ~gains[j].first >= lacking; ++j)
        if (~gains[i].first + count_without(sets_[gains[j].second], with) >= lacking)
          return std::array{gains[i].second, gains[j].second};
    }
    return std::nullopt;
  }

  void grow() {
    while (!enough(chosen_) && chosen_.size() < most_) {
      const auto s = best(held_by(chosen_));
      if (!s) return;
      chosen_.push_back(*s);
    }
  }
  bool drop() {
    for (std::size_t i = chosen_.size(); i-- > 0;)
      if (enough(without({i}))) {
        chosen_ = without({i});
        return true;
      }
    return false;
  }
  /// Sets that alone hold too little, the one with the least first.
  void drop_small() {
    while (!chosen_.empty()) {
      std::size_t least = 0;
      std::uint32_t alone = ~0u;
      for (std::size_t i = chosen_.size(); i-- > 0;)
        if (const std::uint32_t n = count_without(sets_[chosen_[i]], held_by(without({i}))); n < alone)
          alone = n, least = i;
      if (alone >= least_) return;
      chosen_ = without({least});
    }
  }
  bool two_to_one() {
    for (std::size_t i = 0; i < chosen_.size(); ++i)
      for (std::size_t j = i + 1; j < chosen_.size(); ++j) {
        Chosen rest = without({i, j});
        const auto s = best(held_by(rest));
        if (!s) continue;
        rest.push_back(*s);
        if (!enough(rest)) continue;
        chosen_ = rest;
        return true;
      }
    return false;
  }
  bool three_to_two() {
    if (chosen_.size() > kMostForThree || !enough(chosen_)) return false;
    for (std::size_t i = 0; i < chosen_.size(); ++i)
      for (std::size_t j = i + 1; j < chosen_.size(); ++j)
        for (std::size_t k = j + 1; k < chosen_.size(); ++k) {
          Chosen rest = without({i, j, k});
          const auto two = best_two(held_by(rest));
          if (!two) continue;
          rest.insert(rest.end(), two->begin(), two->end());
          chosen_ = rest;
          return true;
        }
    return false;
  }
  /// One set for another with which all hold more, where they do not hold enough.
  bool exchange() {
    const std::uint32_t before = count(held_by(chosen_));
    if (before >= wanted_) return false;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      Chosen other = without({i});
      const auto s = best(held_by(other));
      if (!s) continue;
      other.push_back(*s);
      if (count(held_by(other)) <= before) continue;
      chosen_ = other;
      return true;
    }
    return false;
  }
  /// By what each adds to those before it.
  SetCover in_order() const {
    Chosen left = chosen_;
    std::sort(left.begin(), left.end());
    SetCover cover;
    Bits held(words_, 0);
    while (!left.empty()) {
      const auto next = std::max_element(left.begin(), left.end(), [&](std::uint32_t a, std::uint32_t b) {
        return count_without(sets_[a], held) < count_without(sets_[b], held);
      });
      add(held, sets_[*next]);
      cover.chosen.push_back(*next);
      left.erase(next);
    }
    cover.held = count(held);
    return cover;
  }

  std::uint32_t most_, wanted_ = 0, least_ = 0;
  std::size_t words_ = 0;
  std::vector<Bits> sets_;
  Chosen chosen_;
};

}  // namespace

SetCover cover_by_few(const std::vector<std::vector<std::uint8_t>>& sets, double share, std::uint32_t most,
                      double least_gain) {
  return Chooser(sets, share, most, least_gain).run();
}

}  // namespace tiltfeed::pathgen
