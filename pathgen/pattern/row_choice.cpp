#include "pathgen/pattern/row_choice.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace tiltfeed::pathgen {

namespace {

constexpr double kNoWay = std::numeric_limits<double>::infinity();
/// Rows further on are not tried once filling up to there costs so many times the dearest row.
constexpr double kTooDear = 1.2;

class Choice {
 public:
  Choice(const std::vector<ChoosableRow>& rows, double way_up, double bin)
      : rows_(rows),
        count_(static_cast<std::int32_t>(rows.size())),
        way_up_(way_up),
        bridge_(std::max(1, static_cast<std::int32_t>(way_up / bin))) {}

  ChosenRows run(const std::function<bool()>& go_on) {
    if (!find_fills(go_on)) return {};
    const std::vector<std::int32_t> whole = whole_rows();
    ChosenRows chosen;
    std::int32_t last = -1;
    for (const std::int32_t row : whole) {
      fill(last, row, &chosen.fill);
      last = row;
    }
    fill(last, count_, &chosen.fill);
    order(chosen.fill);
    chosen.main = needed_of(whole);
    return chosen;
  }

 private:
  static void order(std::vector<RowStretch>& stretches) {
    std::sort(stretches.begin(), stretches.end(), [](const RowStretch& a, const RowStretch& b) {
      return a.row != b.row ? a.row < b.row : a.first < b.first;
    });
  }

  static bool before(const RowNeed& a, const RowNeed& b) { return a.bin < b.bin; }

  double cost(std::int32_t row) const {
    const ChoosableRow& r = rows_[static_cast<std::size_t>(row)];
    if (r.passes.empty()) return 0.0;
    // Ends of neighbours are joined.
    return static_cast<double>(r.way.back()) + static_cast<double>(r.passes.size() - 1) * way_up_;
  }

  /// The needs between two rows that neither of them cuts, by rising bin.
  void open_between(std::int32_t last, std::int32_t next, std::vector<RowNeed>& open) const {
    open.clear();
    for (std::int32_t row = last + 1; row < next; ++row)
      for (const RowNeed& need : rows_[static_cast<std::size_t>(row)].needs)
        if (need.low > last && need.high < next) open.push_back(need);
  }

  /// What it costs to cut what two rows leave; its stretches, if asked for.
  double fill(std::int32_t last, std::int32_t next, std::vector<RowStretch>* stretches) const {
    std::vector<RowNeed> open;
    open_between(last, next, open);
    std::stable_sort(open.begin(), open.end(), before);
    return fill(open, stretches);
  }

  /// By rising bin. Costs over `most` are not added up.
  double fill(const std::vector<RowNeed>& open, std::vector<RowStretch>* stretches,
              double most = kNoWay) const {
    double sum = 0.0;
    for (std::size_t from = 0; from < open.size() && sum <= most;) {
      std::size_t to = from + 1;
      while (to < open.size() && open[to].bin - open[to - 1].bin <= bridge_) ++to;
      sum += fill_cluster(std::vector<RowNeed>(open.begin() + static_cast<std::ptrdiff_t>(from),
                                               open.begin() + static_cast<std::ptrdiff_t>(to)),
                          stretches, most - sum);
      from = to;
    }
    return sum;
  }

  /// Rows as far on as the first need that must be cut allows.
  double fill_cluster(std::vector<RowNeed> open, std::vector<RowStretch>* stretches, double most) const {
    double sum = 0.0;
    while (!open.empty() && sum <= most) {
      std::int32_t row = open.front().high;
      for (const RowNeed& need : open) row = std::min(row, need.high);
      const ChoosableRow& r = rows_[static_cast<std::size_t>(row)];
      std::size_t kept = 0;
      std::int32_t first = 0, last = -1;
      const auto put = [&] {
        sum += way_up_ + r.length(first, last);
        if (stretches != nullptr) stretches->push_back({row, first, last});
      };
      for (const RowNeed& need : open) {
        if (need.low > row) {
          open[kept++] = need;
          continue;
        }
        if (last >= first && need.bin - last > bridge_) put(), first = need.bin;
        if (last < first) first = need.bin;
        last = need.bin;
      }
      put();
      open.resize(kept);
    }
    return sum;
  }

  /// fills_[last + 1][i]: what it costs to fill between rows last and last + 1 + i.
  bool find_fills(const std::function<bool()>& go_on) {
    std::atomic<bool> stopped{false};
    fills_.resize(static_cast<std::size_t>(count_) + 1);
    tbb::parallel_for(std::int32_t{-1}, count_, [&](std::int32_t last) {
      if (stopped || (go_on && !go_on())) return void(stopped = true);
      std::vector<double>& costs = fills_[static_cast<std::size_t>(last + 1)];
      std::vector<std::vector<RowNeed>> pending(kFarthestRows);  // by the last row that could cut them
      std::vector<RowNeed> open;
      double dearest = last < 0 ? 0.0 : cost(last), filled = 0.0;
      for (std::int32_t next = last + 1; next <= std::min(count_, last + kFarthestRows); ++next) {
        if (next < count_) dearest = std::max(dearest, cost(next));
        const double most = next < count_ ? kTooDear * (dearest + way_up_) : kNoWay;
        // Only those that the row before could still cut are new.
        if (next > last + 1) {
          std::vector<RowNeed>& opened = pending[static_cast<std::size_t>(next - last - 2)];
          if (!opened.empty()) {
            std::sort(opened.begin(), opened.end(), before);
            const auto middle = static_cast<std::ptrdiff_t>(open.size());
            open.insert(open.end(), opened.begin(), opened.end());
            std::inplace_merge(open.begin(), open.begin() + middle, open.end(), before);
            filled = fill(open, nullptr, most);
          }
        }
        if (filled > most) break;
        costs.push_back(filled);
        if (next == count_) break;
        for (const RowNeed& need : rows_[static_cast<std::size_t>(next)].needs)
          if (need.low > last && need.high <= last + kFarthestRows)
            pending[static_cast<std::size_t>(need.high - last - 1)].push_back(need);
      }
    });
    return !stopped;
  }

