#include "pathgen/free_axis/free_links.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "pathgen/free_axis/surface_joins.h"
#include "pathgen/linking/linking.h"
#include "pathgen/linking/nearest_ends.h"
#include "pathgen/linking/opposite_wall.h"
#include "pathgen/linking/run_order.h"
#include "pathgen/tool/blank_solid.h"
#include "pathgen/tool/face_containment.h"

namespace tiltfeed::pathgen {

namespace {

/// Moves over the sphere turn and travel by at most this, rad (3 degrees): chords dip by 0.04 percent of it,
/// which the sphere has to spare.
constexpr double kSphereStep = 0.052;
constexpr double kSphereSpare = 1.0005;
/// Where it leans as far as it may the axis turns by no more than this in one move (20 degrees); a move over
/// the sphere is halved so often before there is no way.
constexpr double kSphereTurn = 0.35;
constexpr int kSphereHalvings = 8;
/// Directions are outwards if they lean inwards by less than this: rounding.
constexpr double kOutwards = -1e-6;
/// A short way is tried where it is not longer than so many clearances, and turns by at most this (rad).
constexpr double kShortWay = 6.0, kShortTurn = 1.0;

/// Of the work, the order of the nearest ends; the other is linked after it.
constexpr double kNearestShare = 0.5;

PlanOptions grown(PlanOptions options, double by) {
  options.allowance += by;
  options.fixture_room.cutter += by, options.fixture_room.shank += by, options.fixture_room.holder += by;
  return options;
}

struct Polar {
  double tilt, azimuth;
};

class RunLinker {
 public:
  RunLinker(const Admissibility& admissible, const ToolAxisOptions& how, const PlanOptions& options,
            const std::vector<std::uint32_t>& source, const LinkStock& stock)
      : admissible_(admissible),
        tool_(admissible.tool()),
        strayed_(tool_.tree(), grown(options, stray_of_rapids(options.tolerance)), 0.0),
        options_(options),
        source_(source),
        stock_(stock),
        joins_(admissible, how, options.links.join_distance),
        faces_(options.only_faces ? std::make_unique<const FaceContainment>(options) : nullptr) {
    Box box = tool_.bounds();
    if (options.blank)
      for (const Point<Part> corner : {options.blank->bounds().min, options.blank->bounds().max})
        box = grown(box, corner);
    centre_ = lerp(box.min, box.max, 0.5);
    radius_ = (distance(box.min, box.max) / 2.0 + options.links.clearance + tool_.widest()) * kSphereSpare;
    height_ = reference_height(options.cutter);
    const Vec3 up = admissible.up();
    e_ = normalized(std::abs(up.x) < 0.6 ? cross(up, Vec3{1, 0, 0}) : cross(up, Vec3{0, 1, 0}));
    f_ = cross(up, e_);
    step_ = std::sqrt(8.0 * tool_.ball() * options.tolerance);
  }

  /// From the nearest end to the nearest end that is left.
  FreeLinked run_nearest(const std::vector<ToolAxisRun>& runs, bool reversible, const ReportShare& report) {
    std::vector<Point<Part>> ends;
    for (const ToolAxisRun& r : runs)
      ends.push_back(r.front().point.centre), ends.push_back(r.back().point.centre);
    NearestEnds left(ends);
    if (!reversible)
      for (std::uint32_t i = 0; i < runs.size(); ++i) left.remove(2 * i + 1);
    Point<Part> at = start();
    Watch watch(report, runs.size());
    while (const auto end = watch.next() ? left.nearest(at) : std::nullopt) {
      const ToolAxisRun& next = runs[*end / 2];
      const bool reversed = *end % 2 == 1;
      left.remove(*end);
      if (reversible) left.remove(*end ^ 1u);
      if (!add(next, reversed)) continue;
      at = reversed ? next.front().point.centre : next.back().point.centre;
    }
    return finished();
  }

  FreeLinked run_in_order(const std::vector<ToolAxisRun>& runs, const std::vector<OrderedRun>& order,
                          const ReportShare& report) {
    Watch watch(report, order.size());
    for (const OrderedRun& next : order) {
      if (!watch.next()) break;
      add(runs[next.run], next.reversed);
    }
    return finished();
  }

