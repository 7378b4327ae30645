#include <algorithm>
#include <cmath>

#include "sim/removal/contact_run.h"
#include "sim/removal/sheet.h"

namespace tiltfeed::sim {

/// `middle`, `radius`: of the part of the patch that matters, `most` above it.
Contact::Seen Contact::see(const Group& g, const Facet& facet, Point<Part> middle, double radius,
                           double most) const {
  Seen seen;
  seen.middle = middle, seen.radius = radius, seen.patch = facet.patch;
  seen.normal = facet.normal;
  seen.rise = seen.radius * (length(cross(seen.normal, g.axis)) + g.turn);
  seen.offset = dot(seen.normal, from_origin(facet.middle)) + radius_;
  seen.faces = dot(seen.normal, g.axis) > g.turn;
  const double place = dot(seen.middle - g.begin->from.tip, g.along),
               wide = seen.radius + radius_ + std::max(0.0, most);
  seen.first = place - wide, seen.last = place + wide;
  return seen;
}

/// The part of the patch that holds the probes at hand.
Contact::Seen Contact::see_live(const Group& g, const Facet& facet, double most,
                                std::span<const Probes::Live> live) const {
  Vec3 sum;
  for (const Probes::Live& l : live) sum = sum + from_origin(l.place);
  const Point<Part> middle = Point<Part>{} + sum / static_cast<double>(live.size());
  double radius = 0.0;
  for (const Probes::Live& l : live) radius = std::max(radius, distance(middle, l.place));
  return see(g, facet, middle, radius + kBoundSlack, most);
}

/// (W6) Groups that can do nothing to the patch are left out, and so are those that can take no more than
/// what another has taken: the one that may take most comes first.
void Contact::pass(const Found& found, Run& run) const {
  const std::uint32_t patch = found.patch;
  const Facet facet(probes_.patches(), probes_.surface().triangle(patch), patch);
  choose(facet, found.stretches, run);
  const auto bound = [&] {
    double most = -kInfinity;
    for (const Probes::Live& l : run.live) most = std::max(most, l.bound);
    return most;
  };
  bool passed = false;
  double most = bound();
  for (const Candidate& candidate : run.candidates) {
    if (candidate.touches) touch_steps(candidate, facet, run);
    if (candidate.takes && candidate.least < most && pass_steps(candidate, facet, run))
      passed = true, most = bound();
  }
  if (passed) probes_.settle(patch);
}

/// The same for the steps of a group. Did any pass the patch's probes?
bool Contact::pass_steps(const Candidate& candidate, const Facet& facet, Run& run) const {
  const std::span<Probes::Live> live(run.live.data(), pick(candidate, facet, run));
  if (live.empty()) return false;
  double most = -kInfinity;
  for (const Probes::Live& l : live) most = std::max(most, l.bound);
  const Seen c = see_live(*candidate.group, facet, most, live);
  meet_steps(candidate, c, most, run);
  const auto lower = [](const Meeting& a, const Meeting& b) { return a.lowest < b.lowest; };
  const auto first = std::min_element(run.balls.begin(), run.balls.end(), lower);
  if (first != run.balls.end()) std::iter_swap(run.balls.begin(), first);
  for (const Meeting& ball : run.balls)
    if (ball.lowest < most) most = probes_.pass_ball(c.patch, ball.view->way, ball.view->step->move, live);
  for (const Meeting& side : run.sides)
    if (side.lowest < most && !nearest_is_ball(*side.view, c, most, side.up, side.up_end))
      most = pass_side(*side.view, c, most, live);
  return !run.balls.empty() || !run.sides.empty();
}

/// Is all that can matter nearer to the ball at the core's lower end than to the rest of it?
bool Contact::nearest_is_ball(const View& v, const Seen& c, double most, double up, double up_end) const {
  if (!round_ || std::min(up, up_end) <= 0.0) return false;
  const double height = std::max(dot(c.middle - v.step->from.tip, v.step->from.axis),
                                 dot(c.middle - v.step->to.tip, v.step->to.axis)) +
                        c.rise + v.slack + std::max(0.0, most) * std::max({0.0, up, up_end});
  return height <= low_;
}

/// The steps that may be deeper in a patch than what is allowed: by their ball, and by the rest of the core.
void Contact::touch_steps(const Candidate& candidate, const Facet& facet, Run& run) const {
  const Group& group = *candidate.group;
  const double core = high_ - low_;
  const Seen c = see(group, facet, facet.middle, facet.radius, 0.0);
  for (std::size_t i = group.first_view; i < group.end_view; ++i) {
    View& v = run.views[i];
    if (v.last < c.first || v.first > c.last) continue;
    const double start = dot(c.normal, from_origin(v.from)) - c.offset,
                 end = dot(c.normal, from_origin(v.to)) - c.offset, lower = std::min(start, end);
    const auto deep = [&] { return v.step->stray - run.allowed(v); };
    if (candidate.touches.ball && lower < deep() && std::max(start, end) > -2.0 * radius_ &&
        facet.meets(Segment{v.from, v.to}, radius_ + deep()))
      touch(v, c.patch, run);
    if (!candidate.touches.side || (c.faces && lower >= deep())) continue;
    const double up = dot(c.normal, v.step->from.axis), up_end = dot(c.normal, v.step->to.axis);
    if (std::min({lower, start + up * core, end + up_end * core}) < deep() &&
        !nearest_is_ball(v, c, 0.0, up, up_end) && facet.meets(v.corners(core), radius_ + deep()))
      touch_side(v, facet, run);
  }
}

/// The steps that may leave less than `most` on probes of a patch: by their ball, by the rest of the core.
void Contact::meet_steps(const Candidate& candidate, const Seen& c, double most, Run& run) const {
  const Group& group = *candidate.group;
  const double core = high_ - low_;
  run.balls.clear(), run.sides.clear();
  for (std::size_t i = group.first_view; i < group.end_view; ++i) {
    View& v = run.views[i];
    if (v.last < c.first || v.first > c.last) continue;
    const double start = dot(c.normal, from_origin(v.from)) - c.offset,
                 end = dot(c.normal, from_origin(v.to)) - c.offset, lower = std::min(start, end);
    if (c.faces && lower >= most) continue;
    if (candidate.takes.side) {
      const double up = dot(c.normal, v.step->from.axis), up_end = dot(c.normal, v.step->to.axis);
      const double lowest = std::min({lower, start + up * core, end + up_end * core});
      if (lowest >= most) continue;
      run.sides.push_back({&v, lowest, up, up_end});
    }
    if (!candidate.takes.ball || lower >= most || std::max(start, end) <= -2.0 * radius_) continue;
    if (v.way.distance(c.middle) - radius_ - c.radius >= std::max(0.0, most)) continue;
    if (const double least = least_left(v.way, c.middle, c.normal, c.radius); least < most)
      run.balls.push_back({&v, least, 0.0, 0.0});
  }
}

namespace {

/// What the core of a step sweeps, all of it.
struct StepSheet {
  Sheet sheet;
  Point<Part> from;
  Vec3 axis;
  double turn, stray, radius, most;  ///< most: that a place off the core may be higher than where it is asked

