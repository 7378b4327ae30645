#include "pathgen/surface/flat_index.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>

namespace tiltfeed::pathgen {

namespace {

/// Dropping on so many patches takes about as long as putting one in a tree.
constexpr std::size_t kDropsPerHull = 16;

/// Hulls that one task takes at least: some hundred microseconds of work.
constexpr std::size_t kHullsPerTask = 8192;

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double v) { low = std::min(low, v), high = std::max(high, v); }
  void add(const Range& r) { low = std::min(low, r.low), high = std::max(high, r.high); }
};

}  // namespace

bool FlatIndex::has_siblings(std::uint32_t hull) const {
  const auto& hulls = hulls_.hulls;
  return (hull > 0 && hulls[hull - 1].patch == hulls[hull].patch) ||
         (hull + 1 < hulls.size() && hulls[hull + 1].patch == hulls[hull].patch);
}

namespace {

struct Ranges {
  Range x, y;
};
/// Of all boxes, which it writes.
Ranges ranges_of(const FlatHulls& hulls, FreshVector<LooseBox>& boxes) {
  boxes.resize(hulls.hulls.size());
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, hulls.hulls.size(), kHullsPerTask), Ranges{},
      [&](const auto& range, Ranges r) {
        for (std::size_t c = range.begin(); c < range.end(); ++c) {
          const FlatBox box = box_of(hulls, hulls.hulls[c]);
          r.x.add({box.low_x, box.high_x}), r.y.add({box.low_y, box.high_y});
          boxes[c] = loosened(box);
        }
        return r;
      },
      [](Ranges a, const Ranges& b) {
        a.x.add(b.x), a.y.add(b.y);
        return a;
      });
}

/// The rectangle of all boxes, and the periods of what wraps there.
struct Extent {
  FlatBounds bounds;
  double period_x = 0.0, period_y = 0.0;
};
Extent extent_of(Ranges r, const Deformation& deformation) {
  const auto settle = [](Range& range, double period) {
    if (period <= 0.0 || (range.low >= -period / 2.0 && range.high <= period / 2.0)) return 0.0;
    range.low = -period / 2.0, range.high = period / 2.0;
    return period;
  };
  Extent extent;
  extent.period_x = settle(r.x, deformation.period_x());
  extent.period_y = settle(r.y, deformation.period_y());
  if (deformation.frame().mode == AxisMode::kPoint) {  // beyond a pole lie the columns of the other side
    const double pole = kPi / 2.0 * deformation.scale_y();
    r.y.low = std::max(r.y.low, -pole), r.y.high = std::min(r.y.high, pole);
  }
  extent.bounds = {r.x.low, r.x.high, r.y.low, r.y.high};
  return extent;
}

}  // namespace

struct FlatIndex::Drops {
  std::once_flag once;
  std::vector<DropBvh> pieces;
  std::atomic<std::size_t> dropped = 0;
};

std::span<const DropBvh> FlatIndex::drops(const ClSurface& surface) const {
  std::call_once(drops_->once, [&] {
    // A thread that waits for its part of a tree must not take up work that asks for the trees.
    tbb::this_task_arena::isolate([&] {
      const auto add = [&](const FlatHulls& hulls, double period_x, double period_y) {
        const auto begin = hulls.hulls.begin(), end = hulls.hulls.end();
        for (auto first = begin; first != end;) {
          const ToolPiece* piece = &surface.piece(first->patch);
          const auto last = std::partition_point(
              first, end, [&](const FlatHull& hull) { return &surface.piece(hull.patch) == piece; });
          drops_->pieces.emplace_back(surface, hulls, static_cast<std::size_t>(first - begin),
                                      static_cast<std::size_t>(last - begin), period_x, period_y);
          first = last;
        }
      };
      add(hulls_, period_x_, period_y_);
      add(guard_hulls_, guard_period_x_, guard_period_y_);
    });
  });
  return drops_->pieces;
}

std::span<const DropBvh> FlatIndex::cutter_drops(const ClSurface& surface) const {
  const std::span<const DropBvh> all = drops(surface);
  const auto first_guard = std::find_if(all.begin(), all.end(),
                                        [&](const DropBvh& drops) { return drops.first() >= first_guard_; });
  return all.first(static_cast<std::size_t>(first_guard - all.begin()));
}

