#pragma once
// What a move should do (tip on a straight line, axis on a great circle, part space) and how far a block,
// whose axes move linearly, strays from it (K6), (K7).

#include "kinematics/basics/tool_path.h"
#include "kinematics/machine/chain.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed {

/// The ideal motion from one pose to the next at fractions f in [0, 1].
class Sweep {
 public:
  /// Requires: axes unit and not opposite.
  Sweep(const Pose& from, const Pose& to);

  Pose at(double f) const;
  /// Great-circle angle of the whole move, rad.
  double angle() const { return angle_; }
  /// The length of the tip's way, mm.
  double distance() const { return distance_; }

 private:
  friend class SweepSampler;
  Point<Part> tip_, end_tip_;
  Vec3 way_;
  Vec3 axis_, end_axis_, ahead_;  ///< axis(f) = axis cos(f angle) + ahead sin(f angle)
  double angle_, distance_;
};

/// Largest distances over a block from the nearest pose of the sweep.
struct Deviation {
  double tip = 0.0;   ///< mm
  double end = 0.0;   ///< of the point `up` the axis, mm; between it and the tip nothing strays further
  double axis = 0.0;  ///< rad
};

/// Interior samples of a block: seven, and its end. A hump of the deviation falls between them by at most
/// kSampleShare of its height (a sine with two humps over the block, peak half-way between two samples: 8 %).
inline constexpr int kBlockSamples = 8;
inline constexpr double kSampleShare = 0.1;

/// How far up the axis, mm: what is to keep to the sweep; a ball end's centre, by which early is told from
/// late.
struct ToolReach {
  double up = 0.0;
  double centre = 0.0;
};

/// The block `from` -> `to` against fractions f0..f1 of the sweep, sampled.
Deviation worst_deviation(const Chain& chain, const Sweep& sweep, double f0, double f1, const Posture& from,
                          const Joints& to, const ToolReach& reach);

}  // namespace tiltfeed
