#include "sim/removal.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/removal_parts.h"
#include "sim/workers.h"

namespace tiltfeed::sim {
namespace {

// Moves whose bodies are held in memory at a time, and moves that a thread takes at a time: fixed, so that
// nothing depends on the number of threads.
constexpr std::size_t kBatch = 4096, kChunk = 256;
// Material left that is told apart: as deep as this many times what shall be left, or this much, mm.
constexpr double kReachOfStock = 3.0, kLeastReach = 0.5;

/// What the lines of one stripe of one bundle say of a batch.
struct StripeCut {
  std::vector<std::int64_t> removed;  ///< by move of the batch, units of length
  std::vector<MoveHit> hits;
};

class Remover {
 public:
  Remover(const Job& job, const ExecutedPath& path, Stock& stock, Probes& probes,
          const RemovalOptions& options)
      : job_(job),
        path_(path),
        stock_(stock),
        probes_(probes),
        options_(options),
        stand_(job, path, stock, probes, options),
        timeline_(path, job.plan.cutter.diameter, stock.cell) {}

  Result<Removal> run(const Progress& progress);

 private:
  void cut(std::size_t begin, std::size_t count, const std::vector<Swept>& chunks);

  const Job& job_;
  const ExecutedPath& path_;
  Stock& stock_;
  Probes& probes_;
  const RemovalOptions& options_;
  Stand stand_;
  Timeline timeline_;
  std::vector<MoveHit> hits_;
  std::array<double, 4> worst_{};
};

void Remover::cut(std::size_t begin, std::size_t count, const std::vector<Swept>& chunks) {
  std::vector<StripeCut> cuts(stock_.bundles.size() * Dexels::kStripes);
  // Less than this deep a shank or holder only rubs: what the lines and the straight ways can tell.
  const double rub = std::max(options_.tolerance, 0.5 * stock_.cell);
  in_parallel(cuts.size(), options_.threads, [&](std::size_t task) {
    Dexels& dexels = stock_.bundles[task / Dexels::kStripes];
    const int stripe = static_cast<int>(task) % Dexels::kStripes;
    StripeCut& out = cuts[task];
    out.removed.assign(count, 0);
    for (const Swept& chunk : chunks) {
      for (const std::uint32_t index : chunk.by_stripe[task]) {
        const SweptPiece& piece = chunk.pieces[index];
        const bool rapid = path_.moves[piece.move].rapid;
        const bool may_cut = !rapid && piece.body.part == ToolPart::kCutter;
        const Cut cut = dexels.cut(stripe, piece.body, !may_cut);
        out.removed[piece.move - begin] += cut.removed;
        if (may_cut || cut.deepest <= rub) continue;
        out.hits.push_back({rapid ? TroubleKind::kRapidStock : TroubleKind::kStockHit, piece.body.part,
                            piece.move, cut.deepest, kNoFacet, cut.place});
      }
    }
  });
  const double share = Dexels::kUnit * stock_.cell * stock_.cell / static_cast<double>(stock_.bundles.size());
  for (std::size_t i = 0; i < count; ++i) {
    std::int64_t sum = 0;
    for (const StripeCut& c : cuts) sum += c.removed[i];
    timeline_.add(begin + i, static_cast<double>(sum) * share);
  }
  for (const StripeCut& c : cuts) hits_.insert(hits_.end(), c.hits.begin(), c.hits.end());
}

Result<Removal> Remover::run(const Progress& progress) {
  Removal result;
  result.stock_volume = stock_.volume();
  if (const auto inside = stand_.starts_inside()) hits_.push_back(*inside);
  const std::size_t moves = path_.moves.size();
  for (std::size_t begin = 0; begin < moves; begin += kBatch) {
    if (progress && !progress("cut", static_cast<double>(begin) / static_cast<double>(moves)))
      return fail(Code::kCancelled, "verification was cancelled");
    const std::size_t count = std::min(kBatch, moves - begin);
    std::vector<Swept> chunks((count + kChunk - 1) / kChunk);
    in_parallel(chunks.size(), options_.threads, [&](std::size_t i) {
      stand_.sweep_moves(begin + i * kChunk, std::min(begin + count, begin + (i + 1) * kChunk), chunks[i]);
    });
    cut(begin, count, chunks);
    for (const Swept& chunk : chunks) {
      hits_.insert(hits_.end(), chunk.hits.begin(), chunk.hits.end());
      for (std::size_t k = 0; k < worst_.size(); ++k) worst_[k] = std::max(worst_[k], chunk.worst[k]);
      timeline_.add_lengths(chunk.feed_length, chunk.rapid_length);
    }
  }
  if (progress) progress("cut", 1.0);
  result.left_volume = stock_.volume();
  result.cell = stock_.cell;
  result.bytes = stock_.bytes() + probes_.bytes() + path_.moves.size() * sizeof(ExecutedMove);
  timeline_.finish(result);
  measure_excess(probes_, stand_.contact(), options_, path_, result, hits_);
  for (const MoveHit& hit : hits_) {
    double& worst = worst_[static_cast<int>(hit.kind)];
    worst = std::max(worst, hit.depth);
  }
  result.worst = worst_;
  result.troubles = gather(path_, std::move(hits_));
  return result;
}

}  // namespace

Result<Removal> remove_material(const Job& job, const ExecutedPath& path, Stock& stock, Probes& probes,
                                const RemovalOptions& options, const Progress& progress) {
  if (path.moves.empty()) return fail(Code::kInput, "verify: nothing moves");
  return Remover(job, path, stock, probes, options).run(progress);
}

double probe_reach(const Job& job) {
  const double left = job.plan.allowance + job.plan.radial_stock + job.plan.axial_stock;
  return std::max(kLeastReach, kReachOfStock * left);
}

}  // namespace tiltfeed::sim
