#include "sim/forward.h"

#include <array>

namespace tiltfeed::sim {
namespace {

// A frame as a 4 x 4 homogeneous matrix: the columns of its upper left part are its directions, the fourth
// column its origin, both seen from the frame before it in the chain. Right-handed, mm.
struct Frame {
  std::array<std::array<double, 4>, 4> m{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
};

Frame operator*(const Frame& a, const Frame& b) {
  Frame product;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k < 4; ++k) sum += a.m[i][k] * b.m[k][j];
      product.m[i][j] = sum;
    }
  }
  return product;
}

Frame moved(double x, double y, double z) {
  Frame frame;
  frame.m[0][3] = x;
  frame.m[1][3] = y;
  frame.m[2][3] = z;
  return frame;
}

Frame moved(Vec3 by) { return moved(by.x, by.y, by.z); }

/// A body that turns about `axis` through the frame's origin, by the quaternion (cos t/2, axis sin t/2).
Frame turned(Vec3 axis, double angle) {
  const double w = std::cos(angle / 2.0), s = std::sin(angle / 2.0);
  const double x = axis.x * s, y = axis.y * s, z = axis.z * s;
  Frame frame;
  frame.m[0] = {w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y), 0};
  frame.m[1] = {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x), 0};
  frame.m[2] = {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z, 0};
  return frame;
}

Frame mounted(const Rotation& fixture) {
  Frame frame;
  for (std::size_t i = 0; i < 3; ++i)
    frame.m[i] = {fixture.rows[i].x, fixture.rows[i].y, fixture.rows[i].z, 0};
  return frame;
}

/// The way back through a rigid frame: transposed directions, origin carried along.
Frame undone(const Frame& frame) {
  Frame back;
  for (std::size_t i = 0; i < 3; ++i) {
    double origin = 0.0;
    for (std::size_t j = 0; j < 3; ++j) {
      back.m[i][j] = frame.m[j][i];
      origin -= frame.m[j][i] * frame.m[j][3];
    }
    back.m[i][3] = origin;
  }
  return back;
}

/// How far the rotary has turned its body, counter-clockwise about its direction, rad.
double turn_of(const RotaryAxis& axis, double word) {
  return Angle::from_degrees(axis.sign * (word - axis.zero)).radians();
}

}  // namespace

Pose forward_by_frames(const MachineModel& machine, const Setup& setup, const Joints& joints) {
  const Vec3 centre = from_origin(machine.table_centre), zero = centre + setup.part_zero;
  const Vec3 between = machine.rotary_to_tilt;
  const Vec3 pivot_to_tip = machine.pivot_to_gauge + machine.spindle * -setup.tool_length;
  const Frame slides = moved(joints.x, joints.y, joints.z), fixture = mounted(setup.fixture);
  const Frame rotary = turned(machine.rotary.direction, turn_of(machine.rotary, joints.c));
  const Frame tilt = turned(machine.tilt.direction, turn_of(machine.tilt, joints.a));

  // With both rotaries at home the program's origin is part zero, so the slides' home puts the tip there:
  // each chain is laid out from `zero`, bed -> carriers -> part and bed -> slides -> carriers -> tip.
  Frame part, tip;
  switch (machine.structure) {
    case Structure::kTableHead:
      part = moved(centre) * rotary * moved(setup.part_zero) * fixture;
      tip = moved(zero - pivot_to_tip) * slides * tilt * moved(pivot_to_tip);
      break;
    case Structure::kTableTable:
      part = moved(centre + between) * tilt * moved(-between) * rotary * moved(setup.part_zero) * fixture;
      tip = moved(zero) * slides;
      break;
    case Structure::kHeadHead:
      part = moved(zero) * fixture;
      tip = moved(zero - pivot_to_tip - between) * slides * rotary * moved(between) * tilt *
            moved(pivot_to_tip);
      break;
  }
  const Frame seen = undone(part) * tip;
  const auto seen_direction = [&](std::size_t row) {
    const Vec3 e = machine.spindle;
    return seen.m[row][0] * e.x + seen.m[row][1] * e.y + seen.m[row][2] * e.z;
  };
  return {{seen.m[0][3], seen.m[1][3], seen.m[2][3]},
          {seen_direction(0), seen_direction(1), seen_direction(2)}};
}

}  // namespace tiltfeed::sim
