#include "pathgen/linking/run_order.h"

#include "pathgen/linking/rapid_time.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

namespace tiltfeed::pathgen {

namespace {

/// Exchanges must save this much, s: rounding.
constexpr double kSaves = 1e-9;
/// Of each end the ways to so many others are timed, those near in space; for exchanges the quickest count.
constexpr std::size_t kLookedAt = 64, kNeighbours = 12;
/// So often all runs are gone through, at most.
constexpr int kRounds = 60;
constexpr std::size_t kLongestMoved = 3;

/// End 2 r of run r is its first point, 2 r + 1 its last.
using End = std::uint32_t;

class Tour {
 public:
  Tour(const std::vector<RunEnds>& runs, bool reversible, const LinkTime& time, Point<Part> start,
       Vec3 start_axis)
      : runs_(runs), reversible_(reversible), time_(time), start_(start), start_axis_(start_axis) {}

  void begin_with_nearest() {
    find_neighbours();
    std::vector<std::uint32_t> left(runs_.size());
    std::iota(left.begin(), left.end(), 0u);
    std::vector<bool> gone(runs_.size(), false);
    while (order_.size() < runs_.size()) {
      const OrderedRun next = nearest(left, gone);
      order_.push_back(next), gone[next.run] = true;
      if (2 * order_.size() % runs_.size() < 2)
        std::erase_if(left, [&](std::uint32_t run) { return gone[run]; });
    }
  }

  void improve() {
    place_.resize(runs_.size());
    note_places(0, order_.size());
    for (int round = 0; round < kRounds; ++round) {
      bool better = false;
      for (std::uint32_t run = 0; run < runs_.size(); ++run) {
        if (reversible_) better |= turn_round(run);
        better |= move(run);
      }
      if (!better) return;
    }
  }

  std::vector<OrderedRun> order() && { return std::move(order_); }

 private:
  static End entry(OrderedRun r) { return 2 * r.run + (r.reversed ? 1 : 0); }
  static End exit(OrderedRun r) { return entry(r) ^ 1u; }
  const Pose& pose(End e) const { return e % 2 == 0 ? runs_[e / 2].first : runs_[e / 2].last; }
  double link(End a, End b) const { return time_.between(pose(a), pose(b)); }
  /// The way to a run that comes at place `at`.
  double into(std::size_t at, OrderedRun run) const {
    if (at == 0) return time_.from_above(start_, start_axis_, pose(entry(run)));
    return link(exit(order_[at - 1]), entry(run));
  }
  /// And the way on, where there is one.
  double out_of(OrderedRun run, std::size_t next) const {
    return next < order_.size() ? link(exit(run), entry(order_[next])) : 0.0;
  }

  /// Of those that are left, the one that is nearest in time: of the neighbours, if one is left.
  OrderedRun nearest(const std::vector<std::uint32_t>& left, const std::vector<bool>& gone) const {
    if (!order_.empty())
      for (const End end : near_[exit(order_.back())])
        if (!gone[end / 2] && (reversible_ || end % 2 == 0)) return {end / 2, end % 2 == 1};
    double least = std::numeric_limits<double>::infinity();
    OrderedRun best;
    for (const std::uint32_t run : left)
      for (const bool turned : {false, true}) {
        if (gone[run] || (turned && !reversible_)) continue;
        const double way = into(order_.size(), {run, turned});
        if (way < least) least = way, best = {run, turned};
      }
    return best;
  }

  /// Of the ends that are near in space those near in time.
  void find_neighbours() {
    const auto ends = static_cast<End>(2 * runs_.size());
    near_.resize(ends);
    tbb::parallel_for(End{0}, ends, [&](End e) {
      std::vector<std::pair<double, End>> all;
      for (End other = 0; other < ends; ++other)
        if (other / 2 != e / 2) all.push_back({squared_length(pose(other).tip - pose(e).tip), other});
      const auto count = std::min(kLookedAt, all.size());
      std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end());
      all.resize(count);
      for (auto& [time, other] : all) time = link(e, other);
      std::sort(all.begin(), all.end());
      for (const auto& [time, other] : all) near_[e].push_back(other);
    });
  }