  LinkTime link_time() const {
    const double plunge = options_.plunge_feed.mm_per_min() / 60.0;
    return LinkTime({.rapid = options_.links.rapid,
                     .up = admissible_.up(),
                     .centre = centre_,
                     .radius = radius_,
                     .lift = options_.links.clearance,
                     .short_way = kShortWay * options_.links.clearance,
                     .short_turn = Angle::from_radians(kShortTurn),
                     .plunge_seconds = options_.links.approach / plunge});
  }

  std::vector<OrderedRun> order(const std::vector<ToolAxisRun>& runs, bool reversible,
                                const LinkTime& time) const {
    std::vector<RunEnds> ends;
    for (const ToolAxisRun& r : runs) ends.push_back({pose(r.front(), 0.0), pose(r.back(), 0.0)});
    return order_runs(ends, reversible, time, start(), admissible_.up());
  }

 private:
  Point<Part> start() const { return centre_ + admissible_.up() * radius_; }

  FreeLinked finished() {
    if (down_) retract();
    out_.tested += joins_.tested();
    return std::move(out_);
  }

  bool add(const ToolAxisRun& run, bool reversed) {
    const auto point = [&](std::size_t i) -> const ToolAxisPoint& {
      return run[reversed ? run.size() - 1 - i : i];
    };
    if (!go_over(point(0)) && !go_short(point(0)) && !go_round(point(0))) return ++out_.skipped_runs, false;
    for (std::size_t i = 1; i < run.size(); ++i)
      push(pose(point(i), 0.0), MoveKind::kCut, point(i).point.facet);
    down_ = point(run.size() - 1);
    return true;
  }

  Pose pose(const ToolAxisPoint& p, double lift) const {
    return pose_at(p.point.centre + p.axis * lift, p.axis, height_);
  }

  /// `from`: how far over it, along its axis, the tool is.
  void plunge(const ToolAxisPoint& to, double from) {
    double over = options_.links.approach;
    if (stock_.clear_down_to)
      over = std::max(over, stock_.clear_down_to(to.point.centre, to.axis, from, over));
    if (over < from) push(pose(to, over), MoveKind::kRapid);
    push(pose(to, 0.0), MoveKind::kPlunge, to.point.facet);
  }

  /// (J4) Over the surface, as one pass.
  bool go_over(const ToolAxisPoint& to) {
    if (!down_) return false;
    const auto way = joins_.join(*down_, to);
    if (!way) return false;
    const auto leaves = [this](const ToolAxisPoint& p) { return !faces_->near_ball_on_way(p.point.centre); };
    if (faces_ && std::any_of(way->begin(), way->end(), leaves)) return false;
    for (const ToolAxisPoint& p : *way) push(pose(p, 0.0), MoveKind::kCut, p.point.facet);
    ++out_.joins;
    down_.reset();
    return true;
  }

  /// (J3) Up by the clearance, over, and down.
  bool go_short(const ToolAxisPoint& to) {
    if (!down_) return false;
    const double lift = options_.links.clearance;
    const Pose from = pose(*down_, lift), over = pose(to, lift);
    const double turn = angle_between(from.axis, over.axis);
    if (distance(from.tip, over.tip) > kShortWay * lift || turn > kShortTurn || !clear(from, over))
      return false;
    if (stock_.short_way_in && stock_.short_way_in(pose(*down_, 0.0), from, over)) return false;
    push(from, MoveKind::kRapid);
    divide(from, over);
    plunge(to, lift);
    ++out_.short_links;
    down_.reset();
    return true;
  }

  /// In moves that turn by at most kSphereStep.
  void divide(const Pose& from, const Pose& to) {
    const int parts =
        std::max(1, static_cast<int>(std::ceil(angle_between(from.axis, to.axis) / kSphereStep)));
    for (int k = 1; k <= parts; ++k) {
      const double f = static_cast<double>(k) / parts;
      push({lerp(from.tip, to.tip, f), slerp(from.axis, to.axis, f)}, MoveKind::kRapid);
    }
  }

