#pragma once
// What the cutter has to do along a path: how much of it is in material, where, and at which load. The stock
// goes on as the path leaves it.

#include <cstdint>
#include <functional>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "sim/engagement/engaged_span.h"
#include "sim/removal/stock.h"

namespace tiltfeed::sim {

/// What a span has to cut, at the feed that F asks for. With another feed `chip` grows as the feed does, and
/// both loads as its power kChipExponent.
struct SpanEngagement {
  double volume = 0.0;  ///< mm^3
  double angle = 0.0;   ///< round the axis, where the cutter is in material, degrees
  double depth = 0.0;   ///< along the axis, likewise, mm
  /// (CH3) Thickest chip of a column, on the mean of its height, as the feed that would make it in a full
  /// slot, mm/min.
  double chip = 0.0;
  /// (CH3) Largest load on one edge within a turn: mm of edge, each weighted by its chip's thickness.
  double edge_load = 0.0;
  double turn_load = 0.0;  ///< (CH4) mean over a turn of such loads times their radius, mm^2
};

struct Engagement {
  std::vector<EngagedSpan> spans;
  std::vector<SpanEngagement> loads;  ///< by span
};

struct EngagementOptions {
  double step = 0.0;  ///< as SpanOptions::step
  int threads = 1;    ///< the result is the same for any number
};

/// Called now and then with the share that is done; false cancels.
using EngagementProgress = std::function<bool(double share)>;

/// The step of a cutter in such a stock, mm.
double engagement_step(const pathgen::Cutter& cutter, double cell);

/// Cuts `stock` by the path. Properties: 1 The volumes' sum is what the stock loses, within what three
/// bundles differ by. 2 A full slot is 180 degrees, a shoulder of depth ae acos(1 - 2 ae / D). 3 `chip` of a
/// shoulder is 2 sqrt(q (1 - q)) of the feed, q = ae / D < 1/2. 4 The same numbers on any number of threads.
/// Requires: three bundles. Errors: kInput: nothing moves; kCancelled.
Result<Engagement> measure_engagement(const config::Job& job, const ExecutedPath& path, Stock& stock,
                                      const EngagementOptions& options, const EngagementProgress& progress);

}  // namespace tiltfeed::sim
