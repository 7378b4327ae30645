#include "pathgen/free_slices/cl_chains.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "pathgen/tool/swept_tool.h"

namespace tiltfeed::pathgen {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

}  // namespace

ClPoint between(const ClPoint& a, const ClPoint& b, double f) {
  const Vec3 n = a.normal * (1.0 - f) + b.normal * f;
  return {lerp(a.centre, b.centre, f), squared_length(n) > 0.0 ? normalized(n) : a.normal,
          f < 0.5 ? a.facet : b.facet};
}

double length_of(const ClStrand& strand) {
  double sum = 0.0;
  for (std::size_t i = 1; i < strand.size(); ++i) sum += distance(strand[i - 1].centre, strand[i].centre);
  return sum;
}

namespace {

/// Cells of the grid in which starts are looked up.
std::array<std::int64_t, 3> cell(Point<Part> p, double size) {
  const auto index = [size](double v) { return static_cast<std::int64_t>(std::floor(v / size)); };
  return {index(p.x), index(p.y), index(p.z)};
}

/// Which strand starts where another one ends.
class Followers {
 public:
  explicit Followers(const std::vector<ClStrand>& strands)
      : strands_(strands), next_(strands.size(), kNone), taken_(strands.size(), 0) {}

  /// Of the ends and starts not joined yet, and no further apart than `gap` (mm), the nearest first, those
  /// that `joins` allows.
  template <class Joins>
  void join(double gap, const Joins& joins) {
    for (const Pair& pair : pairs(gap)) {
      if (next_[pair.from] != kNone || taken_[pair.to] != 0) continue;
      if (joins(strands_[pair.from].back().centre, strands_[pair.to].front().centre))
        next_[pair.from] = pair.to, taken_[pair.to] = 1;
    }
  }
  /// For each strand the one that follows it.
  const std::vector<std::uint32_t>& next() const { return next_; }

 private:
  struct Start {
    std::array<std::int64_t, 3> cell;
    std::uint32_t strand;
    bool operator<(const Start& o) const { return std::tie(cell, strand) < std::tie(o.cell, o.strand); }
  };
  struct Pair {
    double distance;
    std::uint32_t from, to;
    bool operator<(const Pair& o) const {
      return std::tie(distance, from, to) < std::tie(o.distance, o.from, o.to);
    }
  };

  std::vector<Pair> pairs(double gap) const {
    std::vector<Start> starts;
    for (std::uint32_t i = 0; i < strands_.size(); ++i)
      if (taken_[i] == 0) starts.push_back({cell(strands_[i].front().centre, gap), i});
    std::sort(starts.begin(), starts.end());
    std::vector<Pair> found;
    for (std::uint32_t i = 0; i < strands_.size(); ++i)
      if (next_[i] == kNone) add_pairs(i, gap, starts, found);
    std::sort(found.begin(), found.end());
    return found;
  }

  void add_pairs(std::uint32_t i, double gap, const std::vector<Start>& starts,
                 std::vector<Pair>& found) const {
    const Point<Part> end = strands_[i].back().centre;
    const auto at = cell(end, gap);
    for (std::int64_t x = at[0] - 1; x <= at[0] + 1; ++x)
      for (std::int64_t y = at[1] - 1; y <= at[1] + 1; ++y) {
        auto start = std::lower_bound(starts.begin(), starts.end(), Start{{x, y, at[2] - 1}, 0});
        for (; start != starts.end() && start->cell <= std::array<std::int64_t, 3>{x, y, at[2] + 1};
             ++start) {
          const double d = distance(end, strands_[start->strand].front().centre);
          if (d > gap || (start->strand == i && length_of(strands_[i]) < 4.0 * d)) continue;
          found.push_back({d, i, start->strand});
        }
      }
  }

