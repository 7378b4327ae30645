#include "pathgen/lean/lean_choice.h"

#include <algorithm>
#include <cmath>

#include "pathgen/free_axis/direction_choice.h"

namespace tiltfeed::pathgen {

namespace {

/// Leans that are tried: on rings, and in so many directions on each. The fine ones are tried where none of
/// the coarse ones is clear.
constexpr int kRings = 6, kDirections = 12, kFineRings = 15, kFineDirections = 48;
/// Then round those that were chosen: squares of 2 kHalf + 1 in each direction, each round so much finer.
constexpr int kHalf = 2, kRefinements = 5;
constexpr double kFiner = 2.5;
/// Of the cutter's radius: between places at which a lean is sought.
constexpr double kSpacing = 0.25;
/// Of the radius: over this length a turn costs as much as a lean.
constexpr double kEvenOver = 0.25;
/// A place is put half way where a move is not clear, so many times.
constexpr int kMostRounds = 5;
/// Over what the lean may change, rad: rounding.
constexpr double kRounding = 1e-9;
/// For each break of a sequence: as much as leaning by 36 degrees over 100 mm.
constexpr double kJump = 40.0;

struct Sought {
  LeanStation station;
  bool pinned = false;   ///< no lean there
  bool upright = false;  ///< the tool is clear without one
  std::vector<LeanAngle> clear;
};

class LeanSearch {
 public:
  LeanSearch(const LeanTool& tool, const PassFrames& frames, double spacing)
      : tool_(tool),
        frames_(frames),
        spacing_(spacing),
        limit_(tool.options().lean.limit.radians()),
        max_turn_(tool.options().lean.max_turn.radians()) {}

  std::vector<LeanedRun> run(const LeanStretch& stretch) {
    std::vector<Sought> places;
    for (const LeanStation& s : frames_.between(stretch.from, stretch.to, spacing_))
      places.push_back(seek(s));
    if (stretch.first) pin(places.front(), *stretch.first);
    if (stretch.last) pin(places.back(), *stretch.last);
    for (int round = 0; round < kMostRounds && solve(places, round + 1 < kMostRounds); ++round) {
    }
    extend_ends(stretch);
    return std::move(runs_);
  }

 private:
  static void pin(Sought& s, LeanAngle lean) { s.pinned = true, s.clear = {lean}; }

  Sought seek(const LeanStation& station) {
    Sought s{station, false, false, {}};
    s.upright = tool_.clear_upright(station.point, station.before, station.ahead, hint_);
    if (s.upright) s.clear.push_back({});
    if (!tool_.touches_with_ball(station.point)) return s;
    try_rings(s, kRings, kDirections);
    if (s.clear.empty()) try_rings(s, kFineRings, kFineDirections);
    return s;
  }

  void try_rings(Sought& s, int rings, int directions) {
    for (int i = 1; i <= rings; ++i)
      for (int k = 0; k < directions; ++k) {
        const double size = limit_ * i / rings, turn = 2.0 * kPi * k / directions;
        try_one(s, {size * std::cos(turn), size * std::sin(turn)});
      }
  }

  void try_one(Sought& s, LeanAngle lean) {
    if (lean.size() <= limit_ * (1.0 + kRounding) &&
        tool_.clear(s.station.point, s.station.axis(lean), s.station.before, s.station.ahead, hint_))
      s.clear.push_back(lean);
  }

  /// Leans of places that follow each other, each of which has some.
  /// `spare`: by which they may change too much yet.
  std::vector<LeanAngle> choose(const std::vector<Sought>& places, double spare) const {
    std::vector<AxisCandidates> lists(places.size());
    std::vector<std::vector<LeanAngle>> order(places.size());
    std::vector<const AxisCandidates*> pointers;
    std::vector<double> ways;
    for (std::size_t i = 0; i < places.size(); ++i) {
      order[i] = places[i].clear;
      std::sort(order[i].begin(), order[i].end(), [](LeanAngle a, LeanAngle b) {
        const double za = LeanStation::direction(a).z, zb = LeanStation::direction(b).z;
        return za != zb ? za < zb : a.u != b.u ? a.u < b.u : a.v < b.v;
      });
      const double before = i > 0 ? places[i].station.run - places[i - 1].station.run : 0.0,
                   behind = i + 1 < places.size() ? places[i + 1].station.run - places[i].station.run : 0.0;
      for (const LeanAngle lean : order[i])
        lists[i].push_back(
            {LeanStation::direction(lean), lean.size() * lean.size() * (before + behind) / 2.0});
      pointers.push_back(&lists[i]);
      if (i > 0) ways.push_back(before);
    }
    const double scale = kEvenOver * tool_.options().cutter.radius();
    CheapestSequence cheapest(std::move(pointers), std::move(ways),
                              {scale * scale, max_turn_, spare + kRounding, kJump}, nullptr);
    const std::vector<std::uint32_t> found = cheapest.find();
    std::vector<LeanAngle> out;
    for (std::size_t i = 0; i < places.size(); ++i) out.push_back(order[i][found[i]]);
    return out;
  }

