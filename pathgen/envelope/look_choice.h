#pragma once
// How to look at the next place: patch by patch down the list of those that may be highest there, or by the
// tree of the index. Both find the same; which costs less hangs on the part. (S8) in
// pathgen/surface/README.md.

#include <algorithm>
#include <array>
#include <cstddef>

namespace tiltfeed::pathgen {

class LookChoice {
 public:
  bool by_tree() const { return look_ == kTree; }

  /// After a place that was looked at in the way chosen and took so much (HighestPatch::cost).
  /// `has_tree(spent)`: is there one by now? Asked where the list costs much; `spent`: by it since it was.
  template <class HasTree>
  void count(std::size_t cost, HasTree has_tree) {
    Mean& mean = means_[look_];
    mean.cost += (static_cast<double>(cost) - mean.cost) * (mean.known ? kNewest : 1.0);
    mean.known = true;
    if (--places_ > 0) return;
    places_ = kTrial;
    const Mean &list = means_[kList], &tree = means_[kTree];
    if (list.cost <= kMuch || (!tree.known && !has_tree(static_cast<std::size_t>(kTrial * list.cost)))) {
      look_ = kList, trial_ = false;
    } else if (trial_) {
      look_ = tree.cost < list.cost ? kTree : kList, trial_ = false;
      const double dearer = std::max(tree.cost, list.cost) / std::max(1.0, std::min(tree.cost, list.cost));
      places_ = static_cast<int>(std::clamp(kTrialShare * dearer, double{kKept}, double{kLongest}));
    } else {
      look_ = look_ == kTree ? kList : kTree, trial_ = true;
    }
  }

 private:
  enum Look : std::size_t { kList, kTree };
  /// A list that costs less at a place is not worth leaving.
  static constexpr double kMuch = 48.0;
  /// The better way serves for so many places; then the other is tried for a few. One that is many times as
  /// dear is tried later, up to kLongest, so that trials take some 5 % of the time.
  static constexpr int kKept = 1024, kTrial = 8, kLongest = 16 * kKept;
  static constexpr double kTrialShare = 20.0 * kTrial;
  /// Share of the newest place in the mean.
  static constexpr double kNewest = 1.0 / 64.0;

  Look look_ = kList;
  bool trial_ = false;
  int places_ = kTrial;
  struct Mean {
    double cost = 0.0;
    bool known = false;
  };
  std::array<Mean, 2> means_{};
};

}  // namespace tiltfeed::pathgen
