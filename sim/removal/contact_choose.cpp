#include <algorithm>

#include "sim/removal/contact_run.h"

namespace tiltfeed::sim {
namespace {

// More than rounding takes from a sine or its square.
constexpr float kSineSlack = 0x1p-18f;

}  // namespace

void Contact::Four::set(int lane, const Group& g, Point<Part> origin, double radius) {
  const auto at = static_cast<std::size_t>(lane);
  const Stretch& lower = g.stretches.front();
  groups[at] = &g;
  ball.set(lane, origin, lower.foot, lower.way, {}, g.stray, radius);
  for (std::size_t k = 0; k < g.stretches.size(); ++k) {
    const Stretch& s = g.stretches[k];
    core[k].set(lane, origin, s.foot, s.way, s.core, s.wide, radius);
  }
  axis.x[lane] = static_cast<float>(g.axis.x), axis.y[lane] = static_cast<float>(g.axis.y),
  axis.z[lane] = static_cast<float>(g.axis.z);
  turn[lane] = static_cast<float>(g.turn);
  off[lane] = static_cast<float>(g.stray + g.slack - std::min(0.0, dot(lower.way, g.axis)));
  far[lane] = static_cast<float>(length(lower.way) + g.stray);
}

/// Not less than how far all that can matter of the patch, `most` above it, is above the ball at the core's
/// lower end, in all of the group.
Lanes Contact::Four::above_ball(const FacetLanes& facet, float most) const {
  const LaneVec3 from = facet.middle - ball.foot;
  const Lanes up = dot(facet.normal, axis), slack = turn + kSineSlack;
  const Lanes across = root(greater(Lanes{}, 1.0f - up * up) + kSineSlack);
  const Lanes above = dot(from, axis) + off + turn * (root(squared_length(from)) + far) +
                      (across + slack) * facet.radius + (up + slack) * std::max(0.0f, most) +
                      ball.slack(facet);
  return where_no_more(up, slack, all_lanes(kLaneFar), above);
}

/// The cluster's groups, by fours.
void Contact::line_up(const Cluster& cluster, Run& run) const {
  const std::size_t count = cluster.groups.size();
  run.origin = run.groups[cluster.groups.front()].stretches.front().foot;
  run.fours.assign((count + 3) / 4, Four());
  for (std::size_t i = 0; i < 4 * run.fours.size(); ++i) {
    const Group& g = run.groups[cluster.groups[std::min(i, count - 1)]];
    Four& four = run.fours[i / 4];
    const int lane = static_cast<int>(i % 4);
    four.set(lane, g, run.origin, radius_);
    if (i < count) four.filled |= 1u << lane;
    four.deep[lane] = static_cast<float>(g.step_stray - run.allowed(g) + kBoundSlack);
  }
}

/// Those groups of the cluster that may do something to the patch, in the order of how much they may take.
void Contact::choose(const Facet& facet, std::uint32_t stretches, Run& run) const {
  run.candidates.clear(), run.live.clear();
  const FacetLanes lanes(run.origin, facet);
  for (const Four& four : run.fours) choose(four, facet, lanes, stretches, run);
  std::sort(run.candidates.begin(), run.candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.least < b.least; });
}

void Contact::choose(const Four& four, const Facet& facet, const FacetLanes& lanes, std::uint32_t stretches,
                     Run& run) const {
  const auto radius = static_cast<float>(radius_);
  const auto most = static_cast<float>(std::min(probes_.reach(), probes_.highest(facet.patch)) + kBoundSlack);
  const auto below = [&](Lanes least, Lanes limit) { return four.filled & ~no_more(limit, least); };
  Lanes least = all_lanes(kLaneFar), base{};
  const Lanes matters = greater(all_lanes(most), four.deep);
  FourSheets::Trace trace{};
  unsigned takes_ball = 0, takes_side = 0, touches_ball = 0, touches_side = 0;
  if (round_ && (stretches & 1) != 0) {
    base = four.ball.over(lanes);
    Lanes ball = base + risen(four.ball.beyond(lanes), radius);
    if (below(ball, matters) != 0) {
      trace = four.ball.trace(lanes);
      ball = greater(ball, base + risen(four.ball.beside(lanes, trace, lanes.middle) - lanes.radius, radius));
      takes_ball = below(ball, all_lanes(most));
      if (closed_) touches_ball = below(ball, four.deep);
    }
    least = ball;
  }
  std::array<Lanes, kMostStretches> side;
  side.fill(all_lanes(kLaneFar));
  const unsigned more = round_ ? below(Lanes{}, four.above_ball(lanes, most)) : four.filled;
  for (std::size_t k = 0; more != 0 && k < kMostStretches; ++k) {
    if ((stretches >> k & 1) == 0) continue;
    const FourSheets& core = four.core[k];
    const Lanes over = core.over(lanes) + risen(core.beyond(lanes), radius);
    if ((more & below(over, matters)) == 0) continue;
    const FourSheets::Left left = core.left(lanes, lanes.middle, lanes.radius);
    side[k] = greater(over, left.least);
    takes_side |= more & below(side[k], all_lanes(most));
    if (closed_) touches_side |= more & below(over, four.deep) & below(left.gap, greater(four.deep, Lanes{}));
    least = lesser(least, side[k]);
  }
  if ((takes_ball | takes_side) != 0) {
    if (run.live.empty()) probes_.collect(facet.patch, run.live);
    unsigned no_ball = takes_ball, no_side = takes_side;  // not by any of the probes yet
    for (const Probes::Live& l : run.live) {
      const LaneVec3 place = all_lanes(l.place - run.origin);
      const Lanes bound = all_lanes(static_cast<float>(l.bound + kBoundSlack));
      if (no_ball != 0) no_ball &= ~below(base + risen(four.ball.beside(lanes, trace, place), radius), bound);
      for (std::size_t k = 0; k < kMostStretches && no_side != 0; ++k)
        if ((no_side & below(side[k], bound)) != 0)
          no_side &= ~below(greater(side[k], four.core[k].left(lanes, place, 0.0f).least), bound);
      if ((no_ball | no_side) == 0) break;
    }
    takes_ball &= ~no_ball, takes_side &= ~no_side;
  }
  for (unsigned i = 0; i < 4; ++i) {
    const auto has = [&](unsigned bits) { return (bits >> i & 1) != 0; };
    const Candidate c{four.groups[i],
                      {has(takes_ball), has(takes_side)},
                      {has(touches_ball), has(touches_side)},
                      static_cast<double>(least[i])};
    if (c.takes || c.touches) run.candidates.push_back(c);
  }
}

}  // namespace tiltfeed::sim
