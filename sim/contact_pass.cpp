#include <algorithm>
#include <cmath>

#include "sim/contact_run.h"
#include "sim/sheet.h"

namespace tiltfeed::sim {

Contact::Seen Contact::see(const Group& g, std::uint32_t patch, double most) const {
  const Patches& patches = probes_.patches();
  Seen seen;
  seen.middle = patches.middle[patch], seen.normal = patches.normal[patch], seen.patch = patch;
  seen.radius = static_cast<double>(patches.radius[patch]);
  seen.rise = seen.radius * (length(cross(seen.normal, g.axis)) + g.turn);
  seen.offset = dot(seen.normal, from_origin(seen.middle)) + radius_;
  seen.faces = dot(seen.normal, g.axis) > g.turn;
  const double place = dot(seen.middle - g.begin->from.tip, g.along),
               wide = seen.radius + radius_ + std::max(0.0, most);
  seen.first = place - wide, seen.last = place + wide;
  return seen;
}

/// (R6) Steps that can do nothing to the patch are left out, and so are those that can take no more than what
/// another has taken: the one that may take most comes first.
void Contact::pass(const Candidate& candidate, const Group& group, Run& run) const {
  double most = std::min(probes_.reach(), probes_.highest(candidate.patch));
  const Seen c = see(group, candidate.patch, most);
  meet_steps(candidate, group, c, most, run);
  const auto lower = [](const Meeting& a, const Meeting& b) { return a.lowest < b.lowest; };
  const auto first = std::min_element(run.balls.begin(), run.balls.end(), lower);
  if (first != run.balls.end()) std::iter_swap(run.balls.begin(), first);
  for (const Meeting& ball : run.balls)
    if (ball.lowest < most)
      most = std::min(most, probes_.pass_ball(c.patch, ball.view->way, ball.view->step->move));
  for (const Meeting& side : run.sides) {
    const View& v = *side.view;
    // Is all that can matter nearer to the ball at the core's lower end than to the rest of it?
    const double height = std::max(dot(c.middle - v.step->from.tip, v.step->from.axis),
                                   dot(c.middle - v.step->to.tip, v.step->to.axis)) +
                          c.rise + v.slack + std::max(0.0, most) * std::max({0.0, side.up, side.up_end});
    if (round_ && std::min(side.up, side.up_end) > 0.0 && height <= low_) continue;
    if (side.lowest >= std::max(most, v.step->stray - run.allowed(v))) continue;
    pass_side(*side.view, c, side.lowest, most, run);
    most = std::min(most, probes_.highest(c.patch));
  }
}

/// The steps that may matter to a patch of which `most` is left: by their ball, and by the rest of the core.
void Contact::meet_steps(const Candidate& candidate, const Group& group, const Seen& c, double most,
                         Run& run) const {
  const double core = high_ - low_;
  run.balls.clear(), run.sides.clear();
  for (std::size_t i = group.first_view; i < group.end_view; ++i) {
    View& v = run.views[i];
    if (v.last < c.first || v.first > c.last) continue;
    // What can matter is left less than `most` above the patch, or is deeper in it than what is allowed.
    const double deep = v.step->stray - run.allowed(v), matters = std::max(most, deep);
    const double start = dot(c.normal, from_origin(v.from)) - c.offset,
                 end = dot(c.normal, from_origin(v.to)) - c.offset, lower = std::min(start, end);
    if (c.faces && lower >= matters) continue;
    if (candidate.side) {
      const double up = dot(c.normal, v.step->from.axis), up_end = dot(c.normal, v.step->to.axis);
      const double lowest = std::min({lower, start + up * core, end + up_end * core});
      if (lowest >= matters) continue;
      run.sides.push_back({&v, lowest, up, up_end});
    }
    if (!candidate.ball || lower >= matters || std::max(start, end) <= -2.0 * radius_) continue;
    const double gap = v.way.distance(c.middle) - radius_ - c.radius;
    if (closed_ && gap < deep && lower < deep) touch(v, c.patch, run);
    if (lower >= most || gap >= std::max(0.0, most)) continue;
    if (const double least = probes_.least(c.patch, v.way); least < most)
      run.balls.push_back({&v, least, 0.0, 0.0});
  }
}

/// A patch beside the tool, or any of a tool that is no ball.
void Contact::pass_side(View& view, const Seen& c, double lowest, double most, Run& run) const {
  const SweptStep& step = *view.step;
  const Vec3 axis = mean_axis(step.from, step.to);
  const Sheet sheet(view.from, view.to - view.from, axis * (high_ - low_));
  const double turn = length(step.to.axis - step.from.axis);
  // What a place on the core may be off the sheet grows with its height.
  const auto gap_at = [&](Point<Part> p, double far) {
    const double height = std::max(0.0, dot(p - view.from, axis)) + probes_.reach();
    return far - radius_ - turn * (height + far + sweep_.longest()) - step.stray;
  };
  // The sheet is convex: along the normal a line comes nearer to it by no more than `share` of its way.
  const auto least_at = [&](double gap, double share) {
    return gap <= 0.0 ? gap : share > 0.0 ? gap / share : kInfinity;
  };
  const Vec3 u = sheet.to(c.middle);
  const double far = length(u), gap = gap_at(c.middle, far) - c.radius;
  if (const double allowed = run.allowed(view); closed_ && gap < -allowed && lowest < step.stray - allowed)
    touch_side(view, c.patch, run);
  if (lowest >= most || least_at(gap, -dot(u, c.normal) / far) >= std::max(0.0, most)) return;
  probes_.pass(
      c.patch, radius_, step.move, [&](Point<Part> p) { return sweep_.cutter_near(step.from, step.to, p); },
      [&](Point<Part> p) {
        const Vec3 to = sheet.to(p);
        const double whole = length(to);
        return least_at(gap_at(p, whole), -dot(to, c.normal) / whole);
      });
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
void Contact::touch_side(View& view, std::uint32_t patch, Run& run) const {
  const SweptStep& step = *view.step;
  const Triangle& triangle = probes_.surface().triangle(patch);
  if (view.looks.empty()) {
    const int count = looks(step);
    for (int k = 1; k < count; ++k) view.looks.push_back(pose(step, static_cast<double>(k) / count));
    view.looks.push_back(step.to);
  }
  for (const Pose& p : view.looks) {
    const double near =
        std::sqrt(squared_distance(triangle, Segment{p.tip + p.axis * low_, p.tip + p.axis * high_}));
    if (radius_ - near > run.allowed(view))
      run.report(view, {ToolPart::kCutter, step.move, radius_ - near, patch, p.tip});
  }
}

}  // namespace tiltfeed::sim
