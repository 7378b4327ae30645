#include "pathgen/tool/tool_in_blank.h"

#include <algorithm>
#include <cmath>

#include "pathgen/tool/blank_solid.h"

namespace tiltfeed::pathgen {
namespace {

/// Of a ball's radius: how far apart balls stand, along a piece and along a move.
constexpr double kApart = 0.5;
/// Two balls of radius r that stand d apart leave r - sqrt(r^2 - d^2 / 4) of the side between them uncovered:
/// with d = r / 2 it is 0.032 r. So much larger, and a little more, they cover it.
constexpr double kLarger = 1.04;

}  // namespace

ToolInBlank::ToolInBlank(const PlanOptions& options)
    : options_(options),
      pieces_(all_pieces(options)),
      margin_(0.5 * options.links.approach),
      reference_height_(reference_height(options.cutter)),
      step_(kApart * options.cutter.radius()) {}

bool ToolInBlank::stands_in(Point<Part> reference, Vec3 axis, double above) const {
  return std::any_of(pieces_.begin(), pieces_.end(), [&](const ToolPiece& piece) {
    const double low = piece.above_reference, high = low + std::max(0.0, piece.length);
    const double balls = std::max(1.0, std::ceil((high - low) / (kApart * piece.outer)));
    for (double i = 0.0; i <= balls; ++i) {
      const double h = low + (high - low) * i / balls;
      if (h <= above) continue;
      const Point<Part> centre = reference + axis * h;
      if (options_.blank->holds(centre, kLarger * piece.outer + margin_)) return true;
    }
    return false;
  });
}

double ToolInBlank::steps(const Pose& from, const Pose& to) const {
  double top = 0.0;
  for (const ToolPiece& piece : pieces_) top = std::max(top, piece.above_reference + piece.length);
  const double way =
      distance(from.tip, to.tip) + (top + reference_height_) * angle_between(from.axis, to.axis);
  return std::max(1.0, std::ceil(way / step_));
}

bool ToolInBlank::moves_in(const Pose& from, const Pose& to) const {
  const double count = steps(from, to);
  for (double k = 0.0; k <= count; ++k) {
    const Vec3 axis = slerp(from.axis, to.axis, k / count);
    if (stands_in(lerp(from.tip, to.tip, k / count) + axis * reference_height_, axis)) return true;
  }
  return false;
}

double ToolInBlank::clear_down_to(Point<Part> reference, Vec3 axis, double high, double low) const {
  double clear = high;
  for (double h = high; h > low; h -= step_) {
    if (stands_in(reference + axis * h, axis)) return clear;
    clear = h;
  }
  return stands_in(reference + axis * low, axis) ? clear : low;
}

}  // namespace tiltfeed::pathgen
