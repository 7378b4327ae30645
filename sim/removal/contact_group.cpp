#include <algorithm>
#include <cmath>

#include "sim/removal/contact_run.h"
#include "sim/removal/sheet.h"

namespace tiltfeed::sim {
namespace {

// Steps that are taken together: so many at most, within a cube of so many radii, turning the ends of the
// core's lower part and of all of it by so many.
constexpr std::size_t kGroupSteps = 32;
constexpr double kFootTurnRadii = 0.5, kTopTurnRadii = 2.0;
// And with ends of steps that are off the straight way by so many radii.
constexpr double kBendRadii = 0.1;
// The core's lower part, and what is told from the rest above it, in radii: what is beside them is looked for
// closely, as it turns less far.
constexpr double kFootRadii = 2.0, kMiddleRadii = 8.0;

}  // namespace

Cube Contact::cube(const SweptStep& step) const {
  return cube_at(on_axis(step.from, low_), kCubeRadii * radius_);
}

std::size_t Contact::group_end(const std::vector<SweptStep>& steps, std::size_t begin) const {
  const Pose& first = steps[begin].from;
  const Cube where = cube(steps[begin]);
  const double foot = std::min(high_, low_ + kFootRadii * radius_);
  const Point<Part> start = on_axis(first, low_);
  double way = distance(start, on_axis(steps[begin].to, low_));
  std::size_t end = begin + 1;
  for (; end < steps.size() && end - begin < kGroupSteps && cube(steps[end]) == where; ++end) {
    const double turn = length(steps[end].to.axis - first.axis);
    if (turn * (foot - low_) > kFootTurnRadii * radius_ || turn * (high_ - low_) > kTopTurnRadii * radius_)
      break;
    // What the way goes more than straight on: it then strays by no more than root(way^2 - straight^2) / 2.
    way += distance(on_axis(steps[end].from, low_), on_axis(steps[end].to, low_));
    const double straight = distance(start, on_axis(steps[end].to, low_));
    if (way * way - straight * straight > 4.0 * kBendRadii * kBendRadii * radius_ * radius_) break;
  }
  return end;
}

Contact::Stretch Contact::stretch(const Group& g, double low, double high) const {
  const Pose &first = g.begin->from, &last = (g.end - 1)->to;
  Stretch made(on_axis(first, low), on_axis(last, low) - on_axis(first, low), g.axis * (high - low));
  double stray = g.step_stray;
  for (const SweptStep* s = g.begin; s != g.end; ++s) {
    for (const Pose& p : {s->from, s->to}) {
      const Point<Part> on = made.sheet.on_way(on_axis(p, low));
      stray = std::max({stray, distance(on_axis(p, low), on), distance(on_axis(p, high), on + made.core)});
    }
  }
  // The pieces of the sweep have the mean axis of their step.
  made.wide = stray + g.step_turn * sweep_.longest();
  return made;
}

Contact::Group Contact::group(const SweptStep* begin, const SweptStep* end) const {
  const Pose &first = begin->from, &last = (end - 1)->to;
  Group g;
  g.begin = begin, g.end = end;
  g.axis = mean_axis(first, last);
  for (const SweptStep* s = begin; s != end; ++s) {
    g.turn = std::max({g.turn, length(s->from.axis - g.axis), length(s->to.axis - g.axis)});
    g.step_stray = std::max(g.step_stray, s->stray);
    g.step_turn = std::max(g.step_turn, length(s->to.axis - s->from.axis));
  }
  double from = low_;
  for (const double to : {low_ + kFootRadii * radius_, low_ + kMiddleRadii * radius_, high_}) {
    const double end_height = std::min(to, high_);
    if (g.stretches.empty() || end_height > from) g.stretches.push_back(stretch(g, from, end_height));
    from = end_height;
  }
  const Stretch& lower = g.stretches.front();
  const Vec3 across = lower.way - g.axis * dot(lower.way, g.axis);
  if (squared_length(across) > 0.0) g.along = normalized(across);
  g.stray = g.step_stray;
  for (const SweptStep* s = begin; s != end; ++s)
    g.stray = std::max(g.stray, distance(on_axis(s->to, low_), lower.sheet.on_way(on_axis(s->to, low_))));
  return g;
}

void Contact::view(Group& g, std::vector<View>& views) const {
  g.first_view = views.size();
  for (const SweptStep* s = g.begin; s != g.end; ++s) {
    const Point<Part> from = on_axis(s->from, low_), to = on_axis(s->to, low_);
    View v(*s, BallWay(from, to, radius_));
    v.from = from, v.to = to;
    const double turn = length(s->to.axis - s->from.axis), wide = s->stray + turn * sweep_.longest();
    v.slack = turn * distance(v.from, v.to);
    g.slack = std::max(g.slack, v.slack);
    v.rapid = path_.moves[s->move].rapid;
    g.has[v.rapid ? 1 : 0] = true;
    const auto place = [&](Point<Part> p) { return dot(p - g.begin->from.tip, g.along); };
    const auto [low, high] = std::minmax(
        {place(v.from), place(v.to), place(on_axis(s->from, high_)), place(on_axis(s->to, high_))});
    v.first = low - wide, v.last = high + wide;
    views.push_back(std::move(v));
  }
  g.end_view = views.size();
}

namespace {

/// What a ball of radius R that is x beside a line has risen by over one round the line is R - sqrt(R^2 -
/// x^2), at least this.
double risen(double beside, double radius) {
  return beside >= radius ? kInfinity : beside * beside / (2.0 * radius);
}

}  // namespace

/// Not more than any value that anything that the stretch sweeps can leave on the patch.
double Contact::core_least(const Stretch& s, const Facet& facet) const {
  const Facet::Off off = facet.off(s.corners());
  return off.over - s.wide - radius_ + risen(std::max(0.0, off.beyond - s.wide), radius_);
}

/// (W6) Could what the stretch sweeps be met within `most` of a place of the patch along its normal?
bool Contact::reaches(const Stretch& s, Point<Part> place, Vec3 normal, double most) const {
  const Vec3 u = s.sheet.to(place);
  const double far2 = squared_length(u), near = radius_ + s.wide;
  if (far2 <= near * near) return true;
  // The sheet is convex: a line along the normal comes nearer to it by no more than this share of its way.
  const double towards = -dot(u, normal);
  if (towards <= 0.0 || most <= 0.0) return false;
  const double far = std::sqrt(far2);
  return (far - near) * far < most * towards;
}

}  // namespace tiltfeed::sim
