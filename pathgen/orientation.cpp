#include "pathgen/orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pathgen/direction_choice.h"
#include "pathgen/pass_curve.h"

namespace tiltfeed {

namespace {

/// (O2) Directions are sought this far apart on the pass: a share of the ball's radius.
constexpr double kStationShare = 0.4;
/// Where the wished direction is not admissible, so far (mm per radian of the widest turn) to both sides
/// others are looked at, too.
constexpr double kMarginTurn = 1.0;
/// Directions so near to the wish are looked at wherever any but it are, rad.
constexpr double kLeastWindow = 0.25;
/// Where the wish is not admitted directions further from it by up to this are looked at, rad; where there is
/// none, all.
constexpr double kWidestWindow = 0.9;
/// Candidates of a station at most: those that depart least.
constexpr std::size_t kMostCandidates = 96;
/// Neighbours on the grid are up to so far apart, rad: a turn may be so much faster at one station, and is
/// evened out with those before and after.
constexpr double kGridTurn = 0.17;
/// A break costs as much as a departure of one radian over this length, mm.
constexpr double kJumpLength = 20.0;
/// Borders of what can be reached, and overlaps at breaks, are found this closely, mm.
constexpr double kBorder = 0.1;
/// Up to so many radii of the ball over the reference moves are checked pose by pose, further up by a bound.
constexpr double kBoundedFrom = 3.0;
/// A cylinder of radius r that steps by s leaves s^2 / (8 r) of a corner: a fifth of the tolerance at most.
constexpr double kStepShare = 8.0 * 0.2;
/// How often directions are evened out between their neighbours.
constexpr int kSmoothings = 6;
/// Directions that would turn by less than this (rad) are even.
constexpr double kSmooth = 0.005;
/// How often stations are put in where a move between two was not clear.
constexpr int kRepairs = 6;

struct Station {
  double way = 0.0;
  ClPoint point;
  Vec3 wished;
  bool asked = false, wish_admitted = false;
  double window =
      0.0;  ///< the candidates are the admissible directions so near to the wish, rad; 0: the wish
  std::vector<AxisCandidate> candidates;
  Vec3 axis;
};

/// Stations that follow each other without a break.
struct Stretch {
  std::vector<Station> stations;
};

class Orienter {
 public:
  Orienter(const ClChain& chain, const Admissibility& admissible, const OrientationOptions& options)
      : curve_(chain, options.wish),
        admissible_(admissible),
        options_(options),
        max_turn_(options.wish.max_turn.radians()),
        scale_(std::max(options.wish.smoothing, admissible.tool().ball())),
        lever_(lever()),
        step_(std::sqrt(kStepShare * admissible.tool().ball() * options.tolerance)) {}

  OrientedPass run() {
    const int count = std::max(
        1, static_cast<int>(std::ceil(curve_.length() / (kStationShare * admissible_.tool().ball()))));
    for (int i = 0; i <= count; ++i) add_station(curve_.length() * i / count);
    for (int repair = 0;; ++repair) {
      choose();
      compose(repair == kRepairs);
      if (failed_.empty()) break;
      for (const double way : failed_) add_station(way);
      std::sort(stations_.begin(), stations_.end(),
                [](const Station& a, const Station& b) { return a.way < b.way; });
      for (const double way : failed_) fill_between(index_of(way));
      failed_.clear();
    }
    report_left_out();
    pass_.stations = stations_.size(), pass_.tested = query_.tested;
    return std::move(pass_);
  }

 private:
  /// How far up the tool anything of the part can be.
  double lever() const {
    const Box& b = admissible_.tool().tree().bounds();
    return std::min(admissible_.tool().top(), distance(b.min, b.max));
  }

  Station make_station(double way) const {
    Station s;
    s.way = way, s.point = curve_.at(way), s.wished = admissible_.nearest_tilt(curve_.wished(way));
    return s;
  }
  void add_station(double way) { stations_.push_back(make_station(way)); }

  /// (O2) The admissible set where the wish is not admitted and round about; else the wish alone.
  void find_candidates() {
    for (Station& s : stations_) {
      if (s.asked) continue;
      s.asked = true, s.wish_admitted = admissible_.admits(s.point, s.wished, query_);
    }
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      const Station& s = stations_[i];
      if (!s.wish_admitted) look(i);
      if (i == 0) continue;
      const double way = s.way - stations_[i - 1].way;
      if (angle_between(s.wished, stations_[i - 1].wished) > max_turn_ * way) look(i - 1), look(i);
    }
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      Station& s = stations_[i];
      const double weight = weight_of(i);
      if (s.window <= 0.0) s.candidates = {{s.wished, 0.0}};
      for (AxisCandidate& c : s.candidates) {
        const double angle = angle_between(c.axis, s.wished);
        c.cost = angle * angle * weight;
      }
    }
  }

