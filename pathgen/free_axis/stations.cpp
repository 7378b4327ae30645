#include "pathgen/free_axis/stations.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tiltfeed::pathgen {

namespace {

/// Directions are sought this far apart on the pass: a share of the ball's radius; further, where the axis
/// may not turn from one direction of the grid to the next (rad) in so short a way.
constexpr double kStationShare = 0.4, kFurthestShare = 2.0, kGridTurn = 0.16;
/// Round a station put in directions so near to the wish are looked at, rad.
constexpr double kWideWindow = 1.2;
/// Round the direction chosen on the coarser grid those of the finer one are looked at, rad: neighbours on
/// the coarser one are up to so far apart.
constexpr double kAround = 0.17;
/// Round the direction half way between its neighbours a station put in has so many more.
constexpr int kFan = 6;

}  // namespace

Stations::Stations(const PassCurve& curve, const Admissibility& admissible, const FreeAxis& wish,
                   DirectionQuery& query)
    : curve_(curve),
      admissible_(admissible),
      query_(query),
      max_turn_(wish.max_turn.radians()),
      scale_(std::max(wish.smoothing, admissible.tool().ball())) {
  const double ball = admissible.tool().ball();
  const double apart = std::clamp(kGridTurn / max_turn_, kStationShare * ball, kFurthestShare * ball);
  const int count = std::max(1, static_cast<int>(std::ceil(curve.length() / apart)));
  for (int i = 0; i <= count; ++i) {
    Station s = place(curve.length() * i / count);
    s.wish_admitted = admissible.admits(s.point, s.wished, query);
    stations_.push_back(std::move(s));
  }
  find_windows();
}

Station Stations::place(double way) const {
  Station s;
  s.way = way, s.point = curve_.at(way), s.wished = admissible_.nearest_tilt(curve_.wished(way));
  return s;
}

double Stations::share(std::size_t i) const {
  const double before = i > 0 ? stations_[i].way - stations_[i - 1].way : 0.0;
  const double after = i + 1 < stations_.size() ? stations_[i + 1].way - stations_[i].way : 0.0;
  return (before + after) / 2.0;
}

void Stations::insert(const std::vector<double>& ways) {
  for (const double way : ways) {
    Station s = place(way);
    s.wish_admitted = admissible_.admits(s.point, s.wished, query_);
    const auto after = std::upper_bound(stations_.begin(), stations_.end(), way,
                                        [](double w, const Station& other) { return w < other.way; });
    const auto i = static_cast<std::size_t>(after - stations_.begin());
    stations_.insert(after, std::move(s));
    stations_[i].between = between(i);
    for (std::size_t k = i > 0 ? i - 1 : 0; k <= std::min(i + 1, stations_.size() - 1); ++k)
      stations_[k].window = 0.0, open(k, kWideWindow);
  }
}