  /// Of a tool off the part, wherever it strays: all of it as it stands, the ball too, and nothing swept,
  /// unlike clear_along().
  bool clear(const Pose& from, const Pose& to) {
    if (!admissible_.within_tilt(from.axis, to.axis)) return false;
    const double way =
        distance(from.tip, to.tip) + (tool_.top() + height_) * angle_between(from.axis, to.axis);
    const int steps = std::max(1, static_cast<int>(std::ceil(way / step_)));
    for (int k = 0; k <= steps; ++k) {
      const double f = static_cast<double>(k) / steps;
      const Vec3 axis = slerp(from.axis, to.axis, f);
      ++out_.tested;
      if (strayed_.hit(lerp(from.tip, to.tip, f) + axis * height_, axis)) return false;
    }
    return true;
  }

  /// Where the tip is on the sphere when the tool is drawn back from there.
  Pose on_sphere(const ToolAxisPoint& p) const {
    const Pose inside = pose(p, 0.0);
    const Vec3 m = inside.tip - centre_;
    const double along = dot(m, p.axis), c = squared_length(m) - radius_ * radius_;
    return {inside.tip + p.axis * (std::sqrt(std::max(0.0, along * along - c)) - along), p.axis};
  }

  void retract() {
    push(on_sphere(*down_), MoveKind::kRapid);
    ++out_.retracts;
    down_.reset();
  }

  /// (J1) Out to the sphere, over it, in again. The tool stays up where there is no way.
  bool go_round(const ToolAxisPoint& to) {
    if (down_) retract();
    const Pose entry = on_sphere(to);
    if (out_.moves.empty()) {
      push(entry, MoveKind::kRapid);
    } else {
      const auto way = find_way(out_.moves.back().pose, entry);
      if (!way) return false;
      for (const Pose& p : *way) push(p, MoveKind::kRapid);
    }
    plunge(to, distance(entry.tip, pose(to, 0.0).tip));
    return true;
  }

  using Way = std::vector<Pose>;

  /// (J2) The first of the ways over the sphere that leans outwards and within the tilt limit all along.
  std::optional<Way> find_way(const Pose& from, const Pose& to) const {
    const Vec3 out_from = outwards(from.tip), out_to = outwards(to.tip);
    const bool opposite = dot(out_from, out_to) < -0.999;
    if (!opposite) {
      for (const bool polar : {false, true}) {
        Way way;
        if (turn(from.axis, to.axis, out_from, out_to, polar, way)) return way;
      }
    }
    for (const bool over_top : {false, true}) {
      if (opposite && !over_top) continue;
      Way way;
      const Vec3 lean_from = leaning(out_from), lean_to = leaning(out_to);
      if (!turn_in_place(from.axis, lean_from, out_from, way)) continue;
      const bool there =
          over_top ? travel(out_from, admissible_.up(), way) && travel(admissible_.up(), out_to, way)
                   : travel(out_from, out_to, way);
      if (there && turn_in_place(lean_to, to.axis, out_to, way)) return way;
    }
    return std::nullopt;
  }

  Vec3 outwards(Point<Part> p) const { return normalized(p - centre_); }
  /// Outwards, as far as the tilt limit lets the axis lean.
  Vec3 leaning(Vec3 out) const { return admissible_.nearest_tilt(out); }

  Polar polar(Vec3 axis) const {
    const Vec3 up = admissible_.up();
    return {angle_between(axis, up), std::atan2(dot(axis, f_), dot(axis, e_))};
  }
  Vec3 between(Vec3 a, Vec3 b, double f, bool by_polar) const {
    if (!by_polar) return slerp(a, b, f);
    const Polar p = polar(a), q = polar(b);
    double swing = q.azimuth - p.azimuth;
    swing -= 2.0 * kPi * std::round(swing / (2.0 * kPi));
    const double tilt = p.tilt + (q.tilt - p.tilt) * f, azimuth = p.azimuth + swing * f;
    return admissible_.up() * std::cos(tilt) +
           (e_ * std::cos(azimuth) + f_ * std::sin(azimuth)) * std::sin(tilt);
  }

  /// Turns the axis while the tip goes over the sphere.
  bool turn(Vec3 a, Vec3 b, Vec3 out_a, Vec3 out_b, bool by_polar, Way& way) const {
    if (!by_polar && dot(a, b) < -0.999) return false;
    double widest = std::max(angle_between(a, b), angle_between(out_a, out_b));
    if (by_polar) widest = std::max(widest, kPi);
    const int parts = std::max(1, static_cast<int>(std::ceil(widest / kSphereStep)));
    Vec3 last = a;
    for (int k = 1; k <= parts; ++k) {
      const double f = static_cast<double>(k) / parts;
      const Vec3 out = slerp(out_a, out_b, f), axis = k == parts ? b : between(a, b, f, by_polar);
      if (!admissible_.within_tilt(last, axis) || dot(axis, out) < kOutwards) return false;
      way.push_back({centre_ + out * radius_, axis});
      last = axis;
    }
    return true;
  }

