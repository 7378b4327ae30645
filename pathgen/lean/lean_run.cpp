#include "pathgen/lean/lean_run.h"

#include <algorithm>

#include "pathgen/envelope/pass_trim.h"

namespace tiltfeed::pathgen {

namespace {

/// Places are left out whose lean is nearer than this to what it is without them, rad.
constexpr double kSameLean = 0.003;
/// As many places at a time, at most, so that the work stays in proportion.
constexpr std::size_t kMostLeftOut = 24;

bool upright(const LeanedPlace& p) { return p.lean == LeanAngle{}; }

}  // namespace

LeanedRun moves_between(const LeanTool& tool, const PassFrames& frames, const LeanedPlace& a,
                        const LeanedPlace& b) {
  if (upright(a) && upright(b)) return {b};
  const double turn = angle_between(a.axis(), b.axis()) + std::abs(a.lean.size() - b.lean.size());
  const double moves = std::max(1.0, std::ceil(turn / tool.largest_turn()));
  LeanedRun out;
  for (double k = 1.0; k < moves; ++k) {
    LeanedPlace place{frames.at(a.station.run + (b.station.run - a.station.run) * k / moves),
                      lerp(a.lean, b.lean, k / moves)};
    place.station.given = false;
    out.push_back(place);
  }
  out.push_back(b);
  return out;
}

bool clear_between(const LeanTool& tool, const PassFrames& frames, const LeanedPlace& a, const LeanedPlace& b,
                   std::uint32_t& hint) {
  if (upright(a) && upright(b)) return tool.clear_upright(a.station.point, b.station.point, hint);
  const LeanedPlace* from = &a;
  const LeanedRun moves = moves_between(tool, frames, a, b);
  return std::all_of(moves.begin(), moves.end(), [&](const LeanedPlace& to) {
    const bool clear = tool.clear(from->station.point, from->axis(), to.station.point, to.axis(), hint);
    from = &to;
    return clear;
  });
}

void extend(const LeanTool& tool, const PassFrames& frames, double run, bool forwards, LeanedRun& places,
            std::uint32_t& hint) {
  const LeanedPlace end = forwards ? places.back() : places.front();
  const auto place_at = [&](double at) { return LeanedPlace{frames.at(at), end.lean}; };
  const auto clear_to = [&](const LeanedPlace& to) {
    return (!upright(end) || tool.clear_upright(to.station.point, {}, {}, hint)) &&
           (forwards ? clear_between(tool, frames, end, to, hint)
                     : clear_between(tool, frames, to, end, hint));
  };
  double reached = end.station.run, blocked = run;
  if (clear_to(place_at(run))) reached = run;
  while (std::abs(blocked - reached) > kTrimStep) {
    const double middle = (reached + blocked) / 2.0;
    (clear_to(place_at(middle)) ? reached : blocked) = middle;
  }
  if (std::abs(reached - end.station.run) <= kTrimStep) return;
  places.insert(forwards ? places.end() : places.begin(), place_at(reached));
}

LeanedRun thinned_run(const LeanTool& tool, const PassFrames& frames, const LeanedRun& run,
                      std::uint32_t& hint) {
  LeanedRun out{run.front()};
  for (std::size_t from = 0; from + 1 < run.size();) {
    std::size_t to = from + 1;
    const auto stands_between = [&](std::size_t next) {
      const double way = run[next].station.run - run[from].station.run;
      for (std::size_t i = from + 1; i < next; ++i) {
        const double share = way > 0.0 ? (run[i].station.run - run[from].station.run) / way : 0.0;
        const LeanAngle even = lerp(run[from].lean, run[next].lean, share);
        if (std::hypot(run[i].lean.u - even.u, run[i].lean.v - even.v) > kSameLean) return false;
      }
      return true;
    };
    while (to + 1 < run.size() && !run[to].station.given && to - from < kMostLeftOut &&
           stands_between(to + 1))
      ++to;
    while (to > from + 1 && !clear_between(tool, frames, run[from], run[to], hint))
      to = from + std::max<std::size_t>(1, (to - from) / 2);
    out.push_back(run[to]);
    from = to;
  }
  return out;
}

Pass pass_of(const LeanTool& tool, const PassFrames& frames, const LeanedRun& run) {
  Pass pass;
  const auto add = [&pass](const LeanedPlace& place) {
    pass.push_back(place.station.point);
    pass.back().axis = place.axis();
  };
  add(run.front());
  for (std::size_t i = 1; i < run.size(); ++i)
    for (const LeanedPlace& place : moves_between(tool, frames, run[i - 1], run[i])) add(place);
  return pass;
}

}  // namespace tiltfeed::pathgen
