#include "pathgen/set_cover.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace tiltfeed {

namespace {

/// Sums of the same weights in another order differ by this share of the whole at most.
constexpr double kRounding = 1e-12;

class Chooser {
 public:
  Chooser(const std::vector<std::vector<std::uint8_t>>& sets, const std::vector<double>& weights, double share,
          std::uint32_t most)
      : sets_(sets), weights_(weights), most_(most), held_(weights.size(), 0) {
    for (std::size_t e = 0; e < weights.size(); ++e) {
      all_ += weights[e];
      const bool any = std::any_of(sets.begin(), sets.end(), [e](const auto& s) { return s[e] != 0; });
      wanted_ += any ? weights[e] : 0.0;
    }
    wanted_ = share * wanted_ - kRounding * all_;
  }

  SetCover run() {
    grow();
    while (drop() || merge() || exchange()) grow();
    drop_rest();
    return {in_order(), weight_};
  }

 private:
  bool enough() const { return weight_ >= wanted_; }
  /// What set s adds to those chosen.
  double gain(std::uint32_t s) const {
    double sum = 0.0;
    for (std::size_t e = 0; e < weights_.size(); ++e)
      if (sets_[s][e] != 0 && held_[e] == 0) sum += weights_[e];
    return sum;
  }
  /// What only set s holds of those chosen.
  double own(std::uint32_t s) const {
    double sum = 0.0;
    for (std::size_t e = 0; e < weights_.size(); ++e)
      if (sets_[s][e] != 0 && held_[e] == 1) sum += weights_[e];
    return sum;
  }
  void put(std::uint32_t s) {
    weight_ += gain(s);
    for (std::size_t e = 0; e < weights_.size(); ++e) held_[e] += sets_[s][e];
    chosen_.push_back(s);
  }
  void take(std::size_t place) {
    const std::uint32_t s = chosen_[place];
    weight_ -= own(s);
    for (std::size_t e = 0; e < weights_.size(); ++e) held_[e] -= sets_[s][e];
    chosen_.erase(chosen_.begin() + static_cast<std::ptrdiff_t>(place));
  }
  /// The set that adds the most; the number of sets if none adds anything.
  std::uint32_t best() const {
    double most = kRounding * all_;
    auto found = static_cast<std::uint32_t>(sets_.size());
    for (std::uint32_t s = 0; s < sets_.size(); ++s)
      if (const double g = gain(s); g > most * (1.0 + kRounding)) most = g, found = s;
    return found;
  }
  void grow() {
    while (!enough() && chosen_.size() < most_) {
      const std::uint32_t s = best();
      if (s == sets_.size()) return;
      put(s);
    }
  }
  /// Leaves out the set whose loss is the least, if that leaves enough.
  bool drop() {
    if (chosen_.empty()) return false;
    std::size_t least = 0;
    for (std::size_t i = 1; i < chosen_.size(); ++i)
      if (own(chosen_[i]) < own(chosen_[least])) least = i;
    if (weight_ - own(chosen_[least]) < wanted_) return false;
    take(least);
    return true;
  }
  void drop_rest() {
    while (drop()) continue;
  }
  /// One set for two, if that leaves enough.
  bool merge() {
    for (std::size_t i = 0; i < chosen_.size(); ++i)
      for (std::size_t j = i + 1; j < chosen_.size(); ++j) {
        const std::uint32_t first = chosen_[i], second = chosen_[j];
        take(j), take(i);
        const std::uint32_t s = best();
        if (s != sets_.size() && weight_ + gain(s) >= wanted_) {
          put(s);
          return true;
        }
        put(first), put(second);
        std::rotate(chosen_.begin() + static_cast<std::ptrdiff_t>(i), chosen_.end() - 2, chosen_.end() - 1);
        std::rotate(chosen_.begin() + static_cast<std::ptrdiff_t>(j), chosen_.end() - 1, chosen_.end());
      }
    return false;
  }
  /// One set for another with which all hold more, where they do not hold enough.
  bool exchange() {
    if (enough()) return false;
    for (std::size_t i = 0; i < chosen_.size(); ++i) {
      const std::uint32_t old = chosen_[i];
      const double before = weight_;
      take(i);
      const std::uint32_t s = best();
      if (s != sets_.size() && weight_ + gain(s) > before + kRounding * all_) {
        put(s);
        return true;
      }
      put(old);
      std::rotate(chosen_.begin() + static_cast<std::ptrdiff_t>(i), chosen_.end() - 1, chosen_.end());
    }
    return false;
  }
  /// By what each adds to those before it.
  std::vector<std::uint32_t> in_order() {
    std::vector<std::uint32_t> left = chosen_, order;
    std::sort(left.begin(), left.end());
    std::fill(held_.begin(), held_.end(), 0u);
    while (!left.empty()) {
      const auto next =
          std::max_element(left.begin(), left.end(), [&](auto a, auto b) { return gain(a) < gain(b); });
      for (std::size_t e = 0; e < weights_.size(); ++e) held_[e] += sets_[*next][e];
      order.push_back(*next);
      left.erase(next);
    }
    return order;
  }

  const std::vector<std::vector<std::uint8_t>>& sets_;
  const std::vector<double>& weights_;
  std::uint32_t most_;
  double all_ = 0.0, wanted_ = 0.0, weight_ = 0.0;
  std::vector<std::uint32_t> held_;  ///< by how many chosen sets, of each element
  std::vector<std::uint32_t> chosen_;
};

}  // namespace

SetCover cover_by_few(const std::vector<std::vector<std::uint8_t>>& sets, const std::vector<double>& weights,
                      double share, std::uint32_t most) {
  for (const auto& set : sets) assert(set.size() == weights.size());
  return Chooser(sets, weights, share, most).run();
}

}  // namespace tiltfeed
