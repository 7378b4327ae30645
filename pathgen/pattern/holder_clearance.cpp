#include "pathgen/pattern/holder_clearance.h"

#include <algorithm>

namespace tiltfeed::pathgen {

namespace {

/// A holder that stands this much (mm) too low still counts as clear: rounding.
constexpr double kClear = 1e-6;
/// Of the work on the hulls of shank and holder, making them.
constexpr double kCellsShare = 0.7;

/// Drops the hulls of shank and holder that lie wholly under the passes.
void drop_low(FlatHulls& hulls, const PassDepth& passes, const ReportShare& report) {
  Watch watch(report, hulls.hulls.size());
  std::erase_if(hulls.hulls, [&](FlatHull& hull) {
    if (!watch.next()) return false;
    const FlatBox box = box_of(hulls, hull);
    return static_cast<double>(hull.top) < passes.in(box.low_x, box.high_x, box.low_y, box.high_y);
  });
}

bool only_reports(const ToolPiece& piece, const PlanOptions& options) {
  return (piece.part == ToolPart::kShank && options.shank.reaction == Reaction::kReport) ||
         (piece.part == ToolPart::kHolder && options.holder.reaction == Reaction::kReport);
}

}  // namespace

std::unique_ptr<const ClField> holder_field(const ClField& field, const PlanOptions& options,
                                            const PassDepth& passes, bool reported,
                                            const ReportShare& report) {
  std::vector<ToolPiece> pieces = tool_pieces(options);
  std::erase_if(pieces, [&](const ToolPiece& piece) {
    return piece.part != ToolPart::kCutter && only_reports(piece, options) != reported;
  });
  if (pieces.size() < 2) return nullptr;
  pieces = with_lower_discs(pieces);
  // The patches of fixtures are in the field already, with all of the tool.
  const std::vector<ToolPiece>& known = field.surface.pieces();
  pieces.insert(pieces.begin() + 1, known.begin() + 1, known.end());
  ClSurface surface(field.surface.mesh(), field.surface.sides(), std::move(pieces),
                    field.surface.part_facets());
  FlatHulls hulls =
      make_flat_hulls(surface, field.deformation, smallest_hull(options), part_of(report, 0.0, kCellsShare),
                      [&](PatchId patch) {
                        const ToolPiece& piece = surface.piece(patch);
                        return piece.part != ToolPart::kCutter && !piece.at_fixtures &&
                               highest_reference(surface, field.deformation, patch) >= passes.of_all();
                      });
  drop_low(hulls, passes, part_of(report, kCellsShare, 1.0));
  if (hulls.hulls.empty()) return nullptr;
  FlatIndex index(field.index, surface.numbers_of(field.surface), std::move(hulls), field.deformation);
  return std::make_unique<const ClField>(
      ClField{std::move(surface), field.deformation, std::move(index), field.bounds, false, field.mesh});
}

Touches find_touches(const ClField& guarded, const EnvelopeOptions& options, const Passes& passes,
                     const ReportShare& report) {
  Touches touches;
  std::size_t points = 0;
  for (const auto& row : passes.rows)
    for (const Pass& pass : row) points += pass.size();
  Watch watch(report, points);
  Envelope envelope(guarded.surface, guarded.deformation, guarded.index, options);
  for (const auto& row : passes.rows)
    for (const Pass& pass : row)
      for (const EnvelopePoint& p : pass) {
        if (!watch.next()) return touches;
        if (!envelope.rises_over(p.flat.x, p.flat.y, p.flat.z + kClear)) continue;
        const auto held = envelope.at(p.flat.x, p.flat.y);
        if (!held || guarded.surface.piece(held->patch).part == ToolPart::kCutter ||
            guarded.surface.piece(held->patch).at_fixtures)
          continue;
        ++touches.points;
        touches.facets.push_back(guarded.surface.facet_of(held->patch));
      }
  std::sort(touches.facets.begin(), touches.facets.end());
  touches.facets.erase(std::unique(touches.facets.begin(), touches.facets.end()), touches.facets.end());
  return touches;
}

}  // namespace tiltfeed::pathgen
