#include "sim/removal/removal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "sim/basics/workers.h"
#include "sim/removal/swept_moves.h"

namespace tiltfeed::sim {
namespace {

// Moves whose bodies are held in memory at a time, and moves that a thread takes at a time: fixed, so that
// nothing depends on the number of threads.
constexpr std::size_t kBatch = 32768, kChunk = 4096;
// Material left that is told apart: as deep as this many times what shall be left, or this much, mm.
constexpr double kReachOfStock = 3.0, kReachOfLimit = 1.25, kLeastReach = 0.5;
// Places where much is left that are told of each other, in cutter diameters.
constexpr double kLeftoverDiameters = 2.0;

/// What the lines of one stripe of one bundle say of a batch.
struct StripeCut {
  std::vector<std::int64_t> removed;  ///< by move of the batch, units of length
  std::vector<MoveHit> hits;
};

/// Some moves in a row, and what they sweep.
struct Batch {
  std::size_t begin = 0, count = 0;
  std::vector<Swept> chunks;
  std::vector<StripeCut> cuts;  ///< by stripe of a bundle

  /// The lines are cut by them.
  void forget_bodies() {
    for (Swept& chunk : chunks) chunk.pieces = {}, chunk.by_stripe = {};
  }
};

/// What moves removed together, as evenly as whole units go.
void share_out(std::int64_t removed, std::int64_t* by_move, std::int64_t moves) {
  const std::int64_t each = removed / moves;
  for (std::int64_t i = 0; i < moves; ++i) by_move[i] += each;
  by_move[0] += removed - each * moves;
}

class Remover {
 public:
  Remover(const config::Job& job, const ExecutedPath& path, Stock& stock, Probes& probes,
          const RemovalOptions& options, StockFilm* film)
      : job_(job),
        path_(path),
        stock_(stock),
        probes_(probes),
        options_(options),
        film_(film),
        stand_(job, path, stock, probes, options),
        timeline_(path, job.plan.cutter.diameter, stock.cell) {}

  Result<Removal> run(const pathgen::Progress& progress);

 private:
  Batch start(std::size_t begin) const;
  void sweep(Batch& batch, std::size_t chunk) const;
  void cut(Batch& batch, std::size_t task);
  void show(const Batch& batch);
  void take(const Batch& batch);
  void take_worst(const MoveHit& hit);