  const std::vector<ClStrand>& strands_;
  std::vector<std::uint32_t> next_;
  std::vector<std::uint8_t> taken_;
};

/// For each strand the one that starts where it ends. Most are joined by the narrow gap, which leaves few
/// pairs for the wide one.
template <class Joins>
std::vector<std::uint32_t> followers(const std::vector<ClStrand>& strands, const JoinLimits& limits,
                                     const Joins& joins) {
  Followers found(strands);
  found.join(limits.gap, [](Point<Part>, Point<Part>) { return true; });
  found.join(limits.wide_gap, joins);
  return found.next();
}

/// How many points of the chain come before the place that lies beside `start`, and that place.
std::pair<std::size_t, ClPoint> beside(const ClStrand& chain, Point<Part> start) {
  std::size_t last = chain.size() - 1;
  for (; last > 0; --last) {
    const ClPoint &a = chain[last - 1], &b = chain[last];
    const Vec3 along = b.centre - a.centre;
    const double f = dot(start - a.centre, along) / squared_length(along);
    if (f >= 1.0) break;
    if (f > 0.0) return {last, between(a, b, f)};
  }
  return {last, chain[last]};
}

/// Appends the strand. Where strands cross at a flat angle each runs on beyond the other's end by chords that
/// stand off their arcs: the chain goes back to beside the strand's start first, if the move from there is in
/// contact. In a hollow it is not: there the strand's start may lie behind the chain's end, but above it.
template <class Joins>
void append(ClStrand& chain, const ClStrand& strand, double gap, const Joins& joins) {
  const Point<Part> start = strand.front().centre;
  if (!chain.empty()) {
    const auto [before, place] = beside(chain, start);
    if (distance(place.centre, start) <= gap || joins(place.centre, start))
      chain.resize(before), chain.push_back(place);
  }
  for (const ClPoint& p : strand)
    if (chain.empty() || distance(chain.back().centre, p.centre) > (&p == &strand.front() ? gap : kSamePoint))
      chain.push_back(p);
}

}  // namespace

std::vector<ClChain> join_strands(std::vector<ClStrand> strands, const FacetBvh& tree, double radius,
                                  const JoinLimits& limits) {
  std::erase_if(strands, [](const ClStrand& s) { return s.size() < 2 || length_of(s) < kSamePoint; });
  const auto joins = [&](Point<Part> end, Point<Part> start) {
    return in_contact(end, start, tree, radius, limits.tolerance);
  };
  const std::vector<std::uint32_t> next = followers(strands, limits, joins);
  std::vector<std::uint8_t> used(strands.size(), 0), is_next(strands.size(), 0);
  for (const std::uint32_t n : next)
    if (n != kNone) is_next[n] = 1;
  std::vector<ClChain> chains;
  const auto collect = [&](std::uint32_t first) {
    ClChain chain;
    std::uint32_t at = first;
    for (; at != kNone && used[at] == 0; at = next[at])
      used[at] = 1, append(chain.points, strands[at], limits.gap, joins);
    chain.closed = at == first;
    if (chain.closed) {
      while (chain.points.size() > 2 &&
             distance(chain.points.front().centre, chain.points.back().centre) < limits.gap)
        chain.points.pop_back();
      chain.points.push_back(chain.points.front());
    }
    if (chain.points.size() > 1 && length_of(chain.points) >= limits.shortest)
      chains.push_back(std::move(chain));
  };
  for (std::uint32_t i = 0; i < strands.size(); ++i)
    if (used[i] == 0 && is_next[i] == 0) collect(i);
  for (std::uint32_t i = 0; i < strands.size(); ++i)
    if (used[i] == 0) collect(i);
  return chains;
}

void thin_chain(ClChain& chain, double tolerance) {
  const ClStrand& p = chain.points;
  if (p.size() < 3) return;
  const auto fits = [&](std::size_t from, std::size_t to) {
    const double whole = distance(p[from].centre, p[to].centre);
    if (whole < kSamePoint) return false;
    for (std::size_t i = from + 1; i < to; ++i) {
      if (distance_to_segment(p[i].centre, p[from].centre, p[to].centre) > tolerance) return false;
      const double f = std::clamp(distance(p[from].centre, p[i].centre) / whole, 0.0, 1.0);
      if (angle_between(p[i].normal, between(p[from], p[to], f).normal) > kNormalBend) return false;
    }
    return true;
  };
  ClStrand kept{p.front()};
  // Windows are bounded, so that the time is linear in the points.
  constexpr std::size_t kWindow = 64;
  for (std::size_t at = 0; at + 1 < p.size();) {
    std::size_t to = at + 1;
    while (to + 1 < p.size() && to + 1 - at < kWindow && fits(at, to + 1)) ++to;
    kept.push_back(p[to]);
    at = to;
  }
  chain.points = std::move(kept);
}

}  // namespace tiltfeed::pathgen
