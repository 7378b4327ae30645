#include "pathgen/plan/cleared_space.h"

#include <algorithm>
#include <cmath>

#include "pathgen/plan/between_passes.h"

namespace tiltfeed::pathgen {

namespace {

/// Columns are so many radii of the tool wide.
constexpr double kColumnShare = 0.5;
/// Of a way's length: more than it bows towards the axis feature.
constexpr double kBowShare = 0.1;

/// The tool as it is, without what it was to leave.
ToolPiece bare_piece(const PlanOptions& options) {
  PlanOptions bare = options;
  bare.allowance = bare.radial_stock = bare.axial_stock = 0.0;
  return tool_pieces(bare).front();
}

bool has_field(AxisMode mode) { return mode != AxisMode::kFree && mode != AxisMode::kIndexed; }

Deformation field_of(const PlanOptions& options) {
  AxisFrame frame = options.axis;
  if (!has_field(frame.mode)) frame.mode = AxisMode::kFixed;
  return Deformation(frame, 1.0);
}

}  // namespace

ClearedSpace::ClearedSpace(const EarlierCut& cut)
    : cut_(cut),
      piece_(bare_piece(cut.options)),
      height_(reference_height(cut.options.cutter)),
      map_(field_of(cut.options)),
      known_(has_field(cut.options.axis.mode)) {
  if (!known_) return;
  length_ = kColumnShare * piece_.outer;
  // Columns are as wide as that where the path is, in the mean.
  double rho = 0.0, r = 0.0, count = 0.0;
  for (const Move& move : cut.moves) {
    if (move.kind != MoveKind::kCut) continue;
    const Deformation::Distances d = map_.distances(move.pose.tip);
    rho += d.rho, r += d.r, ++count;
  }
  const auto columns = [&](double period, double scale, double away, double& size, std::int64_t& wraps) {
    const bool is_angle = std::isfinite(away) && count > 0.0;
    size = is_angle ? scale * length_ / std::max(away / count, length_) : length_;
    if (period <= 0.0) return;
    wraps = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::floor(period / size)));
    size = period / static_cast<double>(wraps);
  };
  const bool x_is_angle = map_.period_x() > 0.0, y_is_angle = map_.frame().mode != AxisMode::kFixed;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  columns(map_.period_x(), map_.scale_x(), x_is_angle ? r : kNone, size_x_, count_x_);
  columns(map_.period_y(), map_.scale_y(), y_is_angle ? rho : kNone, size_y_, count_y_);
  for (std::uint32_t i = 1; i < cut.moves.size(); ++i)
    if (cut.moves[i].kind == MoveKind::kCut) take(i);
}

void ClearedSpace::take(std::uint32_t move) {
  const Pose &a = cut_.moves[move - 1].pose, &b = cut_.moves[move].pose;
  const double pieces = std::max(1.0, std::ceil(distance(a.tip, b.tip) / length_));
  for (double i = 0.0; i < pieces; ++i) {
    const auto axis_at = [&](double share) { return normalized(a.axis * (1.0 - share) + b.axis * share); };
    Way way{lerp(a.tip, b.tip, i / pieces), lerp(a.tip, b.tip, (i + 1.0) / pieces), axis_at(i / pieces),
            axis_at((i + 1.0) / pieces)};
    way.middle_axis = normalized(way.from_axis + way.to_axis);
    way.half = 0.5 * distance(way.from, way.to);
    way.turn = kTurnOfChord * length(way.to_axis - way.from_axis);
    const auto flat = [&](double share) { return map_.flatten(lerp(a.tip, b.tip, share)); };
    const Point<Flat> f = flat((i + 0.5) / pieces);
    Ways& ways = ways_[column(f.x, f.y)];
    ways.all.push_back(way);
    for (const double share : {i / pieces, (i + 0.5) / pieces, (i + 1.0) / pieces}) {
      const Point<Flat> end = flat(share);
      // In inside work a tool's side is further from the axis feature than its tip.
      const double side = map_.s() < 0.0 ? std::hypot(end.z, piece_.outer) - std::abs(end.z) : 0.0;
      ways.lowest = std::min(ways.lowest, end.z - side - kBowShare * length_);
      const auto apart = [](double from, double to, double period) {
        return std::abs(period > 0.0 ? std::remainder(to - from, period) : to - from);
      };
      half_x_ = std::max(half_x_, apart(f.x, end.x, map_.period_x()));
      half_y_ = std::max(half_y_, apart(f.y, end.y, map_.period_y()));
    }
  }
}

