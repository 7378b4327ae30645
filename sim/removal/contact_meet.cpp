#include "sim/removal/contact.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/removal/contact_run.h"

namespace tiltfeed::sim {
namespace {

// Exact distances are taken at least every so many least radii, so that nothing is passed over.
constexpr double kLookRadii = 0.5;
// A part of the tool that is not in contact is looked for this many looks ahead.
constexpr double kLooksAhead = 8.0;
// One that is, is asked only whether it is too deep, for so many looks.
constexpr int kLooksInContact = 16;
// Looks at a point that seems to be cut into, for each look at the tool.
constexpr int kDepthLooks = 16, kMostDepthLooks = 4096;

/// About this share of `count`, without a divisor in common with it: steps of it visit all, evenly spread.
constexpr double kGoldenShare = 0.6180339887498949;
std::size_t stride_for(std::size_t count) {
  auto stride = static_cast<std::size_t>(kGoldenShare * static_cast<double>(count));
  while (std::gcd(++stride, count) != 1) {
  }
  return stride;
}

}  // namespace

Contact::Contact(const ExecutedPath& path, const FrameChain& chain, const ToolSolid& solid,
                 const ToolSweep& sweep, Probes& probes, double tolerance)
    : path_(path),
      chain_(chain),
      sweep_(sweep),
      probes_(probes),
      round_(sweep.round()),
      tolerance_(tolerance),
      radius_(sweep.reach()),
      low_(sweep.core_low()),
      high_(sweep.core_high()),
      top_(solid.top()),
      widest_(solid.widest()),
      look_(kLookRadii * solid.narrowest()) {
  const bool alone = !solid.has(ToolPart::kShank) && !solid.has(ToolPart::kHolder);
  const double end = solid.cutting().corners().back().h;
  closed_ = round_ && (alone || end >= low_ + radius_);
  if (closed_ && alone) high_ = std::max(low_, top_);
  if (!closed_)
    for (const Revolved& piece : solid.pieces(ToolPart::kCutter))
      watched_.emplace_back(ToolPart::kCutter, piece);
  else if (!alone)  // the core's upper end is round, the cutting part's is not
    watched_.emplace_back(ToolPart::kCutter, Revolved::from_rims({{radius_, high_}, {radius_, end}}));
  for (const ToolPart part : {ToolPart::kShank, ToolPart::kHolder})
    for (const Revolved& piece : solid.pieces(part)) watched_.emplace_back(part, piece);
}

Pose Contact::pose(const SweptStep& step, double f) const {
  return chain_(
      between(path_.from(step.move), path_.moves[step.move].to, step.begin + (step.end - step.begin) * f));
}

/// No point of the tool moves further, where its ends move straight.
double Contact::travel(const Pose& from, const Pose& to) const {
  return std::max(distance(from.tip, to.tip),
                  distance(from.tip + from.axis * top_, to.tip + to.axis * top_)) +
         widest_ * length(to.axis - from.axis);
}

int Contact::looks(const SweptStep& step) const {
  return std::max(2, static_cast<int>(std::ceil(travel(step.from, step.to) / look_)));
}

/// Parts of the tool that the core does not cover: how far each was last found from the part, less how far it
/// has moved since, says whether it needs a look.
void Contact::watch(View& view, Run& run) const {
  const SweptStep& step = *view.step;
  const double far = travel(step.from, step.to) + 2.0 * step.stray;
  run.poses.clear();
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Watch& w = run.watches[i];
    if (w.free - far >= -run.allowed(view)) {
      w.free -= far;
      continue;
    }
    if (run.poses.empty()) {
      const int count = looks(step);
      for (int k = 0; k < count; ++k) run.poses.push_back(pose(step, static_cast<double>(k) / count));
      run.poses.push_back(step.to);
    }
    for (std::size_t k = 1; k < run.poses.size(); ++k) {
      const double moved = travel(run.poses[k - 1], run.poses[k]);
      w.free -= moved;
      if (w.free >= -run.allowed(view)) continue;
      const double bound = w.in_contact > 0 ? -run.allowed(view) : std::max(kLooksAhead * look_, 4.0 * moved);
      const Hit hit = clearance(probes_.surface(), watched_[i].second, run.poses[k], bound);
      w.free = hit.facet == kNoFacet ? bound : hit.value;
      if (w.in_contact > 0)
        --w.in_contact;
      else if (w.free < 2.0 * moved)
        w.in_contact = kLooksInContact;
      if (w.free < -run.allowed(view))
        run.report(view, {watched_[i].first, step.move, -w.free, hit.facet, run.poses[k].tip});
    }
  }
}

double Contact::depth(std::uint32_t move, Point<Part> p) const {
  const SweptStep whole{move, 0.0, 1.0, 0.0, chain_(path_.from(move)), chain_(path_.moves[move].to)};
  const int count = std::min(kDepthLooks * looks(whole), kMostDepthLooks);
  double depth = -kInfinity;
  for (int k = 0; k <= count; ++k) {
    const Pose at = pose(whole, static_cast<double>(k) / count);
    if (closed_)
      depth = std::max(depth,
                       radius_ - distance_to_segment(p, at.tip + at.axis * low_, at.tip + at.axis * high_));
    const double h = dot(p - at.tip, at.axis), r = length(p - at.tip - at.axis * h);
    for (const auto& [part, solid] : watched_) depth = std::max(depth, -solid.distance(r, h).value);
  }
  return depth;
}

Contacts Contact::meet(const std::vector<SweptStep>& steps) const {
  Run run;
  run.tolerance = tolerance_, run.deepest = &deepest_;
  run.watches.resize(watched_.size());
  run.views.reserve(steps.size());
  for (std::size_t begin = 0; begin < steps.size();) {
    const std::size_t end = group_end(steps, begin);
    run.groups.push_back(group(&steps[begin], steps.data() + end));
    view(run.groups.back(), run.views);
    begin = end;
  }
  cluster(run);
  // Far from each other one after the other: what later ones can take is then soon known to be little.
  const std::size_t count = run.clusters.size(), stride = stride_for(count);
  for (std::size_t i = 0, at = 0; i < count; ++i, at = (at + stride) % count) {
    line_up(run.clusters[at], run);
    gather(run.clusters[at], run);
    for (const Found& found : run.found_patches) pass(found, run);
  }
  for (View& v : run.views) {
    watch(v, run);
    if (v.deepest.depth > tolerance_) run.found.overlaps.push_back(v.deepest);
  }
  return run.found;
}

}  // namespace tiltfeed::sim
