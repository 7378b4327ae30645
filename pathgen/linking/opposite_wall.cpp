#include "pathgen/linking/opposite_wall.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "kinematics/basics/tolerance_budget.h"
#include "kinematics/joints/joint_moves.h"
#include "pathgen/envelope/thinning.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

namespace {

/// A cone is checked as this many cylinders, each as wide as the cone's piece at its top.
constexpr int kStepsPerCone = 8;
/// Of the way down: how closely the end of a rapid is looked for.
constexpr double kRapidEnd = 1.0 / 64.0;
/// Of a cylinder's radius: how far apart places on its axis are asked what is within the radius.
constexpr double kTouchStep = 0.5;

PlanOptions grown(PlanOptions options, double by) {
  options.allowance += by;
  options.fixture_room.cutter += by, options.fixture_room.shank += by, options.fixture_room.holder += by;
  return options;
}

std::array<Point<Part>, 3> corners_of(const Mesh& mesh, std::uint32_t facet) {
  const Facet& f = mesh.facets[facet];
  return {mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]};
}

}  // namespace

double stray_of_rapids(double tolerance) {
  return 2.0 * kRapidToleranceFactor * ToleranceBudget(tolerance).joints() + tolerance;
}

OppositeWall::OppositeWall(const Mesh& mesh, const Deformation& deformation, const PlanOptions& options,
                           double clearance_z)
    : mesh_(mesh),
      map_(deformation),
      clearance_z_(clearance_z),
      reference_height_(reference_height(options.cutter)),
      // A cylinder of radius r that steps by s leaves s^2 / (8 r) of a corner.
      step_(std::sqrt(8.0 * options.cutter.radius() * ToleranceBudget(options.tolerance).corner())) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  low_ = {kFar, kFar, kFar}, high_ = {-kFar, -kFar, -kFar};
  const auto hold = [this](const Mesh& of) {
    for (Point<Part> v : of.vertices) {
      low_ = {std::min(low_.x, v.x), std::min(low_.y, v.y), std::min(low_.z, v.z)};
      high_ = {std::max(high_.x, v.x), std::max(high_.y, v.y), std::max(high_.z, v.z)};
    }
  };
  hold(mesh);
  if (options.fixtures) hold(options.fixtures->mesh);
  tool_ = tool_of(options);
  const ToleranceBudget budget(options.tolerance);
  between_ = tool_of(grown(options, -budget.envelope() - budget.thinning()));
  const double approach = options.links.approach;
  strayed_ = tool_of(grown(options, stray_of_rapids(options.tolerance) + 0.5 * approach));
  over_stock_ = tool_of(grown(options, 0.5 * approach));
  approaching_ = tool_of(grown(options, approach));
  double widest = 0.0;
  for (const Tool* tool : {&strayed_, &approaching_})
    for (const Cylinder& c : *tool) widest = std::max(widest, c.radius);
  note_ends(mesh, widest);
  if (options.fixtures) note_ends(options.fixtures->mesh, widest);
}

/// The facets that may come within the radius of where a column ends.
void OppositeWall::note_ends(const Mesh& mesh, double radius) {
  const bool inside_work = map_.s() < 0.0, circle = map_.frame().mode == AxisMode::kCircle;
  std::vector<NearFeature> near;
  for (std::uint32_t i = 0; (inside_work || circle) && i < mesh.facets.size(); ++i) {
    const auto [u, v, w] = corners_of(mesh, i);
    const Point<Part> centre = Point<Part>{} + (from_origin(u) + from_origin(v) + from_origin(w)) / 3.0;
    const double reach = std::max({distance(centre, u), distance(centre, v), distance(centre, w)}) + radius;
    const Deformation::Distances away = map_.distances(centre);
    if ((inside_work && away.rho < reach) || (circle && away.r < reach)) near.push_back({i, centre, reach});
  }
  if (!near.empty()) ends_.emplace(&mesh, ColumnEnds(std::move(near)));
}