  std::size_t index_of(double way) const {
    const auto before = [](const Station& s, double w) { return s.way < w; };
    return static_cast<std::size_t>(std::lower_bound(stations_.begin(), stations_.end(), way, before) -
                                    stations_.begin());
  }

  /// The admissible sets of station i and those round about: the further off, the nearer to the wish.
  void look(std::size_t i) {
    const double at = stations_[i].way, margin = kMarginTurn / max_turn_;
    const auto window = [&](double way) { return kLeastWindow + kWidestWindow * std::exp(-way / scale_); };
    for (std::size_t k = i; k < stations_.size() && stations_[k].way <= at + margin; ++k)
      fill(stations_[k], window(stations_[k].way - at));
    for (std::size_t k = i; k-- > 0 && stations_[k].way >= at - margin;)
      fill(stations_[k], window(at - stations_[k].way));
  }

  /// The admissible sets of a station put in, and of its neighbours.
  void fill_between(std::size_t i) {
    for (std::size_t k = i > 0 ? i - 1 : 0; k <= std::min(i + 1, stations_.size() - 1); ++k)
      fill(stations_[k], kWidestWindow);
  }

  double weight_of(std::size_t i) const {
    const double before = i > 0 ? stations_[i].way - stations_[i - 1].way : 0.0;
    const double after = i + 1 < stations_.size() ? stations_[i + 1].way - stations_[i].way : 0.0;
    return (before + after) / 2.0;
  }

  void fill(Station& s, double window) {
    window = std::min(window, kPi);
    if (s.window >= window - kLeastWindow / 2.0) return;
    if (!s.asked) s.asked = true, s.wish_admitted = admissible_.admits(s.point, s.wished, query_);
    s.window = window;
    s.candidates.clear();
    for (const std::uint32_t i : admissible_.directions_near(s.point, s.wished, window, query_))
      s.candidates.push_back({admissible_.grid().directions()[i], 0.0});
    if (s.candidates.size() > kMostCandidates) {
      const auto nearer = [&](const AxisCandidate& a, const AxisCandidate& b) {
        return dot(a.axis, s.wished) > dot(b.axis, s.wished);
      };
      std::stable_sort(s.candidates.begin(), s.candidates.end(), nearer);
      s.candidates.resize(kMostCandidates);
    }
    if (s.wish_admitted) s.candidates.insert(s.candidates.begin(), AxisCandidate{s.wished, 0.0});
  }

  /// (O3) The stations with their directions, in stretches without a break.
  void choose() {
    find_candidates();
    stretches_.clear();
    for (std::size_t i = 0; i < stations_.size();) {
      std::size_t end = i;
      while (end < stations_.size() && !stations_[end].candidates.empty()) ++end;
      if (end > i) choose(i, end);
      i = std::max(end, i + 1);
    }
  }

  void choose(std::size_t first, std::size_t last) {
    std::vector<std::vector<AxisCandidate>> candidates;
    std::vector<double> ways;
    for (std::size_t i = first; i < last; ++i) {
      candidates.push_back(stations_[i].candidates);
      if (i > first) ways.push_back(stations_[i].way - stations_[i - 1].way);
    }
    const auto chosen =
        cheapest_sequence(candidates, ways, {scale_ * scale_, max_turn_, kGridTurn, kJumpLength});
    Stretch stretch;
    for (std::size_t i = first; i < last; ++i) {
      Station s = stations_[i];
      s.axis = candidates[i - first][chosen[i - first]].axis;
      if (!stretch.stations.empty() &&
          angle_between(stretch.stations.back().axis, s.axis) > max_turn_ * ways[i - first - 1] + kGridTurn) {
        stretches_.push_back(std::move(stretch));
        stretch = {};
      }
      s.candidates.clear();
      stretch.stations.push_back(std::move(s));
    }
    stretches_.push_back(std::move(stretch));
  }

