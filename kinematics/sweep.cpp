#include "kinematics/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tiltfeed {
namespace {

// Below this angle (rad) two axes are the same and the great circle between them has no direction.
constexpr double kSameAxis = 1e-12;
// mm per rad: weighs the axis against the tip when the nearest pose of the sweep is sought.
constexpr double kLeastLever = 1.0;
// Up to this angle (rad) the second-order sine and cosine below are exact to 1e-13.
constexpr double kSmallAngle = 1e-4;

Vec3 linear_words(const Joints& q) { return {q.x, q.y, q.z}; }

// All samples of a block side by side: the loops over them have no branches and no calls, so that the
// compiler makes vector code of them.
using Lane = std::array<double, kBlockSamples>;
constexpr std::size_t kLanes = kBlockSamples;

struct Lanes3 {
  Lane x, y, z;
  Vec3 at(std::size_t i) const { return {x[i], y[i], z[i]}; }
  void set(std::size_t i, Vec3 v) { x[i] = v.x, y[i] = v.y, z[i] = v.z; }
};

/// Angles as cosine and sine.
struct LanesOfTurns {
  Lane cos, sin;
  LanesOfTurns() = default;
  /// `from` turned on by one `step` after the other.
  LanesOfTurns(Trig from, Trig step) {
    for (std::size_t i = 0; i < kLanes; ++i) set(i, from = from * step);
  }
  Trig at(std::size_t i) const { return {cos[i], sin[i]}; }
  void set(std::size_t i, Trig t) { cos[i] = t.cos, sin[i] = t.sin; }
};

double greatest(const Lane& lane) { return *std::max_element(lane.begin(), lane.end()); }

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

/// Compares the sampled poses of a block with the sweep.
class SweepSampler {
 public:
  SweepSampler(const Sweep& sweep, double corner_radius) : sweep_(sweep), radius_(corner_radius) {
    const double lever = std::max(corner_radius, kLeastLever);
    lever2_ = lever * lever;
    const double metric = squared_length(sweep.way_) + lever2_ * sweep.angle_ * sweep.angle_;
    per_metric_ = metric > 0.0 ? 1.0 / metric : 0.0;
  }

  /// Sample i: linear words `start` + (i + 1) `step`, the i-th angles, the sweep's fraction `f`, whose place
  /// on the great circle is `place`.
  template <ChainKind kind>
  Deviation worst(const Chain& chain, Vec3 start, Vec3 step, const LanesOfTurns& tilt,
                  const LanesOfTurns& rotary, const Lane& f, const LanesOfTurns& place) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const Pose pose = chain.pose_of<kind>(start + step * static_cast<double>(static_cast<int>(i) + 1),
                                            tilt.at(i), rotary.at(i));
      const Vec3 axis = sweep_.axis_ * place.cos[i] + sweep_.ahead_ * place.sin[i];
      const Vec3 turning = sweep_.ahead_ * place.cos[i] - sweep_.axis_ * place.sin[i];
      const Vec3 tip_off = (pose.tip - sweep_.tip_) - sweep_.way_ * f[i];
      // One Gauss-Newton step to the nearest pose of the sweep: being early or late is no deviation.
      const double slip =
          (dot(tip_off, sweep_.way_) + lever2_ * sweep_.angle_ * dot(pose.axis - axis, turning)) *
          per_metric_;
      const double late = f[i] + slip;
      late_[i] = (late < 0.0 ? 0.0 : late > 1.0 ? 1.0 : late) - f[i];
      tip_off_.set(i, tip_off);
      tool_.set(i, pose.axis);
      axis_.set(i, axis);
      turning_.set(i, turning);
    }
    return worst_of(shifts());
  }

 private:
  /// How far each sample is late, as an angle of the great circle.
  LanesOfTurns shifts() const {
    LanesOfTurns shift;
    double largest = 0.0;
    for (std::size_t i = 0; i < kLanes; ++i) {
      const double angle = late_[i] * sweep_.angle_;
      shift.set(i, {1.0 - angle * angle / 2.0, angle});
      largest = std::max(largest, std::abs(angle));
    }
    if (largest <= kSmallAngle) return shift;
    for (std::size_t i = 0; i < kLanes; ++i)
      if (std::abs(shift.sin[i]) > kSmallAngle) shift.set(i, Trig::of(shift.sin[i]));
    return shift;
  }

  Deviation worst_of(const LanesOfTurns& shift) const {
    Lane tip2, centre2, turn2;
    for (std::size_t i = 0; i < kLanes; ++i) {
      const Vec3 off = tip_off_.at(i) - sweep_.way_ * late_[i];
      const Vec3 turn = tool_.at(i) - (axis_.at(i) * shift.cos[i] + turning_.at(i) * shift.sin[i]);
      tip2[i] = squared_length(off);
      centre2[i] = squared_length(off + turn * radius_);
      turn2[i] = squared_length(turn);
    }
    return {std::sqrt(greatest(tip2)), std::sqrt(greatest(centre2)),
            2.0 * std::asin(std::min(1.0, std::sqrt(greatest(turn2)) / 2.0))};
  }

  const Sweep& sweep_;
  double radius_, lever2_, per_metric_;
  Lane late_;
  Lanes3 tip_off_, tool_, axis_, turning_;
};

Deviation worst_deviation(const Chain& chain, const Sweep& sweep, double f0, double f1, const Posture& from,
                          const Joints& to, double corner_radius) {
  const Joints& q = from.joints;
  const auto part = [](double whole) { return Trig::of(whole / kBlockSamples); };
  const LanesOfTurns tilt(from.tilt, part(chain.tilt_radians(to.a) - chain.tilt_radians(q.a)));
  const LanesOfTurns rotary(from.rotary, part(chain.rotary_radians(to.c) - chain.rotary_radians(q.c)));
  const LanesOfTurns place(f0 > 0.0 ? Trig::of(f0 * sweep.angle()) : Trig{}, part((f1 - f0) * sweep.angle()));
  Lane f;
  for (int i = 0; i < kBlockSamples; ++i) f[i] = f0 + (f1 - f0) * (i + 1) / kBlockSamples;
  const Vec3 start = linear_words(q);
  const Vec3 step = (linear_words(to) - start) / kBlockSamples;
  SweepSampler sampler(sweep, corner_radius);
  switch (chain.kind()) {
    case ChainKind::kVertical:
      return sampler.worst<ChainKind::kVertical>(chain, start, step, tilt, rotary, f, place);
    case ChainKind::kTableTable:
      return sampler.worst<ChainKind::kTableTable>(chain, start, step, tilt, rotary, f, place);
    case ChainKind::kHeadHead:
      return sampler.worst<ChainKind::kHeadHead>(chain, start, step, tilt, rotary, f, place);
    case ChainKind::kTableHead:
      break;
  }
  return sampler.worst<ChainKind::kTableHead>(chain, start, step, tilt, rotary, f, place);
}

}  // namespace tiltfeed