  StepSheet(const SweptStep& step, Point<Part> low, Point<Part> low_end, double core, double ball,
            double the_most)
      : sheet(low, low_end - low, mean_axis(step.from, step.to) * core),
        from(low),
        axis(mean_axis(step.from, step.to)),
        turn(length(step.to.axis - step.from.axis)),
        stray(step.stray),
        radius(ball),
        most(the_most) {}

  /// Not more than the distance of p from the tool, `far` from the sheet. What a place on the core may be off
  /// the sheet grows with its height.
  double gap(Point<Part> p, double far) const {
    return far - radius - turn * (std::max(0.0, dot(p - from, axis)) + far + most) - stray;
  }
};

}  // namespace

/// A patch beside the tool, or any of a tool that is no ball.
double Contact::pass_side(const View& view, const Seen& c, double most, std::span<Probes::Live> live) const {
  const SweptStep& step = *view.step;
  const StepSheet core(step, view.from, view.to, high_ - low_, radius_, probes_.reach() + sweep_.longest());
  // The sheet is convex: along the normal a line comes nearer to it by no more than `share` of its way.
  const auto least_at = [&](Point<Part> p, double radius) {
    const Vec3 u = core.sheet.to(p);
    const double far = length(u), gap = core.gap(p, far) - radius, towards = -dot(u, c.normal);
    return gap <= 0.0 ? gap : towards > 0.0 ? gap * far / towards : kInfinity;
  };
  if (least_at(c.middle, c.radius) >= std::max(0.0, most)) return most;
  return probes_.pass(
      c.patch, radius_, step.move, live,
      [&](Point<Part> p) { return sweep_.cutter_near(step.from, step.to, p); },
      [&](Point<Part> p) { return least_at(p, 0.0); });
}

/// The ball along the step: bounded by its straight way, and where that may be too deep, by pieces of the
/// true one.
void Contact::touch(View& view, std::uint32_t patch, Run& run) const {
  const SweptStep& step = *view.step;
  const Triangle& triangle = probes_.surface().triangle(patch);
  const auto ball = [&](const Pose& p) { return p.tip + p.axis * low_; };
  const double near = std::sqrt(squared_distance(triangle, Segment{view.from, view.to}));
  if (radius_ - near <= run.allowed(view) - step.stray) return;
  if (view.ways.empty()) {
    view.ways.push_back(step.from);
    for (int k = 1; k < kWays; ++k) view.ways.push_back(pose(step, static_cast<double>(k) / kWays));
    view.ways.push_back(step.to);
  }
  std::array<double, kWays> squares{};
  for (std::size_t k = 0; k < kWays; ++k)
    squares[k] = squared_distance(triangle, Segment{ball(view.ways[k]), ball(view.ways[k + 1])});
  const auto least = std::min_element(squares.begin(), squares.end());
  const double depth = radius_ - std::sqrt(*least);
  if (depth <= run.allowed(view)) return;
  const Pose middle = pose(step, (static_cast<double>(least - squares.begin()) + 0.5) / kWays);
  run.report(view, {ToolPart::kCutter, step.move, depth, patch, middle.tip});
}

/// The core, at poses that are near enough to each other.
void Contact::touch_side(View& view, const Facet& facet, Run& run) const {
  const SweptStep& step = *view.step;
  const Triangle& triangle = probes_.surface().triangle(facet.patch);
  if (view.looks.empty()) {
    const int count = looks(step);
    for (int k = 1; k < count; ++k) view.looks.push_back(pose(step, static_cast<double>(k) / count));
    view.looks.push_back(step.to);
  }
  for (const Pose& p : view.looks) {
    const Segment look{on_axis(p, low_), on_axis(p, high_)};
    if (!facet.meets(look, radius_ - run.allowed(view))) continue;
    const double near = std::sqrt(squared_distance(triangle, look));
    if (radius_ - near > run.allowed(view))
      run.report(view, {ToolPart::kCutter, step.move, radius_ - near, facet.patch, p.tip});
  }
}

}  // namespace tiltfeed::sim