/// Half way between the directions of a station's neighbours, and as far to all sides as the axis may turn.
std::vector<Vec3> Stations::between(std::size_t i) const {
  if (i == 0 || i + 1 == stations_.size()) return {};
  const Station &a = stations_[i - 1], &b = stations_[i + 1];
  if (a.candidates.empty() || b.candidates.empty()) return {};
  const Vec3 middle = slerp(a.chosen, b.chosen, 0.5);
  const Vec3 u = normalized(cross(middle, std::abs(middle.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const double turn = 0.5 * max_turn_ * std::min(stations_[i].way - a.way, b.way - stations_[i].way);
  std::vector<Vec3> fan{middle};
  for (int k = 0; k < kFan; ++k) {
    const Vec3 aside = rotation_about(middle, 2.0 * kPi / kFan * k) * u;
    fan.push_back(middle * std::cos(turn) + aside * std::sin(turn));
  }
  return fan;
}

/// The candidates are the wish, if admitted, and what lies between the neighbours.
void Stations::start(Station& s) const {
  s.candidates.clear();
  if (s.wish_admitted) s.candidates.push_back({s.wished, 0.0, kNoDirection, true});
  for (const Vec3 axis : s.between)
    if (admissible_.within_limits(s.point.normal, axis))
      s.candidates.push_back({axis, 0.0, kNoDirection, false});
}

/// Appends a direction of the grid, unless it is known not to be admissible.
void Stations::take(Station& s, std::uint32_t direction) {
  if (s.asked[direction] == kStopped) return;
  const Vec3 axis = admissible_.grid().directions()[direction];
  if (!admissible_.within_limits(s.point.normal, axis)) return;
  if (s.asked[direction] == kUnknown && admissible_.still_stopped(s.point, direction, query_)) {
    s.asked[direction] = kStopped;
    return;
  }
  s.candidates.push_back({axis, 0.0, direction, s.asked[direction] == kClear});
}

/// The candidates are the wish, if admitted, and the coarser grid's directions within the window.
void Stations::open(std::size_t i, double window) {
  Station& s = stations_[i];
  window = std::min(window, kPi);
  if (window > 0.0 && s.window >= window) return;
  s.window = window, s.changed = s.coarse = true;
  start(s);
  if (window <= 0.0) return;
  const std::vector<Vec3>& grid = admissible_.grid().directions();
  if (s.asked.empty()) s.asked.assign(grid.size(), kUnknown);
  const double least = std::cos(window);
  for (const std::uint32_t k : admissible_.grid().rising(Admissibility::kAdmissibleLevel))
    if (dot(grid[k], s.wished) >= least) take(s, k);
}

/// The candidates are the wish, if admitted, and all directions round the chosen one.
void Stations::narrow(std::size_t i) {
  Station& s = stations_[i];
  s.coarse = false;
  if (s.window <= 0.0 || s.candidates.empty()) return;
  s.changed = true;
  start(s);
  const std::vector<Vec3>& grid = admissible_.grid().directions();
  const double least = std::cos(kAround);
  const std::vector<std::uint32_t>& rising = admissible_.grid().rising(admissible_.grid().level());
  const double spread = 2.0 * std::sin(kAround / 2.0);  // in z as in any direction
  const auto low = std::partition_point(rising.begin(), rising.end(),
                                        [&](std::uint32_t k) { return grid[k].z < s.chosen.z - spread; });
  for (auto k = low; k != rising.end() && grid[*k].z <= s.chosen.z + spread; ++k)
    if (dot(grid[*k], s.chosen) >= least) take(s, *k);
  price(i);
}

/// Costs by departure, and the candidates in the order that the choice requires.
void Stations::price(std::size_t i) {
  Station& s = stations_[i];
  const double weight = share(i);
  for (AxisCandidate& c : s.candidates) {
    const double angle = angle_between(c.axis, s.wished);
    c.cost = angle * angle * weight;
  }
  const auto lower = [](const AxisCandidate& a, const AxisCandidate& b) { return a.axis.z < b.axis.z; };
  // Most come in that order.
  const auto first = s.candidates.begin(), last = s.candidates.end();
  const auto of_grid =
      std::find_if(first, last, [](const AxisCandidate& c) { return c.direction != kNoDirection; });
  std::stable_sort(first, of_grid, lower);
  if (!std::is_sorted(of_grid, last, lower)) std::stable_sort(of_grid, last, lower);
  std::inplace_merge(first, of_grid, last, lower);
}

/// Nothing that was a candidate is admissible: all directions of the coarser grid that are, else of the finer
/// one.
void Stations::widen(std::size_t i) {
  Station& s = stations_[i];
  open(i, kPi);
  for (const bool finer : {false, true}) {
    if (finer)
      for (std::uint32_t k = DirectionGrid::count(Admissibility::kAdmissibleLevel);
           k < admissible_.grid().directions().size(); ++k)
        take(s, k);
    for (AxisCandidate& c : s.candidates) holds(s, c);
    std::erase_if(s.candidates, [](const AxisCandidate& c) { return !c.clear; });
    if (!s.candidates.empty()) break;
  }
  price(i);
}

}  // namespace tiltfeed::pathgen
