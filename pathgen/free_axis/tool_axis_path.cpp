#include "pathgen/free_axis/tool_axis_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pathgen/free_axis/axis_evening.h"
#include "pathgen/free_axis/move_check.h"
#include "pathgen/free_axis/pass_curve.h"
#include "pathgen/free_axis/stations.h"

namespace tiltfeed::pathgen {

namespace {

/// Borders of what can be reached, and overlaps at breaks, are found this closely, mm.
constexpr double kBorder = 0.1;
/// How often stations are put in where a move between two was not clear.
constexpr int kRepairs = 6;
/// A point of the pass so near to a station is the station, mm.
constexpr double kSamePlace = 1e-6;

class Orienter {
 public:
  Orienter(const ClChain& chain, const Admissibility& admissible, const ToolAxisOptions& options)
      : curve_(chain, options.wish),
        admissible_(admissible),
        options_(options),
        row_(curve_, admissible, options.wish, query_),
        moves_(admissible, options, query_) {}

  ToolAxisPass run() {
    for (int repair = 0;; ++repair) {
      row_.choose();
      compose(repair == kRepairs);
      if (failed_.empty()) break;
      row_.insert(std::exchange(failed_, {}));
    }
    report_left_out();
    pass_.stations = row_.stations().size(), pass_.tested = query_.tested;
    return std::move(pass_);
  }

 private:
  /// The stretches between breaks, even and within the limit of turns.
  std::vector<AxisStretch> stretches() {
    const EveningLimits limits{row_.scale(), row_.max_turn()};
    std::vector<AxisStretch> all;
    const std::vector<Station>& stations = row_.stations();
    for (std::size_t i = 0; i < stations.size();) {
      AxisStretch stretch;
      for (; i < stations.size() && !stations[i].candidates.empty(); ++i) {
        const Station& s = stations[i];
        stretch.push_back({s.way, s.point, s.wished, s.chosen, s.window <= 0.0});
      }
      ++i;
      if (stretch.empty()) continue;
      even_out(stretch, limits, admissible_, query_);
      for (AxisStretch& part : spread_turns(std::move(stretch), limits, admissible_, query_))
        all.push_back(std::move(part));
    }
    return all;
  }

  /// The stretch goes on with its last direction towards `to`, as far as that is admissible.
  void extend(AxisStretch& s, bool forwards, double to) {
    const Vec3 axis = forwards ? s.back().axis : s.front().axis;
    double inside = forwards ? s.back().way : s.front().way, outside = to;
    const double start = inside;
    while (std::abs(outside - inside) > kBorder) {
      const double middle = 0.5 * (inside + outside);
      (admissible_.admits(curve_.at(middle), axis, query_) ? inside : outside) = middle;
    }
    if (std::abs(inside - start) < kBorder / 2.0) return;
    const Station end = row_.place(inside);
    s.insert(forwards ? s.end() : s.begin(), {end.way, end.point, end.wished, axis, false});
  }

  /// Makes the runs, checked; where a move is not clear its place is noted in failed_, or, `last`, the run is
  /// broken there.
  void compose(bool last) {
    pass_.runs.clear();
    std::vector<AxisStretch> all = stretches();
    for (std::size_t k = 0; k < all.size(); ++k) {
      const double end = k + 1 < all.size() ? all[k + 1].front().way : curve_.length();
      const double begin = k > 0 ? all[k - 1].back().way : 0.0;
      if (all[k].back().way < end) extend(all[k], true, end);
      if (all[k].front().way > begin) extend(all[k], false, begin);
      make_run(all[k], last);
    }
    moves_.next_round();
    pass_.breaks = pass_.runs.empty() ? 0 : pass_.runs.size() - 1;
  }

  void make_run(const AxisStretch& s, bool last) {
    PlacedRun run;
    for (std::size_t i = 0; i < s.size(); ++i) {
      run.push_back({s[i].way, {s[i].point, s[i].axis}});
      if (i + 1 == s.size()) break;
      const std::vector<double>& ways = curve_.ways();
      const double from = s[i].way, to = s[i + 1].way;
      auto k = static_cast<std::size_t>(std::upper_bound(ways.begin(), ways.end(), from + kSamePlace) -
                                        ways.begin());
      for (; k < ways.size() && ways[k] < to - kSamePlace; ++k)
        run.push_back(
            {ways[k], {curve_.points()[k], slerp(s[i].axis, s[i + 1].axis, (ways[k] - from) / (to - from))}});
    }
    if (run.size() > 1) check(divided(run, options_), last);
  }

  /// A station more half way between the two about the place.
  void note_failed(double way) {
    const std::vector<Station>& s = row_.stations();
    const auto before = [](const Station& station, double w) { return station.way < w; };
    const auto after = std::clamp<std::ptrdiff_t>(
        std::lower_bound(s.begin(), s.end(), way, before) - s.begin(), 1, std::ssize(s) - 1);
    const double a = s[static_cast<std::size_t>(after) - 1].way, b = s[static_cast<std::size_t>(after)].way;
    const double middle = 0.5 * (a + b);
    if (b - a > kBorder && (failed_.empty() || failed_.back() != middle)) failed_.push_back(middle);
  }

  void check(const PlacedRun& run, bool last) {
    ToolAxisRun checked{run.front().at};
    const auto end_run = [&] {
      if (checked.size() > 1) pass_.runs.push_back(std::move(checked));
      checked.clear();
    };
    for (std::size_t i = 1; i < run.size(); ++i) {
      const bool fine = moves_.clear(run[i - 1], run[i]);
      if (!fine && !last && run[i].way - run[i - 1].way > kBorder)
        note_failed(0.5 * (run[i - 1].way + run[i].way));
      if (!fine) end_run();
      checked.push_back(run[i].at);
    }
    end_run();
  }

  /// The stations without admissible directions, with the reason.
  void report_left_out() {
    const std::vector<Station>& stations = row_.stations();
    for (std::size_t i = 0; i < stations.size(); ++i)
      if (stations[i].candidates.empty())
        pass_.left_out.push_back(
            {row_.share(i), admissible_.why_none(stations[i].point, query_), stations[i].point.facet});
  }

  DirectionQuery query_;
  PassCurve curve_;
  const Admissibility& admissible_;
  const ToolAxisOptions& options_;
  Stations row_;
  MoveCheck moves_;
  std::vector<double> failed_;
  ToolAxisPass pass_;
};

}  // namespace

ToolAxisPass choose_tool_axes(const ClChain& chain, const Admissibility& admissible,
                              const ToolAxisOptions& options) {
  return Orienter(chain, admissible, options).run();
}

}  // namespace tiltfeed::pathgen
