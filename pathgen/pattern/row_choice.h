#pragma once
// Which of many rows side by side are cut, and over which stretches, so that every place is cut as it must be
// in the least time, about. (R5) in pathgen/pattern/README.md.

#include <cstdint>
#include <functional>
#include <vector>

namespace tiltfeed::pathgen {

/// A place beside a row that any of the rows low..high cuts well enough: the row itself is among them.
struct RowNeed {
  std::int32_t bin = 0;  ///< along the rows
  std::int32_t low = 0, high = 0;
};

/// A row that may be cut.
struct ChoosableRow {
  std::vector<RowNeed> needs;  ///< of the places at this row, by rising bin
  /// Passes from bin to bin, both included, in rising order.
  struct Reach {
    std::int32_t first = 0, last = 0;
  };
  std::vector<Reach> passes;
  /// mm cut up to the end of bin first_bin + i.
  std::vector<float> way;
  std::int32_t first_bin = 0;

  /// mm cut from the start of one bin to the end of another; less where the row does not reach so far.
  double length(std::int32_t from, std::int32_t to) const;
};

/// A stretch of a row, both bins included.
struct RowStretch {
  std::int32_t row = 0, first = 0, last = 0;
  bool operator==(const RowStretch&) const = default;
};

struct ChosenRows {
  std::vector<RowStretch> main;  ///< of rows that run on; by rising row, then bin
  std::vector<RowStretch> fill;  ///< between them, where they are too far apart; likewise
};

/// Requires: every need of row k has low <= k <= high. `way_up`: a stretch more costs as much as cutting this
/// far, mm, above 0; `bin`: a bin's width, mm. `go_on` is asked about once a row, by several threads; empty:
/// always. Properties: 1 Each need's bin is in a stretch of one of its rows. 2 The same for the same rows,
/// whatever the threads. 3 Nothing where `go_on` returns false.
ChosenRows choose_rows(const std::vector<ChoosableRow>& rows, double way_up, double bin,
                       const std::function<bool()>& go_on = {});

/// No two rows that run on are further apart than so many.
inline constexpr std::int32_t kFarthestRows = 64;

}  // namespace tiltfeed::pathgen