std::span<const DropBvh> FlatIndex::drops_after(std::size_t dropped, const ClSurface& surface) const {
  const std::size_t before = drops_->dropped.fetch_add(dropped, std::memory_order_relaxed);
  if (before + dropped < kDropsPerHull * (hulls_.hulls.size() + guard_hulls_.hulls.size())) return {};
  return drops(surface);
}

bool FlatIndex::holds(const DropBvh::Found& found, double x, double y) const {
  if (found.patch < first_guard_) {
    for (std::uint32_t i = found.hull; i < hulls_.hulls.size() && hulls_.hulls[i].patch == found.patch; ++i)
      if (holds(box(i), x, y)) return true;
    return false;
  }
  const auto& hulls = guard_hulls_.hulls;
  for (std::uint32_t i = found.hull; i < hulls.size() && hulls[i].patch == found.patch; ++i) {
    const LooseBox b = loosened(box_of(guard_hulls_, hulls[i]));
    const FlatBox round{b.low_x, b.high_x, b.low_y, b.high_y};
    if (holds_on_a_turn(round, x, y, guard_period_x_, guard_period_y_)) return true;
  }
  return false;
}

FlatIndex::FlatIndex(FlatHulls hulls, const Deformation& deformation) : hulls_(std::move(hulls)) {
  assert(!hulls_.hulls.empty());
  const Extent extent = extent_of(ranges_of(hulls_, boxes_), deformation);
  period_x_ = extent.period_x, period_y_ = extent.period_y, bounds_ = extent.bounds;
  bins_ = FlatBins(boxes_, bounds_, period_x_, period_y_);
  covering_ = ColumnEnds(std::move(hulls_.near));
  drops_ = std::make_shared<Drops>();
}

FlatIndex::FlatIndex(const FlatIndex& cutter, std::span<const PatchId> numbers, FlatHulls guards,
                     const Deformation& deformation)
    : FlatIndex(cutter) {
  for (FlatHull& hull : hulls_.hulls) hull.patch = numbers[hull.patch];
  covering_.renumber(numbers);
  FreshVector<LooseBox> boxes;
  Ranges ranges = ranges_of(guards, boxes);
  ranges.x.add({bounds_.min_x, bounds_.max_x}), ranges.y.add({bounds_.min_y, bounds_.max_y});
  bounds_ = extent_of(ranges, deformation).bounds;
  hulls_.furthest = std::max(hulls_.furthest, guards.furthest);
  guards_ = HullBvh(guards, deformation);
  guard_period_x_ = deformation.period_x(), guard_period_y_ = deformation.period_y();
  if (!guards.hulls.empty()) first_guard_ = guards.hulls.front().patch;
  drops_ = std::make_shared<Drops>();
  guard_hulls_ = std::move(guards);
}

double FlatIndex::top() const {
  float top = -std::numeric_limits<float>::infinity();
  for (const FlatHulls* hulls : {&hulls_, &guard_hulls_})
    for (const FlatHull& hull : hulls->hulls) top = std::max(top, hull.top);
  return static_cast<double>(top);
}

double FlatIndex::crossings(double dx, double dy, double step) const {
  const double widths = tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::size_t>(0, hulls_.hulls.size(), kHullsPerTask), 0.0,
      [&](const auto& range, double sum) {
        for (std::size_t c = range.begin(); c < range.end(); ++c) {
          const FlatBox box = this->box(static_cast<std::uint32_t>(c));
          sum += std::abs(dy) * (box.high_x - box.low_x) + std::abs(dx) * (box.high_y - box.low_y);
        }
        return sum;
      },
      std::plus<>());
  return static_cast<double>(hulls_.hulls.size()) + widths / step;
}

void FlatIndex::add_hull(std::uint32_t c, const FlatLine& line, const FlatBox& swept,
                         std::vector<Candidate>& candidates) const {
  const auto add_turned = [&](double shift_x, double shift_y) {
    Candidate candidate;
    if (seen_along(c, line.dx, line.dy, shift_x, shift_y).meets(line, candidate))
      candidates.push_back(candidate);
  };
  if (period_x_ <= 0.0 && period_y_ <= 0.0) return add_turned(0.0, 0.0);
  each_turn(box(c), swept, add_turned);
}