/// Of the mesh from the end of a column, mm; infinite where it is further than the tool is wide.
double OppositeWall::off_end(const Mesh& mesh, Point<Part> end) const {
  double least = std::numeric_limits<double>::infinity();
  const auto near = ends_.find(&mesh);
  if (near == ends_.end()) return least;
  near->second.first_over(end, [&](PatchId facet) {
    const std::array<Point<Part>, 3> corner = corners_of(mesh, facet);
    const Vec3 n = normalized(cross(corner[1] - corner[0], corner[2] - corner[0]));
    least = std::min(least, distance_to_triangle(end, corner, n));
    return false;
  });
  return least;
}

/// A wall that lies at the column's end, and from there on at the cylinder's side as far down as its top at
/// the end of the way: no patch within the column is where the wall ends.
bool OppositeWall::stands_in_wall(const Cylinder& c, Point<Part> reference, Vec3 axis, double column,
                                  double travel) const {
  if (c.from >= column || off_end(*c.mesh, reference + axis * column) >= c.radius - c.margin) return false;
  // The wall may end below the end of the way.
  const double top = c.to + travel, way = column - top;
  if (way <= 0.0) return true;
  const double steps = std::ceil(way / c.radius);
  for (double k = 0.0; k < steps; ++k)
    if (!clearance_of(c).touches(reference + axis * (top + way * k / steps))) return false;
  return true;
}

OppositeWall::Tool OppositeWall::tool_of(const PlanOptions& options) {
  Tool tool;
  add_tool(options, mesh_, tool);
  if (options.fixtures) add_tool(as_of_fixtures(options), options.fixtures->mesh, tool);
  return tool;
}

void OppositeWall::add_tool(const PlanOptions& options, const Mesh& mesh, Tool& tool) {
  bool first = true;
  const double margin = ray_margin(mesh);
  for (const ToolPiece& piece : all_pieces(options)) {
    if (piece.part == ToolPart::kHolder && options.holder.reaction == Reaction::kReport) continue;
    if (piece.part == ToolPart::kShank && options.shank.reaction == Reaction::kReport) continue;
    const double start = piece.above_reference, end = start + piece.length;
    if (end <= 0.0) continue;
    const int steps = piece.has_cone() ? kStepsPerCone : 1;
    for (int k = 1; k <= steps; ++k) {
      const double low = start + piece.length * (k - 1) / steps, high = start + piece.length * k / steps;
      double radius = piece.outer;
      if (piece.has_cone())
        radius = std::min(radius, piece.flat + piece.corner * piece.taper_cos +
                                      (high - start + piece.corner) * piece.taper_sin / piece.taper_cos);
      // The first starts at the reference itself, where the way is known to be free.
      tool.push_back({&mesh, first ? 0.0 : low, high, radius, margin, nullptr});
      first = false;
    }
    reach_ = std::max(reach_, end);
  }
}

ShankCollision& OppositeWall::clearance_of(const Cylinder& c) {
  if (!c.clearance) c.clearance = std::make_unique<ShankCollision>(*c.mesh, c.radius);
  return *c.clearance;
}

/// Does a ball of the radius on the way between two points stay outside of the box round the part?
bool OppositeWall::beyond_part(Point<Part> from, Point<Part> to, double radius) const {
  double first = 0.0, last = 1.0;
  const auto cut = [&](double a, double b, double low, double high) {
    if (a == b) {
      if (a < low || a > high) last = -1.0;
      return;
    }
    const double enter = (low - a) / (b - a), leave = (high - a) / (b - a);
    first = std::max(first, std::min(enter, leave)), last = std::min(last, std::max(enter, leave));
  };
  cut(from.x, to.x, low_.x - radius, high_.x + radius);
  cut(from.y, to.y, low_.y - radius, high_.y + radius);
  cut(from.z, to.z, low_.z - radius, high_.z + radius);
  return first > last;
}

