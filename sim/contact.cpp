#include "sim/contact.h"

#include <algorithm>
#include <cmath>

#include "sim/sheet.h"

namespace tiltfeed::sim {
namespace {

// Exact distances are taken at least every so many least radii, so that nothing is passed over.
constexpr double kLookRadii = 0.5;
// Steps that share their candidates: so many at most, so many radii long, turning the tool's end by so many.
constexpr std::size_t kGroupSteps = 32;
constexpr double kGroupRadii = 8.0, kGroupTurnRadii = 0.5;
// A part of the tool that is not in contact is looked for this many looks ahead.
constexpr double kLooksAhead = 8.0;
// One that is, is asked only whether it is too deep, for so many looks.
constexpr int kLooksInContact = 16;
// A ball that may be too deep is looked at along so many straight pieces of its way: what they stray is the
// square of this less than what the step does.
constexpr int kWays = 4;
// Looks at a point that seems to be cut into, for each look at the tool.
constexpr int kDepthLooks = 16, kMostDepthLooks = 4096;

}  // namespace

/// A patch that the steps of a group may come near to.
struct Contact::Candidate {
  Point<Part> middle;
  Vec3 normal;
  double radius = 0.0;  ///< mm
  double rise = 0.0;    ///< how far it reaches along the tool's axis from its middle, mm
  double offset = 0.0;  ///< of its plane
  bool faces = false;   ///< the tool's axis points away from it in all of the group
  std::uint32_t patch = 0;
};

/// What is known of a part of the tool that is far from contact, or in it.
struct Contact::Watch {
  double free = -kInfinity;  ///< it is at least so far from the part, mm
  int in_contact = 0;        ///< looks that only ask whether it is too deep
};

struct Contact::Run {
  Contacts found;
  std::vector<Candidate> candidates;
  std::vector<Watch> watches;
  std::vector<Pose> poses;  ///< of the step's looks
  std::vector<Pose> ways;   ///< ends of pieces of the step
  Overlap deepest;          ///< of the step
  double* worst = nullptr;
  double allowed = 0.0;  ///< what is not deeper does not matter, mm
  void report(const Overlap& overlap, double tolerance) {
    *worst = std::max(*worst, overlap.depth), allowed = std::min(*worst, tolerance);
    if (overlap.depth > deepest.depth) deepest = overlap;
  }
};

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

std::size_t Contact::group_end(const std::vector<SweptStep>& steps, std::size_t begin) const {
  const Pose& first = steps[begin].from;
  std::size_t end = begin + 1;
  double way = distance(first.tip, steps[begin].to.tip);
  for (; end < steps.size() && end - begin < kGroupSteps; ++end) {
    way += distance(steps[end].from.tip, steps[end].to.tip);
    if (way > kGroupRadii * radius_) break;
    if (length(steps[end].to.axis - first.axis) * (high_ - low_) > kGroupTurnRadii * radius_) break;
  }
  return end;
}

/// The patches within reach of the sheet that the core sweeps, widened by what the steps stray from it.
void Contact::gather(const SweptStep* begin, const SweptStep* end, std::vector<Candidate>& candidates) const {
  const auto at = [](const Pose& p, double h) { return p.tip + p.axis * h; };
  const Pose &first = begin->from, &last = (end - 1)->to;
  const Vec3 axis = mean_axis(first, last);
  const Sheet sheet(at(first, low_), at(last, low_) - at(first, low_), axis * (high_ - low_));
  double stray = 0.0, turn = 0.0;
  for (const SweptStep* s = begin; s != end; ++s) {
    for (const Pose& p : {s->from, s->to}) {
      const Point<Part> on = sheet.on_way(at(p, low_));
      stray =
          std::max({stray, distance(at(p, low_), on), distance(at(p, high_), on + axis * (high_ - low_))});
      turn = std::max(turn, length(p.axis - axis));
    }
    stray = std::max(stray, s->stray);
  }
  // The pieces of the sweep have the mean axis of their step.
  const double within = radius_ + probes_.reach() + stray + turn * sweep_.longest();
  const Patches& patches = probes_.patches();
  candidates.clear();
  double bound = within;
  probes_.surface().search(
      bound, kNoFacet, [&](Vec3 low, Vec3 high) { return sheet.bound(low, high, within); },
      [&](const Triangle& t) {
        const Point<Part> middle = patches.middle[t.facet];
        const double radius = static_cast<double>(patches.radius[t.facet]);
        if (length(sheet.to(middle)) > within + radius) return;
        const Vec3 n = patches.normal[t.facet];
        candidates.push_back({middle, n, radius, radius * (length(cross(n, axis)) + turn),
                              dot(n, from_origin(middle)) + radius_, dot(n, axis) > turn, t.facet});
      });
}

/// (R6) Patches that nothing can come of are left out.
void Contact::pass(const SweptStep& step, Run& run) const {
  const Point<Part> from = step.from.tip + step.from.axis * low_, to = step.to.tip + step.to.axis * low_;
  const double slack = length(step.to.axis - step.from.axis) * distance(from, to), core = high_ - low_;
  const BallWay way(from, to, radius_);
  for (const Candidate& c : run.candidates) {
    // What can matter is left less than `most` above the patch, or is deeper in it than `allowed`.
    double most = std::min(probes_.reach(), probes_.highest(c.patch));
    const double deep = step.stray - run.allowed;
    const double start = dot(c.normal, from_origin(from)) - c.offset,
                 end = dot(c.normal, from_origin(to)) - c.offset, lower = std::min(start, end);
    if (c.faces && lower >= std::max(most, deep)) continue;
    const double up = dot(c.normal, step.from.axis), up_end = dot(c.normal, step.to.axis);
    const double lowest = std::min({lower, start + up * core, end + up_end * core});
    if (lowest >= std::max(most, deep)) continue;
    if (round_ && lower < std::max(most, deep) && std::max(start, end) > -2.0 * radius_) {
      const double gap = way.distance(c.middle) - radius_ - c.radius;
      if (closed_ && gap < deep && lower < deep) touch(step, c.patch, run);
      if (lower < most && gap < std::max(0.0, most))
        most = std::min(most, probes_.pass_ball(c.patch, way, step.move));
    }
    // Is all that can matter nearer to the ball at the core's lower end than to the rest of it?
    const double height =
        std::max(dot(c.middle - step.from.tip, step.from.axis), dot(c.middle - step.to.tip, step.to.axis)) +
        c.rise + slack + std::max(0.0, most) * std::max({0.0, up, up_end});
    if (round_ && std::min(up, up_end) > 0.0 && height <= low_) continue;
    if (lowest < std::max(most, deep)) pass_side(step, c, lowest, most, run);
  }
}

/// A patch beside the tool, or any of a tool that is no ball.
void Contact::pass_side(const SweptStep& step, const Candidate& c, double lowest, double most,
                        Run& run) const {
  const Vec3 axis = mean_axis(step.from, step.to);
  const Point<Part> from = step.from.tip + step.from.axis * low_, to = step.to.tip + step.to.axis * low_;
  const Sheet sheet(from, to - from, axis * (high_ - low_));
  const double turn = length(step.to.axis - step.from.axis);
  // What a place on the core may be off the sheet grows with its height.
  const auto nearest = [&](Point<Part> p) {
    const double far = length(sheet.to(p));
    return far - radius_ - turn * (std::max(0.0, dot(p - from, axis)) + far + sweep_.longest()) - step.stray;
  };
  const double gap = nearest(c.middle) - c.radius;
  if (closed_ && gap < -run.allowed && lowest < step.stray - run.allowed) touch_side(step, c.patch, run);
  if (gap >= std::max(0.0, most) || lowest >= most) return;
  probes_.pass(
      c.patch, radius_, step.move, [&](Point<Part> p) { return sweep_.cutter_near(step.from, step.to, p); },
      nearest);
}

/// The ball along the step: bounded by its straight way, and where that may be too deep, by pieces of the
/// true one.
void Contact::touch(const SweptStep& step, std::uint32_t patch, Run& run) const {
  const Triangle& triangle = probes_.surface().triangle(patch);
  const auto ball = [&](const Pose& p) { return p.tip + p.axis * low_; };
  const double near = std::sqrt(squared_distance(triangle, Segment{ball(step.from), ball(step.to)}));
  if (radius_ - near <= run.allowed - step.stray) return;
  if (run.ways.empty()) {
    run.ways.push_back(step.from);
    for (int k = 1; k < kWays; ++k) run.ways.push_back(pose(step, static_cast<double>(k) / kWays));
    run.ways.push_back(step.to);
  }
  std::array<double, kWays> squares{};
  for (std::size_t k = 0; k < kWays; ++k)
    squares[k] = squared_distance(triangle, Segment{ball(run.ways[k]), ball(run.ways[k + 1])});
  const auto least = std::min_element(squares.begin(), squares.end());
  const double depth = radius_ - std::sqrt(*least);
  if (depth <= run.allowed) return;
  const Pose middle = pose(step, (static_cast<double>(least - squares.begin()) + 0.5) / kWays);
  run.report({ToolPart::kCutter, step.move, depth, patch, middle.tip}, tolerance_);
}

/// The core, at poses that are near enough to each other.
void Contact::touch_side(const SweptStep& step, std::uint32_t patch, Run& run) const {
  const Triangle& triangle = probes_.surface().triangle(patch);
  const int count = looks(step);
  for (int k = 1; k <= count; ++k) {
    const Pose p = k == count ? step.to : pose(step, static_cast<double>(k) / count);
    const double near =
        std::sqrt(squared_distance(triangle, Segment{p.tip + p.axis * low_, p.tip + p.axis * high_}));
    if (radius_ - near > run.allowed)
      run.report({ToolPart::kCutter, step.move, radius_ - near, patch, p.tip}, tolerance_);
  }
}

/// Parts of the tool that the core does not cover: how far each was last found from the part, less how far it
/// has moved since, says whether it needs a look.
void Contact::watch(const SweptStep& step, Run& run) const {
  const double far = travel(step.from, step.to) + 2.0 * step.stray;
  run.poses.clear();
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Watch& w = run.watches[i];
    if (w.free - far >= -run.allowed) {
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
      if (w.free >= -run.allowed) continue;
      const double bound = w.in_contact > 0 ? -run.allowed : std::max(kLooksAhead * look_, 4.0 * moved);
      const Hit hit = clearance(probes_.surface(), watched_[i].second, run.poses[k], bound);
      w.free = hit.facet == kNoFacet ? bound : hit.value;
      if (w.in_contact > 0)
        --w.in_contact;
      else if (w.free < 2.0 * moved)
        w.in_contact = kLooksInContact;
      if (w.free < -run.allowed)
        run.report({watched_[i].first, step.move, -w.free, hit.facet, run.poses[k].tip}, tolerance_);
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
  run.watches.resize(watched_.size());
  for (std::size_t begin = 0; begin < steps.size();) {
    const std::size_t end = group_end(steps, begin);
    gather(&steps[begin], steps.data() + end, run.candidates);
    for (; begin < end; ++begin) {
      const SweptStep& step = steps[begin];
      run.worst = &run.found.worst[path_.moves[step.move].rapid ? 1 : 0];
      run.allowed = std::min(*run.worst, tolerance_);
      run.deepest = {};
      run.ways.clear();
      pass(step, run);
      watch(step, run);
      if (run.deepest.depth > tolerance_) run.found.overlaps.push_back(run.deepest);
    }
  }
  return run.found;
}

}  // namespace tiltfeed::sim
