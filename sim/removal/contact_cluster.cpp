#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "sim/removal/contact_run.h"
#include "sim/removal/sheet.h"

namespace tiltfeed::sim {
namespace {

// Groups that look for patches together: their lower stretches and the others stray from those of the longest
// of them by so many radii at most.
constexpr std::array kStrayRadii{1.0, 1.5, 3.0};

}  // namespace

/// How far any point of the stretch is from the sheet: the distance from a convex set is a convex function,
/// largest at a corner of the parallelogram.
double Contact::apart(const Sheet& sheet, const Stretch& s) const {
  double most = 0.0;
  for (const Point<Part> corner : s.corners()) most = std::max(most, length(sheet.to(corner)));
  return most;
}

/// Takes the group in, if it is near enough to all that the cluster's first one sweeps.
bool Contact::join(Cluster& cluster, std::size_t group, const Run& run) const {
  const Group& g = run.groups[group];
  std::array<double, kStrayRadii.size()> wide{};
  for (std::size_t k = 0; k < g.stretches.size(); ++k) {
    const double off = apart(cluster.hull[k].sheet, g.stretches[k]);
    if (off > kStrayRadii[k] * radius_) return false;
    wide[k] = off + g.stretches[k].wide;
  }
  for (std::size_t k = 0; k < g.stretches.size(); ++k)
    cluster.hull[k].wide = std::max(cluster.hull[k].wide, wide[k]);
  cluster.groups.push_back(group);
  return true;
}

/// Neighbouring passes run through the same cubes: their groups there look for patches together.
void Contact::cluster(Run& run) const {
  std::map<Cube, std::vector<std::size_t>> cubes;
  for (std::size_t i = 0; i < run.groups.size(); ++i) cubes[cube(*run.groups[i].begin)].push_back(i);
  const auto longer = [&](std::size_t a, std::size_t b) {
    return squared_length(run.groups[a].stretches[0].way) > squared_length(run.groups[b].stretches[0].way);
  };
  for (auto& [where, groups] : cubes) {
    std::stable_sort(groups.begin(), groups.end(), longer);
    const std::size_t first = run.clusters.size();
    for (const std::size_t i : groups) {
      bool known = false;
      for (std::size_t c = first; c < run.clusters.size() && !known; ++c)
        known = join(run.clusters[c], i, run);
      if (!known) run.clusters.push_back({run.groups[i].stretches, {i}});
    }
  }
}

/// The patches that the cluster may do something to, each once.
void Contact::gather(const Cluster& cluster, Run& run) const {
  FourSheets hull;
  for (std::size_t k = 0; k < cluster.hull.size(); ++k) {
    const Stretch& s = cluster.hull[k];
    hull.set(static_cast<int>(k), run.origin, s.foot, s.way, s.core, s.wide, radius_);
  }
  const Vec3 origin = from_origin(run.origin);
  run.found_patches.clear();
  probes_.search((1u << cluster.hull.size()) - 1u,
                 [&](Vec3 low, Vec3 high, double most, std::uint32_t which) {
                   const auto matters =
                       static_cast<float>(std::clamp(most, 0.0, probes_.reach()) + kBoundSlack);
                   return which & no_more(hull.distance((low + high) * 0.5 - origin, (high - low) * 0.5),
                                          all_lanes(matters));
                 },
                 [&](std::uint32_t patch, std::uint32_t which) {
                   const double most = std::min(probes_.reach(), probes_.highest(patch));
                   const FacetLanes facet(run.origin, probes_.patches(), patch);
                   const FourSheets::Left left = hull.left(facet, facet.middle, facet.radius);
                   which &= no_more(left.least, all_lanes(static_cast<float>(most)));
                   if (which != 0) run.found_patches.push_back({patch, which});
                 });
}

/// Brings those of the probes at hand to the front that the group may lower; how many they are.
std::size_t Contact::pick(const Candidate& candidate, const Facet& facet, Run& run) const {
  const Group& g = *candidate.group;
  const Stretch& lower = g.stretches.front();
  // Seen along the normal, all of the patch's probes are as high over the ball's way.
  const Vec3 n = facet.normal;
  const Point<Part> foot = lower.foot - n * dot(n, lower.foot - facet.middle);
  const Vec3 way = lower.way - n * dot(n, lower.way);
  const double per_way = squared_length(way) > 0.0 ? 1.0 / squared_length(way) : 0.0;
  const double base =
      dot(n, lower.foot - facet.middle) + std::min(0.0, dot(n, lower.way)) - g.stray - radius_;
  const auto by_ball = [&](const Probes::Live& l) {
    const double room = l.bound - base;
    if (room <= 0.0) return false;
    const Vec3 m = l.place - foot;
    const double beside2 = squared_length(m - way * std::clamp(dot(m, way) * per_way, 0.0, 1.0));
    const double within = std::min(radius_, std::sqrt(2.0 * radius_ * room)) + g.stray;
    return beside2 < within * within;
  };
  std::array<double, kStrayRadii.size()> least{};
  for (std::size_t k = 0; k < g.stretches.size() && candidate.takes.side; ++k)
    least[k] = core_least(g.stretches[k], facet);
  const auto wanted = [&](const Probes::Live& l) {
    if (candidate.takes.ball && by_ball(l)) return true;
    for (std::size_t k = 0; k < g.stretches.size() && candidate.takes.side; ++k)
      if (least[k] < l.bound && reaches(g.stretches[k], l.place, n, l.bound)) return true;
    return false;
  };
  return static_cast<std::size_t>(std::partition(run.live.begin(), run.live.end(), wanted) -
                                  run.live.begin());
}

}  // namespace tiltfeed::sim
