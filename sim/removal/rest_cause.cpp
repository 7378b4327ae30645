#include "sim/removal/rest_cause.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/motion/forward.h"

namespace tiltfeed::sim {

PassDistances::PassDistances(const config::Job& job, const ExecutedPath& path) {
  const FrameChain chain(job.machine.model, job.setup);
  const double nose = job.plan.cutter.nose_radius();
  const auto put = [&](const Joints& joints, bool cuts) {
    Pose pose = chain(joints);
    pose.tip = pose.tip + pose.axis * nose;
    references_.push_back(pose), cuts_.push_back(cuts);
  };
  put(path.start, false);
  for (const ExecutedMove& move : path.moves) put(move.to, !move.rapid);
}

double PassDistances::apart(Point<Part> touching, std::uint32_t move, double farthest) const {
  const Pose &from = references_[move], &to = references_[move + 1];
  const Vec3 feed = to.tip - from.tip, across = cross(to.axis, feed);
  if (!(length(feed) > 0.0) || !(length(across) > 0.0)) return 0.0;
  const Vec3 along = normalized(feed), aside = normalized(across);
  // Of the places at which the path goes through the plane across the feed the nearest on either side.
  constexpr double kFar = std::numeric_limits<double>::infinity();
  double near[2] = {kFar, kFar};
  Point<Part> at[2];
  for (std::size_t i = 1; i < references_.size(); ++i) {
    if (!cuts_[i]) continue;
    const Vec3 a = references_[i - 1].tip - touching, b = references_[i].tip - touching;
    const double before = dot(a, along), behind = dot(b, along);
    if ((before < 0.0) == (behind < 0.0)) continue;
    const Point<Part> place = lerp(references_[i - 1].tip, references_[i].tip, before / (before - behind));
    const Vec3 off = place - touching;
    const std::size_t side = dot(off, aside) < 0.0 ? 0 : 1;
    if (const double away = length(off); away < std::min(farthest, near[side]))
      near[side] = away, at[side] = place;
  }
  return near[0] < kFar && near[1] < kFar ? distance(at[0], at[1]) : 0.0;
}

double left_between(const pathgen::Cutter& cutter, double apart) {
  const double radius = cutter.nose_radius() > 0.0 ? cutter.nose_radius() : cutter.radius();
  const double half = 0.5 * apart;
  return half >= radius ? radius : radius - std::sqrt(radius * radius - half * half);
}

}  // namespace tiltfeed::sim