  /// (O4) Directions towards the mean of their neighbours and the wish, as far as admissible.
  void smooth(Stretch& stretch) {
    std::vector<Station>& s = stretch.stations;
    if (std::all_of(s.begin(), s.end(), [](const Station& at) { return at.window <= 0.0; })) return;
    for (int round = 0; round < kSmoothings; ++round) {
      for (std::size_t i = 0; i < s.size(); ++i) {
        // The least of the costs of (O3), to the second order, with the neighbours held.
        Vec3 pull = s[i].wished * weight(s, i);
        for (const std::size_t k : {i - 1, i + 1}) {
          if (k >= s.size()) continue;
          pull = pull + s[k].axis * (scale_ * scale_ / std::abs(s[k].way - s[i].way));
        }
        if (squared_length(pull) < 1e-12) continue;
        const Vec3 aim = normalized(pull);
        for (const double share : {1.0, 0.5, 0.25}) {
          const Vec3 axis = slerp(s[i].axis, aim, share);
          if (angle_between(axis, s[i].axis) < kSmooth) break;
          if (!turn_allowed(s, i, axis)) continue;
          if (!admissible_.admits(s[i].point, axis, query_)) continue;
          s[i].axis = axis;
          break;
        }
      }
    }
  }
  static double weight(const std::vector<Station>& s, std::size_t i) {
    const double before = i > 0 ? s[i].way - s[i - 1].way : 0.0;
    const double after = i + 1 < s.size() ? s[i + 1].way - s[i].way : 0.0;
    return (before + after) / 2.0;
  }
  bool turn_allowed(const std::vector<Station>& s, std::size_t i, Vec3 axis) const {
    for (const std::size_t k : {i - 1, i + 1})
      if (k < s.size() && angle_between(s[k].axis, axis) > max_turn_ * std::abs(s[k].way - s[i].way))
        return false;
    return true;
  }

  /// The stretch goes on with its last direction towards `to`, as far as that is admissible.
  void extend(Stretch& stretch, bool forwards, double to) {
    std::vector<Station>& s = stretch.stations;
    const Vec3 axis = forwards ? s.back().axis : s.front().axis;
    double inside = forwards ? s.back().way : s.front().way, outside = to;
    const double start = inside;
    while (std::abs(outside - inside) > kBorder) {
      const double middle = 0.5 * (inside + outside);
      (admissible_.admits(curve_.at(middle), axis, query_) ? inside : outside) = middle;
    }
    if (std::abs(inside - start) < kBorder / 2.0) return;
    Station end = make_station(inside);
    end.axis = axis;
    s.insert(forwards ? s.end() : s.begin(), end);
  }

  /// Makes the runs, checked; where a move is not clear its place is noted in failed_, or, `last`, the run is
  /// broken there.
  void compose(bool last) {
    pass_.runs.clear();
    for (std::size_t k = 0; k < stretches_.size(); ++k) {
      smooth(stretches_[k]);
      const double end = k + 1 < stretches_.size() ? stretches_[k + 1].stations.front().way : curve_.length();
      const double begin = k > 0 ? stretches_[k - 1].stations.back().way : 0.0;
      if (stretches_[k].stations.back().way < end) extend(stretches_[k], true, end);
      if (stretches_[k].stations.front().way > begin) extend(stretches_[k], false, begin);
      make_run(stretches_[k].stations, last);
    }
    std::stable_sort(cleared_now_.begin(), cleared_now_.end(),
                     [](const Cleared& a, const Cleared& b) { return a.from < b.from; });
    cleared_ = std::exchange(cleared_now_, {});
    pass_.breaks = pass_.runs.empty() ? 0 : pass_.runs.size() - 1;
  }

  /// A point of a run and where it is on the pass.
  struct Placed {
    double way;
    OrientedPoint at;
  };

  void make_run(const std::vector<Station>& s, bool last) {
    std::vector<Placed> run;
    for (std::size_t i = 0; i < s.size(); ++i) {
      run.push_back({s[i].way, {s[i].point, s[i].axis}});
      if (i + 1 == s.size()) break;
      const auto& ways = curve_.ways();
      auto k = std::upper_bound(ways.begin(), ways.end(), s[i].way + 1e-6) - ways.begin();
      for (; static_cast<std::size_t>(k) < ways.size() &&
             ways[static_cast<std::size_t>(k)] < s[i + 1].way - 1e-6;
           ++k) {
        const double way = ways[static_cast<std::size_t>(k)],
                     f = (way - s[i].way) / (s[i + 1].way - s[i].way);
        run.push_back(
            {way, {curve_.points()[static_cast<std::size_t>(k)], slerp(s[i].axis, s[i + 1].axis, f)}});
      }
    }
    if (run.size() < 2) return;
    divide(run);
    check(run, last);
  }

  /// (O5) No move turns or is longer than it may.
  void divide(std::vector<Placed>& run) const {
    std::vector<Placed> divided{run.front()};
    for (std::size_t i = 1; i < run.size(); ++i) {
      const Placed &a = run[i - 1], &b = run[i];
      const double turn = angle_between(a.at.axis, b.at.axis),
                   way = distance(a.at.point.centre, b.at.point.centre);
      int parts = static_cast<int>(std::ceil(turn / options_.turn_per_move - 1e-9));
      if (options_.longest_move > 0.0)
        parts = std::max(parts, static_cast<int>(std::ceil(way / options_.longest_move - 1e-9)));
      for (int k = 1; k < parts; ++k) {
        const double f = static_cast<double>(k) / parts;
        ClPoint p = f < 0.5 ? a.at.point : b.at.point;
        p.centre = lerp(a.at.point.centre, b.at.point.centre, f);
        divided.push_back({a.way + (b.way - a.way) * f, {p, slerp(a.at.axis, b.at.axis, f)}});
      }
      divided.push_back(b);
    }
    run = std::move(divided);
  }