  /// The rows that run on: those with which all costs the least.
  std::vector<std::int32_t> whole_rows() const {
    std::vector<double> least(static_cast<std::size_t>(count_) + 2, kNoWay);
    std::vector<std::int32_t> before(static_cast<std::size_t>(count_) + 2, -1);
    least[0] = 0.0;  // of row -1
    for (std::int32_t last = -1; last < count_; ++last) {
      const double so_far = least[static_cast<std::size_t>(last + 1)];
      const std::vector<double>& costs = fills_[static_cast<std::size_t>(last + 1)];
      for (std::size_t i = 0; i < costs.size(); ++i) {
        const std::int32_t next = last + 1 + static_cast<std::int32_t>(i);
        const double sum = so_far + costs[i] + (next < count_ ? cost(next) : 0.0);
        if (sum >= least[static_cast<std::size_t>(next + 1)]) continue;
        least[static_cast<std::size_t>(next + 1)] = sum;
        before[static_cast<std::size_t>(next + 1)] = last;
      }
    }
    std::vector<std::int32_t> rows;
    for (std::int32_t row = before[static_cast<std::size_t>(count_ + 1)]; row >= 0;
         row = before[static_cast<std::size_t>(row + 1)])
      rows.push_back(row);
    std::reverse(rows.begin(), rows.end());
    return rows;
  }

  /// Of the rows that run on, what is needed besides the others, and what lies between if that is shorter
  /// than the way up and down.
  std::vector<RowStretch> needed_of(const std::vector<std::int32_t>& whole) const {
    std::vector<RowStretch> kept;
    std::vector<RowNeed> open;  // not cut by a row before
    std::int32_t seen = -1;     // needs of rows up to this one have been taken up
    const auto drop = [&](const RowStretch& by) {
      std::erase_if(open, [&](const RowNeed& need) {
        return need.low <= by.row && by.row <= need.high && by.first <= need.bin && need.bin <= by.last;
      });
    };
    for (std::size_t i = 0; i < whole.size(); ++i) {
      const std::int32_t row = whole[i], next = i + 1 < whole.size() ? whole[i + 1] : count_;
      const ChoosableRow& r = rows_[static_cast<std::size_t>(row)];
      for (; seen + 1 < next; ++seen)
        for (const RowNeed& need : rows_[static_cast<std::size_t>(seen + 1)].needs) open.push_back(need);
      // What the next row cuts, too, waits for it: so does all that lies beyond.
      std::vector<std::int32_t> bins;
      for (const RowNeed& need : open)
        if (need.low <= row && row <= need.high && need.high < next) bins.push_back(need.bin);
      std::sort(bins.begin(), bins.end());
      const std::size_t before = kept.size();
      std::size_t at = 0;
      for (const ChoosableRow::Reach& pass : r.passes) {
        std::int32_t from = pass.first, to = pass.first - 1;
        bool any = false;
        while (at < bins.size() && bins[at] < pass.first) ++at;
        for (; at < bins.size() && bins[at] <= pass.last; ++at) {
          const std::int32_t bin = bins[at];
          if (any ? bin - to > bridge_ : bin - from > bridge_) {
            if (any) kept.push_back({row, from, to});
            from = bin;
          }
          to = bin, any = true;
        }
        if (!any) continue;
        if (pass.last - to <= bridge_) to = pass.last;
        kept.push_back({row, from, to});
      }
      for (std::size_t k = before; k < kept.size(); ++k) drop(kept[k]);
      std::erase_if(open, [&](const RowNeed& need) { return need.high < next; });
    }
    return kept;
  }

  const std::vector<ChoosableRow>& rows_;
  const std::int32_t count_;
  const double way_up_;
  const std::int32_t bridge_;  ///< bins
  std::vector<std::vector<double>> fills_;
};

}  // namespace

double ChoosableRow::length(std::int32_t from, std::int32_t to) const {
  const auto up_to = [&](std::int32_t bin) {
    const std::int32_t i = bin - first_bin;
    if (i < 0 || way.empty()) return 0.0;
    return static_cast<double>(way[std::min(static_cast<std::size_t>(i), way.size() - 1)]);
  };
  return up_to(to) - up_to(from - 1);
}

ChosenRows choose_rows(const std::vector<ChoosableRow>& rows, double way_up, double bin,
                       const std::function<bool()>& go_on) {
  return Choice(rows, way_up, bin).run(go_on);
}

}  // namespace tiltfeed::pathgen
