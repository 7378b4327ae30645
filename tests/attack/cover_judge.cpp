#include "tests/attack/cover_judge.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/judges/reach.h"
#include "tests/judges/surface_sample.h"

namespace tiltfeed::attack {
using namespace pathgen;
namespace {

/// Of a tool that stands in contact: its coordinates are rounded, mm.
constexpr double kRounding = 1e-6;
/// Ridges between rows that are as far apart as ridges allow on a plane are no higher on bent surfaces.
constexpr double kBent = 1.2;
/// Rounding of a flat coordinate, of the judge's own scale.
constexpr double kGraze = 1e-7;
/// Shank and holder keep their clearance to the side and downwards; aslant up to sqrt(2) times as much.
constexpr double kAslant = 1.5;
/// Nearer to the axis feature than this share of the tool the planner is cautious, and says so.
constexpr double kLeastRho = 0.5;

/// The reach, in steps, of what the header names; a little more, as places within are only looked at.
constexpr double kRings = 0.65, kRows = 0.5, kMeasured = 1.0, kLevels = 2.0, kMore = 1.1;
/// Directions in which places are looked at, and circles.
constexpr int kDirections = 12, kCircles = 2;
/// Of so many of the surface's places, where all those about each are looked at.
constexpr int kAskedWithin = 8;

/// The side step that is asked for, at most; on a plane a scallop of height h lies between passes so far
/// apart.
double widest_step(const PlanOptions& o) {
  const double r = o.cutter.nose_radius() > 0.0 ? o.cutter.nose_radius() : o.cutter.radius(),
               h = std::min(o.pattern.scallop, r);
  return std::max(o.pattern.side_step,
                  o.pattern.measure == StepMeasure::kScallop ? 2.0 * std::sqrt(h * (2.0 * r - h)) : 0.0);
}

double reach_of(const PlanOptions& o) {
  const double step = widest_step(o);
  switch (o.pattern.kind) {
    case PatternKind::kZLevel:
      return kMore * kLevels * std::max(step, o.pattern.step_down);
    case PatternKind::kSplit:
      return kMore * kMeasured *
             std::max(step, o.pattern.step_down / std::tan(o.pattern.split_slope.radians()));
    case PatternKind::kContour:
    case PatternKind::kSpiral:
      return kMore * kRings * step;
    default:
      break;
  }
  if (o.pattern.measure == StepMeasure::kRidge) return kMore * kRows * step;
  if (o.pattern.measure != StepMeasure::kFlat) return kMore * kMeasured * step;
  return o.pattern.angle.radians() == 0.0 && o.containment.boundary.empty() ? 0.0 : kMore * kRows * step;
}

/// What rows by their ridges may leave where evenly spaced ones leave less, mm: the ridge that the plan says
/// it allows, a little more where the surface is bent, and half the tolerance. 0 for other rows.
double ridge_of(const PlanOptions& o, double allowed) {
  if (o.pattern.measure != StepMeasure::kRidge) return 0.0;
  const double r = o.cutter.radius(), half = std::min(o.pattern.side_step / 2.0, r);
  const double most = 4.0 * (r - std::sqrt(r * r - half * half));
  return std::min(r, std::min(most, kBent * allowed) + o.tolerance / 2.0);
}

}  // namespace

bool CoverJudge::can_judge(const PlanOptions& o) {
  return o.axis.mode != AxisMode::kFree && o.axis.mode != AxisMode::kIndexed &&
         o.pattern.kind != PatternKind::kRough && o.pattern.kind != PatternKind::kPencil &&
         o.rest_more_than == 0.0 && o.radial_stock == 0.0 && o.axial_stock == 0.0;
}

CoverJudge::CoverJudge(const PlanOptions& options, const CheckedMesh& part, const Plan& planned,
                       const ToolPath& executed, const sim::Growth& growth)
    : options_(options),
      checked_(part),
      executed_(executed),
      growth_(growth),
      part_(part.mesh),
      tool_(options.cutter, growth),
      drawn_(drawn_out(options.cutter, distance(part.bounds.min, part.bounds.max)), growth),
      map_(options.axis, 1.0),
      nose_(options.cutter.nose_radius()),
      flat_radius_(options.cutter.type == CutterType::kBall || options.cutter.type == CutterType::kTaperBall
                       ? 0.0
                       : options.cutter.radius() - nose_),
      laid_(options.axis, mean_rho()),
      reach_(reach_of(options)),
      ridge_(ridge_of(options, planned.report.ridge)),
      places_(pass_places(planned.path)) {
  if (options.fixtures) fixtures_.emplace(options.fixtures->mesh);
}

std::vector<double> CoverJudge::pass_places(const ToolPath& path) const {
  std::vector<double> places, distinct;
  double last = sim::kInfinity, last_along = sim::kInfinity;
  for (const Move& move : path.moves) {
    const Point<Flat> flat = map_.flatten(reference(move.pose));
    const double place = across(flat), along = options_.pattern.along == Along::kX ? flat.x : flat.y;
    // A join, too, goes straight up a wall.
    const bool runs_on = std::abs(place - last) <= kGraze && std::abs(along - last_along) > kGraze;
    if (move.kind == MoveKind::kCut && runs_on) places.push_back(place);
    last = place, last_along = along;
  }
  std::sort(places.begin(), places.end());
  for (const double p : places)
    if (distinct.empty() || p > distinct.back() + kGraze) distinct.push_back(p);
  return distinct;
}

Pose CoverJudge::standing(Point<Part> at) const {
  const Vec3 axis = map_.axis_at(at);
  return {at - axis * nose_, axis};
}

/// The reference lies the rounding's radius along the normal and the flat's radius square to the axis, which
/// depends on where the reference is.
Pose CoverJudge::seat(Point<Part> p, Vec3 normal) const {
  const Point<Part> rounding = p + normal * (nose_ + growth_.allowance);
  Point<Part> at = rounding;
  for (int i = 0; i < 60 && flat_radius_ > 0.0; ++i) {
    const Vec3 axis = map_.axis_at(at), aside = normal - axis * dot(normal, axis);
    if (length(aside) < 1e-6) break;
    at = rounding + normalized(aside) * flat_radius_;
  }
  return standing(at);
}

/// Along the axis to the axis feature (inside work), or to where the part is left behind.
double CoverJudge::way_out(Point<Part> p) const {
  const bool inward = options_.axis.mode != AxisMode::kFixed && options_.axis.sense == Sense::kInward;
  if (inward) return std::abs(map_.flatten(p).z);
  return distance(checked_.bounds.min, checked_.bounds.max) + distance(p, checked_.bounds.min);
}

/// Within the tilt limit and the containment; between two points the axis turns by (E5) at most.
bool CoverJudge::is_wanted(const Pose& pose) const {
  const double turn = std::sqrt(8.0 * options_.tolerance / options_.cutter.shank_length);
  const double limit = options_.tilt_max.radians();
  if (limit < kPi && angle_between(pose.axis, options_.up) > limit - turn) return false;
  const Point<Flat> flat = map_.flatten(reference(pose));
  const Containment& c = options_.containment;
  const double around = options_.axis.mode == AxisMode::kCircle ? options_.axis.circle_radius + 1.0 : 1.0;
  const double height = options_.axis.mode == AxisMode::kFixed ? flat.z : std::abs(flat.z);
  if (options_.axis.mode != AxisMode::kFixed && height < std::max(kLeastRho, options_.cutter.diameter))
    return false;
  return c.first.contains(flat.x / around) && c.second.contains(flat.y) &&
         in_boundary(flat.x / around, flat.y) && c.height.contains(height - options_.tolerance) &&
         c.height.contains(height + options_.tolerance);
}

/// A tool let down through a hole has passed the axis feature, or the middle of a circle: that is another
/// column's matter.
bool CoverJudge::is_beyond(const AxisLine& column, const Pose& pose) const {
  const Point<Part> at = reference(pose);
  return distance(column.base + column.axis * map_.flatten(at).z, at) > options_.tolerance;
}

/// The whole tool stands there with its clearances and can be drawn out along its axis.
bool CoverJudge::is_free(const Pose& pose) const {
  const double keep[] = {-kRounding, kAslant * options_.shank.clearance + options_.tolerance,
                         kAslant * options_.holder.clearance + options_.tolerance};
  for (std::size_t i = 0; i < 3; ++i)
    if (tool_.clearance(part_, pose, sim::kToolParts[i], keep[i]).facet != kNoFacet) return false;
  if (fixtures_) {
    const FixtureRoom& room = options_.fixture_room;
    const double off[] = {kAslant * room.cutter + options_.tolerance,
                          kAslant * room.shank + options_.tolerance,
                          kAslant * room.holder + options_.tolerance};
    for (std::size_t i = 0; i < 3; ++i)
      for (const sim::ToolSolid* tool : {&tool_, &drawn_})
        if (tool->clearance(*fixtures_, pose, sim::kToolParts[i], off[i]).facet != kNoFacet) return false;
  }
  const bool inward = options_.axis.mode != AxisMode::kFixed && options_.axis.sense == Sense::kInward;
  if (!inward) {
    for (const sim::ToolPart part : sim::kToolParts)
      if (drawn_.clearance(part_, pose, part, -kRounding).facet != kNoFacet) return false;
    return true;
  }
  // Up to the axis feature nothing stands in the way of the tool as wide as it is anywhere.
  const Point<Part> at = reference(pose);
  const double way = way_out(at);
  if (part_
          .nearest({at + pose.axis * tool_.widest(), at + pose.axis * std::max(way, tool_.widest())},
                   tool_.widest() + options_.tolerance)
          .facet != kNoFacet)
    return false;
  return part_.winding_number(at) < 0.5;
}

double CoverJudge::leaves(Point<Part> p, const Pose& pose) const {
  const Vec3 off = p - pose.tip;
  const double h = dot(off, pose.axis);
  return tool_.cutting().distance(length(off - pose.axis * h), h).value;
}

/// Infinite where the tool cannot stand or is not wanted there. A pass may be out by the tolerance along
/// itself, which beside a wall is as deep as the wall is high: the worst counts.
double CoverJudge::left_by_pass(Point<Part> p, Point<Flat> flat, double place) const {
  const bool along_x = options_.pattern.along == Along::kX;
  const Deformation::Steps steps =
      map_.steps(along_x ? Point<Flat>{flat.x, place, flat.z} : Point<Flat>{place, flat.y, flat.z});
  const double aside = options_.tolerance / length(along_x ? steps.x : steps.y);
  double most = 0.0;
  for (const double shift : {0.0, kGraze, -kGraze, aside, -aside}) {
    const AxisLine line =
        along_x ? map_.axis_line(flat.x + shift, place) : map_.axis_line(place, flat.y + shift);
    const Point<Part> level = line.base + line.axis * flat.z;
    const Point<Part> high = level + line.axis * way_out(level);
    const Pose start{high - line.axis * nose_, line.axis};
    const sim::Hit drop = tool_.drop(part_, start);
    if (drop.facet == kNoFacet) return sim::kInfinity;
    const Pose pose{start.tip - line.axis * drop.value, line.axis};
    if (is_beyond(line, pose) || !is_wanted(pose) || !is_free({pose.tip + pose.axis * kRounding, pose.axis}))
      return sim::kInfinity;
    most = std::max(most, leaves(p, pose));
  }
  return most;
}

/// The distance of a convex solid that hardly turns has one valley on a straight move.
double CoverJudge::left_by_move(Point<Part> p, const Pose& a, const Pose& b, double way) const {
  const auto left = [&](double f) { return leaves(p, {lerp(a.tip, b.tip, f), slerp(a.axis, b.axis, f)}); };
  const int looks = 2 + static_cast<int>(way / options_.cutter.radius());
  int best = 0;
  double least = left(0.0);
  for (int k = 1; k <= looks; ++k) {
    const double here = left(static_cast<double>(k) / looks);
    if (here < least) least = here, best = k;
  }
  double low = std::max(0.0, (best - 1.0) / looks), high = std::min(1.0, (best + 1.0) / looks);
  for (int i = 0; i < 40; ++i) {
    const double one = low + (high - low) / 3.0, two = high - (high - low) / 3.0;
    (left(one) < left(two) ? high : low) = left(one) < left(two) ? two : one;
  }
  return std::min(least, left(0.5 * (low + high)));
}

double CoverJudge::left_by_path(Point<Part> p) const {
  double least = sim::kInfinity;
  const double reach = tool_.top();
  for (std::size_t i = 1; i < executed_.moves.size(); ++i) {
    if (executed_.moves[i].kind != MoveKind::kCut) continue;
    const Pose &a = executed_.moves[i - 1].pose, &b = executed_.moves[i].pose;
    const double far = distance(a.tip, b.tip) + angle_between(a.axis, b.axis) * reach;
    if (std::min(leaves(p, a), leaves(p, b)) - far > least) continue;
    least = std::min(least, left_by_move(p, a, b, far));
  }
  return least;
}

/// By even and odd crossings of a line to one side.
bool CoverJudge::in_boundary(double first, double second) const {
  const auto& b = options_.containment.boundary;
  bool in = b.empty();
  for (std::size_t i = 0, k = b.size() - 1; i < b.size(); k = i++)
    if ((b[i][1] > second) != (b[k][1] > second) &&
        first < b[i][0] + (b[k][0] - b[i][0]) * (second - b[i][1]) / (b[k][1] - b[i][1]))
      in = !in;
  return in;
}

/// The mean distance of what faces the tool from the axis feature, by area: where flat space is as long as
/// the part.
double CoverJudge::mean_rho() const {
  if (options_.axis.mode == AxisMode::kFixed) return 1.0;
  const Mesh& mesh = checked_.mesh;
  double sum = 0.0, area = 0.0;
  for (const auto& f : mesh.facets) {
    const Point<Part> a = mesh.vertices[f[0]], b = mesh.vertices[f[1]], c = mesh.vertices[f[2]];
    const Vec3 normal = cross(b - a, c - a);
    if (!(length(normal) > 0.0)) continue;
    const Point<Part> over =
        lerp(lerp(a, b, 0.5), c, 1.0 / 3.0) + normalized(normal) * (nose_ + growth_.allowance);
    const double rho = std::abs(map_.flatten(over).z);
    if (checked_.sides == Sides::kOutward && dot(normal, map_.axis_at(over)) <= 0.0) continue;
    sum += rho * length(normal), area += length(normal);
  }
  return area > 0.0 ? sum / area : 1.0;
}

/// The most that is left by a tool anywhere within the reach; infinite where it cannot stand at some place
/// there.
double CoverJudge::must_leave_within(Point<Part> p, Point<Flat> flat) const {
  double most = 0.0;
  std::array<double, kDirections> height{};  ///< of the outer circle
  for (int circle = 0; circle <= kCircles; ++circle)
    for (int k = 0; k < (circle == 0 ? 1 : kDirections); ++k) {
      const double turn = 2.0 * kPi * k / kDirections, away = reach_ * circle / kCircles;
      const AxisLine line = laid_.axis_line(flat.x + away * std::cos(turn), flat.y + away * std::sin(turn));
      const Point<Part> level = line.base + line.axis * flat.z;
      const Pose start{level + line.axis * (way_out(level) - nose_), line.axis};
      const sim::Hit drop = tool_.drop(part_, start);
      if (drop.facet == kNoFacet) return sim::kInfinity;
      const Pose pose{start.tip - line.axis * drop.value, line.axis};
      if (is_beyond(line, pose) || !is_wanted(pose) ||
          !is_free({pose.tip + pose.axis * kRounding, pose.axis}))
        return sim::kInfinity;
      most = std::max(most, leaves(p, pose));
      height[static_cast<std::size_t>(k)] = map_.flatten(reference(pose)).z;
    }
  if (options_.pattern.kind != PatternKind::kZLevel) return most;
  // A level passes between three places in a row and the three opposite to them.
  const auto at = [&](int k) { return height[static_cast<std::size_t>((k + kDirections) % kDirections)]; };
  for (int k = 0; k < kDirections; ++k) {
    const int o = k + kDirections / 2;
    const double low = std::max({at(k - 1), at(k), at(k + 1)}),
                 high = std::min({at(o - 1), at(o), at(o + 1)});
    if (high - low > options_.pattern.step_down) return most;
  }
  return sim::kInfinity;
}

double CoverJudge::must_leave(Point<Part> p, const Pose& seat) const {
  if (reach_ > 0.0) return std::max(ridge_, must_leave_within(p, laid_.flatten(reference(seat))));
  const Point<Flat> flat = map_.flatten(reference(seat));
  const auto above = std::lower_bound(places_.begin(), places_.end(), across(flat));
  if (above == places_.begin() || above == places_.end()) return sim::kInfinity;
  return std::min(left_by_pass(p, flat, above[-1]), left_by_pass(p, flat, *above));
}

void CoverJudge::look_at(Point<Part> p, Vec3 normal, Found& found) const {
  const Pose pose = seat(p, normal);
  const double lean =
      options_.cutter.type == CutterType::kTaperBall ? std::sin(options_.cutter.taper.radians()) : 0.0;
  if (!(dot(pose.axis, normal) > lean + 0.02)) return;
  if (std::abs(leaves(p, pose)) > kRounding || !is_wanted(pose) || !is_free(pose)) return;
  const double must = must_leave(p, pose);
  if (must == sim::kInfinity) return;
  ++found.points;
  const double excess = left_by_path(p) - must;
  if (excess > found.excess) found.excess = excess, found.at = p, found.seat = pose;
}

CoverJudge::Found CoverJudge::look(int surface_points) const {
  Found found;
  if (reach_ == 0.0 && places_.size() < 2) return found;
  SurfaceSample surface(options_.only_faces ? options_.only_faces->mesh : checked_.mesh);
  const int asked = reach_ > 0.0 ? surface_points / kAskedWithin : surface_points;
  for (int i = 0; i < surface_points && static_cast<int>(found.points) < asked; ++i) {
    const SurfaceSample::At at = surface.next();
    look_at(at.point, at.normal, found);
    if (checked_.sides == Sides::kBoth) look_at(at.point, -at.normal, found);
  }
  return found;
}

}  // namespace tiltfeed::attack
