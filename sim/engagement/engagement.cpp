#include "sim/engagement/engagement.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <utility>

#include "sim/basics/workers.h"
#include "sim/engagement/chip_gauge.h"
#include "sim/removal/occupied.h"
#include "sim/removal/tool_sweep.h"

namespace tiltfeed::sim {
namespace {

// Moves whose bodies are held in memory at a time: fixed, so that nothing depends on the number of threads.
constexpr std::size_t kBatchMoves = 4096;
// A span's way in diameters and in cells: short beside the tool, long enough for the lines to see it.
constexpr double kStepDiameters = 0.1, kStepCells = 1.0;
// What a span's path may be off its straight way, in cells.
constexpr double kStrayCells = 0.05;
// A column counts as engaged, and its chip as one, from this share of the span's volume on.
constexpr double kLeastShare = 2e-3, kLeastChipShare = 0.01;

struct SpanBatch {
  std::vector<EngagedSpan> spans;
  std::vector<SweptBody> bodies;
  std::vector<std::uint32_t> span_of;  ///< by body
  /// Bodies that meet stripe s of bundle b: by b * Dexels::kStripes + s.
  std::vector<std::vector<std::uint32_t>> by_stripe;
};

/// What the lines of one stripe say of one span, without its empty columns.
struct StripeColumn {
  std::uint32_t span = 0;
  std::int32_t column = 0;  ///< kColumns: the heights, in `sum.volume`
  ColumnSum sum;
};

class Measuring {
 public:
  Measuring(const config::Job& job, const ExecutedPath& path, Stock& stock, const EngagementOptions& options)
      : path_(path),
        stock_(stock),
        options_(options),
        chain_(job.machine.model, job.setup),
        solid_(job.plan.cutter),
        sweep_(job.plan.cutter),
        occupied_(stock, sweep_.piece_reach() + 2.0 * kRapidReach * options.step),
        span_options_{options.step, kStrayCells * stock.cell, job.plan.cutter.cutting_end()},
        bin_(job.plan.cutter.cutting_end() / kHeights) {}

  Result<Engagement> run(const EngagementProgress& progress);

 private:
  SpanBatch sweep(std::size_t begin) const;
  void cut(const SpanBatch& batch, std::size_t task, std::vector<StripeColumn>& out) const;
  void take(SpanBatch& batch, const std::vector<std::vector<StripeColumn>>& found);
  SpanEngagement load_of(const SpanSum& sum) const;

