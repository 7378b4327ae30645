#include "kinematics/joints/singularity_pieces.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {
namespace {

// Cosine of 45 degrees: where the axis's way turns more sharply it has no one side.
constexpr double kSharp = 0.7071;

/// The move comes as near to the pole as a bend matters.
bool near_pole(Vec3 a, Vec3 b, Vec3 pole, double reach) {
  if (angle_between(a, pole) <= reach || angle_between(b, pole) <= reach) return true;
  const Vec3 ahead = way_of(a, b), back = way_of(b, a);
  if (dot(pole, ahead) <= 0.0 || dot(pole, back) <= 0.0) return false;
  return std::abs(std::asin(std::clamp(dot(pole, cross(a, ahead)), -1.0, 1.0))) <= reach;
}

bool sharp(const ToolPath& path, std::size_t point) {
  const Vec3 at = path.moves[point].pose.axis;
  const Vec3 before = way_of(at, path.moves[point - 1].pose.axis) * -1.0,
             after = way_of(at, path.moves[point + 1].pose.axis);
  return squared_length(before) > 0.0 && squared_length(after) > 0.0 && dot(before, after) < kSharp;
}

}  // namespace

Vec3 way_of(Vec3 a, Vec3 b) {
  const Vec3 across = b - a * dot(a, b);
  return length(across) < kNoTurn ? Vec3{} : normalized(across);
}

std::vector<SingularityPiece> pieces_near_singularity(const ToolPath& path, Vec3 pole, double reach) {
  std::vector<SingularityPiece> found;
  for (std::size_t i = 1; i < path.moves.size(); ++i) {
    if (path.moves[i].kind != MoveKind::kCut ||
        !near_pole(path.moves[i - 1].pose.axis, path.moves[i].pose.axis, pole, reach))
      continue;
    const bool goes_on = !found.empty() && found.back().last == i - 1 && !sharp(path, i - 1);
    if (goes_on)
      found.back().last = i;
    else
      found.push_back({i - 1, i});
  }
  return found;
}

}  // namespace tiltfeed
