#include "sim/motion/forward.h"

namespace tiltfeed::sim {
namespace {

// A body's directions as the columns of a matrix, seen from the frame before it in the chain. Right-handed.
struct Turn {
  Vec3 x, y, z;  ///< rows

  Vec3 out(Vec3 v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }  ///< to the frame before
  Vec3 back(Vec3 v) const { return x * v.x + y * v.y + z * v.z; }       ///< from the frame before: transposed
};

/// A body that turns about `axis` through the frame's origin, by the quaternion (cos t/2, axis sin t/2); t:
/// how far the rotary has turned it, counter-clockwise about its direction.
Turn turned(const RotaryAxis& rotary, double word) {
  const double angle = Angle::from_degrees(rotary.sign * (word - rotary.zero)).radians();
  const double w = std::cos(angle / 2.0), s = std::sin(angle / 2.0);
  const double x = rotary.direction.x * s, y = rotary.direction.y * s, z = rotary.direction.z * s;
  return {{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
          {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
          {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}};
}

}  // namespace

FrameChain::FrameChain(const MachineModel& machine, const Setup& setup)
    : structure_(machine.structure),
      rotary_(machine.rotary),
      tilt_(machine.tilt),
      spindle_(machine.spindle),
      between_(machine.rotary_to_tilt),
      centre_(from_origin(machine.table_centre)),
      part_zero_(setup.part_zero),
      pivot_to_tip_(machine.pivot_to_gauge + machine.spindle * -setup.tool_length),
      fixture_(setup.fixture) {}

// With both rotaries at home the program's origin is part zero, so the slides' home puts the tip at `zero`:
// each chain is laid out from there, out from the tip over carriers and slides to the bed, and back over the
// carriers to the part.
Pose FrameChain::operator()(const Joints& joints) const {
  const Vec3 slides{joints.x, joints.y, joints.z}, zero = centre_ + part_zero_;
  const Turn rotary = turned(rotary_, joints.c), tilt = turned(tilt_, joints.a);
  const Turn fixture{fixture_.rows[0], fixture_.rows[1], fixture_.rows[2]};
  Vec3 tip, axis;  // seen from part zero, before the fixture's turn
  switch (structure_) {
    case Structure::kTableHead:
      tip = zero - pivot_to_tip_ + slides + tilt.out(pivot_to_tip_);
      tip = rotary.back(tip - centre_) - part_zero_;
      axis = rotary.back(tilt.out(spindle_));
      break;
    case Structure::kTableTable:
      tip = tilt.back(zero + slides - centre_ - between_) + between_;
      tip = rotary.back(tip) - part_zero_;
      axis = rotary.back(tilt.back(spindle_));
      break;
    case Structure::kHeadHead:
      tip = slides - pivot_to_tip_ - between_ + rotary.out(between_ + tilt.out(pivot_to_tip_));
      axis = rotary.out(tilt.out(spindle_));
      break;
  }
  return {Point<Part>{} + fixture.back(tip), fixture.back(axis)};
}

Pose forward_by_frames(const MachineModel& machine, const Setup& setup, const Joints& joints) {
  return FrameChain(machine, setup)(joints);
}

}  // namespace tiltfeed::sim
