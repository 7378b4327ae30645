#pragma once
// Where on the cutter a piece of material is taken off, and what that costs. (CH1) to (CH4) in
// sim/engagement/README.md.

#include <array>
#include <cstdint>
#include <vector>

#include "sim/engagement/engaged_span.h"
#include "sim/removal/dexels.h"
#include "sim/solid/revolved.h"

namespace tiltfeed::sim {

/// Columns round the axis, counted from behind the feed: of 5 degrees.
inline constexpr int kColumns = 72;
/// Bins of height over the tip; the last has all that is higher.
inline constexpr int kHeights = 64;
/// (CH3) Exponent of the chip's thickness in Kienzle's law, 1 - m, m about that of steel and aluminium.
inline constexpr double kChipExponent = 0.75;

/// What is taken off within one column, in whole numbers, so that sums depend on no order.
struct ColumnSum {
  std::int64_t volume = 0;  ///< 1e-9 mm^3
  std::int64_t load = 0;    ///< 1e-9 mm of edge (CH3)
  std::int64_t turn = 0;    ///< likewise times its radius, over a whole turn, mm^2
  std::int64_t chip = 0;    ///< 1e-6 mm^3 (mm/min): volume by the chip's thickness
  bool empty() const { return volume == 0 && load == 0; }
  void add(const ColumnSum& more);
};
inline constexpr double kSumUnit = 1e-9, kChipUnit = 1e-6;

/// What a span takes off.
struct SpanSum {
  std::array<ColumnSum, kColumns> columns{};
  std::uint64_t heights = 0;  ///< a bit for each bin
};

/// Takes the material that one span removes.
class ChipGauge {
 public:
  /// `cell`: distance of the stock's lines, mm; `bin`: height of a bin, mm; `chunk`: longer pieces are looked
  /// at in parts of this, mm. Requires: the span has a way; `cutting` outlives this.
  ChipGauge(const Revolved& cutting, const EngagedSpan& span, double cell, double bin, double chunk);

  /// `axis`: of the line, 0 x, 1 y, 2 z. (CH1)
  void take(const Removed& piece, int axis, SpanSum& sum) const;

 private:
  struct Contact {
    double radius = 0.0, height = 0.0;
    Vec3 normal, out;
  };
  Contact contact(Point<Part> p) const;
  Contact stand(Point<Part> p, double share, double& depth) const;
  double depth(Point<Part> p, double share) const;
  void add(Point<Part> p, double length, int axis, SpanSum& sum) const;

  const Revolved& cutting_;
  const Pose from_;
  Vec3 axis_, way_, turn_;  ///< turn_: change of the axis over the span
  Vec3 ahead_, left_;       ///< unit, square to the axis
  double per_minute_;       ///< mm of way to mm/min at the feed asked for
  double cell_, bin_, chunk_;
};

}  // namespace tiltfeed::sim
