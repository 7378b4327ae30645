#pragma once
// The passes of one line as a floor: how low they come between two places of it, and what of them is traced
// anew. (G3) in pathgen/pattern/README.md.

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "pathgen/envelope/pass.h"
#include "pathgen/surface/candidates.h"
#include "pathgen/surface/flat_bins.h"

namespace tiltfeed::pathgen {

/// Where there is no pass the floor is as low as may be.
class PassFloor {
 public:
  /// `slack`: the surface may lie so far under the straight moves, mm. The floor is nowhere lower than
  /// `least`.
  PassFloor(std::span<const Pass> passes, const FlatLine& line, double slack, double least);

  /// No place of the surface between these run coordinates lies lower (z').
  double lowest(double from, double to) const;

  /// Calls visit(from, to) for each stretch between these run coordinates over which the floor may be lower
  /// than `top`; the stretches are whole moves, or what is left of them at the ends.
  template <class Visit>
  void each_below(double from, double to, double top, Visit visit) const {
    const auto [first, last] = moves(from, to);
    for (std::size_t i = first; i < last;) {
      if (!(low_[i] < top)) {
        ++i;
        continue;
      }
      const std::size_t begin = i;
      while (i < last && low_[i] < top) ++i;
      visit(begin == first ? from : run_[begin], i == last ? to : run_[i]);
    }
  }

  /// Lowers the floor to under `passes`, which were traced anew, where they lie lower: by the slack, the next
  /// time by twice as much, and so on, so that few times are enough. False where they lie nowhere lower.
  bool open_over(std::span<const Pass> passes, const FlatLine& line);

  /// What the candidates cover, out to the points of the passes round it, so that moves are replaced as a
  /// whole; `length`: of the line. Apart from each other, rising.
  std::vector<std::pair<double, double>> stretches(std::span<const Candidate> candidates,
                                                   double length) const;

 private:
  void sum_up();
  /// The moves, and gaps, that meet the stretch: [first, last).
  std::pair<std::size_t, std::size_t> moves(double from, double to) const;

  double least_;
  double spare_;                             ///< how far under what was traced anew the floor goes next
  std::vector<double> run_;                  ///< of the points; infinite before the first and after the last
  std::vector<double> low_;                  ///< of the move from there to the next, less the slack
  std::vector<std::vector<double>> lowest_;  ///< [k][i]: of 2^k moves from i on
};

/// Passes of one line of which stretches are replaced, one after another.
class PassSplice {
 public:
  PassSplice(std::span<const Pass> passes, const FlatLine& line) : passes_(passes), line_(line) {}
  /// Requires: `from` not before the last `to`; both at points of the passes or beside them.
  void replace(double from, double to, std::vector<Pass> by);
  std::vector<Pass> finish();

 private:
  void copy_before(double run);

  std::span<const Pass> passes_;
  const FlatLine& line_;
  std::size_t pass_ = 0, point_ = 0;  ///< the next to be copied
  bool open_ = false;                 ///< the last pass goes on with it
  std::vector<Pass> result_;
};

}  // namespace tiltfeed::pathgen
