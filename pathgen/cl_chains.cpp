#include "pathgen/cl_chains.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "pathgen/swept_tool.h"

namespace tiltfeed {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
/// Points nearer than this, mm, are one.
constexpr double kSame = 1e-7;
/// Steps of the search for the least distance on a move; each at least halves what is unknown.
constexpr int kMostSteps = 64;

/// Distance of a facet from the place s of a move, and its derivative.
struct Near {
  double s, distance, slope;
};

class Move1 {
 public:
  Move1(Point<Part> from, Point<Part> to)
      : from_(from), length_(distance(from, to)), along_((to - from) / length_) {}
  double length() const { return length_; }
  Vec3 along() const { return along_; }
  Near at(double s, const Corners& c) const {
    const Point<Part> p = from_ + along_ * s;
    const Vec3 off = p - nearest_point(p, c);
    const double d = tiltfeed::length(off);
    return {s, d, d > 0.0 ? dot(off, along_) / d : 0.0};
  }

 private:
  Point<Part> from_;
  double length_;
  Vec3 along_;
};

/// A place of the move nearer than `limit` to the facet, if there is one: the distance is convex along the
/// move, so between two places it is nowhere less than where their tangents meet.
bool find_inside(const Move1& move, const Corners& c, double limit, Near& inside) {
  Near a = move.at(0.0, c), b = move.at(move.length(), c);
  for (const Near& end : {a, b})
    if (end.distance < limit) return inside = end, true;
  for (int i = 0; i < kMostSteps; ++i) {
    if (a.slope >= 0.0 || b.slope <= 0.0) return false;
    const double meet = (b.distance - b.slope * b.s - a.distance + a.slope * a.s) / (a.slope - b.slope);
    if (a.distance + a.slope * (meet - a.s) >= limit) return false;
    const Near middle = move.at(std::clamp(meet, a.s, b.s), c);
    if (middle.distance < limit) return inside = middle, true;
    (middle.slope < 0.0 ? a : b) = middle;
    if (b.s - a.s < kSame) return false;
  }
  return false;
}

/// Where the move comes out of the limit on the way from `inside` to `outside`.
double border(const Move1& move, const Corners& c, double limit, double inside, double outside) {
  for (int i = 0; i < kMostSteps && std::abs(outside - inside) > 1e-10; ++i) {
    const double middle = 0.5 * (inside + outside);
    (move.at(middle, c).distance < limit ? inside : outside) = middle;
  }
  return outside;
}

using Span = std::array<double, 2>;

/// Appends the part of the move that is too near to the facet, if there is one; true: all of it.
bool add_span_inside(const Move1& move, Point<Part> from, Point<Part> to, const PlacedFacet& facet,
                     double limit, std::vector<Span>& spans) {
  // The plane of the facet is further off at both ends, on the same side: no distance is needed.
  const double low = dot(facet.normal, from_origin(from)) - facet.offset;
  const double high = dot(facet.normal, from_origin(to)) - facet.offset;
  if ((low >= limit && high >= limit) || (low <= -limit && high <= -limit)) return false;
  const Corners& c = facet.corners;
  Near inside{};
  if (!find_inside(move, c, limit, inside)) return false;
  const double end = move.length();
  const bool starts = move.at(0.0, c).distance < limit, ends = move.at(end, c).distance < limit;
  spans.push_back({starts ? 0.0 : border(move, c, limit, inside.s, 0.0),
                   ends ? end : border(move, c, limit, inside.s, end)});
  return starts && ends;
}

/// In rising order, overlaps united.
void unite(std::vector<Span>& spans) {
  if (spans.empty()) return;
  std::sort(spans.begin(), spans.end());
  std::size_t last = 0;
  for (std::size_t i = 1; i < spans.size(); ++i) {
    if (spans[i][0] <= spans[last][1])
      spans[last][1] = std::max(spans[last][1], spans[i][1]);
    else
      spans[++last] = spans[i];
  }
  spans.resize(last + 1);
}

/// Is some part of the move too near to a facet?
bool any_inside(Point<Part> from, Point<Part> to, const FacetTree& tree, double limit) {
  const Move1 move(from, to);
  std::vector<Span> spans;
  return tree.any_along(from, move.along(), 0.0, move.length(), limit,
                        [&](std::uint32_t, const PlacedFacet& facet) {
                          add_span_inside(move, from, to, facet, limit, spans);
                          return !spans.empty();
                        });
}

ClPoint between(const ClPoint& a, const ClPoint& b, double f) {
  const Vec3 n = a.normal * (1.0 - f) + b.normal * f;
  return {lerp(a.centre, b.centre, f), squared_length(n) > 0.0 ? normalized(n) : a.normal,
          f < 0.5 ? a.facet : b.facet};
}

}  // namespace

double length_of(const ClStrand& strand) {
  double sum = 0.0;
  for (std::size_t i = 1; i < strand.size(); ++i) sum += distance(strand[i - 1].centre, strand[i].centre);
  return sum;
}