  const config::Job& job_;
  const ExecutedPath& path_;
  Stock& stock_;
  Probes& probes_;
  const RemovalOptions& options_;
  StockFilm* film_;
  Stand stand_;
  Timeline timeline_;
  std::vector<MoveHit> hits_;
  std::array<double, 4> worst_{};
  MoveHit gouge_;  ///< the deepest so far
  Haste haste_;
};

Batch Remover::start(std::size_t begin) const {
  Batch batch;
  batch.begin = begin, batch.count = std::min(kBatch, path_.moves.size() - begin);
  batch.chunks.resize((batch.count + kChunk - 1) / kChunk);
  return batch;
}

void Remover::sweep(Batch& batch, std::size_t chunk) const {
  const std::size_t begin = batch.begin + chunk * kChunk;
  stand_.sweep_moves(begin, std::min(batch.begin + batch.count, begin + kChunk), batch.chunks[chunk]);
}

/// The lines of a stripe by all that the batch sweeps. `task`: bundle and stripe.
void Remover::cut(Batch& batch, std::size_t task) {
  // Less than this deep a shank or holder only rubs: what the lines and the straight ways can tell.
  const double rub = std::max(options_.tolerance, 0.5 * stock_.cell);
  Dexels& dexels = stock_.bundles[task / Dexels::kStripes];
  const int stripe = static_cast<int>(task) % Dexels::kStripes;
  StripeCut& out = batch.cuts[task];
  out.removed.assign(batch.count, 0);
  for (const Swept& chunk : batch.chunks) {
    for (const std::uint32_t index : chunk.by_stripe[task]) {
      const SweptPiece& piece = chunk.pieces[index];
      const bool rapid = path_.moves[piece.first_move].rapid;
      const bool may_cut = !rapid && piece.body.part == ToolPart::kCutter;
      const Cut cut = dexels.cut(stripe, piece.body, !may_cut);
      share_out(cut.removed, out.removed.data() + (piece.first_move - batch.begin), piece.moves);
      if (may_cut || cut.deepest <= rub || !options_.stock_known) continue;
      out.hits.push_back({rapid ? TroubleKind::kRapidStock : TroubleKind::kStockHit, piece.body.part,
                          piece.first_move, cut.deepest, kNoFacet, cut.place});
    }
  }
}

/// The film goes on by all that the batch sweeps.
void Remover::show(const Batch& batch) {
  for (const Swept& chunk : batch.chunks)
    for (const SweptPiece& piece : chunk.pieces) film_->take(piece.body, path_.moves[piece.first_move].start);
}

/// What a batch found that is swept and cut.
void Remover::take(const Batch& batch) {
  const double share = Dexels::kUnit * stock_.cell * stock_.cell / static_cast<double>(stock_.bundles.size());
  for (std::size_t i = 0; i < batch.count; ++i) {
    std::int64_t sum = 0;
    for (const StripeCut& c : batch.cuts) sum += c.removed[i];
    timeline_.add(batch.begin + i, static_cast<double>(sum) * share,
                  batch.chunks[i / kChunk].ways[i % kChunk]);
  }
  for (const StripeCut& c : batch.cuts) hits_.insert(hits_.end(), c.hits.begin(), c.hits.end());
  for (const Swept& chunk : batch.chunks) {
    hits_.insert(hits_.end(), chunk.hits.begin(), chunk.hits.end());
    for (const MoveHit& worst : chunk.worst) take_worst(worst);
    haste_.take(chunk.haste);
  }
}

void Remover::take_worst(const MoveHit& hit) {
  double& worst = worst_[static_cast<int>(hit.kind)];
  worst = std::max(worst, hit.depth);
  if (hit.kind == TroubleKind::kGouge && hit.depth > gouge_.depth) gouge_ = hit;
}

Result<Removal> Remover::run(const pathgen::Progress& progress) {
  Removal result;
  result.stock_volume = stock_.volume();
  if (const auto inside = stand_.starts_inside()) hits_.push_back(*inside);
  const std::size_t moves = path_.moves.size();
  // While the lines are cut by one batch, the next one is swept and met with the part, and what the one
  // before found is taken: none asks another. The longest tasks come first, so that the threads end together.
  std::optional<Batch> swept, done;
  for (std::size_t begin = 0; begin < moves || swept || done; begin += kBatch) {
    if (progress &&
        !progress("cut", static_cast<double>(std::min(begin, moves)) / static_cast<double>(moves)))
      return fail(Code::kCancelled, "verification was cancelled");
    std::optional<Batch> next;
    if (begin < moves) next = start(begin);
    if (swept) swept->cuts.resize(stock_.bundles.size() * Dexels::kStripes);
    const std::size_t sweeps = next ? next->chunks.size() : 0, shows = film_ && swept ? 1 : 0,
                      takes = done ? 1 : 0, cuts = swept ? swept->cuts.size() : 0;
    in_parallel(sweeps + shows + takes + cuts, options_.threads, [&](std::size_t i) {
      if (i < sweeps)
        sweep(*next, i);
      else if (i < sweeps + shows)
        show(*swept);
      else if (i < sweeps + shows + takes)
        take(*done);
      else
        cut(*swept, i - sweeps - shows - takes);
    });
    if (swept) swept->forget_bodies();
    done = std::exchange(swept, std::move(next));
  }
  if (progress) progress("cut", 1.0);
  if (film_) film_->finish();
  result.left_volume = stock_.volume();
  result.cell = stock_.cell;
  result.bytes = stock_.bytes() + probes_.bytes() + path_.moves.size() * sizeof(ExecutedMove);
  timeline_.finish(result);
  measure_excess(probes_, stand_.contact(), options_, path_, result, hits_);
  if (options_.rest_limit >= 0.0)
    result.rest = find_rest(job_, path_, probes_, options_.rest_limit, options_.threads);
  for (const MoveHit& hit : hits_) take_worst(hit);
  result.worst = worst_;
  if (gouge_.depth > 0.0) result.gouge = gather(path_, {gouge_}).front();
  result.haste = haste_;
  result.haste_block = path_.moves[haste_.move].block, result.haste_line = path_.moves[haste_.move].line;
  result.haste_time = path_.moves[haste_.move].start;
  result.most_left = most_left(probes_, path_, result, kLeftoverDiameters * job_.plan.cutter.diameter);
  result.troubles = gather(path_, std::move(hits_));
  return result;
}

}  // namespace

Result<Removal> remove_material(const config::Job& job, const ExecutedPath& path, Stock& stock,
                                Probes& probes, const RemovalOptions& options,
                                const pathgen::Progress& progress, StockFilm* film) {
  if (path.moves.empty()) return fail(Code::kInput, "verify: nothing moves");
  return Remover(job, path, stock, probes, options, film).run(progress);
}

double probe_reach(const config::Job& job, double rest_limit) {
  const double left = job.plan.allowance + job.plan.radial_stock + job.plan.axial_stock;
  return std::max({kLeastReach, kReachOfStock * left, kReachOfLimit * rest_limit});
}

}  // namespace tiltfeed::sim
