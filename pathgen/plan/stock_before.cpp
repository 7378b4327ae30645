#include "pathgen/plan/stock_before.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "kinematics/basics/units.h"
#include "pathgen/tool/blank_solid.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

namespace {

/// Places round the cutter, and rings of them, at which stock is looked for.
constexpr int kRound = 12, kRings = 3;
/// Of the cutter's radius: how far the places of the box are apart of which is known whether they are stock.
constexpr double kGridShare = 0.25;
constexpr double kMostPlaces = 4e6;
/// Of the cutter's radius: steps in which a way down is looked at.
constexpr double kDownStep = 0.25;
/// Of a piece's radius, and of the cutter's: how far apart places are looked at along a piece and a move.
constexpr double kApart = 0.5;
/// The same where what operations have left of the blank is known: it has edges.
constexpr int kRoundEdges = 24, kRingsOfEdges = 8;
constexpr double kRubbing = 2.0;  ///< tolerances: so much of a touch is none

/// Places on circles round an axis.
struct Round {
  Vec3 u, v;  ///< unit, square to the axis and to each other
  explicit Round(Vec3 axis)
      : u(normalized(cross(axis, std::abs(axis.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}))),
        v(cross(axis, u)) {}

  /// Is any of so many of them stock? The first one is on u.
  template <class IsStock>
  bool any(Point<Part> middle, double radius, int count, const IsStock& is_stock) const {
    for (int k = 0; k < count; ++k) {
      const double turn = 2.0 * kPi * k / count;
      if (is_stock(middle + u * (radius * std::cos(turn)) + v * (radius * std::sin(turn)))) return true;
    }
    return false;
  }
};

/// The tool without what it is to leave.
std::vector<ToolPiece> tool_itself(PlanOptions options) {
  options.allowance = options.radial_stock = options.axial_stock = 0.0;
  return all_pieces(options);
}

}  // namespace

StockBefore::StockBefore(const CheckedMesh& part, const PlanOptions& options)
    : options_(options),
      box_(options.blank ? options.blank->bounds() : part.bounds),
      pieces_(tool_itself(options)) {
  std::vector<ToolMoves> others;
  for (const auto& cut : options.earlier) {
    const AxisMode mode = cut->options.axis.mode;
    if (mode == AxisMode::kFree || mode == AxisMode::kIndexed)
      others.push_back({&cut->options.cutter, &cut->moves, cut->options.tolerance});
    else
      cleared_.emplace_back(*cut);
  }
  if (others.empty()) return;
  left_.emplace(BlankSolid::box(box_).mesh(), others);
  for (const ToolMoves& one : others) left_->clear(one);
}

bool StockBefore::known() const {
  return options_.blank != nullptr ||
         (!options_.earlier.empty() && options_.earlier.front()->options.pattern.kind == PatternKind::kRough);
}

/// Is the cutter in stock anywhere from its end up to `height` over it?
template <class IsStock>
bool StockBefore::in_stock(Point<Part> reference, Vec3 axis, double height, IsStock is_stock) const {
  const Round round(axis);
  const Point<Part> ring = reference + axis * cutter().above_reference;
  for (int level = 0; level < (height > 0.0 ? 3 : 1); ++level)
    for (int r = kRings; r >= 0; --r) {
      const double d = (cutter().flat + cutter().corner) * r / kRings;
      // The border of the piece's lower side there.
      const double beyond = std::max(0.0, d - cutter().flat);
      const double low = -std::sqrt(std::max(0.0, cutter().corner * cutter().corner - beyond * beyond));
      const double h = low + height * level / 2.0;
      if (round.any(ring + axis * h, d, r == 0 ? 1 : kRound, is_stock)) return true;
    }
  return false;
}

/// Is what stands as high as the lower side of the cutter somewhere under it, or higher? The lower side is
/// taken as low on each ring as it is on the next one inwards, so that an edge between them is seen.
template <class IsStock>
bool StockBefore::over_edges(Point<Part> reference, Vec3 axis, IsStock is_stock) const {
  const Round round(axis);
  const Point<Part> ring = reference + axis * cutter().above_reference;
  const auto stands = [&](double d, double h) {
    return round.any(ring + axis * h, d, kRoundEdges, is_stock);
  };
  for (int r = kRingsOfEdges; r > 0; --r) {
    const double angle = 0.5 * kPi * r / kRingsOfEdges, inner = 0.5 * kPi * (r - 1) / kRingsOfEdges;
    if (stands(cutter().flat + cutter().corner * std::sin(angle), -cutter().corner * std::cos(inner)))
      return true;
  }
  for (int r = kRings; r > 0 && cutter().flat > 0.0; --r)
    if (stands(cutter().flat * r / kRings, -cutter().corner)) return true;
  return is_stock(ring - axis * cutter().corner);
}

/// Is anything of the tool in stock, but for its lower side?
bool StockBefore::sides_in_stock(Point<Part> reference, Vec3 axis, Hints& hints) const {
  const Round round(axis);
  const auto exactly = [&](Point<Part> p) { return is_stock(p, hints); };
  return std::any_of(pieces_.begin(), pieces_.end(), [&](const ToolPiece& piece) {
    const double levels = std::max(1.0, std::ceil(std::max(0.0, piece.length) / (kApart * piece.outer)));
    for (double level = 0.0; level <= levels; ++level) {
      const Point<Part> middle =
          reference + axis * (piece.above_reference + std::max(0.0, piece.length) * level / levels);
      if (exactly(middle) || round.any(middle, piece.outer, kRound, exactly)) return true;
    }
    return false;
  });
}