void trim_strand(const ClStrand& strand, const FacetTree& tree, std::span<const std::uint32_t> obstacles,
                 double radius, std::vector<ClStrand>& kept) {
  if (obstacles.empty()) return kept.push_back(strand);
  ClStrand run;
  std::vector<Span> spans;
  const auto end_run = [&] {
    if (run.size() > 1) kept.push_back(std::move(run));
    run.clear();
  };
  for (std::size_t i = 0; i + 1 < strand.size(); ++i) {
    const ClPoint &a = strand[i], &b = strand[i + 1];
    const double whole = distance(a.centre, b.centre);
    if (whole < kSame) continue;
    spans.clear();
    const Move1 move(a.centre, b.centre);
    for (const std::uint32_t facet : obstacles)
      if (add_span_inside(move, a.centre, b.centre, tree.facet(facet), radius - kInside, spans)) break;
    unite(spans);
    if (run.empty()) run.push_back(a);
    for (const Span& span : spans) {
      if (span[0] > kSame)
        run.push_back(between(a, b, span[0] / whole));
      else if (run.size() == 1)
        run.clear();
      end_run();
      if (span[1] < whole - kSame) run.push_back(between(a, b, span[1] / whole));
    }
    if (spans.empty() || spans.back()[1] < whole - kSame) run.push_back(b);
  }
  end_run();
}

bool in_contact(Point<Part> from, Point<Part> to, const FacetTree& tree, double radius, double tolerance) {
  if (any_inside(from, to, tree, radius - tolerance)) return false;
  const Point<Part> middle = lerp(from, to, 0.5);
  const double reach = radius + tolerance;
  bool near = false;
  tree.each_in({middle - Vec3{reach, reach, reach}, middle + Vec3{reach, reach, reach}},
               [&](std::uint32_t, const PlacedFacet& f) {
                 near = near || distance(middle, nearest_point(middle, f.corners)) <= reach;
               });
  return near;
}

namespace {

/// Cells of the grid in which starts are looked up.
std::array<std::int64_t, 3> cell(Point<Part> p, double size) {
  const auto index = [size](double v) { return static_cast<std::int64_t>(std::floor(v / size)); };
  return {index(p.x), index(p.y), index(p.z)};
}

/// For each strand the one that starts where it ends.
std::vector<std::uint32_t> followers(const std::vector<ClStrand>& strands, const FacetTree& tree,
                                     double radius, const JoinLimits& limits) {
  const double gap = limits.wide_gap;
  struct Start {
    std::array<std::int64_t, 3> cell;
    std::uint32_t strand;
    bool operator<(const Start& o) const { return std::tie(cell, strand) < std::tie(o.cell, o.strand); }
  };
  std::vector<Start> starts;
  for (std::uint32_t i = 0; i < strands.size(); ++i)
    starts.push_back({cell(strands[i].front().centre, gap), i});
  std::sort(starts.begin(), starts.end());
  struct Pair {
    double distance;
    std::uint32_t from, to;
    bool operator<(const Pair& o) const {
      return std::tie(distance, from, to) < std::tie(o.distance, o.from, o.to);
    }
  };
  std::vector<Pair> pairs;
  for (std::uint32_t i = 0; i < strands.size(); ++i) {
    const Point<Part> end = strands[i].back().centre;
    const auto at = cell(end, gap);
    for (std::int64_t x = at[0] - 1; x <= at[0] + 1; ++x)
      for (std::int64_t y = at[1] - 1; y <= at[1] + 1; ++y) {
        auto found = std::lower_bound(starts.begin(), starts.end(), Start{{x, y, at[2] - 1}, 0});
        for (; found != starts.end() && found->cell <= std::array<std::int64_t, 3>{x, y, at[2] + 1};
             ++found) {
          const double d = distance(end, strands[found->strand].front().centre);
          if (d > gap || (found->strand == i && length_of(strands[i]) < 4.0 * d)) continue;
          pairs.push_back({d, i, found->strand});
        }
      }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<std::uint32_t> next(strands.size(), kNone);
  std::vector<std::uint8_t> taken(strands.size(), 0);
  for (const Pair& pair : pairs) {
    if (next[pair.from] != kNone || taken[pair.to] != 0) continue;
    if (pair.distance > limits.gap &&
        !in_contact(strands[pair.from].back().centre, strands[pair.to].front().centre, tree, radius,
                    limits.tolerance))
      continue;
    next[pair.from] = pair.to, taken[pair.to] = 1;
  }
  return next;
}

/// Appends the strand. Where strands cross at a flat angle each runs on beyond the other's end by chords that
/// stand off their arcs: the chain goes back to beside the strand's start first.
void append(ClStrand& chain, const ClStrand& strand, double gap) {
  const Point<Part> start = strand.front().centre;
  while (chain.size() > 1) {
    const ClPoint &a = chain[chain.size() - 2], &b = chain.back();
    const Vec3 along = b.centre - a.centre;
    const double f = dot(start - a.centre, along) / squared_length(along);
    if (f >= 1.0) break;
    if (f > 0.0) {
      chain.back() = between(a, b, f);
      break;
    }
    chain.pop_back();
  }
  for (const ClPoint& p : strand)
    if (chain.empty() || distance(chain.back().centre, p.centre) > (&p == &strand.front() ? gap : kSame))
      chain.push_back(p);
}

}  // namespace

std::vector<ClChain> join_strands(std::vector<ClStrand> strands, const FacetTree& tree, double radius,
                                  const JoinLimits& limits) {
  std::erase_if(strands, [](const ClStrand& s) { return s.size() < 2 || length_of(s) < kSame; });
  const std::vector<std::uint32_t> next = followers(strands, tree, radius, limits);
  std::vector<std::uint8_t> used(strands.size(), 0), is_next(strands.size(), 0);
  for (const std::uint32_t n : next)
    if (n != kNone) is_next[n] = 1;
  std::vector<ClChain> chains;
  const auto collect = [&](std::uint32_t first) {
    ClChain chain;
    std::uint32_t at = first;
    for (; at != kNone && used[at] == 0; at = next[at])
      used[at] = 1, append(chain.points, strands[at], limits.gap);
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
    if (whole < kSame) return false;
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

}  // namespace tiltfeed