  static constexpr double kRapidReach = 8.0;  // in steps: the longest span's way
  const ExecutedPath& path_;
  Stock& stock_;
  const EngagementOptions& options_;
  FrameChain chain_;
  ToolSolid solid_;
  ToolSweep sweep_;
  Occupied occupied_;
  SpanOptions span_options_;
  double bin_;
  Engagement result_;
};

SpanBatch Measuring::sweep(std::size_t begin) const {
  SpanBatch batch;
  batch.spans =
      engaged_spans(path_, chain_, span_options_, begin, std::min(begin + kBatchMoves, path_.moves.size()));
  batch.by_stripe.resize(stock_.bundles.size() * Dexels::kStripes);
  const auto clear = [&](Point<Part> p) { return occupied_.clear(p); };
  for (std::size_t i = 0; i < batch.spans.size(); ++i) {
    const EngagedSpan& span = batch.spans[i];
    const std::size_t before = batch.bodies.size();
    sweep_.cutter_bodies(span.from, span.to, clear, batch.bodies);
    for (std::size_t k = before; k < batch.bodies.size(); ++k) {
      batch.span_of.push_back(static_cast<std::uint32_t>(i));
      for (std::size_t b = 0; b < stock_.bundles.size(); ++b) {
        const auto [first, last] = stock_.bundles[b].stripes(batch.bodies[k]);
        for (int s = first; s < last; ++s)
          batch.by_stripe[b * Dexels::kStripes + s].push_back(static_cast<std::uint32_t>(k));
      }
    }
  }
  return batch;
}

/// The lines of a stripe by all spans, in their order. `task`: bundle and stripe.
void Measuring::cut(const SpanBatch& batch, std::size_t task, std::vector<StripeColumn>& out) const {
  Dexels& dexels = stock_.bundles[task / Dexels::kStripes];
  const int stripe = static_cast<int>(task) % Dexels::kStripes;
  const std::vector<std::uint32_t>& mine = batch.by_stripe[task];
  std::vector<Removed> gone;
  for (std::size_t at = 0; at < mine.size();) {
    const std::uint32_t index = batch.span_of[mine[at]];
    const EngagedSpan& span = batch.spans[index];
    gone.clear();
    for (; at < mine.size() && batch.span_of[mine[at]] == index; ++at)
      dexels.cut(stripe, batch.bodies[mine[at]], false, span.rapid ? nullptr : &gone);
    if (gone.empty()) continue;
    const ChipGauge gauge(solid_.cutting(), span, stock_.cell, bin_, std::min(options_.step, stock_.cell));
    SpanSum sum;
    for (const Removed& piece : gone) gauge.take(piece, dexels.axis(), sum);
    for (int c = 0; c < kColumns; ++c)
      if (!sum.columns[c].empty()) out.push_back({index, c, sum.columns[c]});
    out.push_back({index, kColumns, {std::bit_cast<std::int64_t>(sum.heights)}});
  }
}

/// (CH3), (CH4)
SpanEngagement Measuring::load_of(const SpanSum& sum) const {
  SpanEngagement load;
  std::int64_t volume = 0, turn = 0, edge = 0;
  for (const ColumnSum& column : sum.columns)
    volume += column.volume, turn += column.turn, edge = std::max(edge, column.load);
  int engaged = 0;
  for (const ColumnSum& column : sum.columns) {
    const double share =
        static_cast<double>(column.volume) / static_cast<double>(std::max<std::int64_t>(volume, 1));
    engaged += share >= kLeastShare;
    if (share >= kLeastChipShare)
      load.chip = std::max(load.chip, static_cast<double>(column.chip) * kChipUnit /
                                          (static_cast<double>(column.volume) * kSumUnit));
  }
  load.volume = static_cast<double>(volume) * kSumUnit;
  load.angle = 360.0 * engaged / kColumns;
  if (sum.heights != 0)
    load.depth = bin_ * (kHeights - std::countl_zero(sum.heights) - std::countr_zero(sum.heights));
  load.edge_load = static_cast<double>(edge) * kSumUnit;
  load.turn_load = static_cast<double>(turn) * kSumUnit;
  return load;
}

void Measuring::take(SpanBatch& batch, const std::vector<std::vector<StripeColumn>>& found) {
  std::vector<SpanSum> sums(batch.spans.size());
  for (const auto& stripe : found)
    for (const StripeColumn& one : stripe) {
      if (one.column == kColumns)
        sums[one.span].heights |= std::bit_cast<std::uint64_t>(one.sum.volume);
      else
        sums[one.span].columns[one.column].add(one.sum);
    }
  for (const SpanSum& sum : sums) result_.loads.push_back(load_of(sum));
  result_.spans.insert(result_.spans.end(), batch.spans.begin(), batch.spans.end());
}

Result<Engagement> Measuring::run(const EngagementProgress& progress) {
  const std::size_t moves = path_.moves.size();
  std::optional<SpanBatch> next = sweep(0);
  for (std::size_t begin = 0; begin < moves; begin += kBatchMoves) {
    if (progress && !progress(static_cast<double>(begin) / static_cast<double>(moves)))
      return fail(Code::kCancelled, "the engagement was not measured to its end: cancelled");
    SpanBatch batch = std::move(*next);
    std::vector<std::vector<StripeColumn>> found(batch.by_stripe.size());
    const bool more = begin + kBatchMoves < moves;
    // While the lines are cut by one batch the next one is swept: it asks them for bounds only.
    in_parallel(found.size() + (more ? 1 : 0), options_.threads, [&](std::size_t i) {
      if (more && i == 0)
        next = sweep(begin + kBatchMoves);
      else
        cut(batch, i - (more ? 1 : 0), found[i - (more ? 1 : 0)]);
    });
    take(batch, found);
  }
  if (progress) progress(1.0);
  return std::move(result_);
}

}  // namespace

double engagement_step(const pathgen::Cutter& cutter, double cell) {
  return std::max(kStepDiameters * cutter.diameter, kStepCells * cell);
}

Result<Engagement> measure_engagement(const config::Job& job, const ExecutedPath& path, Stock& stock,
                                      const EngagementOptions& options, const EngagementProgress& progress) {
  if (path.moves.empty()) return fail(Code::kInput, "engagement: nothing moves");
  return Measuring(job, path, stock, options).run(progress);
}

}  // namespace tiltfeed::sim
