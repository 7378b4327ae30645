#include "pathgen/pattern/contour_trace.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tiltfeed::pathgen {

namespace {

/// Share of the tolerance to which borders are found by halving.
constexpr double kFineShare = 0.125;
/// Points stand off the border by this share of the tolerance, so that moves round what is convex need not
/// cut into it.
constexpr double kStandOff = 1.0;
/// How far aside of the middle of a move the surface must rise, in tolerances.
constexpr double kAside = 2.0;
/// Moves shorter than this share of the tolerance are not halved.
constexpr double kShortestShare = 0.5;
constexpr int kMostMoveHalvings = 14;
/// How far beside a move the border is looked for, in its lengths, and in how many steps: nearer than kReach
/// the two halves are shorter than the whole; in the corner of a narrow notch it is further off.
constexpr double kReach = 0.75, kFarReach = 3.0;
constexpr double kLookSteps = 16.0;
/// Crossings nearer to each other than this share of the grid's diagonal are one: (Z3).
constexpr double kThinShare = 0.3;
/// A border over which the surface rises by more tolerances than this is a wall.
constexpr double kWallRise = 8.0;
/// A loop shorter than this, in tolerances, goes round nothing that counts.
constexpr double kLeastLoop = 8.0;
/// Where the surface gives way to a shut column is found this closely, in tolerances.
constexpr double kShutEnd = 16.0;
/// A move in the air, where the border is not found again, is made if it is no longer than this (tolerances).
constexpr double kShortAir = 4.0;
/// A step of the flat plane to measure it by, mm.
constexpr double kProbe = 1e-4;

struct Direction2 {
  double x = 0.0, y = 0.0;
};
Place moved(Place p, Direction2 d, double by) { return {p.x + d.x * by, p.y + d.y * by}; }

/// A place of the contour and the pass's point there.
struct Stop {
  Place place;
  EnvelopePoint point;
  bool shut = false;  ///< no point: inside is no surface but a column where the tool may not be, or the level
                      ///< is not in its own column there
};

double length_of(const Pass& pass) {
  double sum = 0.0;
  for (std::size_t i = 1; i < pass.size(); ++i) sum += distance(pass[i - 1].centre, pass[i].centre);
  return sum;
}

class Tracer {
 public:
  Tracer(const TraceOptions& options, Heights& heights)
      : options_(options),
        heights_(heights),
        map_(heights.map()),
        border_(options.level + options.tolerance * kRiseShare) {}

  Trace run(const Loop& loop) {
    std::vector<Stop> stops;
    const std::vector<Crossing> crossings = kept(loop);
    const std::size_t n = crossings.size();
    for (std::size_t i = 0; i < n; ++i) {
      // Across the contour: a grid line may cross it at any angle.
      const Direction2 along = direction(crossings[(i + n - 1) % n].outside, crossings[(i + 1) % n].outside);
      if (!wanted(crossings[i].outside)) {
        stops.push_back(as_found(crossings[i]));
        continue;
      }
      const bool ends_meet = i == 0 || i + 1 == n;  // perhaps beyond a seam
      stops.push_back(stop_at(crossings[i], ends_meet ? direction(crossings[i].inside, crossings[i].outside)
                                                      : Direction2{along.y, -along.x}));
    }
    for (std::size_t i = 0; i < stops.size(); ++i) {
      emit(stops[i]);
      Stop next = stops[(i + 1) % n];
      next.place = near({next.place.x, next.place.y, 0.0}, stops[i].place);  // over the seam
      if (wanted(stops[i].place) && wanted(next.place)) refine(stops[i], next, 0);
    }
    return finish();
  }

 private:
  /// The crossings without those next to each other where two grid lines meet on the contour.
  std::vector<Crossing> kept(const Loop& loop) const {
    const auto& all = loop.crossings;
    double longest = 0.0;
    for (std::size_t i = 0; i + 1 < all.size(); ++i)
      longest = std::max(longest, distance(all[i].outside, all[i + 1].outside));
    std::vector<Crossing> some;
    for (const Crossing& c : all)
      if (some.empty() || distance(some.back().outside, c.outside) > kThinShare * longest) some.push_back(c);
    return some.size() < 3 ? all : some;
  }

  /// On whichever side of a seam.
  bool wanted(Place p) const {
    if (!options_.wanted) return true;
    const double turn_x = map_.period_x(), turn_y = map_.period_y();
    const Place home = near({p.x, p.y, 0.0}, {});
    for (const double x : {home.x - turn_x, home.x, home.x + turn_x})
      for (const double y : {home.y - turn_y, home.y, home.y + turn_y})
        if (options_.wanted->holds(x, y)) return true;
    return false;
  }

