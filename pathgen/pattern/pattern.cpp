#include "pathgen/pattern/pattern.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/envelope/thinning.h"
#include "pathgen/options/side_step.h"
#include "pathgen/pattern/contours.h"
#include "pathgen/pattern/pencil.h"
#include "pathgen/pattern/region_pattern.h"
#include "pathgen/pattern/rough_layers.h"
#include "pathgen/pattern/row_layout.h"
#include "pathgen/progress/watch.h"
#include "pathgen/tool/blank_solid.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

namespace {

/// Where a pattern is split by slope, both sides overlap by this share of the side step.
constexpr double kOverlapShare = 1.0;
/// Of the work there, the contours.
constexpr double kWallsShare = 0.7;
/// Of the cutter's radius, and of the blank's diagonal: how far apart its surface is looked at.
constexpr double kBlankShare = 0.25, kBlankPlaces = 400.0;

/// (Z1) No level where the axis turns too fast: on the point, line or circle itself x' or y' says nothing.
Interval useful(Interval levels, const Deformation& map) {
  if (map.frame().mode == AxisMode::kFixed) return levels;
  if (map.s() < 0.0) levels.high = std::min(levels.high, -kLeastAxisDistance);
  if (map.s() > 0.0 && std::isfinite(levels.low)) levels.low = std::max(levels.low, kLeastAxisDistance);
  return levels;
}

ContourOptions contour_options(const PlanOptions& options, const EnvelopeOptions& envelope,
                               const Region& region, const Deformation& map) {
  ContourOptions contours{envelope, options.pattern, region.boundary(), useful(region.levels(), map)};
  if (contours.pattern.side_step <= 0.0) contours.pattern.side_step = contours.pattern.step_down;
  return contours;
}

/// For work whose steps, in this order, each count from 0 to 1.
Progress in_order(const Progress& progress, std::vector<std::string> steps, double from, double to) {
  if (!progress) return {};
  return [&progress, steps = std::move(steps), from, to](const char* step, double share) {
    const auto at = static_cast<double>(std::find(steps.begin(), steps.end(), step) - steps.begin());
    return progress(step, from + (to - from) * (at + share) / static_cast<double>(steps.size()));
  };
}

/// Contours as passes: without what may not be cut.
Passes from_contours(Contours&& contours, const ClField& field, const PlanOptions& options,
                     const EnvelopeOptions& limits, double smoothing, const Progress& progress) {
  const PointRules rules(options, field);
  Envelope envelope(field.surface, field.deformation, field.index, limits);
  const ToleranceBudget budget(options.tolerance);
  const double too_low = budget.envelope() + budget.thinning();  // (B1): contours are not thinned
  const bool guarded = field.surface.pieces().size() > 1;
  Passes passes;
  passes.as_given = true;
  std::size_t points = 0;
  for (const std::vector<Pass>& group : contours.groups)
    for (const Pass& pass : group) points += pass.size();
  const ReportShare report = [&](double share) { return !progress || progress("held", share); };
  Watch watch(report, points);
  for (std::vector<Pass>& group : contours.groups) {
    for (const Pass& pass : group) {
      passes.traced += pass.size();
      for (const EnvelopePoint& p : pass) passes.top = std::max(passes.top, p.flat.z);
    }
    leave_out(group, [&](const EnvelopePoint& p) {
      if (!watch.next()) return false;
      if (!rules.may_cut(p, passes.refusals)) return true;
      if (!guarded) return false;
      // A contour is found between grid lines: shank and holder are asked again at each of its points.
      if (!envelope.rises_over(p.flat.x, p.flat.y, p.flat.z + too_low)) return false;
      const auto held = envelope.at(p.flat.x, p.flat.y);
      if (!held) return false;
      const ToolPiece& piece = rules.touching(*held);
      if (piece.part == ToolPart::kCutter && !piece.at_fixtures) return false;
      rules.refuse(*held, passes.refusals);
      return true;
    });
    if (smoothing > 0.0) smooth(group, smoothing, rules, envelope, passes.smoothed);
    for (Pass& pass : group) pass = spaced(std::move(pass), field.deformation, limits.max_distance);
    passes.rows.push_back(std::move(group));
  }
  return passes;
}

Passes within(Contours&& found, const Region& region, const ClField& field, const PlanOptions& options,
              const EnvelopeOptions& envelope, double smoothing, const Progress& progress,
              std::vector<std::string>& warnings) {
  warnings.insert(warnings.end(), found.warnings.begin(), found.warnings.end());
  if (region.limited())
    for (auto& group : found.groups)
      group = keep_where(
          group, field.deformation, [&](const EnvelopePoint& p) { return region.over(p.flat); }, 0.0);
  return from_contours(std::move(found), field, options, envelope, smoothing, progress);
}

/// They are the first `share_of_all` of the work that `progress` counts.
Result<Passes> trace_levels(const ClField& field, const PlanOptions& options, const EnvelopeOptions& envelope,
                            const Progress& progress, double share_of_all,
                            std::vector<std::string>& warnings) {
  const Region region(options.containment, field.deformation);
  ContourOptions contours = contour_options(options, envelope, region, field.deformation);
  if (region.limited()) contours.window = region.within(field.index.bounds());
  const Progress steps = in_order(progress, {"grid", "levels", "contours", "held"}, 0.0, share_of_all);
  auto found = z_level(field, contours, steps);
  if (!found) return tl::unexpected(found.error());
  return within(std::move(*found), region, field, options, envelope, 0.0, steps, warnings);
}

/// Walls by contours, first; the rest by rows.
Result<Passes> trace_split(const ClField& field, const PlanOptions& options, const EnvelopeOptions& envelope,
                           double thinning, const Progress& progress, std::vector<std::string>& warnings) {
  auto walls = trace_levels(field, options, envelope, progress, kWallsShare, warnings);
  if (!walls) return walls;
  const Progress steps = in_order(progress, {"passes"}, kWallsShare, 1.0);
  auto rows = trace_raster(field, options, envelope, thinning,
                           [&](double share) { return !steps || steps("passes", share); });
  if (!rows) return rows;
  const double overlap = asked_step(options) * kOverlapShare;
  for (auto& group : walls->rows)
    group = steep_of(group, field.deformation, options.pattern.split_slope, overlap);
  for (auto& row : rows->rows) row = shallow_of(row, field.deformation, options.pattern.split_slope, overlap);
  std::move(rows->rows.begin(), rows->rows.end(), std::back_inserter(walls->rows));
  walls->add(*rows);
  walls->steep = 0;  // contours have them
  return walls;
}

/// The region's border moved inwards, as loops or as a spiral.
Result<Passes> trace_region(const ClField& field, const PlanOptions& options, const EnvelopeOptions& envelope,
                            const Progress& progress, std::vector<std::string>& warnings) {
  const Region region(options.containment, field.deformation);
  const Progress steps = in_order(progress, {"grid", "curves", "held"}, 0.0, 1.0);
  auto found = region_pattern(field, contour_options(options, envelope, region, field.deformation), steps);
  if (!found) return tl::unexpected(found.error());
  return within(std::move(*found), region, field, options, envelope, options.smoothing, steps, warnings);
}

/// Along the creases.
Result<Passes> trace_pencil(const ClField& field, const PlanOptions& options, const EnvelopeOptions& envelope,
                            double thinning, const Progress& progress, std::vector<std::string>& warnings) {
  const Region region(options.containment, field.deformation);
  const Progress steps = in_order(progress, {"lines", "creases", "laid", "held"}, 0.0, 1.0);
  auto found = pencil(field, region.within(field.bounds),
                      contour_options(options, envelope, region, field.deformation), options.cutter.diameter,
                      thinning, steps);
  if (!found) return tl::unexpected(found.error());
  return within(std::move(*found), region, field, options, envelope, options.smoothing, steps, warnings);
}

/// Where the cutter meets the blank, and z' of its highest place.
struct BlankExtent {
  FlatBounds bounds;
  double top = -std::numeric_limits<double>::infinity();
};

/// `apart`: of the places that are looked at; `radius`: of the cutter; mm.
BlankExtent extent_of(const BlankSolid& blank, const Deformation& map, double apart, double radius) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const bool x_is_angle = map.period_x() > 0.0, y_is_angle = map.frame().mode != AxisMode::kFixed;
  // Seen from the axis feature the cutter is so wide.
  const auto half = [&](bool is_angle, double distance, double scale) {
    if (!is_angle) return radius;
    return scale * (distance > radius ? std::asin(radius / distance) : kPi);
  };
  BlankExtent extent{{kNone, -kNone, kNone, -kNone}};
  FlatBounds& b = extent.bounds;
  for (const Point<Part>& p : blank.places(apart)) {
    const Point<Flat> f = map.flatten(p);
    const Deformation::Distances away = map.distances(p);
    const double x = half(x_is_angle, away.r, map.scale_x()), y = half(y_is_angle, away.rho, map.scale_y());
    b.min_x = std::min(b.min_x, f.x - x), b.max_x = std::max(b.max_x, f.x + x);
    b.min_y = std::min(b.min_y, f.y - y), b.max_y = std::max(b.max_y, f.y + y);
    extent.top = std::max(extent.top, f.z);
  }
  return extent;
}