  std::span<const End> quickest(End e) const {
    return std::span<const End>(near_[e]).first(std::min(kNeighbours, near_[e].size()));
  }

  void note_places(std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) place_[order_[i].run] = i;
  }

  /// Turns places first..last round.
  void reverse(std::size_t first, std::size_t last) {
    std::reverse(order_.begin() + static_cast<std::ptrdiff_t>(first),
                 order_.begin() + static_cast<std::ptrdiff_t>(last + 1));
    for (std::size_t i = first; i <= last; ++i) order_[i].reversed = !order_[i].reversed;
    note_places(first, last + 1);
  }

  /// What it saves to turn places first..last round, s.
  double saved_by_turn(std::size_t first, std::size_t last) const {
    const OrderedRun a = order_[first], b = order_[last];
    return into(first, a) + out_of(b, last + 1) - into(first, {b.run, !b.reversed}) -
           out_of({a.run, !a.reversed}, last + 1);
  }

  /// (L8) A stretch from or to this run is turned round so that it lies beside a near end.
  bool turn_round(std::uint32_t run) {
    for (const bool entering : {false, true}) {
      const std::size_t at = place_[run];
      const End end = entering ? entry(order_[at]) : exit(order_[at]);
      for (const End near : quickest(end)) {
        const std::size_t other = place_[near / 2];
        std::size_t first = 0, last = 0;
        if (!entering && near == exit(order_[other]) && other > at) {
          first = at + 1, last = other;
        } else if (!entering && near == exit(order_[other]) && other < at) {
          first = other + 1, last = at;
        } else if (entering && near == entry(order_[other]) && other > at) {
          first = at, last = other - 1;
        } else if (entering && near == entry(order_[other]) && other < at) {
          first = other, last = at - 1;
        } else {
          continue;
        }
        if (saved_by_turn(first, last) <= kSaves) continue;
        reverse(first, last);
        return true;
      }
    }
    return false;
  }

  /// (L8) Up to three runs from this one on go to where a near end is.
  bool move(std::uint32_t run) {
    for (std::size_t count = 1; count <= kLongestMoved; ++count) {
      const std::size_t first = place_[run], last = first + count - 1;
      if (last >= order_.size()) return false;
      const OrderedRun a = order_[first], b = order_[last];
      const double saved = into(first, a) + out_of(b, last + 1) -
                           (last + 1 < order_.size() ? into(first, order_[last + 1]) : 0.0);
      if (saved <= kSaves) continue;
      for (const bool ahead : {false, true})
        for (const End end = ahead ? exit(b) : entry(a); const End near : quickest(end)) {
          if (link(end, near) >= saved) break;
          const std::size_t other = place_[near / 2];
          const bool behind = near == exit(order_[other]);  // that run comes before the gap
          if (behind == ahead && !reversible_) continue;
          if (move(first, last, behind ? other + 1 : other, behind == ahead, saved)) return true;
        }
    }
    return false;
  }

  /// Puts places first..last into the gap before place `gap`, if that takes less than the `saved` time.
  bool move(std::size_t first, std::size_t last, std::size_t gap, bool turned, double saved) {
    if (gap >= first && gap <= last + 1) return false;
    OrderedRun a = order_[first], b = order_[last];
    if (turned) std::swap(a, b), a.reversed = !a.reversed, b.reversed = !b.reversed;
    const double opened = gap < order_.size() ? into(gap, order_[gap]) : 0.0;
    if (saved + opened - into(gap, a) - out_of(b, gap) <= kSaves) return false;
    if (turned) reverse(first, last);
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    if (gap < first) {
      std::rotate(at(gap), at(first), at(last + 1));
      note_places(gap, last + 1);
    } else {
      std::rotate(at(first), at(last + 1), at(gap));
      note_places(first, gap);
    }
    return true;
  }