ClearedSpace::Column ClearedSpace::column(double x, double y) const {
  const auto index = [](double v, double size, std::int64_t wraps) {
    const auto i = static_cast<std::int64_t>(std::floor(v / size));
    return wraps > 0 ? ((i % wraps) + wraps) % wraps : i;
  };
  return {index(x, size_x_, count_x_), index(y, size_y_, count_y_)};
}

/// Does the tool there come within `slack` of the place, or is that above it?
bool ClearedSpace::touches(const Way& way, double share, Point<Part> place, double slack) const {
  const Vec3 axis = way.axis_at(share);
  const Vec3 w = place - (lerp(way.from, way.to, share) + axis * (height_ + piece_.above_reference));
  const double h = dot(w, axis), square = std::max(0.0, squared_length(w) - h * h),
               widest = piece_.outer + slack;
  if (square > widest * widest) return false;
  if (!piece_.has_cone() && h >= 0.0) return true;
  return distance_to_piece(piece_, std::sqrt(square), h) <= slack;
}

bool ClearedSpace::passes(const Way& way, Point<Part> place, double slack) const {
  // Beside it, whatever the share.
  const Vec3& axis = way.middle_axis;
  const Vec3 off = place - lerp(way.from, way.to, 0.5);
  const double up = dot(off, axis), widest = (piece_.outer + slack + way.half + way.turn * std::abs(up)) *
                                             (1.0 + way.turn * way.turn);
  if (squared_length(off) - up * up > widest * widest) return false;
  // Below the tip at both ends.
  if (std::max(dot(place - way.from, way.from_axis), dot(place - way.to, way.to_axis)) <
      -slack - kBowShare * length_)
    return false;
  // Seen along the axis, the place of the move nearest to the place.
  const Vec3 along = way.to - way.from, level = along - axis * dot(along, axis);
  const double square = squared_length(level);
  const double share = square > 0.0 ? std::clamp(dot(place - way.from, level) / square, 0.0, 1.0) : 1.0;
  return touches(way, share, place, slack) || (share > 0.0 && touches(way, 0.0, place, slack)) ||
         (share < 1.0 && touches(way, 1.0, place, slack));
}

bool ClearedSpace::holds(Point<Part> place, double slack) const {
  const Way* hint = nullptr;
  return holds(place, slack, hint);
}

bool ClearedSpace::holds(Point<Part> place, double slack, const Way*& hint) const {
  if (!known_ || ways_.empty()) return false;
  if (hint != nullptr && passes(*hint, place, slack)) return true;
  const Point<Flat> f = map_.flatten(place);
  const Deformation::Distances away = map_.distances(place);
  // Between the place and the axis of the tool.
  const double reach = piece_.outer + slack;
  const auto half = [&](double distance, double scale) {
    if (std::isinf(distance)) return reach;
    return scale * (distance > 2.0 * reach ? std::asin(reach / (distance - reach)) : kPi);
  };
  const bool y_is_angle = map_.frame().mode != AxisMode::kFixed;
  const double wide_x = map_.period_x() > 0.0 ? half(away.r, map_.scale_x()) : reach;
  const double wide_y = y_is_angle ? half(away.rho, map_.scale_y()) : reach;
  const double columns_x = (wide_x + half_x_) / size_x_ + 1.0, columns_y = (wide_y + half_y_) / size_y_ + 1.0;
  // From the middle outwards: the way of a tool that has been there mostly runs near.
  const auto offset = [](std::int64_t k) { return k % 2 == 0 ? k / 2 : -(k + 1) / 2; };
  const auto count = [](double columns, std::int64_t wraps) {
    const auto all = 2 * static_cast<std::int64_t>(std::ceil(columns)) + 1;
    return wraps > 0 ? std::min(all, wraps) : all;
  };
  const std::int64_t of_x = count(columns_x, count_x_), of_y = count(columns_y, count_y_);
  for (std::int64_t i = 0; i < of_x; ++i)
    for (std::int64_t j = 0; j < of_y; ++j) {
      const auto found = ways_.find(column(f.x + static_cast<double>(offset(i)) * size_x_,
                                           f.y + static_cast<double>(offset(j)) * size_y_));
      if (found == ways_.end() || f.z + slack < found->second.lowest) continue;
      for (const Way& way : found->second.all)
        if (passes(way, place, slack)) return hint = &way, true;
    }
  return false;
}

}  // namespace tiltfeed::pathgen