/// No more than one turn.
void keep_to_a_turn(double& low, double& high, double period) {
  if (period > 0.0 && high - low > period) low = -period / 2.0, high = period / 2.0;
}

/// About a point: no row runs on over a pole. What is there lies in the columns half a turn on.
void keep_to_poles(FlatBounds& bounds, const Deformation& map) {
  if (map.frame().mode != AxisMode::kPoint) return;
  const double pole = kPi / 2.0 * map.scale_y();
  bounds.min_y = std::max(bounds.min_y, -pole), bounds.max_y = std::min(bounds.max_y, pole);
}

/// Layers from the top of the blank, of the part, or of the containment, down.
Result<Passes> trace_rough(const ClField& field, const PlanOptions& options, const EnvelopeOptions& envelope,
                           const Progress& progress, std::vector<std::string>& warnings) {
  const Region region(options.containment, field.deformation);
  FlatBounds bounds = field.bounds;
  std::optional<BlankExtent> blank;
  if (options.blank) {
    const Box& box = options.blank->bounds();
    blank =
        extent_of(*options.blank, field.deformation,
                  std::max(kBlankShare * options.cutter.radius(), distance(box.min, box.max) / kBlankPlaces),
                  field.surface.pieces().front().outer);
    bounds = {std::min(bounds.min_x, blank->bounds.min_x), std::max(bounds.max_x, blank->bounds.max_x),
              std::min(bounds.min_y, blank->bounds.min_y), std::max(bounds.max_y, blank->bounds.max_y)};
    keep_to_a_turn(bounds.min_x, bounds.max_x, field.deformation.period_x());
    keep_to_a_turn(bounds.min_y, bounds.max_y, field.deformation.period_y());
    keep_to_poles(bounds, field.deformation);
  }
  const auto raster =
      lay_rows(field.index, region.within(bounds), options.pattern, options.pattern.side_step);
  if (!raster) return tl::unexpected(raster.error());
  std::vector<FlatLine> lines;
  for (double k = 0.0; k < raster->count; ++k)
    for (const FlatLine& piece : region.inside(raster->row(k))) lines.push_back(piece);
  ContourOptions contours = contour_options(options, envelope, region, field.deformation);
  // Beside walls the envelope ends where they begin; there the blank is cut down to where the part ends.
  if (blank && field.deformation.frame().mode == AxisMode::kFixed && !std::isfinite(contours.height.low)) {
    double lowest = std::numeric_limits<double>::infinity();
    const Mesh& mesh = field.surface.mesh();
    for (std::size_t i = 0; i < field.surface.part_facets(); ++i)
      for (const std::uint32_t v : mesh.facets[i])
        lowest = std::min(lowest, field.deformation.flatten(mesh.vertices[v]).z);
    contours.height.low = lowest + reference_height(options.cutter);
  }
  double top = region.levels().high;
  if (blank) {
    top = std::min(top, blank->top + reference_height(options.cutter));
  } else if (!std::isfinite(top)) {
    top = -std::numeric_limits<double>::infinity();
    for (Point<Part> v : field.surface.mesh().vertices) top = std::max(top, field.deformation.flatten(v).z);
    top += reference_height(options.cutter) + options.allowance + options.axial_stock;
  }
  const Progress steps = in_order(progress, {"lines", "layers", "held"}, 0.0, 1.0);
  // Stock stands beside the part, too, where a containment says how far.
  auto found = rough_layers(field, lines, std::min(top, contours.height.high), blank || region.limited(),
                            contours, steps);
  if (!found) return tl::unexpected(found.error());
  warnings.insert(warnings.end(), found->warnings.begin(), found->warnings.end());
  std::vector<double> floors = std::move(found->floors);
  // Over the containment the blank still stands.
  if (blank) floors.front() = blank->top + reference_height(options.cutter);
  Passes passes = from_contours(std::move(*found), field, options, envelope, 0.0, steps);
  passes.floors = std::move(floors);
  return passes;
}

}  // namespace

Result<Passes> trace_pattern(const ClField& field, const PlanOptions& options,
                             const EnvelopeOptions& envelope, double thinning, const Progress& progress,
                             std::vector<std::string>& warnings) {
  switch (options.pattern.kind) {
    case PatternKind::kRaster:
      return trace_raster(field, options, envelope, thinning,
                          [&](double share) { return !progress || progress("passes", share); });
    case PatternKind::kZLevel:
      return trace_levels(field, options, envelope, progress, 1.0, warnings);
    case PatternKind::kSplit:
      return trace_split(field, options, envelope, thinning, progress, warnings);
    case PatternKind::kContour:
    case PatternKind::kSpiral:
      return trace_region(field, options, envelope, progress, warnings);
    case PatternKind::kRough:
      return trace_rough(field, options, envelope, progress, warnings);
    case PatternKind::kPencil:
      return trace_pencil(field, options, envelope, thinning, progress, warnings);
  }
  return fail(Code::kInput, "pattern.kind is unknown");
}

}  // namespace tiltfeed::pathgen