  /// The same, with finer leans round those chosen.
  std::vector<LeanAngle> choose_finely(std::vector<Sought> places) {
    double step = limit_ / kRings;
    // Neighbours of a ring are about half of its size apart.
    std::vector<LeanAngle> chosen = choose(places, std::max(step, limit_ / 2.0));
    for (int round = 1; round <= kRefinements; ++round) {
      step /= kFiner;
      for (std::size_t i = 0; i < places.size(); ++i) {
        refine(places[i], chosen[i], step);
        if (i > 0 && i + 1 < places.size() && !places[i].pinned)
          try_one(places[i], lerp(chosen[i - 1], chosen[i + 1], 0.5));
      }
      chosen = choose(places, round < kRefinements ? kHalf * step : 0.0);
    }
    return chosen;
  }

  void refine(Sought& s, LeanAngle about, double step) {
    if (s.pinned || !tool_.touches_with_ball(s.station.point)) return;
    s.clear = {about};
    if (s.upright && !(about == LeanAngle{})) s.clear.push_back({});
    for (int i = -kHalf; i <= kHalf; ++i)
      for (int k = -kHalf; k <= kHalf; ++k) {
        const LeanAngle lean{about.u + i * step, about.v + k * step};
        if ((i != 0 || k != 0) && !(lean == LeanAngle{})) try_one(s, lean);
      }
  }

  bool turns_slowly(const LeanedPlace& a, const LeanedPlace& b) const {
    return angle_between(LeanStation::direction(a.lean), LeanStation::direction(b.lean)) <=
           max_turn_ * (b.station.run - a.station.run) + 10.0 * kRounding;
  }

  /// Sets the runs; where `may_insert`, puts places in half way on moves that are not clear, and says so.
  bool solve(std::vector<Sought>& places, bool may_insert) {
    runs_.clear();
    std::vector<double> halves;
    for (std::size_t i = 0; i < places.size();) {
      std::size_t end = i;
      while (end < places.size() && !places[end].clear.empty()) ++end;
      if (end > i)
        solve_group({places.begin() + static_cast<std::ptrdiff_t>(i),
                     places.begin() + static_cast<std::ptrdiff_t>(end)},
                    halves);
      i = std::max(end, i + 1);
    }
    if (!may_insert || halves.empty()) return false;
    for (const double run : halves) places.push_back(seek(frames_.at(run)));
    std::sort(places.begin(), places.end(),
              [](const Sought& a, const Sought& b) { return a.station.run < b.station.run; });
    return true;
  }

  void solve_group(const std::vector<Sought>& places, std::vector<double>& halves) {
    const std::vector<LeanAngle> leans = choose_finely(places);
    LeanedRun run;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const LeanedPlace next{places[i].station, leans[i]};
      if (!run.empty()) {
        const bool slow = turns_slowly(run.back(), next);
        if (!slow || !clear_between(tool_, frames_, run.back(), next, hint_)) {
          if (slow) halves.push_back((run.back().station.run + next.station.run) / 2.0);
          runs_.push_back(std::move(run));
          run = {};
        }
      }
      run.push_back(next);
    }
    runs_.push_back(std::move(run));
  }

  /// Runs end between places.
  void extend_ends(LeanStretch stretch) {
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      const double end = runs_[i].back().station.run,
                   next = i + 1 < runs_.size() ? runs_[i + 1].front().station.run : stretch.to;
      if (const double to = std::min(next, end + spacing_); to > end)
        extend(tool_, frames_, to, true, runs_[i], hint_);
      const double start = runs_[i].front().station.run,
                   last = i > 0 ? runs_[i - 1].back().station.run : stretch.from;
      if (const double to = std::max(last, start - spacing_); to < start)
        extend(tool_, frames_, to, false, runs_[i], hint_);
    }
  }

  const LeanTool& tool_;
  const PassFrames& frames_;
  double spacing_, limit_, max_turn_;
  std::vector<LeanedRun> runs_;
  std::uint32_t hint_ = kNoFacet;
};

}  // namespace

double lean_spacing(const LeanTool& tool) { return kSpacing * tool.options().cutter.radius(); }

std::vector<LeanedRun> lean_along(const LeanTool& tool, const PassFrames& frames, const LeanStretch& stretch,
                                  double spacing) {
  return LeanSearch(tool, frames, spacing).run(stretch);
}

}  // namespace tiltfeed::pathgen