  const std::vector<RunEnds>& runs_;
  const bool reversible_;
  const LinkTime& time_;
  const Point<Part> start_;
  const Vec3 start_axis_;
  std::vector<OrderedRun> order_;
  std::vector<std::size_t> place_;      ///< of each run in order_
  std::vector<std::vector<End>> near_;  ///< of each end
};

}  // namespace

/// Drawn back along the axis.
double LinkTime::up_to_sphere(const Pose& at, Point<Part>& on_sphere) const {
  const Vec3 m = at.tip - o_.centre;
  const double along = dot(m, at.axis), c = squared_length(m) - o_.radius * o_.radius;
  const double way = std::max(0.0, std::sqrt(std::max(0.0, along * along - c)) - along);
  on_sphere = at.tip + at.axis * way;
  return way;
}

double LinkTime::between(const Pose& from, const Pose& to) const {
  const double turning = rest_to_rest(turn(from.axis, to.axis), o_.rapid);
  const double apart = distance(from.tip + from.axis * o_.lift, to.tip + to.axis * o_.lift);
  if (apart <= o_.short_way && angle_between(from.axis, to.axis) <= o_.short_turn.radians())
    return 2.0 * rapid(o_.lift) + std::max(rapid(apart), turning) + o_.plunge_seconds;
  Point<Part> over;
  const double up = up_to_sphere(from, over);
  return rapid(up) + from_above(over, from.axis, to);
}

double LinkTime::from_above(Point<Part> from, Vec3 axis, const Pose& to) const {
  Point<Part> over;
  const double down = up_to_sphere(to, over);
  const double round = o_.radius * angle_between(from - o_.centre, over - o_.centre);
  return std::max(rapid(round), rest_to_rest(turn(axis, to.axis), o_.rapid)) + rapid(down) +
         o_.plunge_seconds;
}

double LinkTime::of(const std::vector<Move>& moves) const {
  double sum = 0.0, way = 0.0;
  RotaryTurn turned;
  const auto stop = [&] {
    if (way > 0.0 || turned.tilt > 0.0 || turned.table > 0.0)
      sum += std::max(rapid(way), rest_to_rest(turned, o_.rapid));
    way = 0.0, turned = {};
  };
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const Pose &from = moves[i - 1].pose, &to = moves[i].pose;
    const bool back = i > 1 && dot(to.tip - from.tip, from.tip - moves[i - 2].pose.tip) < 0.0;
    if (moves[i].kind != MoveKind::kRapid || back) stop();
    if (moves[i].kind == MoveKind::kPlunge) sum += o_.plunge_seconds;
    if (moves[i].kind != MoveKind::kRapid) continue;
    const RotaryTurn by = turn(from.axis, to.axis);
    way += distance(from.tip, to.tip), turned.tilt += by.tilt, turned.table += by.table;
  }
  stop();
  return sum;
}

double time_of_order(const std::vector<OrderedRun>& order, const std::vector<RunEnds>& runs,
                     const LinkTime& time, Point<Part> start, Vec3 start_axis) {
  double seconds = 0.0;
  const Pose* at = nullptr;
  for (const OrderedRun& r : order) {
    const RunEnds& ends = runs[r.run];
    const Pose& to = r.reversed ? ends.last : ends.first;
    seconds += at == nullptr ? time.from_above(start, start_axis, to) : time.between(*at, to);
    at = r.reversed ? &ends.first : &ends.last;
  }
  return seconds;
}

std::vector<OrderedRun> order_runs(const std::vector<RunEnds>& runs, bool reversible, const LinkTime& time,
                                   Point<Part> start, Vec3 start_axis) {
  Tour tour(runs, reversible, time, start, start_axis);
  tour.begin_with_nearest();
  tour.improve();
  return std::move(tour).order();
}

}  // namespace tiltfeed::pathgen