void FlatIndex::ask(Scratch& scratch) const {
  scratch.seen.resize(hulls_.hulls.size(), 0);
  if (++scratch.question != 0) return;
  std::fill(scratch.seen.begin(), scratch.seen.end(), 0U);
  scratch.question = 1;
}

void FlatIndex::near(const FlatBox& box, Scratch& scratch, std::vector<Nearby>& nearby) const {
  nearby.clear();
  ask(scratch);
  bins_.each_near(box, [&](std::uint32_t c) {
    if (scratch.seen[c] == scratch.question) return;
    scratch.seen[c] = scratch.question;
    const FlatHull& hull = hulls_.hulls[c];
    const FlatBox own = this->box(c);
    each_turn(own, box, [&](double x, double y) {
      const FlatBox turned{own.low_x + x, own.high_x + x, own.low_y + y, own.high_y + y};
      if (turned.overlaps(box)) nearby.push_back({turned, hull.patch, hull.top});
    });
  });
  std::sort(nearby.begin(), nearby.end(), [](const Nearby& a, const Nearby& b) {
    return a.top != b.top ? a.top > b.top : a.patch < b.patch;
  });
}

void FlatIndex::along(const FlatLine& line, const std::vector<Nearby>& nearby, Scratch& scratch,
                      std::vector<Candidate>& candidates) {
  candidates.clear();
  scratch.pieces.clear();
  for (const Nearby& n : nearby) {
    double from, to;
    if (run_in_box(n.box, line, from, to)) scratch.pieces.push_back({from, to, n.patch, n.top});
  }
  join_pieces(scratch.pieces, candidates);
  sort_by_start(candidates, line.length, scratch.sorting);
}

void FlatIndex::along(const FlatLine& line, std::span<const Candidate> met, Scratch& scratch,
                      std::vector<Candidate>& candidates) {
  candidates.clear();
  scratch.pieces.clear();
  const auto same = [&](std::size_t a, std::size_t b) {
    return b < met.size() && met[a].patch == met[b].patch;
  };
  for (std::size_t i = 0; i < met.size(); ++i)
    (same(i, i + 1) || (i > 0 && same(i, i - 1)) ? scratch.pieces : candidates).push_back(met[i]);
  join_pieces(scratch.pieces, candidates);
  sort_by_start(candidates, line.length, scratch.sorting);
}

void FlatIndex::along(const FlatLine& line, Scratch& scratch, std::vector<Candidate>& candidates) const {
  candidates.clear();
  scratch.pieces.clear();
  ask(scratch);
  const FlatBox swept = box_round(line);
  bins_.each_on(line, [&](std::uint32_t c) {
    if (scratch.seen[c] == scratch.question) return;
    scratch.seen[c] = scratch.question;
    add_hull(c, line, swept, has_siblings(c) ? scratch.pieces : candidates);
  });
  join_pieces(scratch.pieces, candidates);
  sort_by_start(candidates, line.length, scratch.sorting);
}

void FlatIndex::along_over(const FlatLine& line, const AxisLine& middle, double low, const ClSurface& surface,
                           const Deformation& deformation, Scratch& scratch,
                           std::vector<Candidate>& candidates) const {
  candidates.clear();
  scratch.pieces.clear();
  const FlatBox swept = box_round(line);
  const double half = 0.5 * line.length;
  DropBvh::Stretch stretch{line.x_at(half), line.y_at(half), half * std::abs(line.dx),
                           half * std::abs(line.dy)};
  for (const DropBvh& drops : cutter_drops(surface)) {
    // From the middle to a place of the line the axis line is moved as a body is, no contact by more than
    // this.
    const Deformation::Stretch most = deformation.stretch(drops.furthest_from(deformation.frame().origin));
    stretch.slack = stretch.half_x * most.x + stretch.half_y * most.y;
    drops.each(stretch, middle, {.low = low}, [&](const DropBvh::Found& found) {
      for (std::uint32_t c = found.hull; c < hulls_.hulls.size() && hulls_.hulls[c].patch == found.patch; ++c)
        add_hull(c, line, swept, has_siblings(c) ? scratch.pieces : candidates);
    });
  }
  join_pieces(scratch.pieces, candidates);
  sort_by_start(candidates, line.length, scratch.sorting);
}

}  // namespace tiltfeed::pathgen
