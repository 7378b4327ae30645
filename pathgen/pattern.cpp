#include "pathgen/pattern.h"

#include <algorithm>

#include "pathgen/contours.h"

namespace tiltfeed {

namespace {

/// Where a pattern is split by slope, both sides overlap by this share of the side step.
constexpr double kOverlapShare = 1.0;

/// Contours as passes: without what may not be cut.
Passes from_contours(Contours&& contours, const ClField& field, const PlanOptions& options) {
  const PassRules rules(options, field);
  Passes passes;
  passes.as_given = true;
  for (std::vector<Pass>& group : contours.groups) {
    for (const Pass& pass : group) {
      passes.traced += pass.size();
      for (const EnvelopePoint& p : pass) passes.top = std::max(passes.top, p.flat.z);
    }
    leave_out(group, [&](const EnvelopePoint& p) { return !rules.may_cut(p, passes.refusals); });
    passes.rows.push_back(std::move(group));
  }
  return passes;
}

Result<Passes> trace_levels(const ClField& field, const PlanOptions& options, const EnvelopeOptions& envelope,
                            const Progress& progress, std::vector<std::string>& warnings) {
  ContourOptions contours{envelope, options.pattern, {}, {}};
  if (contours.pattern.side_step <= 0.0) contours.pattern.side_step = contours.pattern.step_down;
  const Region region(options.containment, field.deformation);
  contours.height = region.levels();
  auto found = z_level(field, contours, progress);
  if (!found) return tl::unexpected(found.error());
  warnings.insert(warnings.end(), found->warnings.begin(), found->warnings.end());
  if (region.limited())
    for (auto& group : found->groups)
      group = keep_where(
          group, field.deformation, [&](const EnvelopePoint& p) { return region.over(p.flat); }, 0.0);
  return from_contours(std::move(*found), field, options);
}

/// Walls by contours, first; the rest by rows.
Result<Passes> trace_split(const ClField& field, const PlanOptions& options, const EnvelopeOptions& envelope,
                           double thinning, const Progress& progress, std::vector<std::string>& warnings) {
  auto walls = trace_levels(field, options, envelope, progress, warnings);
  if (!walls) return walls;
  auto rows = trace_raster(field, options, envelope, thinning,
                           [&](double share) { return !progress || progress("passes", share); });
  if (!rows) return rows;
  const double overlap = options.pattern.side_step * kOverlapShare;
  for (auto& group : walls->rows)
    group = steep_of(group, field.deformation, options.pattern.split_slope, overlap);
  for (auto& row : rows->rows) row = shallow_of(row, field.deformation, options.pattern.split_slope, overlap);
  std::move(rows->rows.begin(), rows->rows.end(), std::back_inserter(walls->rows));
  walls->add(*rows);
  walls->steep = 0;  // contours have them
  return walls;
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
      return trace_levels(field, options, envelope, progress, warnings);
    case PatternKind::kSplit:
      return trace_split(field, options, envelope, thinning, progress, warnings);
    case PatternKind::kContour:
    case PatternKind::kSpiral:
    case PatternKind::kRough:
      break;
  }
  return fail(Code::kInput,
              "pattern.kind: contour, spiral and rough are not made by this version; use raster, "
              "z_level or split");
}

}  // namespace tiltfeed