  Stop as_found(const Crossing& c) const { return {c.outside, at_level({}, c.outside), false}; }

  /// The tool's place on the axis line there.
  EnvelopePoint at_level(EnvelopePoint point, Place place) const {
    point.flat = {place.x, place.y, options_.level};
    const AxisLine line = map_.axis_line(place.x, place.y);
    point.axis = line.axis;
    point.centre = line.base + line.axis * options_.level;
    return point;
  }

  /// mm of the flat plane for `mm` of part space at the level, along d.
  double flat_length(Place p, Direction2 d, double mm) const {
    const Place q = moved(p, d, kProbe);
    const double real =
        distance(map_.unflatten({p.x, p.y, options_.level}), map_.unflatten({q.x, q.y, options_.level}));
    return mm * kProbe / std::max(real, 0.01 * kProbe);
  }

  static Direction2 direction(Place from, Place to) {
    const double length = distance(from, to);
    return length > 0.0 ? Direction2{(to.x - from.x) / length, (to.y - from.y) / length}
                        : Direction2{1.0, 0.0};
  }

  /// On the border between the two places of a crossing, and off it by the stand-off in the direction `out`.
  Stop stop_at(const Crossing& c, Direction2 out) {
    Crossing border = c;
    const double fine =
        flat_length(c.outside, direction(c.inside, c.outside), options_.tolerance * kFineShare);
    bisect(heights_, border_, fine, border.outside, border.inside);
    Place place = moved(border.outside, out, flat_length(c.outside, out, options_.tolerance * kStandOff));
    if (heights_.is_over(place, border_)) place = border.outside;
    EnvelopePoint point = heights_.contact(border.inside);
    const bool shut =
        point.flat.z == kShut || !map_.in_column({place.x, place.y, options_.level}, kLeastInColumn);
    const bool wall = !(point.flat.z <= border_ + kWallRise * options_.tolerance);
    point = at_level(std::move(point), place);
    if (wall) {
      const Place beside = moved(place, out, kProbe);
      const Vec3 v = map_.unflatten({beside.x, beside.y, options_.level}) - point.centre;
      point.normal = normalized(v - point.axis * dot(v, point.axis));
    }
    return {place, point, shut};
  }

  Place near(Point<Flat> f, Place reference) const {
    const Point<Flat> image = map_.beside(f, {reference.x, reference.y, 0.0});
    return {image.x, image.y};
  }

  /// Beyond a pole of the mode point there is no column of its own.
  bool has_column(Place p) const {
    return map_.frame().mode != AxisMode::kPoint || std::abs(p.y) <= kPi / 2.0 * map_.scale_y();
  }

  /// Emits what is needed strictly between two stops.
  void refine(const Stop& a, const Stop& b, int depth) {
    if (!has_column(a.place) || !has_column(b.place)) return cut();
    const Point<Flat> half = map_.flatten(lerp(a.point.centre, b.point.centre, 0.5));
    const Place middle = near(half, lerp(a.place, b.place, 0.5));
    const Direction2 along = direction(a.place, b.place), out{along.y, -along.x};
    const bool straight = length(cross(a.point.axis, b.point.axis)) <= options_.max_axis_step &&
                          std::abs(half.z - options_.level) <= options_.tolerance * kRiseShare;
    const double top = options_.level + options_.tolerance;
    const bool solid = !a.shut && !b.shut;
    const bool rises =
        solid && straight && rises_beside(middle, out) && (!is_cut(a, b) || cut_beside(middle, out));
    // The envelope all along the move costs the most: it is asked last, and where nothing else decides.
    std::optional<bool> asked;
    Pass under;
    const auto clear = [&] {
      if (!asked)
        asked = !heights_.is_over(middle, top) && heights_.keeps_under(top, a.place, b.place, under);
      return *asked;
    };
    if (rises && quarters_fit(a.place, b.place, out, top) && clear() && stays_near(under, out)) return;
    const double size = distance(a.point.centre, b.point.centre);
    if (!solid && (a.shut == b.shut || size <= kShutEnd * options_.tolerance)) return cut();
    std::optional<Stop> stop;
    if (depth < kMostMoveHalvings && size > options_.tolerance * kShortestShare)
      for (const double reach : {kReach, kFarReach})
        if (!stop) stop = border_near(middle, out, reach * distance(a.place, b.place));
    if (stop && distance(stop->place, a.place) > 0.0 && distance(stop->place, b.place) > 0.0) {
      refine(a, *stop, depth + 1);
      emit(*stop);
      refine(*stop, b, depth + 1);
    } else if (!solid || !straight || (size > kShortAir * options_.tolerance && !rises) || !clear()) {
      trace_.left_out += solid ? 1 : 0;
      cut();
    }
  }

