#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "sim/contact_run.h"
#include "sim/sheet.h"

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
  const Patches& patches = probes_.patches();
  run.found_patches.clear();
  for (std::size_t k = 0; k < cluster.hull.size(); ++k) {
    const Stretch& s = cluster.hull[k];
    const double near = s.wide + radius_;
    probes_.search(
        [&](Vec3 low, Vec3 high, double most) {
          const double within = near + std::clamp(most, 0.0, probes_.reach());
          return s.sheet.bound(low, high, within) < within;
        },
        [&](std::uint32_t patch) {
          const double most = std::min(probes_.reach(), probes_.highest(patch));
          if (reaches(s, patches.middle[patch], patches.normal[patch],
                      static_cast<double>(patches.radius[patch]), most))
            run.found_patches.push_back({patch, std::uint32_t{1} << k});
        });
  }
  if (cluster.hull.size() == 1) return;
  std::vector<Found>& found = run.found_patches;
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.patch < b.patch; });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (kept > 0 && found[kept - 1].patch == found[i].patch)
      found[kept - 1].stretches |= found[i].stretches;
    else
      found[kept++] = found[i];
  }
  found.resize(kept);
}

/// Those groups of the cluster that may do something to the patch, in the order of how much they may take.
void Contact::choose(const Cluster& cluster, const Facet& facet, std::uint32_t stretches, Run& run) const {
  const double most = std::min(probes_.reach(), probes_.highest(facet.patch));
  run.candidates.clear();
  for (const std::size_t i : cluster.groups) {
    const Group& g = run.groups[i];
    const double deep = g.step_stray - run.allowed(g), matters = std::max(most, deep);
    Candidate c{&g};
    const double ball = round_ && (stretches & 1) != 0 ? ball_least(g, facet) : kInfinity;
    if (ball < matters) c.ball = true, c.least = ball, c.touch = closed_ && ball < deep;
    if (!by_ball_alone(g, facet, most)) {
      for (std::size_t k = 0; k < g.stretches.size(); ++k) {
        if ((stretches >> k & 1) == 0) continue;
        const Stretch& s = g.stretches[k];
        const double least = core_least(s, facet);
        if (least >= matters || !reaches(s, facet.middle, facet.normal, facet.radius, most)) continue;
        c.side = true, c.least = std::min(c.least, least);
        c.touch |= closed_ && least < deep;
      }
    }
    if (c.ball || c.side) run.candidates.push_back(c);
  }
  std::sort(run.candidates.begin(), run.candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.least < b.least; });
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
  for (std::size_t k = 0; k < g.stretches.size() && candidate.side; ++k)
    least[k] = core_least(g.stretches[k], facet);
  const auto wanted = [&](const Probes::Live& l) {
    if (candidate.ball && by_ball(l)) return true;
    for (std::size_t k = 0; k < g.stretches.size() && candidate.side; ++k)
      if (least[k] < l.bound && reaches(g.stretches[k], l.place, n, 0.0, l.bound)) return true;
    return false;
  };
  return static_cast<std::size_t>(std::partition(run.live.begin(), run.live.end(), wanted) -
                                  run.live.begin());
}

}  // namespace tiltfeed::sim