/// Does the tool, its reference going `travel` up from where it is, hit something further up than `column`?
bool OppositeWall::blocked(const Tool& tool, Point<Part> reference, Vec3 axis, double column,
                           double travel) const {
  if (column >= reach_ + travel && (ends_.empty() || !std::isfinite(column))) return false;
  return std::any_of(tool.begin(), tool.end(), [&](const Cylinder& c) {
    if (stands_in_wall(c, reference, axis, column, travel)) return true;
    if (column >= c.to + travel) return false;
    // What is further down the column is clear.
    if (beyond_part(reference + axis * std::max(c.from, column - c.radius),
                    reference + axis * (c.to + travel), c.radius))
      return false;
    const Point<Part> start = reference + axis * c.from;
    // Where a cylinder starts beyond the column, nothing is known yet of its place.
    if (c.from > column - c.radius && c.from > 0.0 && clearance_of(c).touches(start)) return true;
    return clearance_of(c).blocked(start, axis, c.to - c.from + travel);
  });
}

/// Does the tool, grown by the approach, come near to anything beyond the column on its way from z' up to the
/// clearance surface? Nothing is known of where it begins, which may be beyond already.
bool OppositeWall::approaches(const AxisLine& line, Point<Flat> place) const {
  const Point<Part> reference = line.base + line.axis * place.z;
  const double column = map_.column_length(place), travel = std::max(0.0, clearance_z_ - place.z);
  if (blocked(approaching_, reference, line.axis, column, travel)) return true;
  return std::any_of(approaching_.begin(), approaching_.end(), [&](const Cylinder& c) {
    const double low = std::max(c.from, column - c.radius), high = c.to + travel;
    if (low >= high || beyond_part(reference + line.axis * low, reference + line.axis * high, c.radius))
      return false;
    const double steps = std::ceil((high - low) / (kTouchStep * c.radius));
    for (double k = 0.0; k <= steps; ++k)
      if (clearance_of(c).touches(reference + line.axis * (low + (high - low) * k / steps))) return true;
    return false;
  });
}

double OppositeWall::rapid_end(Point<Flat> place, double to) {
  const AxisLine line = map_.axis_line(place.x, place.y);
  const auto in_way = [&](double z) { return approaches(line, {place.x, place.y, z}); };
  if (to >= clearance_z_ || !in_way(to)) return to;
  if (in_way(clearance_z_)) return clearance_z_;
  double low = to, high = clearance_z_;  // the less of the way is left, the less is in it
  while (high - low > kRapidEnd * (clearance_z_ - to)) {
    const double middle = 0.5 * (low + high);
    (in_way(middle) ? low : high) = middle;
  }
  return high;
}

double OppositeWall::travel_from(const EnvelopePoint& p) const {
  return std::max(0.0, clearance_z_ - p.flat.z);
}

/// Of a move between two places of the tool, so that neither end of it goes further in one than step_.
double OppositeWall::steps_of(Point<Part> from, Vec3 from_axis, Point<Part> to, Vec3 to_axis) const {
  const double way = std::max(distance(from, to), distance(from + from_axis * reach_, to + to_axis * reach_));
  return std::max(1.0, std::ceil(way / step_));
}

/// Of one line. Its moves are looked at between their ends, too, as closely as is_clear() does.
std::uint64_t OppositeWall::trim(std::vector<Pass>& passes, Watch& watch) {
  std::uint64_t count = 0;
  std::vector<Pass> kept;
  Pass piece;
  const auto end_piece = [&] {
    if (!piece.empty()) kept.push_back(std::move(piece));
    piece.clear();
  };
  for (const Pass& pass : passes) {
    for (std::size_t i = 0; i < pass.size() && watch.next(); ++i) {
      const EnvelopePoint& to = pass[i];
      const bool came = !piece.empty(), goes_on = !keeps_off(tool_, to);
      if (!goes_on) ++count;
      if (i > 0 && (came || goes_on)) {
        const Stretch clear = clear_of(pass[i - 1], to, came, goes_on);
        if (clear.broken && came) {
          if (clear.before) piece.push_back(*clear.before);
          end_piece();
        }
        if (clear.broken && goes_on) {
          if (came) ++count;
          if (clear.behind) piece.push_back(*clear.behind);
        }
      }
      if (goes_on) piece.push_back(to);
    }
    end_piece();
  }
  passes = std::move(kept);
  return count;
}

