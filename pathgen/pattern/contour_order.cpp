#include "pathgen/pattern/contour_order.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace tiltfeed::pathgen {

namespace {

/// What must be done before any of the loops below it: the loops of one level round one pocket, or of the
/// islands that are one at the next level.
struct Gate {
  int open_after = 0;
  std::vector<LoopId> below;
};

/// A pocket's gate is its region on the upper level; on open ground, the region of the island on the lower.
using Key = std::tuple<int, int, int>;  // upper level, region outside on it, region inside one level down

class Order {
 public:
  explicit Order(const std::vector<LevelSet>& sets) : sets_(sets) {
    for (int level = 0; level < static_cast<int>(sets.size()); ++level)
      for (int k = 0; k < static_cast<int>(loops(level).size()); ++k) enter({level, k});
  }

  std::vector<std::vector<LoopId>> run() {
    // Last in, first out: the last to be pushed is followed down first.
    for (int level = static_cast<int>(sets_.size()) - 1; level >= 0; --level) {
      std::vector<LoopId> tops;
      for (int k = 0; k < static_cast<int>(loops(level).size()); ++k)
        if (gates_[above({level, k})].open_after == 0) tops.push_back({level, k});
      push(tops);
    }
    while (!ready_.empty()) {
      const LoopId id = ready_.back();
      ready_.pop_back();
      if (groups_.empty() || !follows_) groups_.emplace_back();
      groups_.back().push_back(id);
      Gate& gate = gates_[below(id)];
      follows_ = --gate.open_after == 0 && !gate.below.empty();
      if (gate.open_after == 0) push(gate.below);
      const bool same_region = !ready_.empty() && ready_.back().level == id.level &&
                               outside(ready_.back()) == outside(id) && !sea(id);
      follows_ = follows_ || same_region;
    }
    return std::move(groups_);
  }

 private:
  const std::vector<Loop>& loops(int level) const { return sets_[static_cast<std::size_t>(level)].loops(); }
  const Loop& loop(LoopId id) const { return loops(id.level)[static_cast<std::size_t>(id.loop)]; }
  int outside(LoopId id) const { return loop(id).outside; }
  bool sea(LoopId id) const { return sets_[static_cast<std::size_t>(id.level)].is_sea(outside(id)); }

  Key below(LoopId id) const {
    int island = -1;
    if (sea(id) && id.level + 1 < static_cast<int>(sets_.size()))
      island = sets_[static_cast<std::size_t>(id.level) + 1].region_at(loop(id).in_inside);
    return {id.level, outside(id), island};
  }
  Key above(LoopId id) const {
    if (id.level == 0) return {-1, -1, -1};
    const LevelSet& up = sets_[static_cast<std::size_t>(id.level) - 1];
    const int ground = up.region_at(loop(id).in_outside);
    return {id.level - 1, ground, up.is_sea(ground) ? loop(id).inside : -1};
  }
  void enter(LoopId id) {
    ++gates_[below(id)].open_after;
    gates_[above(id)].below.push_back(id);
  }
  /// The loops of one region end up next to each other.
  void push(std::vector<LoopId> ids) {
    std::stable_sort(ids.begin(), ids.end(), [&](LoopId a, LoopId b) { return outside(a) > outside(b); });
    ready_.insert(ready_.end(), ids.begin(), ids.end());
  }

  const std::vector<LevelSet>& sets_;
  std::map<Key, Gate> gates_;
  std::vector<LoopId> ready_;
  std::vector<std::vector<LoopId>> groups_;
  bool follows_ = false;
};

}  // namespace

std::vector<std::vector<LoopId>> order_of(const std::vector<LevelSet>& sets) { return Order(sets).run(); }

}  // namespace tiltfeed::pathgen
