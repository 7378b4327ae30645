#include "kinematics/machine/sweep.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {
namespace {

// Below this angle (rad) two axes are the same and the great circle between them has no direction.
constexpr double kSameAxis = 1e-12;
// mm per rad: weighs the axis against the tip when the nearest pose of the sweep is sought.
constexpr double kLeastLever = 1.0;
// Up to this angle (rad) the series of sine and cosine below are exact to 1e-15.
constexpr double kSmallStep = 0.1, kSmallAngle = 2e-3;

Vec3 linear_words(const Joints& q) { return {q.x, q.y, q.z}; }

Trig small(double x) {
  if (!(std::abs(x) <= kSmallStep)) return Trig::of(x);
  const double z = x * x;
  return {1.0 - z * (1.0 / 2 - z * (1.0 / 24 - z * (1.0 / 720 - z * (1.0 / 40320)))),
          x - x * z * (1.0 / 6 - z * (1.0 / 120 - z * (1.0 / 5040 - z * (1.0 / 362880))))};
}

template <bool far>
TwinTrig turn_of(Twin x) {
  if constexpr (far) return beside(Trig::of(x[0]), Trig::of(x[1]));
  const Twin z = x * x;
  return {1.0 - z * (1.0 / 2 - z * (1.0 / 24)), x - x * z * (1.0 / 6)};
}

/// The angle between two unit vectors so far apart.
double angle_of(double chord) {
  if (chord > kSmallAngle) return 2.0 * std::asin(std::min(1.0, chord / 2.0));
  return chord + chord * chord * chord * (1.0 / 24);
}

/// An angle at two samples after the other, from the first two on.
class Turning {
 public:
  Turning(Trig from, double whole) {
    const Trig one = small(whole / kBlockSamples), two = one * one;
    now = beside(from * one, from * two);
    step_ = beside(two, two);
  }
  void go_on() { now = now * step_; }
  TwinTrig now;

 private:
  TwinTrig step_;
};

}  // namespace

Sweep::Sweep(const Pose& from, const Pose& to)
    : tip_(from.tip), end_tip_(to.tip), way_(to.tip - from.tip), axis_(from.axis), end_axis_(to.axis) {
  const Vec3 normal = cross(from.axis, to.axis);
  angle_ = std::atan2(length(normal), dot(from.axis, to.axis));
  distance_ = length(way_);
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

/// A block compared with the sweep at two samples at a time, as the table sees them.
class SweepSampler {
 public:
  SweepSampler(const Chain& chain, const Sweep& sweep, const ToolReach& reach)
      : chain_(chain),
        tip_(chain.from_table_axis(sweep.tip_)),
        way_(chain.on_table(sweep.way_)),
        axis_(chain.on_table(sweep.axis_)),
        ahead_(chain.on_table(sweep.ahead_)),
        angle_(sweep.angle_),
        up_(reach.up) {
    const double lever = std::max(reach.centre, kLeastLever);
    const double metric = squared_length(way_) + lever * lever * angle_ * angle_;
    per_metric_ = metric > 0.0 ? 1.0 / metric : 0.0;
    lever_ = lever * lever * angle_;
  }

  /// `late_far`: samples may be late by more than kSmallAngle.
  template <ChainKind kind, bool late_far = false>
  Deviation worst(double f0, double f1, const Posture& from, const Joints& to) const {
    const Joints& q = from.joints;
    Turning tilt(from.tilt, chain_.tilt_radians(to.a) - chain_.tilt_radians(q.a));
    Turning rotary(from.rotary, chain_.rotary_radians(to.c) - chain_.rotary_radians(q.c));
    Turning place(f0 > 0.0 ? Trig::of(f0 * angle_) : Trig{}, (f1 - f0) * angle_);
    const Vec3 start = linear_words(q), step = (linear_words(to) - start) / kBlockSamples;
    const double way2 = squared_length(way_), part = (f1 - f0) / kBlockSamples;
    Twin sample{1.0, 2.0}, latest{}, tip2{}, end2{}, turn2{};
    for (int i = 0; i < kBlockSamples; i += 2) {
      const auto tool = chain_.held<kind>(start + step * sample, tilt.now, rotary.now);
      const Twin f = f0 + part * sample;
      const TwinVec3 tip = tool.tip - tip_;
      // One Gauss-Newton step to the nearest pose of the sweep: being early or late is no deviation.
      const Twin ahead = dot(tool.axis, ahead_) * place.now.cos - dot(tool.axis, axis_) * place.now.sin;
      const Twin nearest = f + (dot(tip, way_) - way2 * f + lever_ * ahead) * per_metric_;
      const Twin there = lesser(greater(nearest, Twin{}), Twin{1.0, 1.0}), shift = (there - f) * angle_;
      latest = greater(latest, greater(shift, -shift));
      const TwinTrig place_there = place.now * turn_of<late_far>(shift);
      const TwinVec3 off = tip - way_ * there;
      const TwinVec3 turn = tool.axis - (axis_ * place_there.cos + ahead_ * place_there.sin);
      tip2 = greater(tip2, squared_length(off));
      end2 = greater(end2, squared_length(off + turn * up_));
      turn2 = greater(turn2, squared_length(turn));
      tilt.go_on();
      rotary.go_on();
      place.go_on();
      sample += 2.0;
    }
    if (!late_far && !(greatest(latest) <= kSmallAngle)) return worst<kind, true>(f0, f1, from, to);
    return {std::sqrt(greatest(tip2)), std::sqrt(greatest(end2)), angle_of(std::sqrt(greatest(turn2)))};
  }

 private:
  const Chain& chain_;
  Vec3 tip_, way_, axis_, ahead_;
  double angle_, up_, lever_, per_metric_;
};

Deviation worst_deviation(const Chain& chain, const Sweep& sweep, double f0, double f1, const Posture& from,
                          const Joints& to, const ToolReach& reach) {
  const SweepSampler sampler(chain, sweep, reach);
  switch (chain.kind()) {
    case ChainKind::kVertical:
      return sampler.worst<ChainKind::kVertical>(f0, f1, from, to);
    case ChainKind::kTableTable:
      return sampler.worst<ChainKind::kTableTable>(f0, f1, from, to);
    case ChainKind::kHeadHead:
      return sampler.worst<ChainKind::kHeadHead>(f0, f1, from, to);
    case ChainKind::kTableHead:
      break;
  }
  return sampler.worst<ChainKind::kTableHead>(f0, f1, from, to);
}

}  // namespace tiltfeed
