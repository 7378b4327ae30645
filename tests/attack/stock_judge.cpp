#include "tests/attack/stock_judge.h"

#include <algorithm>
#include <cmath>

#include "tests/attack/dice.h"

namespace tiltfeed::attack {
namespace {

/// Of the cutter's radius: places are so deep in it. Rapids that only graze stock are no finding.
constexpr double kDepth = 0.1;
/// Places of a rapid: along it, and in the cutter at each.
constexpr int kAlong = 4, kInCutter = 12;
/// A cutting move is looked at in steps of so many radii: they leave cusps of less than half of kDepth.
constexpr double kStep = 0.2;

}  // namespace

bool StockJudge::can_judge(const Job& job) {
  return job.plan.from_blank && job.blank && job.blank->shape == BlankShape::kBox;
}

StockJudge::StockJudge(const Job& job, const CheckedMesh& part, const ToolPath& executed)
    : job_(job),
      path_(executed),
      tool_(job.plan.cutter),
      blank_(part.bounds),
      depth_(std::max(kDepth * job.plan.cutter.radius(), job.plan.tolerance)) {
  const Vec3 margin{job.blank->margin, job.blank->margin, job.blank->margin};
  blank_.min = blank_.min - margin, blank_.max = blank_.max + margin;
}

bool StockJudge::in_blank(Point<Part> p) const {
  return p.x > blank_.min.x && p.x < blank_.max.x && p.y > blank_.min.y && p.y < blank_.max.y &&
         p.z > blank_.min.z && p.z < blank_.max.z;
}

/// Distance from the cutting part, drawn out along its axis; negative in it. Where shank and holder have to
/// pass is another matter than what rapids meet.
double StockJudge::off_cutter(Point<Part> p, const Pose& pose) const {
  const Vec3 off = p - pose.tip;
  const double h = dot(off, pose.axis), r = length(off - pose.axis * h);
  if (h > job_.plan.cutter.cutting_end()) return r - job_.plan.cutter.cutting_top_radius();
  return tool_.cutting().distance(r, h).value;
}

bool StockJudge::is_cut(Point<Part> p, std::size_t before) const {
  const double radius = job_.plan.cutter.cutting_top_radius();
  for (std::size_t i = before; i-- > 1;) {
    if (path_.moves[i].kind == MoveKind::kRapid) continue;
    const Pose &a = path_.moves[i - 1].pose, &b = path_.moves[i].pose;
    const Vec3 off = p - b.tip;
    const double turn = angle_between(a.axis, b.axis), way = distance(a.tip, b.tip) + turn * length(off);
    if (length(off - b.axis * dot(off, b.axis)) > radius + way) continue;
    const int steps = 1 + static_cast<int>(way / (kStep * job_.plan.cutter.radius()));
    for (int k = 0; k <= steps; ++k) {
      const double f = static_cast<double>(k) / steps;
      if (off_cutter(p, {lerp(a.tip, b.tip, f), slerp(a.axis, b.axis, f)}) < 0.5 * depth_) return true;
    }
  }
  return false;
}

StockJudge::Found StockJudge::look(std::size_t rapids) const {
  Found found;
  Dice dice(path_.moves.size());
  std::vector<std::size_t> all;
  for (std::size_t i = 1; i < path_.moves.size(); ++i)
    if (path_.moves[i].kind == MoveKind::kRapid) all.push_back(i);
  const Cutter& cutter = job_.plan.cutter;
  const double widest = std::max(cutter.radius(), cutter.cutting_top_radius());
  for (std::size_t n = 0; n < std::min(rapids, all.size()); ++n) {
    const std::size_t i = all.size() <= rapids ? all[n] : all[dice.below(all.size())];
    const Pose &a = path_.moves[i - 1].pose, &b = path_.moves[i].pose;
    for (int k = 1; k <= kAlong; ++k) {
      const double f = static_cast<double>(k) / kAlong;
      const Pose pose{lerp(a.tip, b.tip, f), slerp(a.axis, b.axis, f)};
      for (int j = 0; j < kInCutter; ++j) {
        const double h = cutter.cutting_end() * dice.unit() * dice.unit();
        const Vec3 way = dice.direction(), aside = way - pose.axis * dot(way, pose.axis);
        const Point<Part> p = pose.tip + pose.axis * h + aside * (widest * std::sqrt(dice.unit()));
        const double depth = -off_cutter(p, pose);
        if (depth < depth_ || !in_blank(p)) continue;
        ++found.places;
        if (is_cut(p, i)) continue;
        found.pose = pose, found.at = p, found.depth = depth;
        return found;
      }
    }
  }
  return found;
}

}  // namespace tiltfeed::attack
