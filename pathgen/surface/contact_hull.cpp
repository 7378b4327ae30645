#include "pathgen/surface/contact_hull.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kinematics/basics/units.h"
#include "pathgen/surface/normal_cone.h"

namespace tiltfeed::pathgen {

namespace {

/// Contact normals further apart than this (cosine of 60 degrees to their mean) bound nothing.
constexpr double kNarrow = 0.5;
/// Sine up to which an angle between contact normals, or of the axis over a hull, against the lean of the
/// normal still tells where on its ring a flat or bull-nose tool touches.
constexpr double kSureShare = 0.4;
/// Sine of a normal's lean from which on it tells so: a level feature is touched anywhere under a flat
/// bottom.
constexpr double kSureLean = 4.0 * kLevel;
/// A bulge (mm) that is not worth another corner.
constexpr double kFine = 1e-3;

}  // namespace

ContactHull::Reach ContactHull::take(PatchId patch, int side) {
  piece_ = &surface_.piece(patch);
  if (!surface_.normals(patch, side, normals_)) return Reach::kNone;
  if (gather_normals()) return Reach::kBounded;
  return normals_.empty() ? Reach::kAround : Reach::kTip;
}

/// Mean of the contact normals and how far they lie from it; false if they are too far apart.
bool ContactHull::gather_normals() {
  if (normals_.empty()) return false;
  if (normals_.size() == 1) {  // a facet
    mean_ = normals_[0], cone_cosine_ = 1.0, cone_sine_ = 0.0, bulge_ = 0.0;
    return true;
  }
  Vec3 sum;
  for (Vec3 n : normals_) sum = sum + n;
  if (length(sum) < kSteepest) return false;
  mean_ = normalized(sum);
  double cosine = 1.0, sine2 = 0.0;  // the sine not from the cosine, which is 1 for small angles
  for (Vec3 n : normals_)
    cosine = std::min(cosine, dot(n, mean_)), sine2 = std::max(sine2, squared_length(cross(n, mean_)));
  cone_cosine_ = cosine, cone_sine_ = std::sqrt(sine2);
  if (cosine < kNarrow) return false;
  surround_normals();
  return true;
}

/// (S4) Directions between the normals bulge out of the hull of their ends; those along an arc lie in the
/// triangle of its ends and its apex.
void ContactHull::surround_normals() {
  bulge_ = piece_->corner * (1.0 / cone_cosine_ - 1.0);
  if (!piece_->is_ball() || bulge_ <= kFine) return;
  const NormalArc arc = widest_arc(normals_);
  if (piece_->corner * arc.aside >= bulge_) return;
  bulge_ = piece_->corner * arc.aside;
  normals_ = {arc.from, arc_apex(arc), arc.to};
}

///
void ContactHull::place(std::span<const Point<Part>> core) {
  points_.clear();
  margin_ = bulge_;
  if (!piece_->is_ball()) return place_on_rings(core);
  for (Point<Part> q : core)
    for (Vec3 n : normals_) points_.push_back(q + n * piece_->corner);
}

/// (S5) Flat, bull-nose and taper: the axis stands beside the contact, on the side to which the normal
/// leans; where it hardly leans, anywhere round it.
void ContactHull::place_on_rings(std::span<const Point<Part>> core) {
  double size = 0.0;
  for (Point<Part> q : core) size = std::max(size, length(map_.bending(q - core[0])));
  const double turning = map_.turning_length(map_.distances(core[0])) - size - piece_->outer;
  const double spread = turning > 0.0 ? (size + 2.0 * piece_->outer) / turning : 1.0;  // of the axis, rad
  const Vec3 axis = map_.axis_at(core[0] + mean_ * piece_->corner);
  const double along = dot(mean_, axis), across = std::sqrt(std::max(0.0, 1.0 - along * along));
  const double sway = (cone_sine_ + spread) / std::max(across, kSteepest);
  // Lean of the normals against the axis; beyond the cone's they touch its upper rim, not the arc.
  const double lean = std::atan2(across, along), open = std::acos(cone_cosine_) + spread;
  const double cone = kPi / 2.0 - std::asin(piece_->taper_sin);
  const bool ring = lean - open <= cone;
  const bool rim = piece_->has_cone() && lean + open >= cone;
  if (sway > kSureShare || spread > kSureShare || across < kSureLean) {
    margin_ = rim ? piece_->outer + piece_->corner
                  : piece_->flat + piece_->corner * std::sqrt(2.0 - 2.0 * cone_cosine_);
    for (Point<Part> q : core) points_.push_back(q + mean_ * (rim ? 0.0 : piece_->corner));
    return;
  }
  // Of the ring's bulge between two directions; of what the axis turns over the feature.
  margin_ += (rim ? piece_->outer : piece_->flat) * sway * sway;
  for (Point<Part> q : core)
    for (Vec3 n : normals_) {
      if (ring) points_.push_back(on_ring(q, n, piece_->flat, piece_->corner));
      if (rim) points_.push_back(on_ring(q, n, piece_->outer, 0.0));
    }
}

/// The CL reference (any point of its axis line) over a contact q with normal n, on the ring of radius d
/// and then r along n. The axis is that of the column, found by iteration.
Point<Part> ContactHull::on_ring(Point<Part> q, Vec3 n, double d, double r) {
  Point<Part> p = q + n * r;
  double moved = 0.0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 axis = map_.axis_at(p);
    const Vec3 lateral = n - axis * dot(n, axis);
    const Point<Part> next = q + n * r + lateral * (d / std::max(length(lateral), kSteepest));
    moved = distance(p, next);
    p = next;
  }
  margin_ = std::max(margin_, 2.0 * moved);
  return p;
}

}  // namespace tiltfeed::pathgen
