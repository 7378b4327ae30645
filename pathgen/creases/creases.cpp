#include "pathgen/creases/creases.h"

#include <algorithm>
#include <numeric>

namespace tiltfeed::pathgen {

namespace {

/// Nodes where creases end or meet, put together where they are near to each other, and the curves between
/// them.
class CreaseJoin {
 public:
  CreaseJoin(const CreaseGraph& graph, double gap)
      : graph_(graph), same_(graph.nodes.size()), alive_(graph.pieces.size(), true) {
    std::iota(same_.begin(), same_.end(), 0U);
    join_near(gap);
  }

  std::vector<Crease> curves(double least_length) {
    while (true) {
      find_ways();
      std::vector<Crease> all;
      bool any_short = false;
      for (const bool loops : {false, true})
        for (std::uint32_t k = 0; k < beside_.size(); ++k)
          for (std::size_t w = 0; loops == (beside_[k].size() == 2) && w < beside_[k].size(); ++w) {
            if (done_[beside_[k][w].piece]) continue;
            Curve curve = follow(k, beside_[k][w]);
            if (curve.ends_freely && crease_length(curve.crease) < least_length) {
              any_short = true;
              for (const std::uint32_t piece : curve.pieces) alive_[piece] = false;
            } else {
              all.push_back(std::move(curve.crease));
            }
          }
      if (!any_short) return all;
    }
  }

 private:
  struct Way {
    std::uint32_t to = 0, piece = 0;
  };
  struct Curve {
    Crease crease;
    std::vector<std::uint32_t> pieces;
    bool ends_freely = false;  ///< or where it begins
  };

  std::uint32_t first(std::uint32_t k) const {
    while (same_[k] != k) k = same_[k];
    return k;
  }

  void join_near(double gap) {
    std::vector<std::uint32_t> count(graph_.nodes.size()), ends;
    for (const auto& [a, b] : graph_.pieces) ++count[a], ++count[b];
    for (std::uint32_t k = 0; k < count.size(); ++k)
      if (count[k] != 0 && count[k] != 2) ends.push_back(k);
    const auto x = [&](std::uint32_t k) { return graph_.nodes[k].point.centre.x; };
    std::sort(ends.begin(), ends.end(),
              [&](std::uint32_t a, std::uint32_t b) { return std::pair(x(a), a) < std::pair(x(b), b); });
    for (std::size_t i = 0; i < ends.size(); ++i)
      for (std::size_t j = i + 1; j < ends.size() && x(ends[j]) - x(ends[i]) <= gap; ++j) {
        const std::uint32_t a = first(ends[i]), b = first(ends[j]);
        if (a != b && distance(graph_.nodes[ends[i]].point.centre, graph_.nodes[ends[j]].point.centre) <= gap)
          same_[std::max(a, b)] = std::min(a, b);
      }
  }

  void find_ways() {
    beside_.assign(graph_.nodes.size(), {});
    done_.assign(graph_.pieces.size(), false);
    for (std::uint32_t k = 0; k < graph_.pieces.size(); ++k) {
      const std::uint32_t a = first(graph_.pieces[k].first), b = first(graph_.pieces[k].second);
      if (a == b || !alive_[k]) continue;
      beside_[a].push_back({b, k}), beside_[b].push_back({a, k});
    }
  }

  Curve follow(std::uint32_t start, Way way) {
    Curve curve;
    curve.crease.push_back(graph_.nodes[start]);
    curve.ends_freely = beside_[start].size() == 1;
    while (true) {
      done_[way.piece] = true;
      curve.pieces.push_back(way.piece);
      curve.crease.push_back(graph_.nodes[way.to]);
      const std::vector<Way>& ways = beside_[way.to];
      curve.ends_freely |= ways.size() == 1 || way.to == start;
      if (ways.size() != 2 || way.to == start) return curve;
      way = done_[ways[0].piece] ? ways[1] : ways[0];
      if (done_[way.piece]) return curve;
    }
  }

  const CreaseGraph& graph_;
  std::vector<std::uint32_t> same_;  ///< the first of those that are one; itself where it is the first
  std::vector<bool> alive_, done_;   ///< by piece: not left out; in a curve
  std::vector<std::vector<Way>> beside_;
};

}  // namespace

double crease_length(const Crease& crease) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < crease.size(); ++i)
    sum += distance(crease[i].point.centre, crease[i + 1].point.centre);
  return sum;
}

std::vector<Crease> joined_creases(const CreaseGraph& graph, double gap, double least_length) {
  return CreaseJoin(graph, gap).curves(least_length);
}

}  // namespace tiltfeed::pathgen
