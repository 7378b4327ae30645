#include <algorithm>
#include <cmath>

#include "sim/contact_run.h"
#include "sim/sheet.h"

namespace tiltfeed::sim {
namespace {

// Steps that share their candidates: so many at most, so many radii long, turning the ends of the core's
// lower part and of all of it by so many.
constexpr std::size_t kGroupSteps = 32;
constexpr double kGroupRadii = 4.0, kFootTurnRadii = 0.5, kTopTurnRadii = 2.0;
// The core's lower part, in radii: what is beside it is looked for closely.
constexpr double kFootRadii = 4.0;

Point<Part> at(const Pose& p, double h) { return p.tip + p.axis * h; }

}  // namespace

std::size_t Contact::group_end(const std::vector<SweptStep>& steps, std::size_t begin) const {
  const Pose& first = steps[begin].from;
  const double foot = std::min(high_, low_ + kFootRadii * radius_);
  std::size_t end = begin + 1;
  double way = distance(first.tip, steps[begin].to.tip);
  for (; end < steps.size() && end - begin < kGroupSteps; ++end) {
    way += distance(steps[end].from.tip, steps[end].to.tip);
    if (way > kGroupRadii * radius_) break;
    const double turn = length(steps[end].to.axis - first.axis);
    if (turn * (foot - low_) > kFootTurnRadii * radius_ || turn * (high_ - low_) > kTopTurnRadii * radius_)
      break;
  }
  return end;
}

Contact::Stretch Contact::stretch(const Group& g, double low, double high) const {
  const Pose &first = g.begin->from, &last = (g.end - 1)->to;
  Stretch made(at(first, low), at(last, low) - at(first, low), g.axis * (high - low));
  double stray = g.step_stray;
  for (const SweptStep* s = g.begin; s != g.end; ++s) {
    for (const Pose& p : {s->from, s->to}) {
      const Point<Part> on = made.sheet.on_way(at(p, low));
      stray = std::max({stray, distance(at(p, low), on), distance(at(p, high), on + made.core)});
    }
  }
  // The pieces of the sweep have the mean axis of their step.
  made.wide = stray + g.turn * sweep_.longest();
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
  }
  const double foot = std::min(high_, low_ + kFootRadii * radius_);
  g.stretches.push_back(stretch(g, low_, foot));
  if (foot < high_) g.stretches.push_back(stretch(g, foot, high_));
  const Stretch& lower = g.stretches.front();
  const Vec3 across = lower.way - g.axis * dot(lower.way, g.axis);
  if (squared_length(across) > 0.0) g.along = normalized(across);
  g.stray = g.step_stray;
  for (const SweptStep* s = begin; s != end; ++s)
    g.stray = std::max(g.stray, distance(at(s->to, low_), lower.sheet.on_way(at(s->to, low_))));
  return g;
}

void Contact::view(Group& g, std::vector<View>& views) const {
  g.first_view = views.size();
  for (const SweptStep* s = g.begin; s != g.end; ++s) {
    const Point<Part> from = at(s->from, low_), to = at(s->to, low_);
    View v(*s, BallWay(from, to, radius_));
    v.from = from, v.to = to;
    const double turn = length(s->to.axis - s->from.axis), wide = s->stray + turn * sweep_.longest();
    v.slack = turn * distance(v.from, v.to);
    g.slack = std::max(g.slack, v.slack);
    v.rapid = path_.moves[s->move].rapid;
    const auto place = [&](Point<Part> p) { return dot(p - g.begin->from.tip, g.along); };
    const auto [low, high] =
        std::minmax({place(v.from), place(v.to), place(at(s->from, high_)), place(at(s->to, high_))});
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

double Contact::ball_least(const Group& g, std::uint32_t patch) const {
  const Stretch& lower = g.stretches.front();
  const Vec3 n = probes_.patches().normal[patch], from = lower.foot - probes_.patches().middle[patch];
  const double rise = dot(n, from), climb = dot(n, lower.way);
  const Point<Part> foot = Point<Part>{} + (from - n * rise);
  const double beside = distance_to_segment({}, foot, foot + (lower.way - n * climb));
  const double wide = static_cast<double>(probes_.patches().radius[patch]) + g.stray;
  return rise + std::min(0.0, climb) - g.stray - radius_ + risen(std::max(0.0, beside - wide), radius_);
}

/// (R6) Could what the stretch sweeps, within `most` of a place of the patch along its normal, be met?
bool Contact::reaches(const Stretch& s, std::uint32_t patch, double most) const {
  const Patches& patches = probes_.patches();
  const Vec3 u = s.sheet.to(patches.middle[patch]);
  const double far2 = squared_length(u), near = radius_ + s.wide + static_cast<double>(patches.radius[patch]);
  if (far2 <= near * near) return true;
  // The sheet is convex: a line along the normal comes nearer to it by no more than this share of its way.
  const double towards = -dot(u, patches.normal[patch]);
  if (towards <= 0.0 || most <= 0.0) return false;
  const double far = std::sqrt(far2);
  return (far - near) * far < most * towards;
}

/// Is all that can matter of the patch, `most` above it, nearer to the ball at the core's lower end than to
/// the rest of the core, in all of the group?
bool Contact::by_ball_alone(const Group& g, std::uint32_t patch, double most) const {
  const Stretch& lower = g.stretches.front();
  const Vec3 n = probes_.patches().normal[patch], from = probes_.patches().middle[patch] - lower.foot;
  const double up = dot(n, g.axis);
  if (!round_ || up <= g.turn) return false;
  const double far = length(from) + length(lower.way) + g.stray,
               rise =
                   static_cast<double>(probes_.patches().radius[patch]) * (length(cross(n, g.axis)) + g.turn);
  return dot(from, g.axis) - std::min(0.0, dot(lower.way, g.axis)) + g.stray + g.turn * far + rise + g.slack +
             std::max(0.0, most) * (up + g.turn) <=
         0.0;
}

/// The patches that the group may do something to.
void Contact::gather(const Group& g, Run& run) const {
  const double deep = g.step_stray - run.allowed();
  run.candidates.clear();
  const auto meet = [&](const Stretch& s, std::uint32_t patch) {
    const double most = std::min(probes_.reach(), probes_.highest(patch));
    const Stretch& lower = g.stretches.front();
    const bool first = &s == &lower;
    if (!reaches(s, patch, most) || (!first && reaches(lower, patch, most))) return;
    Candidate c{patch};
    c.ball = round_ && first && ball_least(g, patch) < std::max(most, deep);
    c.side = !by_ball_alone(g, patch, most);
    if (c.ball || c.side) run.candidates.push_back(c);
  };
  for (const Stretch& s : g.stretches) {
    const double near = s.wide + radius_;
    probes_.search(
        [&](Vec3 low, Vec3 high, double most) {
          const double within = near + std::clamp(most, 0.0, probes_.reach());
          return s.sheet.bound(low, high, within) < within;
        },
        [&](std::uint32_t patch) { meet(s, patch); });
  }
}

}  // namespace tiltfeed::sim
