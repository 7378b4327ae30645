#include "pathgen/pattern/region_pattern.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "pathgen/envelope/thinning.h"
#include "pathgen/pattern/level_set.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

namespace {

/// Ends of two pieces nearer than this are one place (mm): the envelope of each is exact there.
constexpr double kJoined = 1e-6;
constexpr std::size_t kCurvesPerReport = 64;

}  // namespace

std::vector<Pass> lay_curve(const FlatCurve& curve, Heights& heights) {
  std::vector<Pass> laid;
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    const FlatLine line = line_between(curve[i], curve[i + 1]);
    if (line.length == 0.0) continue;
    Envelope& envelope = heights.envelope();
    LineEnvelope found =
        envelope.is_crowded(line) ? envelope.along_short(line, kAnyHeight) : envelope.along(line);
    leave_held(found, line);
    for (Pass& pass : found.passes) {
      const bool on = !laid.empty() && distance(laid.back().back().centre, pass.front().centre) < kJoined;
      if (!on) laid.emplace_back();
      laid.back().insert(laid.back().end(), pass.begin() + (on ? 1 : 0), pass.end());
    }
  }
  std::erase_if(laid, [](const Pass& pass) { return pass.size() < 2; });
  if (laid.empty() || distance(curve.front(), curve.back()) > 0.0) return laid;
  if (distance(laid.front().front().centre, laid.back().back().centre) >= kJoined) return laid;
  if (laid.size() == 1) {
    laid[0].back() = laid[0].front();
  } else {  // one piece over the curve's start
    laid.back().insert(laid.back().end(), laid.front().begin() + 1, laid.front().end());
    laid.erase(laid.begin());
  }
  return laid;
}

Result<std::vector<FlatRegion>> silhouette(const ClField& field, double spacing,
                                           const EnvelopeOptions& options, const Progress& progress) {
  const auto grid = make_level_grid(field, spacing, options, std::nullopt, progress);
  if (!grid) return tl::unexpected(grid.error());
  if (grid->x.wraps || grid->y.wraps)
    return fail(Code::kInput,
                "the surface goes all round the axis, so that it has no border to start from: give "
                "containment.boundary");
  Heights heights(field, options);
  const LevelSet set(*grid, kNoSurface, heights, options.tolerance);
  std::vector<FlatPolygon> polygons;
  for (const Loop& loop : set.loops()) {
    polygons.emplace_back();
    for (const Crossing& c : loop.crossings) polygons.back().push_back({c.inside.x, c.inside.y});
  }
  return regions_of(polygons);
}

Result<Contours> region_pattern(const ClField& field, const ContourOptions& options,
                                const Progress& progress) {
  const Pattern& pattern = options.pattern;
  if (!(pattern.side_step > 0.0)) return fail(Code::kInput, "pattern.side_step_mm must be a positive length");
  auto regions = options.boundary.empty() ? silhouette(field, pattern.side_step, options.envelope, progress)
                                          : Result<std::vector<FlatRegion>>(regions_of({options.boundary}));
  if (!regions) return tl::unexpected(regions.error());
  const auto curves = region_curves(*regions, {pattern.side_step, options.envelope.tolerance, pattern.climb,
                                               pattern.kind == PatternKind::kSpiral});
  if (!curves) return tl::unexpected(curves.error());

  std::vector<const FlatCurve*> all;
  for (const auto& group : curves->groups)
    for (const FlatCurve& curve : group) all.push_back(&curve);
  std::vector<std::vector<Pass>> laid(all.size());
  tbb::enumerable_thread_specific<Heights> heights([&] { return Heights(field, options.envelope); });
  for (std::size_t from = 0; from < all.size(); from += kCurvesPerReport) {
    const std::size_t to = std::min(from + kCurvesPerReport, all.size());
    tbb::parallel_for(from, to, [&](std::size_t k) { laid[k] = lay_curve(*all[k], heights.local()); });
    if (progress && !progress("curves", static_cast<double>(to) / static_cast<double>(all.size())))
      return cancelled();
  }
  Contours result;
  std::size_t next = 0;
  for (const auto& group : curves->groups) {
    std::vector<Pass> passes;
    for (std::size_t k = 0; k < group.size(); ++k)
      for (Pass& pass : laid[next++]) passes.push_back(std::move(pass));
    if (!passes.empty()) result.groups.push_back(std::move(passes));
  }
  if (result.groups.empty())
    return fail(Code::kUnreachable,
                "nothing is left of the region half a pattern.side_step_mm inside its "
                "border, or it has no surface: check containment");
  if (curves->loops_in_spiral > 0)
    result.warnings.push_back(std::to_string(curves->loops_in_spiral) +
                              " rings stay closed loops: a spiral cannot go round holes");
  return result;
}

}  // namespace tiltfeed::pathgen