  /// Is the tool clear all along the move? High up by a bound; near the contact, or where that does not tell,
  /// at poses between which no point of the tool moves further than what a ball leaves of a corner between
  /// two places within a fifth of the tolerance.
  bool clear(const OrientedPoint& a, const OrientedPoint& b) {
    const double turn = angle_between(a.axis, b.axis), way = distance(a.point.centre, b.point.centre);
    const double from = kBoundedFrom * admissible_.tool().ball();
    ++query_.tested;
    const bool bounded = !admissible_.tool().may_stop(
        lerp(a.point.centre, b.point.centre, 0.5), slerp(a.axis, b.axis, 0.5), way / 2.0, turn / 2.0, from);
    const int steps =
        std::max(1, static_cast<int>(std::ceil((way + (bounded ? from : lever_) * turn) / step_)));
    const double h = options_.reference_height;
    const Point<Part> tip_a = a.point.centre - a.axis * h, tip_b = b.point.centre - b.axis * h;
    for (int k = 0; k <= steps; ++k) {
      const double f = static_cast<double>(k) / steps;
      const Vec3 axis = slerp(a.axis, b.axis, f);
      const Point<Part> centre = lerp(tip_a, tip_b, f) + axis * h;
      ++query_.tested;
      if (bounded ? admissible_.tool().stopped_below(centre, axis, from, query_.hint)
                  : admissible_.tool().stop(centre, axis, query_.hint).has_value())
        return false;
      if (!admissible_.within_tilt(axis)) return false;
    }
    return true;
  }

  /// A station more half way between the two about the place.
  void note_failed(double way) {
    const std::size_t after = std::clamp<std::size_t>(index_of(way), 1, stations_.size() - 1);
    const double middle = 0.5 * (stations_[after - 1].way + stations_[after].way);
    if (stations_[after].way - stations_[after - 1].way > kBorder &&
        (failed_.empty() || failed_.back() != middle))
      failed_.push_back(middle);
  }

  /// A move that was found clear the time before; runs are made in the order of their ways.
  struct Cleared {
    double from;
    std::array<Vec3, 2> axes;
    double to;
  };
  bool known_clear(const Placed& a, const Placed& b) const {
    const auto before = [](const Cleared& c, double way) { return c.from < way; };
    for (auto c = std::lower_bound(cleared_.begin(), cleared_.end(), a.way, before);
         c != cleared_.end() && c->from == a.way; ++c)
      if (c->to == b.way && c->axes[0] == a.at.axis && c->axes[1] == b.at.axis) return true;
    return false;
  }

  void check(const std::vector<Placed>& run, bool last) {
    OrientedRun checked{run.front().at};
    const auto end_run = [&] {
      if (checked.size() > 1) pass_.runs.push_back(std::move(checked));
      checked.clear();
    };
    for (std::size_t i = 1; i < run.size(); ++i) {
      const bool fine = known_clear(run[i - 1], run[i]) || clear(run[i - 1].at, run[i].at);
      if (fine) cleared_now_.push_back({run[i - 1].way, {run[i - 1].at.axis, run[i].at.axis}, run[i].way});
      if (!fine && !last && run[i].way - run[i - 1].way > kBorder)
        note_failed(0.5 * (run[i - 1].way + run[i].way));
      if (!fine) end_run();
      checked.push_back(run[i].at);
    }
    end_run();
  }

  /// What no run covers, with the reason.
  void report_left_out() {
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      if (!stations_[i].candidates.empty()) continue;
      pass_.left_out.push_back(
          {weight_of(i), admissible_.why_none(stations_[i].point, query_), stations_[i].point.facet});
    }
  }

  PassCurve curve_;
  const Admissibility& admissible_;
  const OrientationOptions& options_;
  double max_turn_, scale_, lever_, step_;
  std::vector<Station> stations_;
  std::vector<Stretch> stretches_;
  std::vector<double> failed_;
  std::vector<Cleared> cleared_, cleared_now_;  ///< moves of the time before, and of this
  DirectionQuery query_;
  OrientedPass pass_;
};

}  // namespace

OrientedPass orient_pass(const ClChain& chain, const Admissibility& admissible,
                         const OrientationOptions& options) {
  return Orienter(chain, admissible, options).run();
}

}  // namespace tiltfeed
