#include "kinematics/sweep.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {
namespace {

// Below this angle (rad) two axes are the same and the great circle between them has no direction.
constexpr double kSameAxis = 1e-12;
// mm per rad: weighs the axis against the tip when the nearest pose of the sweep is sought.
constexpr double kLeastLever = 1.0;
// Up to this angle (rad) the second-order sine and cosine below are exact to 1e-13.
constexpr double kSmallAngle = 1e-4;

Trig small_trig(double angle) {
  if (std::abs(angle) > kSmallAngle) return Trig::of(angle);
  return {1.0 - angle * angle / 2.0, angle};
}

Vec3 linear_words(const Joints& q) { return {q.x, q.y, q.z}; }

}  // namespace

Sweep::Sweep(const Pose& from, const Pose& to)
    : tip_(from.tip), end_tip_(to.tip), way_(to.tip - from.tip), axis_(from.axis), end_axis_(to.axis) {
  const Vec3 normal = cross(from.axis, to.axis);
  angle_ = std::atan2(length(normal), dot(from.axis, to.axis));
  if (angle_ < kSameAxis)
    angle_ = 0.0;
  else
    ahead_ = normalized(cross(normal, from.axis));
}

Pose Sweep::at(double f) const {
  if (f >= 1.0) return {end_tip_, end_axis_};
  const Trig t = Trig::of(f * angle_);
  return {tip_ + way_ * f, normalized(axis_ * t.cos + ahead_ * t.sin)};
}

/// Compares one sampled pose with the sweep; its place on the great circle is kept as cosine and sine.
class SweepSampler {
 public:
  SweepSampler(const Sweep& sweep, double corner_radius) : sweep_(sweep), radius_(corner_radius) {
    const double lever = std::max(corner_radius, kLeastLever);
    lever2_ = lever * lever;
    const double metric = squared_length(sweep.way_) + lever2_ * sweep.angle_ * sweep.angle_;
    per_metric_ = metric > 0.0 ? 1.0 / metric : 0.0;
  }

  /// `place`: f * angle as cosine and sine.
  void add(const Pose& pose, double f, Trig place) {
    const Vec3 axis = sweep_.axis_ * place.cos + sweep_.ahead_ * place.sin;
    const Vec3 turning = sweep_.ahead_ * place.cos - sweep_.axis_ * place.sin;
    const Vec3 tip_off = (pose.tip - sweep_.tip_) - sweep_.way_ * f;
    // One Gauss-Newton step to the nearest pose of the sweep: being early or late is no deviation.
    const double slip =
        (dot(tip_off, sweep_.way_) + lever2_ * sweep_.angle_ * dot(pose.axis - axis, turning)) * per_metric_;
    const double late = std::clamp(f + slip, 0.0, 1.0) - f;
    const Trig shift = small_trig(late * sweep_.angle_);
    const Vec3 off = tip_off - sweep_.way_ * late;
    const Vec3 turn = pose.axis - (axis * shift.cos + turning * shift.sin);
    tip2_ = std::max(tip2_, squared_length(off));
    centre2_ = std::max(centre2_, squared_length(off + turn * radius_));
    turn2_ = std::max(turn2_, squared_length(turn));
  }

  Deviation worst() const {
    return {std::sqrt(tip2_), std::sqrt(centre2_), 2.0 * std::asin(std::min(1.0, std::sqrt(turn2_) / 2.0))};
  }

 private:
  const Sweep& sweep_;
  double radius_, lever2_, per_metric_;
  double tip2_ = 0.0, centre2_ = 0.0, turn2_ = 0.0;
};

Deviation worst_deviation(const Chain& chain, const Sweep& sweep, double f0, double f1, const Joints& from,
                          const Joints& to, double corner_radius) {
  const double alpha = chain.head_radians(from.a), phi = chain.table_radians(from.c);
  Trig head = Trig::of(alpha), table = Trig::of(phi), place = Trig::of(f0 * sweep.angle());
  const Trig head_step = Trig::of((chain.head_radians(to.a) - alpha) / kBlockSamples);
  const Trig table_step = Trig::of((chain.table_radians(to.c) - phi) / kBlockSamples);
  const Trig place_step = Trig::of((f1 - f0) * sweep.angle() / kBlockSamples);
  const Vec3 start = linear_words(from), step = (linear_words(to) - start) / kBlockSamples;
  SweepSampler sampler(sweep, corner_radius);
  for (int i = 1; i <= kBlockSamples; ++i) {
    head = head * head_step;
    table = table * table_step;
    place = place * place_step;
    sampler.add(chain.pose(start + step * i, head, table), f0 + (f1 - f0) * i / kBlockSamples, place);
  }
  return sampler.worst();
}

}  // namespace tiltfeed
