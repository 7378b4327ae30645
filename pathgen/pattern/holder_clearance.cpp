#include "pathgen/pattern/holder_clearance.h"
#include "pathgen/options/side_step.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Places of the grid in one direction, at most.
constexpr double kMostPlaces = 512.0;
/// A holder that stands this much (mm) too low still counts as clear: rounding.
constexpr double kClear = 1e-6;
/// Of the work on the hulls of shank and holder, making them.
constexpr double kCellsShare = 0.7;

/// The lowest place of the passes in each square of flat space.
class LowestPlaces {
 public:
  /// `spacing`: of the passes in flat space, mm: no square lies between two of them.
  LowestPlaces(const Passes& passes, const FlatBounds& bounds, double spacing, const Deformation& map)
      : bounds_(bounds) {
    const double width = std::max(bounds.max_x - bounds.min_x, 1e-9);
    const double height = std::max(bounds.max_y - bounds.min_y, 1e-9);
    size_ = std::max(spacing, std::max(width, height) / kMostPlaces);
    columns_ = static_cast<std::int64_t>(std::ceil(width / size_));
    rows_ = static_cast<std::int64_t>(std::ceil(height / size_));
    wraps_x_ = map.period_x() > 0.0, wraps_y_ = map.period_y() > 0.0;
    lowest_.assign(static_cast<std::size_t>(columns_ * rows_), kInfinity);
    for (const auto& row : passes.rows)
      for (const Pass& pass : row)
        for (std::size_t i = 0; i + 1 < pass.size(); ++i) add(pass[i].flat, pass[i + 1].flat);
    // Contours run elsewhere, and on other levels, once shank and holder are heeded.
    if (passes.as_given) lowest_.assign(lowest_.size(), -kInfinity);
    sum_up();
  }

  double of_all() const { return of_all_; }

  /// Over all places of the passes in the rectangle.
  double in(double low_x, double high_x, double low_y, double high_y) const {
    // What lies past a seam may be anywhere.
    if ((wraps_x_ && (low_x < bounds_.min_x || high_x > bounds_.max_x)) ||
        (wraps_y_ && (low_y < bounds_.min_y || high_y > bounds_.max_y)))
      return -kInfinity;
    double lowest = kInfinity;
    const std::int64_t x0 = column(low_x), x1 = column(high_x), y0 = row(low_y), y1 = row(high_y);
    for (std::int64_t j = y0; j <= y1;) {
      const bool high = j % kBlock == 0 && j + kBlock - 1 <= y1;
      for (std::int64_t i = x0; i <= x1;) {
        const bool whole = high && i % kBlock == 0 && i + kBlock - 1 <= x1;
        if (whole) {
          lowest = std::min(lowest, of_block_[static_cast<std::size_t>(j / kBlock * blocks_ + i / kBlock)]);
        } else {
          for (std::int64_t k = j; k < (high ? j + kBlock : j + 1); ++k)
            lowest = std::min(lowest, lowest_[static_cast<std::size_t>(k * columns_ + i)]);
        }
        i += whole ? kBlock : 1;
      }
      j += high ? kBlock : 1;
    }
    return lowest;
  }

 private:
  /// Squares of a block in one direction.
  static constexpr std::int64_t kBlock = 8;

  void sum_up() {
    blocks_ = columns_ / kBlock + 1;
    of_block_.assign(static_cast<std::size_t>(blocks_ * (rows_ / kBlock + 1)), kInfinity);
    for (std::int64_t j = 0; j < rows_; ++j)
      for (std::int64_t i = 0; i < columns_; ++i) {
        double& block = of_block_[static_cast<std::size_t>(j / kBlock * blocks_ + i / kBlock)];
        block = std::min(block, lowest_[static_cast<std::size_t>(j * columns_ + i)]);
      }
    of_all_ = *std::min_element(of_block_.begin(), of_block_.end());
  }
  std::int64_t column(double x) const {
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor((x - bounds_.min_x) / size_)), 0,
                                    columns_ - 1);
  }
  std::int64_t row(double y) const {
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor((y - bounds_.min_y) / size_)), 0,
                                    rows_ - 1);
  }
  /// A straight move, with the squares beside it, since its flat image is bent.
  void add(Point<Flat> a, Point<Flat> b) {
    const double z = std::min(a.z, b.z);
    for (std::int64_t j = row(std::min(a.y, b.y) - size_); j <= row(std::max(a.y, b.y) + size_); ++j)
      for (std::int64_t i = column(std::min(a.x, b.x) - size_); i <= column(std::max(a.x, b.x) + size_);
           ++i) {
        double& lowest = lowest_[static_cast<std::size_t>(j * columns_ + i)];
        lowest = std::min(lowest, z);
      }
  }

  FlatBounds bounds_;
  double size_ = 1.0;
  std::int64_t columns_ = 1, rows_ = 1, blocks_ = 1;
  bool wraps_x_ = false, wraps_y_ = false;
  std::vector<double> lowest_, of_block_;
  double of_all_ = kInfinity;
};

/// Drops the hulls of shank and holder that lie wholly under the passes.
void drop_low(FlatHulls& hulls, const LowestPlaces& passes, const ReportShare& report) {
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
                                            const Passes& passes, bool reported, const ReportShare& report) {
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
  // Leads and joins reach a little beyond the passes.
  const double spacing = 2.0 * std::max(asked_step(options), options.pattern.step_down) +
                         options.links.lead_radius + options.links.join_distance;
  const LowestPlaces lowest(passes, field.bounds, spacing, field.deformation);
  FlatHulls hulls =
      make_flat_hulls(surface, field.deformation, smallest_hull(options), part_of(report, 0.0, kCellsShare),
                      [&](PatchId patch) {
                        const ToolPiece& piece = surface.piece(patch);
                        return piece.part != ToolPart::kCutter && !piece.at_fixtures &&
                               highest_reference(surface, field.deformation, patch) >= lowest.of_all();
                      });
  drop_low(hulls, lowest, part_of(report, kCellsShare, 1.0));
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
