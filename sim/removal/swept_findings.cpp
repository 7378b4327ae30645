#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/basics/workers.h"
#include "sim/removal/swept_moves.h"

namespace tiltfeed::sim {
namespace {

constexpr std::size_t kBins = 600;
// A stretch of feed moves is called air when it removes nothing over this many cells, or diameters.
constexpr double kAirCells = 4.0, kAirDiameters = 1.0;
// Moves between two wrong ones that belong to one run.
constexpr std::uint32_t kRunGap = 50;
// Runs of each kind that are kept.
constexpr std::size_t kMostTroubles = 50;
// Material left is counted in steps of this, mm, over all that the tool came near.
constexpr double kExcessStep = 2e-4;
constexpr std::size_t kExcessTasks = 64;
// Places where much is left that are told.
constexpr std::size_t kMostLeftovers = 5;

std::array<double, 5> words(const Joints& j) { return {j.x, j.y, j.z, j.a, j.c}; }

}  // namespace

Timeline::Timeline(const ExecutedPath& path, double diameter, double cell)
    : path_(path),
      begin_(path.moves.front().start),
      width_(std::max(1e-9, (path.moves.back().end - path.moves.front().start) / kBins)),
      window_(std::max(kAirCells * cell, kAirDiameters * diameter)),
      bins_(kBins) {
  for (TimeBin& bin : bins_) bin.low.fill(kInfinity), bin.high.fill(-kInfinity);
  travel_low_ = travel_high_ = words(path.start);
}

std::size_t Timeline::bin(double time) const {
  return static_cast<std::size_t>(std::clamp((time - begin_) / width_, 0.0, kBins - 1.0));
}

void Timeline::end_stretch() {
  if (stretch_seconds_ > 0.0 && stretch_removed_ <= 0.0) {
    air_seconds_ += stretch_seconds_;
    for (std::size_t m = stretch_begin_; m < stretch_end_; ++m) {
      const ExecutedMove& move = path_.moves[m];
      bins_[bin(0.5 * (move.start + move.end))].air += move.end - move.start;
    }
  }
  stretch_removed_ = stretch_way_ = stretch_seconds_ = 0.0;
}

void Timeline::move_axes(std::size_t m) {
  const ExecutedMove& move = path_.moves[m];
  const auto from = words(path_.from(m)), to = words(move.to);
  const double seconds = move.end - move.start;
  for (std::size_t b = bin(move.start); b <= bin(move.end); ++b) {
    for (std::size_t k = 0; k < from.size(); ++k) {
      const auto at = [&](double time) {
        const double f = seconds > 0.0 ? std::clamp((time - move.start) / seconds, 0.0, 1.0) : 1.0;
        return from[k] + (to[k] - from[k]) * f;
      };
      const double a = at(begin_ + static_cast<double>(b) * width_),
                   z = at(begin_ + static_cast<double>(b + 1) * width_);
      bins_[b].low[k] = std::min({bins_[b].low[k], a, z}),
      bins_[b].high[k] = std::max({bins_[b].high[k], a, z});
      if (seconds > 0.0)
        bins_[b].speed[k] = std::max(bins_[b].speed[k], std::abs(to[k] - from[k]) / seconds * 60.0);
    }
  }
  for (std::size_t k = 0; k < to.size(); ++k)
    travel_low_[k] = std::min(travel_low_[k], to[k]), travel_high_[k] = std::max(travel_high_[k], to[k]);
}

void Timeline::add(std::size_t m, double removed, double way) {
  const ExecutedMove& move = path_.moves[m];
  const double seconds = move.end - move.start;
  TimeBin& at = bins_[bin(0.5 * (move.start + move.end))];
  at.removed += removed;
  (move.rapid ? at.rapid : at.cutting) += seconds;
  (move.rapid ? rapid_seconds_ : feed_seconds_) += seconds;
  (move.rapid ? rapid_length_ : feed_length_) += way;
  move_axes(m);
  if (move.rapid) {
    end_stretch();
    return;
  }
  if (stretch_seconds_ == 0.0) stretch_begin_ = m;
  stretch_removed_ += removed, stretch_seconds_ += seconds, stretch_end_ = m + 1;
  stretch_way_ += way;
  if (stretch_way_ >= window_) end_stretch();
}

void Timeline::finish(Removal& result) {
  end_stretch();
  result.blocks = path_.blocks();
  result.seconds = path_.seconds;
  result.feed_seconds = feed_seconds_, result.rapid_seconds = rapid_seconds_,
  result.air_seconds = air_seconds_;
  result.feed_length = feed_length_, result.rapid_length = rapid_length_;
  result.bin_seconds = width_;
  result.bins = std::move(bins_);
  result.travel_low = travel_low_, result.travel_high = travel_high_;
}

namespace {

/// Leaves out probes at moves whose exact depth is known, and takes the others as deep as the tool truly
/// comes over them: what is swept while the axis turns may be an eighth of a cell off.
void add_unknown(const std::vector<MoveHit>& probed, const Contact& contact, double tolerance,
                 std::vector<MoveHit>& hits) {
  std::vector<std::uint32_t> known;
  for (const MoveHit& hit : hits)
    if (hit.kind == TroubleKind::kGouge || hit.kind == TroubleKind::kRapidPart) known.push_back(hit.move);
  std::sort(known.begin(), known.end());
  for (const MoveHit& hit : probed) {
    const auto next = std::lower_bound(known.begin(), known.end(), hit.move - std::min(hit.move, kRunGap));
    if (next != known.end() && *next <= hit.move + kRunGap) continue;
    MoveHit exact = hit;
    exact.depth = contact.depth(hit.move, hit.place);
    if (exact.depth > tolerance) hits.push_back(exact);
  }
}

}  // namespace

void measure_excess(const Probes& probes, const Contact& contact, const RemovalOptions& options,
                    const ExecutedPath& path, Removal& result, std::vector<MoveHit>& hits) {
  struct Share {
    std::vector<double> area;
    std::vector<MoveHit> hits;
    std::uint64_t touched = 0;
    double all = 0.0, near = 0.0, deepest = 0.0;
  };
  const Patches& patches = probes.patches();
  const std::size_t count = patches.mesh.facets.size();
  const double low = -probes.reach();
  const auto steps = static_cast<std::size_t>(2.0 * probes.reach() / kExcessStep) + 1;
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  result.patch_low.assign(count, kNone), result.patch_high = result.patch_mean = result.patch_low;
  std::vector<Share> parts(kExcessTasks);
  in_parallel(kExcessTasks, options.threads, [&](std::size_t task) {
    Share& out = parts[task];
    out.area.assign(steps, 0.0);
    for (std::size_t p = count * task / kExcessTasks; p < count * (task + 1) / kExcessTasks; ++p) {
      const auto patch = static_cast<std::uint32_t>(p);
      const double area = probes.patch_area(patch);
      const double each = area / static_cast<double>(patches.first[p + 1] - patches.first[p]);
      out.all += area;
      double sum = 0.0, least = kInfinity, most = -kInfinity;
      std::uint64_t touched = 0;
      MoveHit deepest{TroubleKind::kGouge, ToolPart::kCutter,      0,
                      options.tolerance,   patches.mesh.source[p], {}};
      for (std::uint64_t i = patches.first[p]; i < patches.first[p + 1]; ++i) {
        const Probes::Value v = probes.value(i);
        if (v.move == Probes::kNever) continue;
        ++touched, sum += v.left, least = std::min(least, v.left), most = std::max(most, v.left);
        out.area[static_cast<std::size_t>(
            std::clamp((v.left - low) / kExcessStep, 0.0, static_cast<double>(steps) - 1.0))] += each;
        if (-v.left <= deepest.depth) continue;
        deepest.depth = -v.left, deepest.move = v.move, deepest.place = probes.place(patch, i);
        if (path.moves[v.move].rapid) deepest.kind = TroubleKind::kRapidPart;
      }
      if (touched == 0) continue;
      out.touched += touched, out.near += each * static_cast<double>(touched);
      out.deepest = std::min(out.deepest, least);
      result.patch_low[p] = static_cast<float>(least), result.patch_high[p] = static_cast<float>(most);
      result.patch_mean[p] = static_cast<float>(sum / static_cast<double>(touched));
      if (deepest.depth > options.tolerance) out.hits.push_back(deepest);
    }
  });
  std::vector<double> area(steps, 0.0);
  std::vector<MoveHit> probed;
  for (const Share& part : parts) {
    for (std::size_t i = 0; i < steps; ++i) area[i] += part.area[i];
    result.touched += part.touched, result.area += part.all, result.touched_area += part.near;
    result.deepest = std::min(result.deepest, part.deepest);
    probed.insert(probed.end(), part.hits.begin(), part.hits.end());
  }
  add_unknown(probed, contact, options.tolerance, hits);
  result.probes = probes.count(), result.reach = probes.reach(), result.probe_spacing = probes.spacing();
  for (std::size_t k = 0; k < kPercentiles.size(); ++k) {
    double below = 0.0;
    std::size_t i = 0;
    while (i + 1 < steps && below + area[i] < kPercentiles[k] / 100.0 * result.touched_area)
      below += area[i++];
    result.excess[k] = low + (static_cast<double>(i) + 0.5) * kExcessStep;
  }
}

namespace {

/// The probe of a patch with the most left.
Leftover highest_of(const Probes& probes, const ExecutedPath& path, std::uint32_t patch) {
  const Patches& patches = probes.patches();
  Leftover found;
  found.left = -kInfinity, found.facet = patches.mesh.source[patch];
  for (std::uint64_t i = patches.first[patch]; i < patches.first[patch + 1]; ++i) {
    const Probes::Value v = probes.value(i);
    if (v.move == Probes::kNever || v.left <= found.left) continue;
    const ExecutedMove& move = path.moves[v.move];
    found.left = v.left, found.block = move.block, found.line = move.line, found.time = move.start;
    found.place = probes.place(patch, i);
  }
  return found;
}

}  // namespace

std::vector<Leftover> most_left(const Probes& probes, const ExecutedPath& path, const Removal& result,
                                double apart) {
  std::vector<Leftover> places;
  const std::vector<Point<Part>>& middle = probes.patches().middle;
  const auto told = [&](Point<Part> p) {
    return std::any_of(places.begin(), places.end(),
                       [&](const Leftover& other) { return distance(other.place, p) < apart; });
  };
  while (places.size() < kMostLeftovers) {
    float most = 0.0F;
    std::size_t at = middle.size();
    for (std::size_t p = 0; p < middle.size(); ++p)  // never touched: NaN, not above anything
      if (result.patch_high[p] > most && !told(middle[p])) most = result.patch_high[p], at = p;
    if (at == middle.size()) break;
    places.push_back(highest_of(probes, path, static_cast<std::uint32_t>(at)));
  }
  return places;
}

std::vector<Trouble> gather(const ExecutedPath& path, std::vector<MoveHit> hits) {
  std::stable_sort(hits.begin(), hits.end(), [](const MoveHit& a, const MoveHit& b) {
    if (a.kind != b.kind) return a.kind < b.kind;
    if (a.tool != b.tool) return a.tool < b.tool;
    return a.move < b.move;
  });
  std::vector<Trouble> troubles;
  const MoveHit* before = nullptr;
  for (const MoveHit& hit : hits) {
    const bool same = before != nullptr && before->kind == hit.kind && before->tool == hit.tool &&
                      hit.move - before->move <= kRunGap;
    before = &hit;
    const ExecutedMove& move = path.moves[hit.move];
    if (!same) troubles.push_back({hit.kind, hit.tool, 0.0, 0, 0, kNoFacet, {}, 0.0, hit.move, hit.move});
    Trouble& run = troubles.back();
    run.last_move = hit.move;
    if (hit.depth <= run.depth) continue;
    run.depth = hit.depth, run.block = move.block, run.line = move.line, run.facet = hit.facet,
    run.place = hit.place;
    run.time = move.start;
  }
  std::stable_sort(troubles.begin(), troubles.end(), [](const Trouble& a, const Trouble& b) {
    return a.kind != b.kind ? a.kind < b.kind : a.depth > b.depth;
  });
  std::array<std::size_t, 4> kept{};
  std::erase_if(troubles, [&](const Trouble& t) { return ++kept[static_cast<int>(t.kind)] > kMostTroubles; });
  return troubles;
}

}  // namespace tiltfeed::sim