  /// A wall that a move only grazes may lie between the places where highest() looked: it does so within the
  /// envelope's tolerance sideways, and most of all there. A border to and fro over the move leaves it there.
  bool quarters_fit(Place a, Place b, Direction2 out, double top) {
    const Place early = lerp(a, b, 0.25), late = lerp(a, b, 0.75);
    return !heights_.is_over(early, top) && !heights_.is_over(late, top) && rises_beside(early, out) &&
           rises_beside(late, out);
  }

  /// Between two places of the cutting part something else may hold the tool off: it needs a place there, for
  /// whoever leaves it out.
  bool is_cut(const Stop& a, const Stop& b) {
    Envelope& envelope = heights_.envelope();
    return envelope.has_guards() && envelope.is_cut(a.point) && envelope.is_cut(b.point);
  }
  bool cut_beside(Place p, Direction2 out) { return heights_.cut_is_over(inwards(p, out), border_); }

  /// Where what is under a move is so low, square to itself, that the border may be further off than it
  /// should be, the border is still beside the move.
  bool stays_near(const Pass& under, Direction2 out) {
    return std::all_of(under.begin(), under.end(), [&](const EnvelopePoint& p) {
      const double off = (options_.level - p.flat.z) * dot(p.normal, p.axis);
      return off <= kAside * options_.tolerance || rises_beside({p.flat.x, p.flat.y}, out);
    });
  }

  /// As far aside of a move as the border may be.
  Place inwards(Place p, Direction2 out) const {
    return moved(p, out, -flat_length(p, out, kAside * options_.tolerance));
  }
  bool rises_beside(Place p, Direction2 out) { return heights_.is_over(inwards(p, out), border_); }

  /// The border on the line across a move, looked for as far as `reach` to the side where it must be.
  std::optional<Stop> border_near(Place from, Direction2 out, double reach) {
    const bool inside = heights_.is_over(from, border_);
    const Direction2 way = inside ? out : Direction2{-out.x, -out.y};
    const double least = flat_length(from, out, options_.tolerance);
    const double step = std::max(least, reach / kLookSteps);
    Place last = from;
    for (double gone = std::min(least, step); gone <= reach + least; gone += step) {
      const Place next = moved(from, way, gone);
      if (heights_.is_over(next, border_) != inside)
        return stop_at(inside ? Crossing{next, last} : Crossing{last, next}, out);
      last = next;
    }
    return std::nullopt;
  }

  void emit(const Stop& stop) {
    if (!stop.shut) pass_.push_back(stop.point);
  }
  /// The move from the last point is not made.
  void cut() { cuts_.push_back(pass_.size()); }

  Trace finish() {
    if (pass_.empty()) return {};
    for (EnvelopePoint& p : pass_) {
      const Place home = near(p.flat, {});
      p.flat.x = home.x, p.flat.y = home.y;
    }
    if (cuts_.empty()) {
      pass_.push_back(pass_.front());
      if (length_of(pass_) < kLeastLoop * options_.tolerance) return {};
      trace_.passes.push_back(std::move(pass_));
    } else {  // from the first cut round to it again
      std::rotate(pass_.begin(), pass_.begin() + static_cast<std::ptrdiff_t>(cuts_.front() % pass_.size()),
                  pass_.end());
      std::size_t from = 0;
      for (std::size_t k = 1; k <= cuts_.size(); ++k) {
        const std::size_t to = k < cuts_.size() ? cuts_[k] - cuts_.front() : pass_.size();
        if (to > from + 1)
          trace_.passes.emplace_back(pass_.begin() + static_cast<std::ptrdiff_t>(from),
                                     pass_.begin() + static_cast<std::ptrdiff_t>(to));
        from = to;
      }
    }
    if (options_.climb) {
      for (Pass& pass : trace_.passes) std::reverse(pass.begin(), pass.end());
      std::reverse(trace_.passes.begin(), trace_.passes.end());
    }
    return std::move(trace_);
  }

  const TraceOptions& options_;
  Heights& heights_;
  const Deformation& map_;
  double border_;  ///< z' over which a place is inside
  Pass pass_;
  std::vector<std::size_t> cuts_;  ///< before which points of the pass it is cut, rising
  Trace trace_;
};

}  // namespace

Trace trace_contour(const Loop& loop, const TraceOptions& options, Heights& heights) {
  return Tracer(options, heights).run(loop);
}

}  // namespace tiltfeed::pathgen