/// Of the move between the two, from its start (where `starts`) and to its end (where `ends`).
OppositeWall::Stretch OppositeWall::clear_of(const EnvelopePoint& from, const EnvelopePoint& to, bool starts,
                                             bool ends) {
  const double steps = steps_of(from.centre, from.axis, to.centre, to.axis);
  const auto place = [&](double k) { return on_move(from, to, k / steps, map_); };
  double first = 0.0, last = steps;
  while (first + 1.0 < steps && starts && !keeps_off(between_, place(first + 1.0))) ++first;
  if (starts && ends && first + 1.0 >= steps) return {};
  while (last - 1.0 > first && ends && !keeps_off(between_, place(last - 1.0))) --last;
  // As a pass's end it has to be clear as every point is.
  while (first > 0.0 && keeps_off(tool_, place(first))) --first;
  while (last < steps && keeps_off(tool_, place(last))) ++last;
  Stretch found{true, {}, {}};
  if (starts && first > 0.0) found.before = place(first);
  if (ends && last < steps) found.behind = place(last);
  return found;
}

std::uint64_t OppositeWall::trim(std::vector<std::vector<Pass>>& lines, const ReportShare& report) {
  // Mostly the tool ends before the column does.
  std::vector<std::uint8_t> reaches_over(lines.size(), 0);
  tbb::parallel_for(std::size_t{0}, lines.size(), [&](std::size_t i) {
    for (const Pass& pass : lines[i])
      for (const EnvelopePoint& p : pass)
        if (const double column = map_.column_length(p.flat);
            column < reach_ + travel_from(p) || (!ends_.empty() && std::isfinite(column)))
          reaches_over[i] = 1;
  });
  std::uint64_t count = 0, points = 0;
  for (const std::vector<Pass>& line : lines)
    for (const Pass& pass : line) points += pass.size();
  Watch watch(report, points);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (reaches_over[i] == 0) {
      for (const Pass& pass : lines[i]) watch.next(pass.size());
      continue;
    }
    count += trim(lines[i], watch);
  }
  return count;
}

bool OppositeWall::keeps_off(Tool& tool, const EnvelopePoint& stand) const {
  return blocked(tool, stand.centre, stand.axis, map_.column_length(stand.flat), travel_from(stand));
}

Point<Part> OppositeWall::reference_of(const Pose& pose) const {
  return pose.tip + pose.axis * reference_height_;
}

bool OppositeWall::is_astray(const Pose& pose) const { return map_.is_astray(reference_of(pose), pose.axis); }

/// All of the tool, of whose place nothing is known.
bool OppositeWall::stands_in_part(Tool& tool, const Pose& pose) const {
  return std::any_of(tool.begin(), tool.end(), [&](Cylinder& c) {
    const Point<Part> start = reference_of(pose) + pose.axis * c.from;
    return clearance_of(c).touches(start) || clearance_of(c).blocked(start, pose.axis, c.to - c.from);
  });
}

bool OppositeWall::is_clear(Tool& tool, const Pose& from, const Pose& to) const {
  const auto column_of = [&](const Pose& pose) {
    return map_.column_length(map_.flatten(reference_of(pose)));
  };
  // The clearance surface of a circle runs on past the axis of Theta, into columns that it does not clear.
  const bool strays = is_astray(from) || is_astray(to);
  if (!strays && ends_.empty() && column_of(from) >= reach_ && column_of(to) >= reach_) return true;
  const double steps = steps_of(from.tip, from.axis, to.tip, to.axis);
  for (double k = 1.0; k <= steps; ++k) {
    const Pose pose{lerp(from.tip, to.tip, k / steps), slerp(from.axis, to.axis, k / steps)};
    if (strays ? stands_in_part(tool, pose)
               : blocked(tool, reference_of(pose), pose.axis, column_of(pose), 0.0))
      return false;
  }
  return true;
}

}  // namespace tiltfeed::pathgen
