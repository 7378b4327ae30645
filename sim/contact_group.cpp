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

/// The patches within reach of the sheets that the core's lower part and the rest of it sweep, each widened
/// by what the steps stray from it.
void Contact::gather(const SweptStep* begin, const SweptStep* end, Run& run) const {
  const Pose &first = begin->from, &last = (end - 1)->to;
  const Vec3 axis = mean_axis(first, last);
  double turn = 0.0, step_stray = 0.0;
  for (const SweptStep* s = begin; s != end; ++s) {
    turn = std::max({turn, length(s->from.axis - axis), length(s->to.axis - axis)});
    step_stray = std::max(step_stray, s->stray);
  }
  struct Stretch {
    Sheet sheet;
    double within;
  };
  const auto stretch = [&](double low, double high) {
    const Sheet sheet(at(first, low), at(last, low) - at(first, low), axis * (high - low));
    double stray = 0.0;
    for (const SweptStep* s = begin; s != end; ++s) {
      for (const Pose& p : {s->from, s->to}) {
        const Point<Part> on = sheet.on_way(at(p, low));
        stray = std::max({stray, distance(at(p, low), on), distance(at(p, high), on + axis * (high - low))});
      }
    }
    // The pieces of the sweep have the mean axis of their step.
    return Stretch{sheet, radius_ + probes_.reach() + std::max(stray, step_stray) + turn * sweep_.longest()};
  };
  const Patches& patches = probes_.patches();
  const Vec3 along = along_group(first, last, axis);
  const auto search = [&](const Stretch& where, const Stretch* before) {
    double bound = where.within;
    probes_.surface().search(
        bound, kNoFacet, [&](Vec3 low, Vec3 high) { return where.sheet.bound(low, high, where.within); },
        [&](const Triangle& t) {
          const Point<Part> middle = patches.middle[t.facet];
          const double radius = static_cast<double>(patches.radius[t.facet]);
          if (length(where.sheet.to(middle)) > where.within + radius) return;
          if (before != nullptr && length(before->sheet.to(middle)) <= before->within + radius) return;
          const Vec3 n = patches.normal[t.facet];
          const double place = dot(middle - first.tip, along), wide = radius + radius_ + probes_.reach();
          run.candidates.push_back({middle, n, radius, radius * (length(cross(n, axis)) + turn),
                                    dot(n, from_origin(middle)) + radius_, dot(n, axis) > turn, t.facet,
                                    place - wide, place + wide});
        });
  };
  run.candidates.clear();
  const double foot = std::min(high_, low_ + kFootRadii * radius_);
  const Stretch lower = stretch(low_, foot);
  search(lower, nullptr);
  if (foot < high_) search(stretch(foot, high_), &lower);
}

/// The unit direction of the group's way across its axis, zero if there is none.
Vec3 Contact::along_group(const Pose& first, const Pose& last, Vec3 axis) const {
  const Vec3 way = at(last, low_) - at(first, low_), across = way - axis * dot(way, axis);
  return squared_length(across) > 0.0 ? normalized(across) : Vec3{};
}

void Contact::view(const SweptStep* begin, const SweptStep* end, Run& run) const {
  const Pose &first = begin->from, &last = (end - 1)->to;
  const Vec3 along = along_group(first, last, mean_axis(first, last));
  run.views.clear();
  for (const SweptStep* s = begin; s != end; ++s) {
    const Point<Part> from = at(s->from, low_), to = at(s->to, low_);
    View v(*s, BallWay(from, to, radius_));
    v.from = from, v.to = to;
    const double turn = length(s->to.axis - s->from.axis), wide = s->stray + turn * sweep_.longest();
    v.slack = turn * distance(v.from, v.to);
    v.rapid = path_.moves[s->move].rapid;
    const auto place = [&](Point<Part> p) { return dot(p - first.tip, along); };
    const auto [low, high] =
        std::minmax({place(v.from), place(v.to), place(at(s->from, high_)), place(at(s->to, high_))});
    v.first = low - wide, v.last = high + wide;
    run.views.push_back(std::move(v));
  }
}

}  // namespace tiltfeed::sim
