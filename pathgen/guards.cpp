#include "pathgen/guards.h"
#include "pathgen/side_step.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Places of the grid in one direction, at most.
constexpr double kMostPlaces = 512.0;
/// A holder that stands this much (mm) too low still counts as clear: rounding.
constexpr double kClear = 1e-6;
/// Of the work on the cells of shank and holder, making them.
constexpr double kCellsShare = 0.7;

/// (G2) No CL point of the patch is higher than this (z'): the contact is on the feature, at most `outer`
/// beside the axis line.
double highest_reference(const ClSurface& surface, const Deformation& map, PatchId patch) {
  const ToolPiece& piece = surface.piece(patch);
  const ClSurface::Core core = surface.core(patch);
  const AxisFrame& frame = map.frame();
  const double lift = piece.corner - piece.above_reference, aside = piece.outer;
  double top = -kInfinity, size = 0.0;
  for (Point<Part> p : core.points()) {
    top = std::max(top, map.flatten(p).z);
    size = std::max(size, distance(p, core.corner[0]));
  }
  if (frame.mode == AxisMode::kFixed) return top + lift;
  if (map.s() > 0.0) {
    if (frame.mode != AxisMode::kCircle) return top + lift;
    // The contact may be nearest to a place of the circle further round, by an angle whose sine is at most
    // aside / r: from there its distance is the lesser by what the circle bends.
    double r = kInfinity;
    for (Point<Part> p : core.points()) {
      const Vec3 d = p - frame.origin;
      r = std::min(r, std::hypot(dot(d, frame.t), dot(d, frame.n)));
    }
    const double sine = aside / std::max(r - size, 1e-9);
    return top + lift + frame.circle_radius * (sine < 1.0 ? 1.0 - std::sqrt(1.0 - sine * sine) : 2.0);
  }
  // Inside work: -z' is the distance from the feature, less along the axis line, and less between corners.
  const double near = std::max(0.0, -top - size);
  return lift - std::sqrt(std::max(0.0, near * near - aside * aside));
}

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
  }

  /// Over all places of the passes in the rectangle.
  double in(double low_x, double high_x, double low_y, double high_y) const {
    // What lies past a seam may be anywhere.
    if ((wraps_x_ && (low_x < bounds_.min_x || high_x > bounds_.max_x)) ||
        (wraps_y_ && (low_y < bounds_.min_y || high_y > bounds_.max_y)))
      return -kInfinity;
    double lowest = kInfinity;
    for (std::int64_t j = row(low_y); j <= row(high_y); ++j)
      for (std::int64_t i = column(low_x); i <= column(high_x); ++i)
        lowest = std::min(lowest, lowest_[static_cast<std::size_t>(j * columns_ + i)]);
    return lowest;
  }

 private:
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
  std::int64_t columns_ = 1, rows_ = 1;
  bool wraps_x_ = false, wraps_y_ = false;
  std::vector<double> lowest_;
};

/// Drops the cells of shank and holder that lie wholly under the passes; false if none stays.
bool drop_low(Cells& cells, const ClSurface& surface, const Deformation& map, const LowestPlaces& passes,
              const ReportShare& report) {
  bool guarded = false;
  PatchId last = 0;
  double top = kInfinity;
  Watch watch(report, cells.cells.size());
  std::erase_if(cells.cells, [&](Cell& cell) {
    if (!watch.next()) return false;
    if (surface.piece(cell.patch).part == ToolPart::kCutter) return false;
    if (cell.patch != last) last = cell.patch, top = highest_reference(surface, map, cell.patch);
    double low_x = kInfinity, high_x = -kInfinity, low_y = kInfinity, high_y = -kInfinity;
    for (std::uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
      const double x = cells.corners[i].x, y = cells.corners[i].y;
      low_x = std::min(low_x, x), high_x = std::max(high_x, x);
      low_y = std::min(low_y, y), high_y = std::max(high_y, y);
    }
    const double lowest =
        passes.in(low_x - cell.pad_x, high_x + cell.pad_x, low_y - cell.pad_y, high_y + cell.pad_y);
    if (top < lowest) return true;
    guarded = true;
    cell.top = std::nextafter(static_cast<float>(top), std::numeric_limits<float>::infinity());
    return false;
  });
  return guarded;
}

bool only_reports(const ToolPiece& piece, const PlanOptions& options) {
  return (piece.part == ToolPart::kShank && options.shank.reaction == Reaction::kReport) ||
         (piece.part == ToolPart::kHolder && options.holder.reaction == Reaction::kReport);
}

}  // namespace

std::unique_ptr<const ClField> guarded_field(const ClField& field, const PlanOptions& options,
                                             const Passes& passes, bool reported, const ReportShare& report) {
  std::vector<ToolPiece> pieces = tool_pieces(options);
  std::erase_if(pieces, [&](const ToolPiece& piece) {
    return piece.part != ToolPart::kCutter && only_reports(piece, options) != reported;
  });
  if (pieces.size() < 2) return nullptr;
  ClSurface surface(field.surface.mesh(), field.surface.sides(), std::move(pieces));
  Cells cells =
      make_cells(surface, field.deformation, smallest_cell(options), part_of(report, 0.0, kCellsShare));
  // Leads and joins reach a little beyond the passes.
  const double spacing = 2.0 * std::max(asked_step(options), options.pattern.step_down) +
                         options.links.lead_radius + options.links.join_distance;
  const LowestPlaces lowest(passes, field.bounds, spacing, field.deformation);
  if (!drop_low(cells, surface, field.deformation, lowest, part_of(report, kCellsShare, 1.0))) return nullptr;
  FlatIndex index(std::move(cells), field.deformation);
  return std::make_unique<const ClField>(
      ClField{std::move(surface), field.deformation, std::move(index), field.bounds});
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
        const auto held = envelope.at(p.flat.x, p.flat.y);
        if (!held || held->flat.z <= p.flat.z + kClear ||
            guarded.surface.piece(held->patch).part == ToolPart::kCutter)
          continue;
        ++touches.points;
        touches.facets.push_back(guarded.surface.facet_of(held->patch));
      }
  std::sort(touches.facets.begin(), touches.facets.end());
  touches.facets.erase(std::unique(touches.facets.begin(), touches.facets.end()), touches.facets.end());
  return touches;
}

}  // namespace tiltfeed