  bool turn_in_place(Vec3 a, Vec3 b, Vec3 out, Way& way) const {
    const std::size_t before = way.size();
    for (const bool by_polar : {false, true}) {
      way.resize(before);
      if (turn(a, b, out, out, by_polar, way)) return true;
    }
    return false;
  }

  /// Over the sphere on a great circle, the axis outwards.
  bool travel(Vec3 from, Vec3 to, Way& way) const {
    if (dot(from, to) < -0.9999) return false;
    const int parts = std::max(1, static_cast<int>(std::ceil(angle_between(from, to) / kSphereStep)));
    Vec3 last = leaning(from);
    for (int k = 1; k <= parts; ++k)
      if (!travel_part(from, to, (k - 1.0) / parts, static_cast<double>(k) / parts, kSphereHalvings, last,
                       way))
        return false;
    return true;
  }
  /// Below the part the leaning axis turns faster than the tip goes, and a long turn at the tilt limit would
  /// lean over further: in halves of that way, until they are short enough.
  bool travel_part(Vec3 from, Vec3 to, double f, double g, int halvings, Vec3& last, Way& way) const {
    const Vec3 out = slerp(from, to, g), axis = leaning(out);
    if (dot(axis, out) < kOutwards) return false;
    if (angle_between(last, axis) > kSphereTurn || !admissible_.within_tilt(last, axis)) {
      const double middle = (f + g) / 2.0;
      return halvings > 0 && travel_part(from, to, f, middle, halvings - 1, last, way) &&
             travel_part(from, to, middle, g, halvings - 1, last, way);
    }
    way.push_back({centre_ + out * radius_, axis});
    last = axis;
    return true;
  }

  void push(const Pose& at, MoveKind kind, std::uint32_t facet = kNoFacet) {
    out_.moves.push_back({at, kind, facet == kNoFacet ? kNoFacet : source_[facet]});
  }

  const Admissibility& admissible_;
  const SweptTool& tool_;
  const SweptTool strayed_;  ///< grown by what rapids stray
  const PlanOptions& options_;
  const std::vector<std::uint32_t>& source_;
  const LinkStock& stock_;
  Point<Part> centre_;
  double radius_ = 0.0, height_ = 0.0, step_ = 0.0;
  Vec3 e_, f_;
  SurfaceJoins joins_;
  std::unique_ptr<const FaceContainment> faces_;  ///< that joins keep to; null: all of the part
  std::optional<ToolAxisPoint> down_;             ///< where a run ended, while the tool is there
  FreeLinked out_;
};

}  // namespace

FreeLinked link_runs(const std::vector<ToolAxisRun>& runs, bool reversible, const Admissibility& admissible,
                     const ToolAxisOptions& how, const PlanOptions& options,
                     const std::vector<std::uint32_t>& source, const LinkStock& stock,
                     const ReportShare& report) {
  const bool ordered = runs.size() > 2 && runs.size() <= kMostOrderedRuns;
  RunLinker linker(admissible, how, options, source, stock);
  const LinkTime time = linker.link_time();
  FreeLinked nearest =
      linker.run_nearest(runs, reversible, part_of(report, 0.0, ordered ? kNearestShare : 1.0));
  if (!ordered || (report && !report(kNearestShare))) return nearest;
  RunLinker other(admissible, how, options, source, stock);
  FreeLinked quick =
      other.run_in_order(runs, other.order(runs, reversible, time), part_of(report, kNearestShare, 1.0));
  quick.tested += nearest.tested;
  nearest.tested = quick.tested;
  const bool better =
      quick.skipped_runs < nearest.skipped_runs ||
      (quick.skipped_runs == nearest.skipped_runs && time.of(quick.moves) < time.of(nearest.moves));
  return better ? std::move(quick) : std::move(nearest);
}

}  // namespace tiltfeed::pathgen