/// In the blank or near to it, and no operation has been there.
bool StockBefore::is_stock(Point<Part> p, Hints& hints) const {
  const double margin = 0.5 * options_.links.approach;
  for (const auto& [v, low, high] :
       {std::array{p.x, box_.min.x, box_.max.x}, std::array{p.y, box_.min.y, box_.max.y},
        std::array{p.z, box_.min.z, box_.max.z}})
    if (v < low - margin || v > high + margin) return false;
  if (options_.blank && !options_.blank->holds(p, margin)) return false;
  const double slack = kRubbing * options_.tolerance;
  hints.resize(cleared_.size(), nullptr);
  for (std::size_t i = 0; i < cleared_.size(); ++i)
    if (cleared_[i].holds(p, slack, hints[i])) return false;
  return !left_ || left_->lines().stands_about(line_place(from_origin(p), left_->lines().along()));
}

/// Places of the box a share of the cutter's radius apart: what of them is stock.
void StockBefore::lay_grid() {
  const Vec3 size = box_.max - box_.min;
  grid_step_ = std::max(kGridShare * cutter().outer, std::cbrt(size.x * size.y * size.z / kMostPlaces));
  const auto along = [&](double length) {
    return static_cast<std::size_t>(std::ceil(length / grid_step_)) + 1;
  };
  grid_size_ = {along(size.x), along(size.y), along(size.z)};
  const std::size_t nx = grid_size_[0], ny = grid_size_[1], nz = grid_size_[2];
  grid_.assign(nx * ny * nz, 0);
  tbb::parallel_for(std::size_t{0}, nx * ny, [&](std::size_t column) {
    const double x = static_cast<double>(column % nx), y = static_cast<double>(column / nx);
    Hints hints;
    for (std::size_t k = 0; k < nz; ++k)
      grid_[column * nz + k] =
          is_stock(box_.min + Vec3{x, y, static_cast<double>(k)} * grid_step_, hints) ? 1 : 0;
  });
}

/// Is the place of the grid next to it stock?
bool StockBefore::is_stock_about(Point<Part> p) const {
  const Vec3 at = (p - box_.min) / grid_step_;
  const std::array<double, 3> near{std::round(at.x), std::round(at.y), std::round(at.z)};
  for (std::size_t i = 0; i < 3; ++i)
    if (near[i] < 0.0 || near[i] >= static_cast<double>(grid_size_[i])) return false;
  const auto x = static_cast<std::size_t>(near[0]), y = static_cast<std::size_t>(near[1]),
             z = static_cast<std::size_t>(near[2]);
  return grid_[(y * grid_size_[0] + x) * grid_size_[2] + z] != 0;
}

bool StockBefore::meets(Point<Part> reference, Vec3 axis, double height) const {
  return in_stock(reference, axis, height, [&](Point<Part> p) { return is_stock_about(p); });
}

double StockBefore::free_from(const Deformation& field, Point<Flat> place, double from, double to) const {
  const AxisLine line = field.axis_line(place.x, place.y);
  Hints hints;
  const auto exactly = [&](Point<Part> p) { return is_stock(p, hints); };
  return down_to(from, to, [&](double z) {
    const Point<Part> reference = line.base + line.axis * z;
    return is_whole() ? in_stock(reference, line.axis, 0.0, exactly)
                      : over_edges(reference, line.axis, exactly);
  });
}

double StockBefore::clear_down_to(Point<Part> reference, Vec3 axis, double from, double to) const {
  Hints hints;
  const auto exactly = [&](Point<Part> p) { return is_stock(p, hints); };
  return down_to(from, to, [&](double height) {
    const Point<Part> at = reference + axis * height;
    return over_edges(at, axis, exactly) || sides_in_stock(at, axis, hints);
  });
}

bool StockBefore::moves_in(const Pose& from, const Pose& to) const {
  const double height = reference_height(options_.cutter),
               top = height + pieces_.back().above_reference + std::max(0.0, pieces_.back().length);
  const double way = distance(from.tip, to.tip) + top * angle_between(from.axis, to.axis);
  const double steps = std::max(1.0, std::ceil(way / (kApart * cutter().outer)));
  Hints hints;
  const auto exactly = [&](Point<Part> p) { return is_stock(p, hints); };
  for (double k = 0.0; k <= steps; ++k) {
    const Vec3 axis = slerp(from.axis, to.axis, k / steps);
    const Point<Part> at = lerp(from.tip, to.tip, k / steps) + axis * height;
    if (over_edges(at, axis, exactly) || sides_in_stock(at, axis, hints)) return true;
  }
  return false;
}

template <class Stands>
double StockBefore::down_to(double from, double to, Stands stands_at) const {
  const double step = kDownStep * cutter().outer;
  // The blank is asked with a margin; what operations have left of it is not.
  const double margin = is_whole() ? 0.0 : 0.5 * options_.links.approach;
  double free = from;
  for (double z = from - step; z > to; z -= step) {
    if (stands_at(z)) return std::min(from, free + margin);
    free = z;
  }
  return stands_at(to) ? std::min(from, free + margin) : to;
}

}  // namespace tiltfeed::pathgen
