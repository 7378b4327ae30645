#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "sim/contact_run.h"
#include "sim/sheet.h"

namespace tiltfeed::sim {
namespace {

// Groups that look for patches together: their lower stretches and the others stray from those of the longest
// of them by so many radii at most.
constexpr double kStrayRadii[2] = {1.0, 3.0};

}  // namespace

/// How far any point of the stretch is from the sheet: the distance from a convex set is a convex function,
/// largest at a corner of the parallelogram.
double Contact::apart(const Sheet& sheet, const Stretch& s) const {
  double most = 0.0;
  for (const Point<Part> corner : {s.foot, s.foot + s.way, s.foot + s.core, s.foot + s.way + s.core})
    most = std::max(most, length(sheet.to(corner)));
  return most;
}

/// Takes the group in, if it is near enough to all that the cluster's first one sweeps.
bool Contact::join(Cluster& cluster, std::size_t group, const Run& run) const {
  const Group& g = run.groups[group];
  std::array<double, 2> wide{};
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
  run.patches.clear();
  for (const Stretch& s : cluster.hull) {
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
            run.patches.push_back(patch);
        });
  }
  if (cluster.hull.size() == 1) return;
  std::sort(run.patches.begin(), run.patches.end());
  run.patches.erase(std::unique(run.patches.begin(), run.patches.end()), run.patches.end());
}

/// Those groups of the cluster that may do something to the patch; the one that may take most comes first.
void Contact::choose(const Cluster& cluster, std::uint32_t patch, Run& run) const {
  const Patches& patches = probes_.patches();
  const Point<Part> middle = patches.middle[patch];
  const Vec3 normal = patches.normal[patch];
  const double radius = static_cast<double>(patches.radius[patch]),
               most = std::min(probes_.reach(), probes_.highest(patch));
  run.candidates.clear();
  for (const std::size_t i : cluster.groups) {
    const Group& g = run.groups[i];
    const double deep = g.step_stray - run.allowed(g), matters = std::max(most, deep);
    Candidate c{&g, patch};
    const double ball = round_ ? ball_least(g, middle, normal, radius) : kInfinity;
    if (ball < matters) c.ball = true, c.least = ball, c.touch = closed_ && ball < deep;
    if (!by_ball_alone(g, patch, most)) {
      for (const Stretch& s : g.stretches) {
        const double plane = plane_least(s, patch);
        if (plane >= matters || !reaches(s, middle, normal, radius, most)) continue;
        c.side = true, c.least = std::min(c.least, plane);
        c.touch |= closed_ && plane < deep;
      }
    }
    if (c.ball || c.side) run.candidates.push_back(c);
  }
  const auto first =
      std::min_element(run.candidates.begin(), run.candidates.end(),
                       [](const Candidate& a, const Candidate& b) { return a.least < b.least; });
  if (first != run.candidates.end()) std::iter_swap(run.candidates.begin(), first);
}

/// Brings those of the probes at hand to the front that the group may lower; how many they are.
std::size_t Contact::pick(const Candidate& candidate, Run& run) const {
  const Group& g = *candidate.group;
  const Vec3 normal = probes_.patches().normal[candidate.patch];
  std::array<double, 2> least{};
  for (std::size_t k = 0; k < g.stretches.size(); ++k)
    least[k] = plane_least(g.stretches[k], candidate.patch);
  const auto wanted = [&](const Probes::Live& l) {
    for (std::size_t k = 0; k < g.stretches.size(); ++k) {
      if (least[k] >= l.bound || (k > 0 && !candidate.side)) continue;
      if (k == 0 && !candidate.side && ball_least(g, l.place, normal, 0.0) >= l.bound) continue;
      if (reaches(g.stretches[k], l.place, normal, 0.0, l.bound)) return true;
    }
    return false;
  };
  return static_cast<std::size_t>(std::partition(run.live.begin(), run.live.end(), wanted) -
                                  run.live.begin());
}

}  // namespace tiltfeed::sim
